"""The command line: a thin view of the library, one file per verb."""

from gd_analyze.cli.entry import main

__all__ = ["main"]
