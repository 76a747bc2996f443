"""Measured torques against the exact model: does the robot file describe the robot?"""

from gd_analyze.measured_torque.comparison import TorqueComparison, compare_torque
from gd_analyze.measured_torque.friction import Friction
from gd_analyze.measured_torque.verdict import VERDICTS, Verdict

__all__ = ["VERDICTS", "Friction", "TorqueComparison", "Verdict", "compare_torque"]
