"""The generalized d'Alembert equations as written in FGL87: link by link, term by term.

[FGL87] section 3.4, extended to prismatic joints: w_j = z_{j-1} for a revolute joint, u_j = z_{j-1} for a
prismatic one, and z_{j-1} x (r_s - p_{j-1}) becomes the velocity v_js = w_j x (r_s - p_{j-1}) + u_j. A
prismatic joint k adds one more Coriolis acceleration, 2 w_{k-1} x u_k qd_k, to FGL87's four.

This path is slow and fully itemized; `composite_moments` gives the sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, cross, dot
from gd_analyze.dynamics.kinematics import Kinematics, joint_motions
from gd_analyze.robots.arm import RobotArm

EFFECTS = ("translation", "rotation")


@dataclass(frozen=True)
class Term:
    """One term of h in FGL87: its effect and its meaning."""

    name: str
    effect: str
    meaning: str


TERMS = (
    Term("T1", "translation", "centrifugal and Coriolis, from the links below s: w_k x (w_k x p_k*)"),
    Term("T2", "translation", "Coriolis, from the links below s: b_k x p_k*"),
    Term("T3", "translation", "centrifugal and Coriolis, from link s itself: w_s x (w_s x c_s)"),
    Term("T4", "translation", "Coriolis, from link s itself: b_s x c_s"),
    Term("R1", "rotation", "Coriolis: I_s times the change of the axes"),
    Term("R2", "rotation", "centrifugal and Coriolis: gyroscopic couple of link s"),
)
PRISMATIC_TERM = Term("T5", "translation", "Coriolis, from prismatic joints: 2 w_{k-1} x u_k qd_k")


def terms_of(arm: RobotArm) -> tuple[Term, ...]:
    """Terms of h: FGL87's six, and a seventh for an arm with prismatic joints."""
    return TERMS if all(arm.is_revolute) else (*TERMS, PRISMATIC_TERM)


def inertia_by_link(arm: RobotArm, kinematics: Kinematics) -> Array:
    """What each link adds to D by effect, shape (2, n links, n, n, N). [FGL87] Eq. (3.4-25)."""
    n, count = arm.n_joints, kinematics.joint_axes.shape[-1]
    revolute, _ = motions = joint_motions(arm, kinematics)
    out = np.zeros((2, n, n, n, count), kinematics.joint_axes.dtype)
    for s in range(n):
        velocity = [_com_velocity(kinematics, motions, i, s) for i in range(s + 1)]
        in_link = [_into_link(kinematics, s, revolute[i]) for i in range(s + 1)]
        for i in range(s + 1):
            momentum = np.einsum("ab,bn->an", arm.inertia_com[s], in_link[i])
            for j in range(s + 1):
                out[0, s, i, j] = arm.mass[s] * dot(velocity[j], velocity[i])
                out[1, s, i, j] = dot(in_link[j], momentum)
    return out


def coriolis_centrifugal_by_link(arm: RobotArm, kinematics: Kinematics, qd: Array) -> Array:
    """What each link adds to the `terms_of` h, (n terms, n links, n, N). [FGL87] Eqs. (3.4-26), (3.4-27)."""
    n, count = qd.shape
    revolute, prismatic = motions = joint_motions(arm, kinematics)
    terms = terms_of(arm)
    out = np.zeros((len(terms), n, n, count), kinematics.joint_axes.dtype)
    spin = revolute * qd[:, None]
    omega = np.cumsum(spin, axis=0)
    before = np.concatenate([np.zeros_like(omega[:1]), omega[:-1]])
    b = np.cumsum(cross(before, spin), axis=0)
    steps = kinematics.joint_origins[1:] - kinematics.joint_origins[:-1]
    inboard = np.zeros((2, 3, count), out.dtype)
    of_prismatic = np.zeros((3, count), out.dtype)
    for s in range(n):
        com = kinematics.com_from_joint[s]
        of_prismatic = of_prismatic + 2.0 * cross(before[s], prismatic[s] * qd[s])
        accelerations = [*inboard, cross(omega[s], cross(omega[s], com)), cross(b[s], com)]
        spins = [_into_link(kinematics, s, spin[j]) for j in range(s + 1)]
        turning_axes = np.zeros_like(spins[0])
        for j in range(s):
            turning_axes = turning_axes + cross(spins[j], sum(spins[j + 2 :], start=spins[j + 1]))
        of_turning_axes = np.einsum("ab,bn->an", arm.inertia_com[s], turning_axes)
        link_omega = _into_link(kinematics, s, omega[s])
        momentum = np.einsum("ab,bn->an", arm.inertia_com[s], link_omega)
        for i in range(s + 1):
            velocity = _com_velocity(kinematics, motions, i, s)
            for t, acceleration in enumerate(accelerations):
                out[t, s, i] = arm.mass[s] * dot(acceleration, velocity)
            axis = _into_link(kinematics, s, revolute[i])
            out[4, s, i] = dot(axis, of_turning_axes)
            out[5, s, i] = dot(cross(axis, link_omega), momentum)
            if len(terms) > len(TERMS):
                out[6, s, i] = arm.mass[s] * dot(of_prismatic, velocity)
        if s + 1 < n:
            inboard = inboard + np.stack([cross(omega[s], cross(omega[s], steps[s])), cross(b[s], steps[s])])
    return out


def gravity_loading_by_link(arm: RobotArm, kinematics: Kinematics) -> Array:
    """What each link adds to c, shape (n links, n, N). [FGL87] Eq. (3.4-28)."""
    n, count = arm.n_joints, kinematics.joint_axes.shape[-1]
    motions = joint_motions(arm, kinematics)
    out = np.zeros((n, n, count), kinematics.joint_axes.dtype)
    for s in range(n):
        for i in range(s + 1):
            velocity = _com_velocity(kinematics, motions, i, s)
            out[s, i] = -arm.mass[s] * np.einsum("a,an->n", arm.gravity_vector, velocity)
    return out


def _com_velocity(kinematics: Kinematics, motions: tuple[Array, Array], i: int, s: int) -> Array:
    """v_is, velocity of link s's centre of mass per unit velocity of joint i, s >= i."""
    revolute, prismatic = motions
    return cross(revolute[i], kinematics.com_positions[s] - kinematics.joint_origins[i]) + prismatic[i]


def _into_link(kinematics: Kinematics, s: int, vector: Array) -> Array:
    """sR0 x."""
    return np.einsum("abn,an->bn", kinematics.link_rotations[s], vector)
