"""The command line: a thin view of the library, a command per verb."""

from gd_analyze.cli.entry import main

__all__ = ["main"]
