"""Coefficients of energy terms as sums of base parameters.

The energies are linear in the base parameters. An arm whose links have one parameter alone has the terms of
one unit of it; all links may have it at once, as harmonics are found link by link. Unit masses at the origins
make bodies of first moments possible, and are subtracted.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray, homogeneous
from gd_analyze.dynamics.base_parameters import BaseParameters
from gd_analyze.dynamics.regrouping import PARAMETER_KINDS, UNIT_BODIES
from gd_analyze.harmonics.lagrangian import energy_weights
from gd_analyze.harmonics.terms import EnergyTerm
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, of_point_mass

# Amplitudes below this share of the largest are round-off of a dozen sums.
_ROUND_OFF = 1e-12


def energy_terms_of_parameters(harmonics: Harmonics, base: BaseParameters) -> dict[EnergyTerm, FloatArray]:
    """Coefficient of every energy term per unit of every base parameter, shape (base parameters,).

    The terms are all that the geometry allows. Those of `energy_terms` are among them, with the product of
    these and the base parameters as coefficients; of the others this product is zero with the arm's numbers.
    """
    inertia, potential = _per_unit(harmonics.arm, base)
    stacked = TrigonometricPolynomial.stacked
    weights = energy_weights(
        harmonics.velocities,
        {place: stacked([whole, inertia[place]]) for place, whole in harmonics.whole_inertia().items()},
        stacked([harmonics.potential, potential]),
        harmonics.noise,
    )
    return {term: _without_round_off(of_parameters) for term, (_, *of_parameters) in weights.items()}


def _without_round_off(weights: Sequence[float]) -> FloatArray:
    values = np.array(weights)
    return np.where(np.abs(values) > _ROUND_OFF * np.abs(values).max(initial=0.0), values, 0.0)


def _per_unit(
    arm: RobotArm, base: BaseParameters
) -> tuple[dict[tuple[int, int], TrigonometricPolynomial], TrigonometricPolynomial]:
    """D_ij, i <= j, and the potential energy, of one unit of every base parameter."""
    kinds = dict.fromkeys(parameter.kind for parameter in base if parameter.kind != "J")
    origin = harmonics_of(_with_bodies(arm, [np.zeros((4, 4))] * arm.n_joints))
    of_kinds = {kind: harmonics_of(_with_bodies(arm, _unit_bodies(base, kind))) for kind in kinds}
    prismatic = tuple(not revolute for revolute in arm.is_revolute)
    zero = TrigonometricPolynomial.constant(prismatic, 0.0)
    inertia = {}
    for i, j in itertools.combinations_with_replacement(range(arm.n_joints), 2):
        rows = []
        for parameter in base:
            s = parameter.link - 1
            if parameter.kind == "J":
                rows.append(TrigonometricPolynomial.constant(prismatic, float(i == j == s)))
            elif s < j:
                rows.append(zero)
            else:
                whole, at_origin = (
                    form.inertia_by_link[s, i, j].total() for form in (of_kinds[parameter.kind], origin)
                )
                rows.append(_difference(whole, at_origin))
        inertia[i, j] = TrigonometricPolynomial.stacked(rows)
    potential = [
        zero
        if parameter.kind == "J"
        else _difference(
            *(form.potential_by_link[[parameter.link - 1]] for form in (of_kinds[parameter.kind], origin))
        )
        for parameter in base
    ]
    return inertia, TrigonometricPolynomial.stacked(potential)


def _difference(first: TrigonometricPolynomial, second: TrigonometricPolynomial) -> TrigonometricPolynomial:
    """First minus second, without round-off of what cancels."""
    size = max(np.abs(part.coefficients).max(initial=0.0) for part in (first, second))
    return TrigonometricPolynomial.summed([first, -1.0 * second]).above(_ROUND_OFF * float(size))


def _unit_bodies(base: BaseParameters, kind: str) -> list[FloatArray]:
    """Moments of one unit of a kind in every link's frame of base parameters, in its own frame, (4, 4)."""
    unit = UNIT_BODIES[PARAMETER_KINDS.index(kind)]
    places = [homogeneous(frame.rotation, frame.translation) for frame in base.frames]
    return [place @ unit @ place.T for place in places]


def _with_bodies(arm: RobotArm, bodies: list[FloatArray]) -> RobotArm:
    """The arm with these moments and a unit mass at the origin as links, and nothing else."""
    links = tuple(_with_body(link, body) for link, body in zip(arm.links, bodies, strict=True))
    return replace(arm, links=links, drives=(), dh_table=(), spread=None)


def _with_body(link: Link, body: FloatArray) -> Link:
    mass = 1.0 + float(body[3, 3])
    com, second = body[:3, 3] / mass, body[:3, :3]
    inertia = np.trace(second) * np.eye(3) - second - of_point_mass(mass, com)
    return replace(link, mass=mass, com=com, inertia_com=inertia, uncertainty=None)
