"""Torque over time: as a function of time and state, or a history of set points."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.robots.arm import RobotArm

TorqueFunction: TypeAlias = Callable[[float, FloatArray, FloatArray], ArrayLike]
TorqueHistory: TypeAlias = tuple[ArrayLike, ArrayLike]


def torque_function(
    arm: RobotArm, torque: TorqueFunction | TorqueHistory, duration: float
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    """Turn either way of stating torque into a checked function of t, q and qd.

    A history becomes a cubic spline through its set points (SciPy's, not-a-knot): twice continuously
    differentiable, so that an integrator of high order keeps its order, and exact to the fourth power of the
    spacing where the torque is smooth. Near a jump a spline overshoots; state such a torque as a function.

    Raises
    ------
    UsageError
        If a history's shapes do not fit, its time does not increase or does not cover 0 to the duration.
    """
    inner = torque if callable(torque) else _spline(arm, torque, duration)

    def checked(t: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        value = np.asarray(inner(t, q, qd), dtype=float)
        if value.shape != (arm.n_joints,) or not np.isfinite(value).all():
            raise GdAnalyzeError(
                "the torque function does not give one finite torque per joint",
                where=f"t = {t:g} s",
                expected=f"{arm.n_joints} finite numbers",
                found=f"shape {value.shape}" if value.shape != (arm.n_joints,) else str(value.tolist()),
            )
        return value

    return checked


def _spline(arm: RobotArm, history: TorqueHistory, duration: float) -> TorqueFunction:
    from scipy.interpolate import CubicSpline

    try:
        time, values = (np.asarray(part, dtype=float) for part in history)
    except (TypeError, ValueError):
        raise UsageError(
            "torque is neither a function nor a history",
            where="torque",
            expected="a function of t, q and qd, or (time, values)",
            found=type(history).__name__,
        ) from None
    if time.ndim != 1 or len(time) < 2 or values.shape != (len(time), arm.n_joints):
        raise UsageError(
            f"the torque history does not fit arm {arm.name}",
            where="torque",
            expected=f"time of shape (N,) with N of 2 or more, and values of shape (N, {arm.n_joints})",
            found=f"time {time.shape}, values {values.shape}",
        )
    if not (np.isfinite(time).all() and np.isfinite(values).all() and (np.diff(time) > 0).all()):
        raise UsageError(
            "the torque history is not finite, or its time does not increase",
            where="torque",
            expected="finite numbers, time strictly increasing",
        )
    if time[0] > 0 or time[-1] < duration:
        raise UsageError(
            "the torque history does not cover the simulation",
            where="torque",
            expected=f"0 to {duration:g} s",
            found=f"{time[0]:g} to {time[-1]:g} s",
            next_step="simulate for a shorter duration, or shift the history so that it begins at 0",
        )
    spline = CubicSpline(time, values)
    return lambda t, q, qd: spline(t)
