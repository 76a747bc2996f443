"""The recursive Newton-Euler algorithm (RNEA) with every vector in its own link's frame.

[FGL87] section 3.3, Table 3.3 (Luh, Walker and Paul). In link frame i the joint's axis, the link's vectors
and its inertia tensor are constants; only the step from link frame to link frame depends on q_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, FloatArray, cross, rigid_acceleration, turn_parts
from gd_analyze.robots.arm import RobotArm


def torque(
    arm: RobotArm,
    q: Array,
    qd: Array,
    qdd: Array,
    *,
    gravity: bool = True,
    external_wrench: FloatArray | None = None,
) -> Array:
    """Generalized torque by Newton-Euler, shape (n, N); arguments as for `newton_euler_base.torque`."""
    n, count = qd.shape
    cos_q, sin_q = np.cos(q), np.sin(q)
    steps = [_step(arm, i, q[i], cos_q[i], sin_q[i]) for i in range(n)]
    omega = omega_dot = np.zeros((3, count))
    acceleration = np.broadcast_to(-int(gravity) * arm.gravity_vector[:, None], (3, count))
    motions = []
    for i, step in enumerate(steps):
        # Up to the joint's origin with the link before, then into link frame i.
        if step.to_joint is not None:
            acceleration = acceleration + rigid_acceleration(omega, omega_dot, step.to_joint)
        acceleration = step.into(acceleration)
        omega_dot = step.into(omega_dot)
        omega = step.into(omega)
        if arm.is_revolute[i]:
            omega_dot = omega_dot + step.axis * qdd[i] + cross(omega, step.axis * qd[i])
            omega = omega + step.axis * qd[i]
        else:
            acceleration = acceleration + step.axis * qdd[i] + 2.0 * cross(omega, step.axis * qd[i])
        acceleration = acceleration + rigid_acceleration(omega, omega_dot, step.link_vector)
        com_acceleration = acceleration + rigid_acceleration(omega, omega_dot, arm.com[i][:, None])
        inertial_force = arm.mass[i] * com_acceleration
        tensor = arm.inertia_com[i]
        couple = _times(tensor, omega_dot) + cross(omega, _times(tensor, omega))
        motions.append((inertial_force, couple))
    out = np.empty((n, count), np.result_type(q, float))
    # The wrench is constant in the base frame and is transformed to the last link's.
    force, moment = np.zeros((2, 3, 1)) if external_wrench is None else external_wrench[:, :, None]
    for step in steps if external_wrench is not None else ():
        force, moment = step.into(force), step.into(moment)
    for i in reversed(range(n)):
        step = steps[i]
        inertial, couple = motions[i]
        # From here force and moment act about link frame i's origin; the link adds its own.
        moment = moment + cross(arm.com[i][:, None], inertial) + couple
        force = force + inertial
        # About the joint's origin, one link vector below.
        moment = moment + cross(step.link_vector, force)
        effort = moment if arm.is_revolute[i] else force
        out[i] = np.einsum("an,an->n", np.broadcast_to(step.axis, effort.shape), effort)
        moment = step.out_of(moment)
        force = step.out_of(force)
        if step.to_joint is not None:
            moment = moment + cross(step.to_joint, force)
    return out


@dataclass(frozen=True)
class _Step:
    """From link frame i-1 to link frame i."""

    rotation: Array  # of frame i in frame i-1
    # Joint origin in frame i-1; None if it is the frame's own, as in standard Denavit-Hartenberg arms
    to_joint: Array | None
    axis: Array  # z_{i-1} in frame i
    link_vector: Array  # from the joint's origin to link frame i, in frame i; constant for a revolute joint

    def into(self, vector: Array) -> Array:
        """Express a vector of link frame i-1 in link frame i."""
        return np.einsum("ban,bn->an", self.rotation, vector)

    def out_of(self, vector: Array) -> Array:
        """Express a vector of link frame i in link frame i-1."""
        return np.einsum("abn,bn->an", self.rotation, vector)


def _step(arm: RobotArm, i: int, q: Array, cos_q: Array, sin_q: Array) -> _Step:
    joint, frame = arm.joints[i], arm.links[i].frame
    before, behind = joint.placement.rotation, frame.rotation
    axis = behind.T @ joint.axis
    link_vector: Array = (behind.T @ frame.translation)[:, None]
    if arm.is_revolute[i]:
        fixed, by_sin, by_cos = ((before @ part @ behind)[:, :, None] for part in turn_parts(joint.axis))
        rotation = fixed + by_cos * cos_q + by_sin * sin_q
    else:
        rotation = np.broadcast_to((before @ behind)[:, :, None], (3, 3, len(q)))
        link_vector = link_vector + axis[:, None] * q
    to_joint = joint.placement.translation[:, None] if joint.placement.translation.any() else None
    return _Step(rotation, to_joint, axis[:, None], link_vector)


def _times(tensor: Array, vector: Array) -> Array:
    """Multiply by a constant tensor; a diagonal one takes three products."""
    principal = np.diagonal(tensor)
    if np.count_nonzero(tensor - np.diag(principal)) == 0:
        return principal[:, None] * vector
    return np.einsum("ab,bn->an", tensor, vector)
