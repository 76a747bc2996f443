"""Uncertainty of the torque due to uncertain parameters of the links and drives, to first order."""

from __future__ import annotations

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.dynamics.base_parameters import inertial_parameters, regressor
from gd_analyze.errors import require_type
from gd_analyze.motions.states import States, states_for
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.parts import Link, of_point_mass
from gd_analyze.threads import one_thread


@strict
@one_thread()
def torque_uncertainty(arm: RobotArm, states: States, drives: bool | None = None) -> FloatArray | None:
    """Standard uncertainty of the torque due to those stated for the arm's parameters, N m (N), shape (N, n).

    The stated uncertainties are independent of each other, so the squares of their effects add up. Torque is
    linear in masses, first moments and inertias about the link frames' origins; the effect of a parameter is
    the torque of their change, to first order in that of a centre of mass. Parameters without stated
    uncertainty count as exactly known; the result is None if none is stated that affects the torque.
    `drives` includes the drives' inertia; by default if the arm describes drives.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> from gd_analyze.motions.states import states_in_box
    >>> puma = gd.load_arm("puma560")
    >>> torque_uncertainty(puma, states_in_box(puma, 10)).shape
    (10, 6)
    """
    arm = arm_of(arm)
    require_type(states, States, "states", "the States of `states_of` or `states_in_box`")
    if arm.spread is not None:
        return _of_spread(arm, arm.spread, states, arm.counts_drives(drives))
    changes = [None if link.uncertainty is None else _changes(link) for link in arm.links]
    of_drives = [drive.inertia_uncertainty for drive in arm.drives if arm.counts_drives(drives)]
    if all(change is None for change in changes) and all(u is None for u in of_drives):
        return None
    q, qd, qdd = states_for(arm, states).last
    squares = np.zeros(q.shape)
    for chunk in chunks(q.shape[1]):
        per_unit = regressor(arm, q[:, chunk], qd[:, chunk], qdd[:, chunk])
        for s, change in enumerate(changes):
            if change is not None:
                effects = np.einsum("pk,ikn->pin", change, per_unit[: s + 1, s])
                squares[: s + 1, chunk] += np.einsum("pin,pin->in", effects, effects)
    for i, uncertainty in enumerate(of_drives):
        if uncertainty is not None:
            squares[i] += (uncertainty * qdd[i]) ** 2
    return np.sqrt(squares).T


def _of_spread(arm: RobotArm, spread: FloatArray, states: States, drives: bool) -> FloatArray:
    """Standard uncertainty of the torque from a joint covariance, shape (N, n)."""
    q, qd, qdd = states_for(arm, states).last
    squares = np.zeros(q.shape)
    for chunk in chunks(q.shape[1]):
        per_unit = regressor(arm, q[:, chunk], qd[:, chunk], qdd[:, chunk])
        effects = np.einsum("ksp,ispn->kin", spread[:, :, :10], per_unit)
        if drives:
            effects += spread[:, :, 10, None] * qdd[:, chunk]
        squares[:, chunk] = np.einsum("kin,kin->in", effects, effects)
    return np.sqrt(squares).T


def _changes(link: Link) -> FloatArray:
    """Change of a link's inertial parameters by one standard uncertainty of each of P quantities, (P, 10)."""
    stated = link.uncertainty
    assert stated is not None  # callers pass only uncertain links
    mass = link.mass if stated.body_mass is None else stated.body_mass
    com = link.com if stated.body_com is None else stated.body_com
    # If the inertia is stated about the centre of mass, that about the origin changes with the centre.
    moves = float(stated.inertia_about == "com")
    rows = []
    if stated.mass is not None:
        rows.append(stated.mass * inertial_parameters(1.0, com, of_point_mass(moves, com)))
    if stated.com is not None:
        for step in mass * np.diag(stated.com):
            crossed = np.outer(com, step)
            about_origin = 2 * (com @ step) * np.eye(3) - crossed - crossed.T
            rows.append(inertial_parameters(0.0, step, moves * about_origin))
    if stated.inertia is not None:
        entries = inertial_parameters(0.0, np.zeros(3), stated.inertia)
        rows += list(np.diag(entries)[4:])
    return np.array(rows).reshape(-1, 10)
