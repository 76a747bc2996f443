"""What the stated uncertainties of an arm's parameters make of its torque, to first order, and arms drawn.

Standard uncertainties are of a link's mass, centre of mass and inertia, without its payload, or a joint
covariance of all parameters, of an identified arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics.base_parameters import (
    inertial_parameters,
    link_regressor,
    parameters_of,
    point_masses,
)
from gd_analyze.errors import ArmError, require_type
from gd_analyze.motions.states import States, states_for
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.parts import Link, LinkUncertainty, of_point_mass, second_moment
from gd_analyze.threads import one_thread

# Rejected samples of a link per sample asked for, before its uncertainty is refused.
_MOST_REJECTED_PER_SAMPLE = 100


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
    changes = [None if link.uncertainty is None else _changes(link, link.uncertainty) for link in arm.links]
    of_drives = [drive.inertia_uncertainty for drive in arm.drives if arm.counts_drives(drives)]
    if all(uncertain is None for uncertain in (*changes, *of_drives)):
        return None
    q, qd, qdd = states_for(arm, states).last
    squares = np.zeros(q.shape)
    for chunk in chunks(q.shape[1]):
        per_unit = link_regressor(arm, q[:, chunk], qd[:, chunk], qdd[:, chunk])
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
        per_unit = link_regressor(arm, q[:, chunk], qd[:, chunk], qdd[:, chunk])
        effects = np.einsum("ksp,ispn->kin", spread[:, :, :10], per_unit)
        if drives:
            effects += spread[:, :, 10, None] * qdd[:, chunk]
        squares[:, chunk] = np.einsum("kin,kin->in", effects, effects)
    return np.sqrt(squares).T


def _changes(link: Link, stated: LinkUncertainty) -> FloatArray:
    """Change of a link's inertial parameters by one standard uncertainty of each of P quantities, (P, 10)."""
    body = link.bare or link
    mass, com = body.mass, body.com
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
        rows += list(np.diag(inertial_parameters(0.0, np.zeros(3), stated.inertia))[4:])
    return np.array(rows).reshape(-1, 10)


@dataclass(frozen=True)
class Drawn:
    """Sampled arms: parameters of every link as `parameters_of` gives them."""

    points: FloatArray  # of point masses: translation, (samples, n links, 10)
    matter: FloatArray  # the rest: rotation
    redrawn: Array  # number of inconsistent samples by link, (n links,)

    @classmethod
    def from_arm(cls, arm: RobotArm, samples: int, rng: np.random.Generator) -> Drawn:
        """Draw arms; ArmError if nothing is uncertain, or hardly any sample is consistent."""
        if arm.spread is None and all(link.uncertainty is None for link in arm.links):
            where, hint = f"arm {arm.name}", "give one, such as mass=5%,com=2mm,inertia=10%"
            raise ArmError("the links have no stated uncertainty", where=where, next_step=hint)
        if arm.spread is None:
            drawn, redrawn = _drawn_by_link(arm, samples, rng)
        else:
            drawn, redrawn = _drawn_of_spread(arm, arm.spread[:, :, :10], samples, rng)
        points = point_masses(drawn)
        return cls(points, drawn - points, redrawn)


def _drawn_by_link(arm: RobotArm, samples: int, rng: np.random.Generator) -> tuple[FloatArray, Array]:
    """Draw parameters link by link, inconsistent links again; and count those."""
    nominal = parameters_of(arm)
    drawn = np.tile(nominal, (samples, 1, 1))
    redrawn = np.zeros(arm.n_joints, dtype=int)
    for s, link in enumerate(arm.links):
        stated = link.uncertainty or LinkUncertainty()
        moments = np.linalg.eigvalsh(second_moment(link.inertia_com))
        is_checked = link.mass > 0.0 and moments[0] > 1e-9 * moments[-1]
        missing = np.arange(samples)
        while missing.size:
            drawn[missing, s] = sample = nominal[s] + _drawn_changes(link, stated, missing.size, rng)
            missing = missing[~_is_consistent(sample)] if is_checked else missing[:0]
            redrawn[s] += missing.size
            if redrawn[s] > _MOST_REJECTED_PER_SAMPLE * samples:
                message = f"hardly any sample of link {link.name} is physically consistent"
                raise ArmError(message, where=link.place, next_step="state a smaller uncertainty of it")
    return drawn, redrawn


def _drawn_of_spread(
    arm: RobotArm, spread: FloatArray, samples: int, rng: np.random.Generator
) -> tuple[FloatArray, Array]:
    """Draw from a joint covariance; inconsistent links are counted and kept.

    Parameters of an identified arm are correlated. Drawing one link again would change well-known sums.
    """
    drawn = parameters_of(arm) + np.einsum("mk,ksp->msp", rng.normal(size=(samples, len(spread))), spread)
    inconsistent = [int((~_is_consistent(link)).sum()) for link in np.moveaxis(drawn, 1, 0)]
    return drawn, np.array(inconsistent)


def _drawn_changes(link: Link, stated: LinkUncertainty, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw changes of a link's parameters, consistent or not, (count, 10)."""
    body = link.bare or link
    mass, com = body.mass, body.com
    change = np.zeros((count, 10))
    if stated.mass is not None or stated.com is not None:
        masses = rng.normal(mass, stated.mass or 0.0, (count, 1))
        coms = rng.normal(com, 0.0 if stated.com is None else stated.com, (count, 3))
        given = np.concatenate([[mass], mass * com, np.zeros(6)])
        change[:, :4] = np.concatenate([masses, masses * coms], axis=1)
        change = point_masses(change) - point_masses(given)
        change[:, 4:] *= stated.inertia_about == "com"
    if stated.inertia is not None:
        spread = inertial_parameters(0.0, np.zeros(3), stated.inertia)[4:]
        change[:, 4:] += rng.normal(0.0, spread, (count, 6))
    return change


def _is_consistent(parameters: FloatArray) -> Array:
    """Whether mass and second moment about the centre of mass are positive definite, shape (count,)."""
    xx, xy, yy, xz, yz, zz = (parameters - point_masses(parameters))[:, 4:].T
    half = 0.5 * (xx + yy + zz)
    a, b, c = half - xx, half - yy, half - zz
    # Leading minors of the second moment tr(I)/2 - I (Sylvester).
    determinant = a * b * c - 2 * xy * xz * yz - a * yz**2 - b * xz**2 - c * xy**2
    return (parameters[:, 0] > 0.0) & (a > 0.0) & (a * b > xy**2) & (determinant > 0.0)
