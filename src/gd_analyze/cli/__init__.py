"""The command line: a thin view of the library, a command per verb."""

import signal
import sys
from pathlib import Path

# An interrupt while the command still loads ends it as the system does, without Python's traceback.
if (
    Path(sys.argv[0]).stem == "gd-analyze" or Path(sys.argv[0]).parts[-2:] == ("gd_analyze", "__main__.py")
) and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from gd_analyze.cli.entry import main

__all__ = ["main"]
