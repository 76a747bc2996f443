"""Where a result comes from: versions, time and command, as flat strings."""

from __future__ import annotations

import datetime
import platform
from importlib.metadata import version as installed_version

from gd_analyze.version import __version__


def provenance(command: str) -> dict[str, str]:
    """Flat description of this run, stored with every result and shown in every report."""
    return {
        "gd_analyze": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": command,
        "python": platform.python_version(),
        "numpy": installed_version("numpy"),
        "pinocchio": installed_version("pin"),
    }
