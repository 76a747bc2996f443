"""What is doubtful of an identified arm beside its file: torques beyond limits, bodies, and scale."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits, warn_of_weight
from gd_analyze.errors import TorqueLimitWarning
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.plausibility import CHECKS

# Standard error of torque constants and gear efficiencies, of which nothing is known.
_UNKNOWN_SCALE_ERROR = 0.2
_COMPARED_STATES = 300  # set points of a log at which models are compared


def doubts_of(
    file_arm: RobotArm, identified_arm: RobotArm, motions: Sequence[Trajectory], *, physical: bool
) -> tuple[str, ...]:
    """Sentences on what is implausible of an identified arm, but not of its file.

    Bodies of plain least squares may be impossible (`physical` is False), and are not checked.
    """
    doubts = list(_beyond_limits(file_arm, identified_arm, _states_of(motions)))
    return (*doubts, *(_newly_implausible(file_arm, identified_arm) if physical else ()))


def scale_error(file_arm: RobotArm, identified_arm: RobotArm, motions: Sequence[Trajectory]) -> float:
    """Relative standard error of the torques' scale: how far gravity torques are from the file's, as RMS.

    Noise does not show the scale of torque constants. If they and the file's masses are right, both agree.
    """
    if not file_arm.mass.any():
        return _UNKNOWN_SCALE_ERROR
    q = _states_of(motions).q
    resting = States(q, np.zeros_like(q), np.zeros_like(q))
    file_torque, identified_torque = (
        torque_of(arm, resting, drives=False) for arm in (file_arm, identified_arm)
    )
    along, squares = (file_torque * identified_torque).sum(axis=0), np.square(file_torque).sum(axis=0)
    has_gravity = squares > 0.0
    if not has_gravity.any():
        return _UNKNOWN_SCALE_ERROR
    deviations = along[has_gravity] / squares[has_gravity] - 1.0
    return float(np.sqrt(squares[has_gravity] @ deviations**2 / squares.sum()))


def _states_of(motions: Sequence[Trajectory]) -> States:
    """Some set points of logs."""
    samples = [(motion, evenly(motion.n_set_points, _COMPARED_STATES)) for motion in motions]
    q, qd, qdd = (np.concatenate([getattr(log, x)[at] for log, at in samples]) for x in ("q", "qd", "qdd"))
    return States(q, qd, qdd)


def _beyond_limits(file_arm: RobotArm, identified_arm: RobotArm, states: States) -> Iterator[str]:
    """Torque along the logs, and weight, beyond the drives' limits, as of any arm, but not of the file."""
    for check in (lambda arm: warn_of_torque_limits(arm, states), warn_of_weight):
        texts = []
        for arm in (identified_arm, file_arm):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                check(arm)
            texts.append(
                [str(warning.message) for warning in caught if warning.category is TorqueLimitWarning]
            )
        if not texts[1]:
            yield from texts[0]


def _newly_implausible(file_arm: RobotArm, identified_arm: RobotArm) -> Iterator[str]:
    """Findings of the checks of any arm's file, at places where the file has none."""
    for check in CHECKS:
        before = {place for place, _ in check(file_arm)}
        yield from (f"{place}: {text}" for place, text in check(identified_arm) if place not in before)
