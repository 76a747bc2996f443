"""A second derivation to hold vectors against: 4x4 transforms, and derivatives by a complex step.

It shares no formula with the kinematics of the package: no axis, no vector product. Energies by effect rest
on the Lagrange-Euler formulation, which shares none with the generalized d'Alembert form: a link's mass at
its centre of mass (translation) and its matter about it (rotation) are two arms, and D is linear in them. All
of it accepts complex q: Im f(q + i e dq) / e is then the derivative of f along dq to the last bits, with
nothing subtracted.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import lagrange_euler
from gd_analyze.types import Joint, Link, Placement, RobotArm

Array = NDArray[Any]
_STEP = 1e-40


def derivative(f: Callable[[Array], Array], x: FloatArray, direction: FloatArray) -> FloatArray:
    """Directional derivative by a complex step."""
    return np.imag(f(x + 1j * _STEP * direction)) / _STEP


def link_frames(arm: RobotArm, q: Array) -> Array:
    """0A_i of states (N, n), shape (n, N, 4, 4)."""
    frames = []
    frame = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for i in range(arm.n_joints):
        frame = frame @ _link_transform(arm.joints[i], arm.links[i], q[:, i])
        frames.append(frame)
    return np.array(frames)


def of_one_effect(arm: RobotArm) -> tuple[RobotArm, RobotArm]:
    """The arm of point masses (translation) and the arm of massless matter (rotation)."""
    return tuple(
        dataclasses.replace(arm, links=tuple(dataclasses.replace(link, **change) for link in arm.links))
        for change in ({"inertia_com": np.zeros((3, 3))}, {"mass": 0.0})
    )


def inertia(arm: RobotArm, q: Array) -> Array:
    """D by effect, shape (2, n, n, N). [FGL87] Eq. (3.2-31)."""
    return np.array([lagrange_euler.solve(part, q.T).inertia for part in of_one_effect(arm)])


def h_ikm(arm: RobotArm, q: FloatArray) -> FloatArray:
    """h_ikm by effect, shape (2, n, n, n, N). [FGL87] Eq. (3.2-32)."""
    return np.array([lagrange_euler.solve(part, q.T).christoffel for part in of_one_effect(arm)])


def christoffel(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Christoffel symbols of D by effect, shape (2, n, n, n, N): h_ijk of Lagrange's equation."""
    n = arm.n_joints
    slope = np.array([derivative(lambda x: inertia(arm, x), q, direction) for direction in np.eye(n)])
    return 0.5 * (
        np.einsum("keijN->eijkN", slope) + np.einsum("jeikN->eijkN", slope) - np.einsum("iejkN->eijkN", slope)
    )


def potential_energy(arm: RobotArm, q: Array) -> Array:
    """- sum_s m_s g . r_s, shape (N,)."""
    points = np.array([np.append(link.com, 1.0) for link in arm.links])
    com = np.einsum("sNab,sb->sNa", link_frames(arm, q), points)[..., :3]
    return -np.einsum("s,a,sNa->N", arm.mass, arm.gravity_vector, com)


def kinetic_energy(arm: RobotArm, q: Array, qd: Array) -> Array:
    """By effect, shape (2, N)."""
    return 0.5 * np.einsum("Ni,eijN,Nj->eN", qd, inertia(arm, q), qd)


def _link_transform(joint: Joint, link: Link, q: Array) -> Array:
    x, y, z = joint.axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    moved = np.zeros((len(q), 4, 4), dtype=q.dtype)
    moved[:] = np.eye(4)
    if joint.kind == "revolute":
        angle = q[:, None, None]
        moved[:, :3, :3] = np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * (skew @ skew)
    else:
        moved[:, :3, 3] = joint.axis * q[:, None]
    return _matrix(joint.placement) @ moved @ _matrix(link.frame)


def _matrix(placement: Placement) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = placement.rotation, placement.translation
    return matrix
