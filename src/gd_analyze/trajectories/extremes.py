"""Extreme positions, rates and accelerations of a motion, joint by joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.trajectories.trajectory import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


@dataclass(frozen=True, eq=False)
class Extreme:
    """The extreme value of one quantity of each joint and the instant it is taken, both (n,)."""

    value: FloatArray
    time: FloatArray


@dataclass(frozen=True, eq=False)
class Extremes:
    """Lowest and highest joint variable, largest magnitude of rate and acceleration, SI and radians."""

    lowest: Extreme
    highest: Extreme
    rate: Extreme
    acceleration: Extreme


def extremes_at_set_points(trajectory: Trajectory) -> Extremes:
    """Extremes over the set points of a trajectory."""

    def largest(values: FloatArray) -> Extreme:
        where = values.argmax(axis=0)
        return Extreme(values[where, np.arange(values.shape[1])], trajectory.time[where])

    negated = largest(-trajectory.q)
    return Extremes(
        lowest=Extreme(-negated.value, negated.time),
        highest=largest(trajectory.q),
        rate=largest(np.abs(trajectory.qd)),
        acceleration=largest(np.abs(trajectory.qdd)),
    )


def extremes_of_path(path: PPoly[np.float64]) -> Extremes:
    """Exact extremes of the motion: on each piece they lie at its ends or where the next derivative is 0."""

    def candidates(order: int) -> list[tuple[FloatArray, FloatArray]]:
        """Instants and values of each joint's possible extremes."""
        wanted = path.derivative(order) if order else path
        found = []
        for joint in range(wanted.c.shape[2]):
            instants, values = [], []
            for piece, (begin, width) in enumerate(zip(wanted.x, np.diff(wanted.x), strict=False)):
                coefficients = wanted.c[:, piece, joint]
                local = np.concatenate([[0.0, width], _stationary(coefficients, width)])
                instants.append(begin + local)
                values.append(np.polyval(coefficients, local))
            found.append((np.concatenate(instants), np.concatenate(values)))
        return found

    def largest(found: list[tuple[FloatArray, FloatArray]], sign: float | None) -> Extreme:
        picks = [int((np.abs(values) if sign is None else sign * values).argmax()) for _, values in found]
        taken = np.array([values[pick] for (_, values), pick in zip(found, picks, strict=True)])
        instants = np.array([times[pick] for (times, _), pick in zip(found, picks, strict=True)])
        return Extreme(np.abs(taken) if sign is None else taken, instants)

    position = candidates(0)
    return Extremes(
        lowest=largest(position, -1.0),
        highest=largest(position, 1.0),
        rate=largest(candidates(1), None),
        acceleration=largest(candidates(2), None),
    )


def _stationary(coefficients: FloatArray, width: float) -> FloatArray:
    """Where a polynomial, highest power first, may be stationary inside (0, width)."""
    slope = np.polyder(coefficients) * width ** np.arange(len(coefficients) - 2, -1, -1)
    size = np.abs(slope).max(initial=0.0)
    # Below this the joint stands still; the quotients of its coefficients would overflow.
    if size < np.finfo(float).tiny / np.finfo(float).eps:
        return np.empty(0)
    slope = np.where(np.abs(slope) < np.finfo(float).eps * size, 0.0, slope)
    roots = np.roots(slope).real.astype(float)
    return roots[(roots > 0) & (roots < 1)] * width
