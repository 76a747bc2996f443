"""The command as a program for another process; a conftest cannot be imported where folders are tested together."""

from __future__ import annotations

PROGRAM = "from gd_analyze.cli import main\nmain()"
