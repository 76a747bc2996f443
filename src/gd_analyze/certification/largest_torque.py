"""The largest torque of an arm within a box or a tube: what errors there are a share of."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.along import bound_along
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.tube import Tube
from gd_analyze.harmonics.torque_rows import exact_row, rate_factors
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.simplification.model import SimplifiedModel

# Positions looked at, and the best of them from which the search climbs.
_DRAWN, _STARTS = 512, 4


def largest_torque(
    model: SimplifiedModel, region: Box | Tube | None = None, *, harmonics: Harmonics | None = None
) -> FloatArray:
    """Largest exact torque of every joint that a search finds among some states, N m (N), shape (n,).

    There may be larger ones: a share of it is rather too large than too small. It follows from the arm and
    these states alone, not from anything that the model states.

    Parameters
    ----------
    model
        Whose arm it is, and whether drives act.
    region
        The states; the arm's own limits by default.
    harmonics
        The arm's exact dynamics where they are at hand.
    """
    arm = model.arm
    box = box_of(region.enclosing if isinstance(region, Tube) else region, arm)
    harmonics = harmonics or harmonics_of(arm)
    inertia = harmonics.whole_inertia(arm.drive_inertia if model.drives else None)
    nothing = TrigonometricPolynomial.constant(harmonics.potential.sliding, 0.0)[
        [0] * len(rate_factors(arm.n_joints))
    ]
    drawn = np.random.default_rng(0).uniform(box.lower, box.upper, (_DRAWN, arm.n_joints)).T
    out = np.zeros(arm.n_joints)
    for i in range(arm.n_joints):
        field = ErrorField.of(exact_row(harmonics, inertia, i), nothing, 0.0, box)
        if isinstance(region, Tube):
            out[i] = bound_along(field, region, 0).found
        elif len(field.waves):
            order = np.argsort(-field.motion.reached(field.waves(drawn)), kind="stable")
            out[i] = field.worst(box, drawn[:, order[:_STARTS]])[0]
    return out
