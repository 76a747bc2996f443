"""Logs of robots as they are found: read, understood, and put into SI units by joint."""

from gd_analyze.logs.logged import ColumnUse, Logged

__all__ = ["ColumnUse", "Logged"]
