"""The command as a program for another process; folders tested together cannot import a conftest."""

from __future__ import annotations

PROGRAM = "from gd_analyze.cli import main\nmain()"
