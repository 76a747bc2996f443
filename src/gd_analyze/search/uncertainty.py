"""What the stated uncertainties of an arm's parameters make of its torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.decomposition import CHUNK
from gd_analyze.kinematics import Kinematics, solve_kinematics
from gd_analyze.robots import Link, RobotArm
from gd_analyze.states import States
from gd_analyze.vectors import Array, FloatArray, apply, cross, outer


def torque_uncertainty(arm: RobotArm, states: States, drives: bool = False) -> FloatArray | None:
    """Standard uncertainty of the torque that follows from those stated for the arm's parameters.

    The stated uncertainties are independent of each other, so the squares of their effects add up. Torque is
    linear in masses, first moments and inertias about the link frames' origins; the effect of a parameter is
    the torque of their change, to first order in that of a centre of mass.

    Parameters
    ----------
    arm, states
        Arm and states.
    drives
        Whether the drives' inertia is part of the torque, and its uncertainty with it.

    Returns
    -------
    numpy.ndarray or None
        N m (N for a sliding joint), shape (N, n); None where no uncertainty is stated of anything that is
        part of the torque. A parameter without a stated one counts as known exactly.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> from gd_analyze.states import states_in_box
    >>> puma = gd.load_arm("puma560")
    >>> torque_uncertainty(puma, states_in_box(puma, 10)).shape
    (10, 6)
    """
    changes = [_changes(link) for link in arm.links]
    of_drives = [drive.inertia_uncertainty for drive in arm.drives if drives]
    if all(change is None for change in changes) and all(u is None for u in of_drives):
        return None
    q, qd, qdd = states.last
    squares = np.zeros(q.shape)
    for start in range(0, q.shape[1], CHUNK):
        chunk = slice(start, start + CHUNK)
        _add_squares(arm, changes, q[:, chunk], qd[:, chunk], qdd[:, chunk], squares[:, chunk])
    for i, uncertainty in enumerate(of_drives):
        if uncertainty is not None:
            squares[i] += (uncertainty * qdd[i]) ** 2
    return np.sqrt(squares).T


@dataclass(frozen=True, eq=False)
class _Changes:
    """One standard uncertainty of each of a link's P uncertain parameters, in what torque is linear in.

    Parameters
    ----------
    mass, first_moment, inertia
        Change of the mass, of mass times centre of mass and of the inertia about the link frame's origin;
        shapes (P,), (P, 3) and (P, 3, 3).
    """

    mass: FloatArray
    first_moment: FloatArray
    inertia: FloatArray


def _changes(link: Link) -> _Changes | None:
    stated = link.uncertainty
    if stated is None:
        return None
    mass = link.mass if stated.body_mass is None else stated.body_mass
    com = link.com if stated.body_com is None else stated.body_com
    unit = np.eye(3)
    zero = np.zeros((3, 3))
    # Where the inertia is known about the centre of mass, that about the origin moves along with it.
    moves = stated.inertia_about == "com"
    changes: list[tuple[float, FloatArray, FloatArray]] = []
    if stated.mass is not None:
        about_origin = (com @ com) * unit - np.outer(com, com) if moves else zero
        changes.append((stated.mass, stated.mass * com, stated.mass * about_origin))
    if stated.com is not None:
        for k, uncertainty in enumerate(stated.com):
            step = mass * uncertainty * unit[k]
            turned = 2 * (com @ step) * unit - np.outer(com, step) - np.outer(step, com) if moves else zero
            changes.append((0.0, step, turned))
    if stated.inertia is not None:
        for a, b in zip(*np.triu_indices(3), strict=True):
            entry = np.zeros((3, 3))
            entry[a, b] = entry[b, a] = stated.inertia[a, b]
            changes.append((0.0, np.zeros(3), entry))
    # An uncertainty of zero is stated, and does nothing.
    acting = [change for change in changes if any(np.any(part) for part in change)]
    return _Changes(
        np.array([change[0] for change in acting]),
        np.array([change[1] for change in acting]).reshape(-1, 3),
        np.array([change[2] for change in acting]).reshape(-1, 3, 3),
    )


def _add_squares(
    arm: RobotArm, changes: list[_Changes | None], q: Array, qd: Array, qdd: Array, squares: Array
) -> None:
    """Add the squares of the parameters' torques to `squares`, set points last, (n, N)."""
    kinematics = solve_kinematics(arm, q)
    omega = omega_dot = np.zeros((3, q.shape[1]))
    acceleration = -arm.gravity[:, None]
    frame_below = np.zeros((3, 1))
    for s, change in enumerate(changes):
        # [FGL87] Table 3.2, but for the frames' origins in place of the centres of mass.
        axis, origin = kinematics.joint_axes[s], kinematics.joint_origins[s]
        acceleration = acceleration + _rigid(omega, omega_dot, origin - frame_below)
        if arm.is_revolute[s]:
            omega_dot = omega_dot + axis * qdd[s] + cross(omega, axis * qd[s])
            omega = omega + axis * qd[s]
        else:
            acceleration = acceleration + axis * qdd[s] + 2.0 * cross(omega, axis * qd[s])
        frame_below = kinematics.link_origins[s]
        acceleration = acceleration + _rigid(omega, omega_dot, frame_below - origin)
        if change is None or not len(change.mass):
            continue
        into_frame = np.swapaxes(kinematics.link_rotations[s], 0, 1)
        motion = [apply(into_frame, vector) for vector in (omega, omega_dot, acceleration)]
        force, moment = _wrench(change, *motion)
        by_moment, by_force = _levers(arm, kinematics, s, into_frame)
        torque = np.einsum("ian,pan->pin", by_moment, moment)
        if force is not None:
            torque += np.einsum("ian,pan->pin", by_force, force)
        squares[: s + 1] += np.einsum("pin,pin->in", torque, torque)


def _rigid(omega: Array, omega_dot: Array, lever: Array) -> Array:
    """Acceleration of a point of a rigid body relative to another of its points."""
    return cross(omega_dot, lever) + cross(omega, cross(omega, lever))


def _wrench(
    change: _Changes, omega: Array, omega_dot: Array, acceleration: Array
) -> tuple[Array | None, Array]:
    """Force and moment about the link frame's origin, in the link frame, (P, 3, N); None for no force."""
    moment = np.einsum("pab,bn->pan", change.inertia, omega_dot)
    moment += cross(omega, np.einsum("pab,bn->pan", change.inertia, omega))
    if not change.mass.any() and not change.first_moment.any():
        return None, moment
    turning = outer(omega, omega)
    speed = np.einsum("an,an->n", omega, omega)
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turning[a, a] -= speed
        turning[a, b] -= omega_dot[c]
        turning[b, a] += omega_dot[c]
    force = np.einsum("abn,pb->pan", turning, change.first_moment)
    force += change.mass[:, None, None] * acceleration
    moment += cross(change.first_moment[:, :, None], acceleration)
    return force, moment


def _levers(arm: RobotArm, kinematics: Kinematics, s: int, into_frame: Array) -> tuple[Array, Array]:
    """Turn moment and force on link s, in its frame, into torque at joints 1..s: (s, 3, N) each."""
    axes = kinematics.joint_axes[: s + 1]
    slides = [i for i in range(s + 1) if not arm.is_revolute[i]]
    by_moment = axes.copy()
    by_moment[slides] = 0.0
    by_force = cross(axes, kinematics.link_origins[s] - kinematics.joint_origins[: s + 1])
    by_force[slides] = axes[slides]
    return apply(into_frame, by_moment), apply(into_frame, by_force)
