"""Rates that a file gives but that its positions and instants contradict, and the slip behind it.

What is compared are integrals: the change of x, and that of its derivative v by the trapezoidal rule.
Differentiating x would compare the noise of x instead. Between two set points v is taken to lie between its
values there, so that the rule errs by half its change times the time step at most; of coarse set points,
that pass over whole movements, the few intervals where the two disagree most are left out.
"""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.text import named_joints

# An arm may stop, turn or jerk between two set points: in as many intervals as this nothing is concluded, and
# there must be more besides. Planned motions of any profile with up to four vias then show no contradiction.
_LEFT_OUT = 3
FEWEST_SET_POINTS = 8
# Share of the movement that v may miss beyond what the time steps explain. Rates of real arms, filtered or
# from a sensor of their own, miss up to 0.1 of it; the slips named here at least 0.9.
_MISSED = 0.25
# Movements below these are noise: of a joint beside the others, and in rad or m (per s).
_STILL_SHARE, _STILL = 0.05, 1e-3
# Nearer to a factor than this is that factor, and with no more than this share left over.
_NEAR, _LEFT_OVER = 0.1, 0.2

_DEGREES = math.degrees(1.0)


def rate_slips(trajectory: Trajectory) -> list[str]:
    """Say which given rates and accelerations are not derivatives, one sentence for each likely slip.

    Rates that were derived from the file's numbers are derivatives, and are not looked at; nor are
    accelerations where the rates are wrong already, which they would be compared with.
    """
    if trajectory.n_set_points < FEWEST_SET_POINTS:
        return []
    for name, values, derivative in (
        ("qd", trajectory.q, trajectory.qd),
        ("qdd", trajectory.qd, trajectory.qdd),
    ):
        joints_of: dict[float | None, list[int]] = {}
        if name not in trajectory.derived:
            found = _contradicted(trajectory.time, values, derivative, trajectory.gaps)
            for joint, factor in found.items():
                joints_of.setdefault(factor, []).append(joint + 1)
        if joints_of:
            n_joints = values.shape[1]
            return [_sentence(name, factor, joints, n_joints) for factor, joints in joints_of.items()]
    return []


def _contradicted(
    time: FloatArray, x: FloatArray, v: FloatArray, gaps: tuple[int, ...]
) -> dict[int, float | None]:
    """Joints (from 0) where v is not the derivative of x, and the factor by which v is too large.

    None where it is no factor; of the known factors the exact one. Changes across gaps do not count.
    """
    steps = np.diff(time)[:, None]
    changes = np.diff(x, axis=0)
    integrals = steps * (v[1:] + v[:-1]) / 2
    unsure = steps * np.abs(np.diff(v, axis=0)) / 2
    across = np.array(gaps, dtype=int) - 1
    for array in (changes, integrals, unsure):
        array[across] = 0.0
    worst = np.argsort(np.abs(changes - integrals), axis=0)[-_LEFT_OUT:]
    for array in (changes, integrals, unsure):
        np.put_along_axis(array, worst, 0.0, axis=0)
    moved, integrated = (_path(array) for array in (changes, integrals))
    size = np.maximum(np.ptp(moved, axis=0), np.ptp(integrated, axis=0))
    missed = np.ptp(moved - integrated, axis=0) - unsure.sum(axis=0)
    moves = size > max(_STILL, _STILL_SHARE * float(size.max()))
    return {
        int(joint): _factor(moved[:, joint], integrated[:, joint])
        for joint in np.flatnonzero(moves & (missed > _MISSED * size))
    }


def _path(steps: FloatArray) -> FloatArray:
    return np.vstack([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])


def _factor(moved: FloatArray, integrated: FloatArray) -> float | None:
    """The known factor between two paths, if one is; 0 where only the first moves."""
    if not np.ptp(integrated):
        return 0.0
    a, b = moved - moved.mean(), integrated - integrated.mean()
    if not a.any():
        return None
    factor = float(a @ b / (a @ a))
    if np.ptp(b - factor * a) > _LEFT_OVER * np.ptp(b):
        return None
    return next((known for known in _MEANING if abs(factor / known - 1) < _NEAR), None)


_TIME = "times the derivative of {x}, as if time, which is read as seconds, were in"
_MEANING = {
    1e3: f"1000 {_TIME} milliseconds",
    1e6: f"1e6 {_TIME} microseconds",
    1e9: f"1e9 {_TIME} nanoseconds",
    _DEGREES: "57.3 times the derivative of {x}, as if {v} were in degrees and {x} in radians: "
    "columns in degrees are named {v}1_deg and so on",
    1 / _DEGREES: "the derivative of {x} divided by 57.3, as if {x} were in degrees and {v} in radians: "
    "columns in degrees are named {x}1_deg and so on",
    -1.0: "the derivative of {x} with the other sign",
}


def _sentence(name: str, factor: float | None, joints: list[int], n_joints: int) -> str:
    x = {"qd": "q", "qdd": "qd"}[name]
    if factor == 0.0:
        told = (
            f"0 throughout while {x} changes: if unknown, leave the {name} columns out and they are derived"
        )
    elif factor is None:
        told = f"not the derivative of {x}: check the units, and the order of the columns"
    else:
        told = _MEANING[factor].format(x=x, v=name)
    return f"{name} of {named_joints(joints, n_joints)} is {told}"
