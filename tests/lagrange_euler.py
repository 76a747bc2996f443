"""A second derivation to hold the formulations against: Lagrange-Euler, with 4x4 transforms.

[FGL87] section 3.2. It shares no formula with the generalized d'Alembert form: no axis, no vector product.
The pseudo-inertia of a link splits into its mass at the centre of mass (translation) and its matter about
it (rotation), hence D_ik = sum_j Tr(U_jk J_j U_ji^T) by effect, Eq. (3.2-31). All of it accepts complex q:
Im f(q + i e dq) / e is then the derivative of f along dq to the last bits, with nothing subtracted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.robots import Joint, Link, Placement, RobotArm
from gd_analyze.vectors import FloatArray

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


def frame_rates(arm: RobotArm, q: Array) -> Array:
    """U_ij = d 0A_i / d q_j, shape (n, n, N, 4, 4). [FGL87] Eq. (3.2-11)."""
    n = arm.n_joints
    rates = np.zeros((n, n, len(q), 4, 4), dtype=q.dtype)
    for j in range(n):
        frame = np.broadcast_to(np.eye(4), (len(q), 4, 4))
        for i in range(n):
            factor = _link_transform if i != j else _link_transform_rate
            frame = frame @ factor(arm.joints[i], arm.links[i], q[:, i])
            if i >= j:
                rates[i, j] = frame
    return rates


def pseudo_inertia(link: Link) -> FloatArray:
    """J by effect about the link frame's origin, shape (2, 4, 4). [FGL87] Eq. (3.2-18)."""
    point = np.append(link.com, 1.0)
    about_com = np.zeros((4, 4))
    about_com[:3, :3] = 0.5 * np.trace(link.inertia_com) * np.eye(3) - link.inertia_com
    return np.array([link.mass * np.outer(point, point), about_com])


def inertia(arm: RobotArm, q: Array) -> Array:
    """D by effect, shape (2, n, n, N). [FGL87] Eq. (3.2-31)."""
    rates = frame_rates(arm, q)
    pseudo = np.array([pseudo_inertia(link) for link in arm.links])
    momenta = np.einsum("skNab,sebc->eskNac", rates, pseudo)
    return np.einsum("eskNac,siNac->eikN", momenta, rates)


def coupling(arm: RobotArm, q: FloatArray) -> FloatArray:
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
    return -np.einsum("s,a,sNa->N", arm.mass, arm.gravity, com)


def kinetic_energy(arm: RobotArm, q: Array, qd: Array) -> Array:
    """By effect, shape (2, N)."""
    return 0.5 * np.einsum("Ni,eijN,Nj->eN", qd, inertia(arm, q), qd)


def _link_transform(joint: Joint, link: Link, q: Array) -> Array:
    skew = _skew(joint.axis)
    moved = np.zeros((len(q), 4, 4), dtype=q.dtype)
    moved[:] = np.eye(4)
    if joint.kind == "revolute":
        angle = q[:, None, None]
        moved[:, :3, :3] = np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * (skew @ skew)
    else:
        moved[:, :3, 3] = joint.axis * q[:, None]
    return _matrix(joint.placement) @ moved @ _matrix(link.frame)


def _link_transform_rate(joint: Joint, link: Link, q: Array) -> Array:
    skew = _skew(joint.axis)
    moved = np.zeros((len(q), 4, 4), dtype=q.dtype)
    if joint.kind == "revolute":
        angle = q[:, None, None]
        moved[:, :3, :3] = np.cos(angle) * skew + np.sin(angle) * (skew @ skew)
    else:
        moved[:, :3, 3] = joint.axis
    return _matrix(joint.placement) @ moved @ _matrix(link.frame)


def _matrix(placement: Placement) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = placement.rotation, placement.translation
    return matrix


def _skew(axis: FloatArray) -> FloatArray:
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
