"""Hollerbach's recursive Lagrangian formulation with 3x3 matrices.

J. M. Hollerbach, A recursive Lagrangian formulation of manipulator dynamics and a comparative study of
dynamics formulation complexity, IEEE Transactions on Systems, Man, and Cybernetics 10(11), 1980, section IV.

With the rotation W_j of link frame j, its origin p_j, and the first and second moments n_j and J_j of link j
about that origin in its own frame, Lagrange's equations are

    tau_i = sum_{j>=i} tr[ dW_j/dq_i (n_j p_j''^T + J_j W_j''^T) ] + dp_j/dq_i . (m_j p_j'' + W_j'' n_j)

W, W', W'' and p'' propagate outward; the sums over j inward, in link frame i:

    e_i = e_{i+1} + m_i p_i'' + W_i'' n_i
    D_i = R_{i+1} D_{i+1} + (p_{i+1} in frame i) e_{i+1}^T + n_i p_i''^T + J_i W_i''^T

No angular velocity appears; gravity enters as an acceleration of the base.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, apply, dot, outer, product, times_constant, turn_parts
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import second_moment_about_origin


def torque(arm: RobotArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True) -> Array:
    """Generalized torque by the recursive Lagrangian, shape (n, N)."""
    n, count = qd.shape
    cos_q, sin_q = np.cos(q), np.sin(q)
    steps = [_step(arm, i, q[i], cos_q[i], sin_q[i]) for i in range(n)]
    w: Array = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count))
    w1 = w2 = np.zeros((3, 3, count))
    p2: Array = np.broadcast_to(-int(gravity) * arm.gravity[:, None], (3, count))
    slopes, origins, rotations = [], [], []
    for i, step in enumerate(steps):
        # With the step's position s and rotation R in frame i-1: p_i = p + W s, W_i = W R.
        s1, s2 = step.place_slope * qd[i], step.place_slope * qdd[i] + step.place_curve * (qd[i] * qd[i])
        r1, r2 = step.slope * qd[i], step.slope * qdd[i] + step.curve * (qd[i] * qd[i])
        slopes.append((product(w, step.slope), apply(w, step.place_slope)))
        p2 = p2 + apply(w2, step.place) + 2.0 * apply(w1, s1) + apply(w, s2)
        w, w1, w2 = (
            product(w, step.rotation),
            product(w1, step.rotation) + product(w, r1),
            product(w2, step.rotation) + 2.0 * product(w1, r1) + product(w, r2),
        )
        origins.append(p2)
        rotations.append(w2)
    out = np.empty((n, count), np.result_type(q, float))
    e: Array = np.zeros((3, count))
    big_d: Array = np.zeros((3, 3, count))
    for i in reversed(range(n)):
        first = (arm.mass[i] * arm.com[i])[:, None]
        second = second_moment_about_origin(arm.mass[i], arm.com[i], arm.inertia_com[i])
        if i + 1 < n:
            big_d = product(steps[i + 1].rotation, big_d) + outer(steps[i + 1].place, e)
        e = e + arm.mass[i] * origins[i] + apply(rotations[i], first)
        big_d = big_d + outer(first, origins[i]) + np.einsum("ab,cbn->acn", second, rotations[i])
        turning, moving = slopes[i]
        out[i] = np.einsum("abn,ban->n", turning, big_d) + dot(moving, e)
    return out


@dataclass(frozen=True)
class _Step:
    """Rotation R(q) and position s(q) of link frame i in frame i-1, with their derivatives by q."""

    rotation: Array
    slope: Array
    curve: Array
    place: Array
    place_slope: Array
    place_curve: Array


def _step(arm: RobotArm, i: int, q: Array, cos_q: Array, sin_q: Array) -> _Step:
    joint, frame = arm.joints[i], arm.links[i].frame
    before, behind = joint.placement.rotation, frame.rotation
    base, offset = joint.placement.translation[:, None], frame.translation
    zero = np.zeros((3, 3, len(q)))
    if not arm.is_revolute[i]:
        constant = np.broadcast_to((before @ behind)[:, :, None], zero.shape)
        axis = (before @ joint.axis)[:, None]
        place = base + (before @ offset)[:, None] + axis * q
        return _Step(constant, zero, zero, place, np.broadcast_to(axis, place.shape), np.zeros(place.shape))
    # Each derivative of the turn advances sin and cos by one.
    fixed, by_sin, by_cos = (before @ part for part in turn_parts(joint.axis))
    turn = fixed[:, :, None] + by_sin[:, :, None] * sin_q + by_cos[:, :, None] * cos_q
    slope = by_sin[:, :, None] * cos_q - by_cos[:, :, None] * sin_q
    curve = -(by_sin[:, :, None] * sin_q + by_cos[:, :, None] * cos_q)
    turned = [times_constant(matrix, behind) for matrix in (turn, slope, curve)]
    placed = [np.einsum("abn,b->an", matrix, offset) for matrix in (turn, slope, curve)]
    return _Step(turned[0], turned[1], turned[2], base + placed[0], placed[1], placed[2])
