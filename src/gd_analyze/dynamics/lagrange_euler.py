"""The Lagrange-Euler formulation with 4x4 homogeneous matrices and pseudo-inertia.

[FGL87] section 3.2, for revolute and prismatic joints. In FGL87 joint i moves about or along z_{i-1}, so
dA_i/dq_i = Q_i A_i with a constant Q_i. Here A_j leads from joint frame j-1 (where joint j's axis is fixed)
to joint frame j, which are FGL87's link frames for a Denavit-Hartenberg table; Q_j is the generator of the
joint's own axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from gd_analyze.arrays import Array, homogeneous, product, skew, times_constant, turn_about
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import pseudo_inertia


@dataclass(frozen=True)
class LagrangeEuler:
    """Results of the formulation, set points last."""

    inertia: Array  # D_ik, shape (n, n, N). Eq. (3.2-31)
    christoffel: Array  # h_ikm, shape (n, n, n, N). Eq. (3.2-32)
    gravity_loading: Array  # c_i, shape (n, N). Eq. (3.2-34)

    def coriolis_centrifugal(self, qd: Array) -> Array:
        """h_i = sum_k sum_m h_ikm qd_k qd_m, shape (n, N). Eq. (3.2-33)."""
        return np.einsum("ikmn,kn,mn->in", self.christoffel, qd, qd)


def solve(arm: RobotArm, q: Array) -> LagrangeEuler:
    """D, h_ikm and c at q, shape (n, N)."""
    n, count = q.shape
    dtype = np.result_type(q, float)
    generators = [_generator(arm, i) for i in range(n)]
    first, second = _derivatives(*_steps(arm, q), generators)
    # J_i, Eq. (3.2-18).
    masses = [pseudo_inertia(arm.mass[i], arm.com[i], arm.inertia_com[i]) for i in range(n)]
    inertia = np.zeros((n, n, count), dtype)
    christoffel = np.zeros((n, n, n, count), dtype)
    gravity_loading = np.zeros((n, count), dtype)
    gravity = np.array([*arm.gravity_vector, 0.0])
    for j in range(n):
        com = np.array([*arm.com[j], 1.0])
        weighted = [np.einsum("ab,cbn->acn", masses[j], first[i, j]) for i in range(j + 1)]
        for i in range(j + 1):
            lever = np.einsum("abn,b->an", first[i, j], com)
            gravity_loading[i] += -arm.mass[j] * np.einsum("a,an->n", gravity, lever)
            for k in range(j + 1):
                inertia[i, k] += _trace_of_product(first[k, j], weighted[i])
                for m in range(j + 1):
                    christoffel[i, k, m] += _trace_of_product(second[min(k, m), max(k, m), j], weighted[i])
    return LagrangeEuler(inertia, christoffel, gravity_loading)


def _derivatives(
    base: list[Array], step: list[Array], to_link: dict[tuple[int, int], Array], generators: list[Array]
) -> tuple[dict[tuple[int, int], Array], dict[tuple[int, int, int], Array]]:
    """U_ij and U_ijk by (j, i) and (j, k, i), j <= k <= i. Eqs. (3.2-11), (3.2-13)."""
    n = len(base)
    first: dict[tuple[int, int], Array] = {}
    second: dict[tuple[int, int, int], Array] = {}
    for j in range(n):
        moved = times_constant(base[j], generators[j])
        relative = None
        for k in range(j, n):
            # moved @ relative leads to joint frame k-1; turning by Q_k there gives the second derivative.
            at_k = moved if relative is None else product(moved, relative)
            twice = times_constant(at_k, generators[k])
            for i in range(k, n):
                if k == j:
                    first[j, i] = product(moved, to_link[j, i])
                second[j, k, i] = product(twice, to_link[k, i])
            relative = step[k] if relative is None else product(relative, step[k])
    return first, second


def _steps(arm: RobotArm, q: Array) -> tuple[list[Array], list[Array], dict[tuple[int, int], Array]]:
    """Joint frames in the base, steps between joint frames, and steps to every link frame."""
    n, cos_q, sin_q = arm.n_joints, np.cos(q), np.sin(q)
    before = [homogeneous(joint.placement.rotation, joint.placement.translation) for joint in arm.joints]
    behind = [homogeneous(link.frame.rotation, link.frame.translation) for link in arm.links]
    motions = [_motion(arm, i, q[i], cos_q[i], sin_q[i]) for i in range(n)]
    moved = [times_constant(motion, frame) for motion, frame in zip(motions, behind, strict=True)]
    step = [times_constant(moved[i], before[i + 1]) if i + 1 < n else moved[i] for i in range(n)]
    first = np.broadcast_to(before[0][:, :, None], (4, 4, q.shape[-1])).astype(step[0].dtype)
    base = list(accumulate(step[:-1], product, initial=first))
    to_link: dict[tuple[int, int], Array] = {}
    for j in range(n):
        relative = None
        for i in range(j, n):
            to_link[j, i] = moved[i] if relative is None else product(relative, moved[i])
            relative = step[i] if relative is None else product(relative, step[i])
    return base, step, to_link


def _motion(arm: RobotArm, i: int, q: Array, cos_q: Array, sin_q: Array) -> Array:
    """exp(Q_i q_i): the joint's own displacement in joint frame i-1, shape (4, 4, N)."""
    axis = arm.joints[i].axis
    out = np.zeros((4, 4, len(q)), np.result_type(q, float))
    out[range(4), range(4)] = 1.0
    if arm.is_revolute[i]:
        out[:3, :3] = turn_about(axis, cos_q, sin_q)
    else:
        out[:3, 3] = axis[:, None] * q
    return out


def _generator(arm: RobotArm, i: int) -> Array:
    """Q_i with dA_i/dq_i = Q_i A_i. Eqs. (3.2-8), (3.2-9)."""
    out = np.zeros((4, 4))
    if arm.is_revolute[i]:
        out[:3, :3] = skew(arm.joints[i].axis)
    else:
        out[:3, 3] = arm.joints[i].axis
    return out


def _trace_of_product(a: Array, b: Array) -> Array:
    return np.einsum("abn,ban->n", a, b)
