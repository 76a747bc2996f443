"""Arithmetic made visible: trace array code into a straight-line program, count it, run it."""

from gd_analyze.operations.counting import count_operations
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Expression, Trace

__all__ = ["Expression", "OperationCount", "Program", "Trace", "count_operations"]
