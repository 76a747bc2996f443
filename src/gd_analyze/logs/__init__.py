"""Logs of robots as they are found: read, understood, and put into SI units by joint."""

from gd_analyze.logs.logged import ColumnUse, Logged
from gd_analyze.logs.read import read_log
from gd_analyze.logs.reading import Reading

__all__ = ["ColumnUse", "Logged", "Reading", "read_log"]
