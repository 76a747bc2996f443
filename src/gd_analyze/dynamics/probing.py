"""D, h, h_ijk and c from nothing but torque calls.

[FGL87] problems 3.11 and 3.12; Walker and Orin (1982). Any inverse dynamics will do: it is asked for the
torque at states that make all but one of its terms vanish.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from gd_analyze.arrays import Array


class InverseDynamics(Protocol):
    """Torque (n, N) at velocities and accelerations (n, N) of fixed positions, with or without gravity."""

    def __call__(self, qd: Array, qdd: Array, *, gravity: bool) -> Array:
        """Evaluate the torque."""
        ...


def inertia(torque: InverseDynamics, n: int, count: int) -> Array:
    """D, shape (n, n, N): column j is the torque of a unit acceleration of joint j, at rest, without gravity.

    n calls.
    """
    still = np.zeros((n, count))
    return np.stack([torque(still, _unit(n, j, count), gravity=False) for j in range(n)], axis=1)


def gravity_loading(torque: InverseDynamics, n: int, count: int) -> Array:
    """c, shape (n, N): the torque at rest. One call."""
    still = np.zeros((n, count))
    return torque(still, still, gravity=True)


def coriolis_centrifugal(torque: InverseDynamics, qd: Array) -> Array:
    """h, shape (n, N): the torque of velocities alone. One call."""
    return torque(qd, np.zeros(qd.shape), gravity=False)


def christoffel(torque: InverseDynamics, n: int, count: int) -> Array:
    """h_ijk, shape (n, n, n, N), by polarisation: h(e_j + e_k) - h(e_j) - h(e_k) = 2 h_jk.

    n (n + 1) / 2 calls.
    """
    still = np.zeros((n, count))
    alone = [torque(_unit(n, j, count), still, gravity=False) for j in range(n)]
    out = np.empty((n, n, n, count), alone[0].dtype)
    for j in range(n):
        out[:, j, j] = alone[j]
        for k in range(j + 1, n):
            both = torque(_unit(n, j, count) + _unit(n, k, count), still, gravity=False)
            out[:, j, k] = out[:, k, j] = 0.5 * (both - alone[j] - alone[k])
    return out


def _unit(n: int, j: int, count: int) -> Array:
    out = np.zeros((n, count))
    out[j] = 1.0
    return out
