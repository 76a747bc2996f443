"""Arithmetic made visible: trace array code into a straight-line program, count it, run it."""

from gd_analyze.operations.counting import count_operations as count_operations
from gd_analyze.operations.program import OperationCount as OperationCount
from gd_analyze.operations.program import Program as Program
from gd_analyze.operations.trace import Expression as Expression
from gd_analyze.operations.trace import Trace as Trace
