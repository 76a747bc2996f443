"""What every formulation gives, and how it is called: an arm and one chunk of set points, set points last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks, set_points_last
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class Dynamics:
    """D (n, n, N), h (n, N) and c (n, N) of one method."""

    inertia: Array
    coriolis_centrifugal: Array
    gravity_loading: Array


class TorqueOf(Protocol):
    """Torque (n, N) of an arm at q, qd, qdd (n, N)."""

    def __call__(self, arm: RobotArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True) -> Array:
        """Evaluate the torque."""
        ...


# D, h and c of an arm at q, qd (n, N).
DynamicsOf = Callable[[RobotArm, Array, Array], Dynamics]


@dataclass(frozen=True, eq=False)
class Method:
    """One formulation.

    Parameters
    ----------
    name, title, short
        Identifier, display name, and display name where there is little room.
    source
        Where it is derived.
    kinematics
        How it represents kinematics, and `form` the form of its equations, as in [FGL87] Table 3.5.
    growth
        Order of its operations in the number of joints.
    torque
        Its torque.
    dynamics
        Its D, h and c at q and qd; recursions are probed for theirs.
    """

    name: str
    title: str
    short: str
    source: str
    kinematics: str
    form: str
    growth: str
    torque: TorqueOf
    dynamics: DynamicsOf


def torque_of_states(
    method: Method, arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Torque by one method, N m (N), of any number of states, shape (N, n) as q, qd and qdd."""
    states = [set_points_last(np.asarray(x, dtype=float)) for x in (q, qd, qdd)]
    out = np.empty(states[0].shape)
    for chunk in chunks(len(q)):
        part = (x[:, chunk] for x in states)
        out[:, chunk] = method.torque(arm, *part)
    return out.T
