r"""The generalized d'Alembert elements from the moments of composite links.

FGL87 sums over links s for every element, Eqs. (3.4-25) to (3.4-28). Each of those sums is a
moment of the composite of links m..n, taken about the origin of joint m, so suffix sums do them all at once:

    mass            M_m = sum_{s>=m} m_s
    first moment    S_m = sum_{s>=m} m_s rho_s,            rho_s = r_s - p_{m-1}
    second moment   P_m = sum_{s>=m} m_s rho_s rho_s^T     translation: masses at the centres of mass
                    P_m = sum_{s>=m} R_s (tr(I_s)/2 - I_s) R_s^T      rotation: matter about those centres

The translational and rotational effects differ only in P. With w_m = z_{m-1}, u_m = 0 for a revolute joint
and w_m = 0, u_m = z_{m-1} for a prismatic one, the velocity that joint m gives the point r is v_m(r) = w_m x
(r - p_{m-1}) + u_m, and for i, l <= m

    f_m   = sum m_s v_m(r_s) = w_m x S_m + M_m u_m
    D_im  = sum m_s v_i(r_s) . v_m(r_s)      = w_i . (tr(P_m) w_m - P_m w_m + S_m x u_m) + v_i(p_{m-1}) . f_m
    h_ilm = sum m_s v_i(r_s) . (w_l x v_m(r_s))
          = w_l . B_im,   B_im = P_m (w_m x w_i) + f_m x v_i(p_{m-1}) + u_m x (w_i x S_m)
    c_m   = - g . f_m

where S, f and u belong to translation only. D_im does not depend on q_1..q_i, hence h_mli = -h_ilm for l <= i
<= m: the brackets B_im of the pairs i < m hold all of h. Summed over l and k with the velocities,

    h_i = sum_{m>i} a_m . B_im - sum_{k<i} a_k . B_ki,   a_m = qd_m (2 sum_{l<m} w_l qd_l + w_m qd_m)

of which a_m = w_m qd_m^2 is the centrifugal share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, apply, cross, dot, outer, times_constant
from gd_analyze.dynamics.kinematics import Kinematics, joint_motions
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import second_moment

TRANSLATION, ROTATION = 0, 1


@dataclass(frozen=True)
class CompositeMoments:
    """Moments of the composites of links m..n about p_{m-1}, in the base frame, set points last."""

    # w_m and u_m, shape (n, 3, N); `prismatic` is None for an arm of revolute joints only
    revolute: Array
    prismatic: Array | None
    origins: Array  # p_{m-1}, shape (n, 3, N)
    mass: Array  # M_m, shape (n,)
    first: Array  # S_m, shape (n, 3, N)
    second: Array  # P_m of both effects, shape (2, n, 3, 3, N)
    momentum: Array  # f_m, shape (n, 3, N)
    # v_i(p_{m-1}) of every pair i < m, ordered as `pairs_of` says, shape (n (n - 1) / 2, 3, N)
    origin_velocities: Array


def composite_moments(arm: RobotArm, kinematics: Kinematics) -> CompositeMoments:
    """Sum the links' moments from the last link to the first."""
    n, count = arm.n_joints, kinematics.joint_axes.shape[-1]
    origins = kinematics.joint_origins
    # Without prismatic joints multiplications by zero are skipped.
    revolute, prismatic = (
        (kinematics.joint_axes, None) if all(arm.is_revolute) else joint_motions(arm, kinematics)
    )
    mass = np.cumsum(arm.mass[::-1])[::-1]
    first = np.empty_like(origins)
    second = np.empty((2, n, 3, 3, count), origins.dtype)
    for s in reversed(range(n)):
        com = kinematics.com_from_joint[s]
        matter = second_moment(arm.inertia_com[s])
        rotation = kinematics.link_rotations[s]
        first[s] = arm.mass[s] * com
        second[TRANSLATION, s] = outer(first[s], com)
        second[ROTATION, s] = _turned_tensor(rotation, matter)
        if s + 1 < n:
            step = origins[s + 1] - origins[s]
            half = outer(first[s + 1] + 0.5 * mass[s + 1] * step, step)
            first[s] += first[s + 1] + mass[s + 1] * step
            second[TRANSLATION, s] += half + np.swapaxes(half, 0, 1)
            second[:, s] += second[:, s + 1]
    momentum = cross(revolute, first)
    if prismatic is not None:
        momentum += mass[:, None, None] * prismatic
    velocities = np.empty((n * (n - 1) // 2, 3, count), origins.dtype)
    for m in range(1, n):
        velocity = cross(revolute[:m], origins[m] - origins[:m], out=velocities[pairs_of(m)])
        if prismatic is not None:
            velocity += prismatic[:m]
    return CompositeMoments(revolute, prismatic, origins, mass, first, second, momentum, velocities)


def pairs_of(m: int) -> slice:
    """Slice of the pairs i < m of outer joint m: pairs are ordered by m, then i."""
    start = m * (m - 1) // 2
    return slice(start, start + m)


def inertia(moments: CompositeMoments, out: Array | None = None) -> Array:
    """D by effect, the mass matrix from composite bodies (CRBA), shape (2, n, n, N). [FGL87] Eq. (3.4-25)."""
    n, w = len(moments.mass), moments.revolute
    out = np.empty((2, n, n, moments.first.shape[-1]), moments.first.dtype) if out is None else out
    for m in range(n):
        second = moments.second[:, m]
        trace = second[:, 0, 0] + second[:, 1, 1] + second[:, 2, 2]
        angular = trace[:, None] * w[m] - apply(second, w[m])
        if moments.prismatic is not None:
            angular[TRANSLATION] += cross(moments.first[m], moments.prismatic[m])
        column = np.einsum("ian,ean->ein", w[: m + 1], angular, out=out[:, : m + 1, m])
        column[TRANSLATION, :m] += dot(moments.origin_velocities[pairs_of(m)], moments.momentum[m])
        if moments.prismatic is not None:
            column[TRANSLATION, m] += dot(moments.prismatic[m], moments.momentum[m])
        out[:, m, :m] = column[:, :m]
    return out


def brackets(moments: CompositeMoments) -> Array:
    """B_im of every pair i < m by effect, ordered as `pairs_of` says, shape (2, n (n - 1) / 2, 3, N)."""
    n, w = len(moments.mass), moments.revolute
    velocities = moments.origin_velocities
    out = np.empty((2, *velocities.shape), velocities.dtype)
    for m in range(1, n):
        pairs = pairs_of(m)
        np.einsum("eabn,ibn->eian", moments.second[:, m], cross(w[m], w[:m]), out=out[:, pairs])
        out[TRANSLATION, pairs] += cross(moments.momentum[m], velocities[pairs])
        if moments.prismatic is not None:
            out[TRANSLATION, pairs] += cross(moments.prismatic[m], cross(w[:m], moments.first[m]))
    return out


def christoffel(moments: CompositeMoments, pairs: Array, out: Array | None = None) -> Array:
    """h_ijk by effect from the `brackets`, shape (2, n, n, n, N). [FGL87] Eqs. (3.4-26), (3.4-27)."""
    n, w = len(moments.mass), moments.revolute
    out = np.empty((2, n, n, n, moments.first.shape[-1]), moments.first.dtype) if out is None else out
    for m in range(n):
        slab = np.einsum("eian,lan->eiln", pairs[:, pairs_of(m)], w[: m + 1], out=out[:, :m, : m + 1, m])
        out[:, :m, m, :m] = slab[:, :, :m]
        out[:, m, : m + 1, m] = out[:, m, m, :m] = 0.0
        for i in range(m):
            np.negative(slab[:, i, : i + 1], out=out[:, m, : i + 1, i])
            out[:, m, i, :i] = out[:, m, :i, i]
    return out


def coriolis_centrifugal(moments: CompositeMoments, pairs: Array, qd: Array) -> tuple[Array, Array]:
    """Vector h by effect and its centrifugal share, each (2, n, N). [FGL87] Eqs. (3.4-26), (3.4-27)."""
    n, count = qd.shape
    spins = moments.revolute * qd[:, None]
    below = np.cumsum(spins, axis=0) - spins
    factors = np.stack([2.0 * below + spins, spins]) * qd[:, None]
    out = np.zeros((2, 2, n, count), moments.first.dtype)
    for m in range(1, n):
        of_m = pairs[:, pairs_of(m)]
        out[:, :, :m] += np.einsum("eian,kan->kein", of_m, factors[:, m])
        out[:, :, m] -= np.einsum("eian,kian->ken", of_m, factors[:, :m])
    return out[0], out[1]


def gravity_loading(arm: RobotArm, moments: CompositeMoments) -> Array:
    """c_i = -g . f_i, shape (n, N). [FGL87] Eq. (3.4-28)."""
    return -np.einsum("a,ian->in", arm.gravity_vector, moments.momentum)


def _turned_tensor(rotation: Array, constant: Array) -> Array:
    """R T R^T; principal axes along the frame's save a product of matrices."""
    principal = np.diagonal(constant)
    is_diagonal = np.count_nonzero(constant - np.diag(principal)) == 0
    turned = rotation * principal[:, None] if is_diagonal else times_constant(rotation, constant)
    return np.einsum("acn,bcn->abn", turned, rotation)
