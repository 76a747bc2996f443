"""Measured torques against the exact model, to tell whether the robot file describes the robot."""

from gd_analyze.measured_torque.comparison import TorqueComparison, compare_torque
from gd_analyze.measured_torque.friction import TERMS, Friction
from gd_analyze.measured_torque.verdict import VERDICTS, Verdict

__all__ = ["TERMS", "VERDICTS", "Friction", "TorqueComparison", "Verdict", "compare_torque"]
