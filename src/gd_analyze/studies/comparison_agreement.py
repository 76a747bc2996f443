"""Torques of every formulation and of Pinocchio: how far they agree, and how long they take."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.methods import METHODS, Method, torque_of_states
from gd_analyze.dynamics.pinocchio_check import (
    largest_differences,
    pinocchio_dynamics,
    pinocchio_torques,
    round_off_bounds,
)
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm

PINOCCHIO = "pinocchio"
REPEATS = 7

# Products of 4x4 or 3x3 matrices take twice the roundings per joint of rotating a vector, and probing sums
# whole torques: each of two formulations may be off by twice what `round_off_bounds` allows.
_ROUNDINGS = 4


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest differences over all joints and set points, SI units.

    Parameters
    ----------
    names
        The methods, and "pinocchio" last.
    torque
        Largest difference of torque between any two of them, N m (N), shape (m, m).
    from_pinocchio
        By method and quantity (D, h, c and torque): largest difference from Pinocchio.
    bounds
        What round-off explains, by quantity.
    """

    names: tuple[str, ...]
    torque: FloatArray
    from_pinocchio: Mapping[str, Mapping[str, float]]
    bounds: Mapping[str, float]

    @property
    def largest(self) -> float:
        """Largest difference of torque between any two, N m (N)."""
        return float(self.torque.max())

    @property
    def holds(self) -> bool:
        """Whether round-off explains every difference."""
        return bool(self.torque.max() <= self.bounds["torque"]) and all(
            row[quantity] <= self.bounds[quantity]
            for row in self.from_pinocchio.values()
            for quantity in self.bounds
        )

    def worst_of(self, name: str) -> float:
        """Largest difference of one method's torque from any other, N m (N)."""
        return float(self.torque[self.names.index(name)].max())


def agreement(arm: RobotArm, states: States, *, methods: Mapping[str, Method] = METHODS) -> Agreement:
    """Compare torque, D, h and c of methods at the same states; recursions are probed for D, h and c."""
    q_last, qd_last, _ = states.last
    theirs = pinocchio_dynamics(arm, *states.arrays)
    torques, from_pinocchio = [], {}
    for name, method in methods.items():
        torques.append(torque_of_states(method, arm, *states.arrays))
        given = method.dynamics(arm, q_last, qd_last)
        ours = {
            "inertia": np.moveaxis(given.inertia, -1, 0),
            "coriolis_centrifugal": given.coriolis_centrifugal.T,
            "gravity_loading": given.gravity_loading.T,
            "torque": torques[-1],
        }
        from_pinocchio[name] = largest_differences(ours, theirs)
    torques.append(theirs["torque"])
    differences = np.array([[np.abs(a - b).max() for b in torques] for a in torques])
    bounds = {name: _ROUNDINGS * float(b) for name, b in round_off_bounds(arm, *states.arrays).items()}
    return Agreement((*methods, PINOCCHIO), differences, from_pinocchio, bounds)


@dataclass(frozen=True)
class Timing:
    """Seconds per set point, the median over repeats.

    Parameters
    ----------
    seconds
        By method; one array call per operation and chunk of set points.
    pinocchio
        A Python loop over Pinocchio's `rnea` at the same set points, between ours.
    set_points, repeats
        How many.
    """

    seconds: Mapping[str, float]
    pinocchio: float
    set_points: int
    repeats: int


def time_methods(
    arm: RobotArm,
    states: States,
    *,
    repeats: int = REPEATS,
    progress: Callable[[int], None] = lambda done: None,
) -> Timing:
    """Time the torque of every method and of Pinocchio, in turn, on one thread.

    A first run of each is not counted. `progress` is called with 1 after every round.
    """
    works: dict[str, Callable[[], object]] = {
        name: partial(torque_of_states, method, arm, *states.arrays) for name, method in METHODS.items()
    }
    works[PINOCCHIO] = pinocchio_torques(arm, *states.arrays)
    taken: dict[str, list[float]] = {name: [] for name in works}
    for repeat in range(repeats + 1):
        # In turn, so that a machine whose speed drifts slows all alike.
        for name, work in works.items():
            start = time.perf_counter()
            work()
            if repeat:
                taken[name].append(time.perf_counter() - start)
        progress(1)
    per_set_point = {name: median(times) / len(states) for name, times in taken.items()}
    pinocchio = per_set_point.pop(PINOCCHIO)
    return Timing(per_set_point, pinocchio, len(states), repeats)
