"""Exact and simplified torque side by side, each against what was measured."""

from __future__ import annotations

from dataclasses import dataclass

from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.evaluation import Evaluation


@dataclass(frozen=True, eq=False)
class BesideMeasured:
    """Measured torques held against both models alike; friction is fitted beside each by itself.

    Parameters
    ----------
    exact, simplified
        The comparison with the exact dynamics, and with the simplified model.
    """

    exact: TorqueComparison
    simplified: TorqueComparison

    @classmethod
    def of(cls, arm: RobotArm, trajectory: Trajectory, evaluation: Evaluation) -> BesideMeasured | None:
        """Compare, where torques were recorded with the motion; None elsewhere."""
        if trajectory.recording is None or trajectory.recording.torque is None:
            return None
        return cls(
            compared(arm, trajectory, evaluation.dynamics.torque),
            compared(arm, trajectory, evaluation.torque),
        )
