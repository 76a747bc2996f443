"""A process that waits in the midst of replacing a file, to be killed there."""

from __future__ import annotations

KILLED_MIDWAY = """
import sys
from gd_analyze.files import replacing
with replacing(sys.argv[1]) as temporary:
    with temporary.open("w") as file:
        file.write("half" * 100_000)
        file.flush()
        print("writing", flush=True)
        sys.stdin.read()
"""
