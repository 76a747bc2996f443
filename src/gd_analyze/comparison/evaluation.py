"""Any formulation on many set points: chunks that stay in the cache."""

from __future__ import annotations

import numpy as np

from gd_analyze.comparison.methods import Dynamics, Method
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray, set_points_last

# Long enough to hide the cost of an array call, short enough that what one link needs stays in the cache.
CHUNK = 4096


def torque_of_states(
    method: Method, arm: RobotArm, q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> FloatArray:
    """Torque by one method, N m (N), shape (N, n).

    Parameters
    ----------
    method
        One of `METHODS`.
    arm
        The arm.
    q, qd, qdd
        States, shape (N, n).
    """
    states = [set_points_last(np.asarray(x, dtype=float)) for x in (q, qd, qdd)]
    out = np.empty(states[0].shape)
    for chunk in _chunks(len(q)):
        part = (x[:, chunk] for x in states)
        out[:, chunk] = method.torque(arm, *part, gravity=True, cos=np.cos, sin=np.sin)
    return out.T


def dynamics_of_states(method: Method, arm: RobotArm, q: FloatArray, qd: FloatArray) -> Dynamics:
    """D, h and c by one method; arrays with the set points last, see `Dynamics`."""
    q_last, qd_last = (set_points_last(np.asarray(x, dtype=float)) for x in (q, qd))
    parts = [method.dynamics(arm, q_last[:, chunk], qd_last[:, chunk]) for chunk in _chunks(len(q))]
    return Dynamics(
        np.concatenate([part.inertia for part in parts], axis=-1),
        np.concatenate([part.coriolis_centrifugal for part in parts], axis=-1),
        np.concatenate([part.gravity_loading for part in parts], axis=-1),
    )


def _chunks(count: int) -> list[slice]:
    return [slice(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]
