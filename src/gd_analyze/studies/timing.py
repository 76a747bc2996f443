"""How long every formulation takes per set point, beside Pinocchio in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.methods import METHODS, torque_of_states
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.agreement import PINOCCHIO

N_SET_POINTS = 2000
REPEATS = 7


@dataclass(frozen=True)
class Timing:
    """Seconds per set point.

    Parameters
    ----------
    seconds
        By method, median over the repeats; one array call per operation and chunk of set points.
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
    """Time the torque of every method and of Pinocchio, in turn.

    All run on one thread: none of them calls a library that would start more.

    Parameters
    ----------
    arm, states
        The arm and its states.
    repeats
        How often each runs; a first run of each is not counted.
    progress
        Called with the number of repeats done since the last call.
    """
    works: dict[str, Callable[[], object]] = {
        name: partial(torque_of_states, method, arm, *states.arrays) for name, method in METHODS.items()
    }
    works[PINOCCHIO] = _pinocchio_loop(arm, *states.arrays)
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


def _pinocchio_loop(arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> Callable[[], object]:
    import pinocchio as pin

    model = pinocchio_model(arm)
    data = model.createData()

    def loop() -> FloatArray:
        out = np.empty(q.shape)
        for k in range(len(q)):
            out[k] = pin.rnea(model, data, q[k], qd[k], qdd[k])
        return out

    return loop
