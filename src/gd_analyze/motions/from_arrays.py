"""Motions of arrays that are in memory already."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray, array_of
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.derived_rates import FEWEST_SET_POINTS, complete_rates
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.measured import motion_of
from gd_analyze.motions.trajectory import Trajectory

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gd_analyze.motions.treatment import Treatment
    from gd_analyze.robots.arm import RobotArm

ORIGIN = "arrays in memory"


def planned_motion(
    time: ArrayLike, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike | None, name: str
) -> Trajectory:
    """Take the numbers as they are, and derive what is missing; see `Trajectory.from_arrays`."""
    instants, positions, rates, accelerations = _arrays(time, q, qd, qdd)
    if rates is not None and accelerations is not None:
        return Trajectory(instants, positions, rates, accelerations, name, ORIGIN)
    # Checked as a value before a spline is laid through it.
    nothing = np.zeros_like(positions)
    Trajectory(instants, positions, nothing if rates is None else rates, nothing, name)
    if len(instants) < FEWEST_SET_POINTS:
        raise TrajectoryError(
            "too few set points to derive what is missing",
            where=name,
            expected=f"at least {FEWEST_SET_POINTS} set points, or q, qd and qdd",
            found=str(len(instants)),
            next_step="give qd and qdd, or more set points",
        )
    rates, accelerations, rates_from = complete_rates(instants, positions, rates, accelerations)
    return Trajectory(instants, positions, rates, accelerations, name, ORIGIN, rates_from)


def recorded_motion(
    time: ArrayLike,
    q: ArrayLike,
    qd: ArrayLike | None,
    qdd: ArrayLike | None,
    name: str,
    arm: RobotArm | None,
    treatment: Treatment | None,
) -> Trajectory:
    """Treat the numbers as readings; see `Trajectory.from_arrays`."""
    instants, positions, rates, accelerations = _arrays(time, q, qd, qdd)
    logged = Logged(instants, positions, rates, accelerations, None, measured=True, name=name, origin=ORIGIN)
    return motion_of(logged, arm, treatment)


def _arrays(
    time: ArrayLike, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray | None, FloatArray | None]:
    instants, positions = (array_of(x, what, TrajectoryError) for x, what in ((time, "time"), (q, "q")))
    if positions.ndim != 2 or not positions.size:
        raise TrajectoryError(
            "a trajectory needs at least one set point",
            expected="q of shape (N, n)",
            found=str(positions.shape),
        )
    rates, accelerations = (
        None if x is None else array_of(x, what, TrajectoryError) for x, what in ((qd, "qd"), (qdd, "qdd"))
    )
    for what, array, shape in (
        ("time", instants, positions.shape[:1]),
        ("qd", rates, positions.shape),
        ("qdd", accelerations, positions.shape),
    ):
        if array is not None and array.shape != shape:
            raise TrajectoryError(f"{what} has the wrong shape", expected=str(shape), found=str(array.shape))
    return instants, positions, rates, accelerations
