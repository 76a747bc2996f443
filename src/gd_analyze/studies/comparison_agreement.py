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
    pinocchio_dynamics,
    pinocchio_torques,
    round_off_bounds,
)
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm

PINOCCHIO = "pinocchio"
REPEATS = 7  # of timings

# Products of 4x4 or 3x3 matrices take twice the roundings per joint of rotating a vector, and probing sums
# whole torques: each of two formulations may be off by twice what `round_off_bounds` allows.
_ROUNDINGS = 4


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest differences over all joints and set points, SI units."""

    names: tuple[str, ...]  # the m methods, and "pinocchio" last
    torque: FloatArray  # between any two of them, N m (N), (m + 1, m + 1)
    from_pinocchio: Mapping[str, Mapping[str, float]]  # by method and quantity: D, h, c and torque
    bounds: Mapping[str, float]  # what round-off explains, by quantity

    @property
    def largest(self) -> float:
        """Largest difference of torque between any two, N m (N)."""
        return float(self.torque.max())

    @property
    def holds(self) -> bool:
        """Whether round-off explains every difference."""
        return self.largest <= self.bounds["torque"] and all(
            row[quantity] <= bound
            for row in self.from_pinocchio.values()
            for quantity, bound in self.bounds.items()
        )


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
        from_pinocchio[name] = {of: float(np.abs(ours[of] - value).max()) for of, value in theirs.items()}
    torques.append(theirs["torque"])
    differences = np.array([[np.abs(a - b).max() for b in torques] for a in torques])
    bounds = {name: _ROUNDINGS * float(b) for name, b in round_off_bounds(arm, *states.arrays).items()}
    return Agreement((*methods, PINOCCHIO), differences, from_pinocchio, bounds)


def time_methods(
    arm: RobotArm, states: States, progress: Callable[[int], None] = lambda done: None
) -> dict[str, float]:
    """Median seconds per set point of every method and, last, of a Python loop over Pinocchio's `rnea`.

    All run in turn on one thread, ours as one array call per operation and chunk of set points. A first round
    is not counted; `progress` is called with 1 after every round.
    """
    works: dict[str, Callable[[], object]] = {
        name: partial(torque_of_states, method, arm, *states.arrays) for name, method in METHODS.items()
    }
    works[PINOCCHIO] = pinocchio_torques(arm, *states.arrays)
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(REPEATS + 1):
        # In turn, so that a machine whose speed drifts slows all alike.
        for name, work in works.items():
            start = time.perf_counter()
            work()
            taken[name].append(time.perf_counter() - start)
        progress(1)
    return {name: median(times[1:]) / len(states) for name, times in taken.items()}
