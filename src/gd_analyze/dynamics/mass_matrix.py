"""Check that the mass matrix D, with drives if included, is positive definite at given states.

Physically consistent inertias make D positive definite, unless some motion moves no mass. Inconsistent ones
can make it indefinite: then some motion has negative energy, and shares of torque are meaningless.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.dynamics import composite_moments, generalized_dalembert
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ArmError, argument
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link


def require_positive_definite(arm: RobotArm, states: States, drives: bool) -> None:
    """Raise an ArmError unless D, less a diagonal for round-off, is positive definite."""
    added = arm.drive_inertia if drives else np.zeros(arm.n_joints)
    floor = _round_off(arm, np.maximum(states.q.max(axis=0), -states.q.min(axis=0)))
    for chunk in chunks(len(states)):
        moments = composite_moments.composite_moments(arm, solve_kinematics(arm, states.q[chunk].T))
        inertia = np.moveaxis(composite_moments.inertia(moments).sum(axis=0), -1, 0) + np.diag(added)
        try:
            np.linalg.cholesky(inertia - np.diag(floor))
        except np.linalg.LinAlgError:
            row = int(np.linalg.eigvalsh(inertia)[:, 0].argmin())
            where = f"set point {chunk.start + row + 1} of {states.in_words}"
            raise not_positive_definite(arm, states.q[chunk][row], inertia[row], floor, where) from None


def _round_off(arm: RobotArm, farthest: FloatArray) -> FloatArray:
    """Diagonal that outweighs the rounding of D where |q| <= `farthest`, shape (n,).

    D_ij sums m_s v_i . v_j and the inertias of the links s that both joints move; v_i is at most the path
    length L_i from joint i to the centres of mass beyond (1 for a prismatic joint), and v_i and I_s pass some
    10 roundings per joint, as in `round_off_bounds`. Positions are rounded relative to their distance R from
    the base, which grows with the travel of prismatic joints. Hence the error of D_ij is at most 20 n eps
    sum_s m_s (L_i L_j + R (L_i + L_j)) + |I_s|, and a diagonal of its row sums outweighs it (Gershgorin).
    """
    travel = np.where(arm.is_revolute, 0.0, farthest)
    frames = [joint.placement for joint in arm.joints], [link.frame for link in arm.links]
    translations = [[frame.translation for frame in row] for row in frames]
    steps = np.linalg.norm(translations, axis=-1).sum(axis=0) + travel
    com = float(np.linalg.norm(arm.com, axis=1).max())
    whole = float(steps.sum()) + com
    # For joint i: its own travel and frame, and all steps beyond it.
    beyond = np.cumsum(steps[::-1])[::-1] + com
    size = np.where(arm.is_revolute, beyond, 1.0)
    pairs = np.outer(size, size) + whole * np.add.outer(size, size)
    behind = np.maximum.outer(np.arange(arm.n_joints), np.arange(arm.n_joints))
    mass = np.cumsum(arm.mass[::-1])[::-1][behind]
    inertia = np.cumsum(np.abs(arm.inertia_com).sum(axis=(1, 2))[::-1])[::-1][behind]
    unit = 20 * arm.n_joints * np.finfo(float).eps
    out: FloatArray = unit * (mass * pairs + inertia).sum(axis=1)
    return out


def not_positive_definite(
    arm: RobotArm, q: FloatArray, inertia: FloatArray, floor: FloatArray, where: str
) -> ArmError:
    """Error for a D that is not positive definite at q: smallest eigenvalue, and faulty link or joint."""
    values, vectors = np.linalg.eigh(inertia)
    place = ", ".join(f"{x:.4g}" for x in q)
    eigenvalue_text = f"smallest eigenvalue {values[0]:.3g} at {where}, q = ({place})"
    if np.linalg.eigvalsh(inertia + np.diag(floor))[0] < 0.0:
        # The faulty link has the most negative energy in that motion.
        by_link = generalized_dalembert.inertia_by_link(arm, solve_kinematics(arm, q[:, None]))
        energies = np.einsum("i,elijn,j->l", vectors[:, 0], by_link, vectors[:, 0])
        link = arm.links[int(energies.argmin())]
        return ArmError(
            f"the mass matrix D is not positive definite because of the inertia of link {link.name}",
            where=_place(arm, link),
            expected="positive eigenvalues: no motion of an arm has negative energy",
            found=[eigenvalue_text, f"principal moments of link {link.name} {link.moments_text}"],
            next_step="fix that inertia (signs of products, units, reference point), or include the drives' "
            "inertia",
        )
    index = _without_inertia(inertia, floor)
    joint, link = arm.joints[index], arm.links[index]
    is_bare = inertia[index, index] <= floor[index]
    moves = "moves no mass" if is_bare else "has no inertia while the joints before it are free"
    return ArmError(
        f"the mass matrix D is singular: joint {index + 1} ({joint.name}) {moves}",
        where=_place(arm, link),
        expected="positive eigenvalues"
        + (f", above round-off of {floor[index]:.1e}" if floor[index] else ""),
        found=eigenvalue_text,
        next_step=f"give link {link.name} or those beyond it mass, or inertia about that joint's axis; "
        "include the drives' inertia; or hold that joint (URDF and MJCF: "
        f"{argument('lock', f'{joint.name}=0')})",
    )


def _without_inertia(inertia: FloatArray, floor: FloatArray) -> int:
    """Index of the first joint whose pivot is not above its `floor`, or of the smallest pivot.

    A pivot of the elimination is the inertia felt at a joint while the joints before it are free.
    """
    complement, pivots = inertia.copy(), np.empty(len(inertia))
    for i in range(len(complement)):
        pivots[i] = complement[i, i]
        if not pivots[i] > floor[i]:
            return i
        complement[i:, i:] -= np.outer(complement[i:, i], complement[i:, i]) / pivots[i]
    return int(pivots.argmin())


def _place(arm: RobotArm, link: Link) -> str:
    return str(link.source or f"arm {arm.name}, link {link.name}")
