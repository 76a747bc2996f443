"""Whether a program computes the terms that it is written from, at every state and not at some."""

from __future__ import annotations

import numpy as np

from gd_analyze.harmonics.expansion import expanded
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.operations.program import Program
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.torque_program import ROUGH
from gd_analyze.types import ExactForm

# The search for common parts treats coefficients that differ by 1e-9 as equal, up to ten of which add up in
# a number.
EQUAL_COEFFICIENTS = 1e-8


def assert_computes(program: Program, form: ExactForm, level: Level, terms: Terms) -> None:
    """Both are written out; their coefficients agree to 1e-8 of the row's, and to their round-off."""
    sliding, unit = [not turns for turns in form.arm.is_revolute], np.ones(form.arm.n_joints)
    stated, runs = (expanded(x, sliding) for x in (level.write(form, terms, ROUGH), program))
    sizes = np.array([float(np.abs(row.coefficients).sum()) for row in stated.rows])
    noise = stated.round_off(unit, unit, unit) + runs.round_off(unit, unit, unit)
    rows = zip(stated.rows, runs.rows, strict=True)
    polynomials = (TrigonometricPolynomial.summed([a, -1.0 * b]).coefficients for a, b in rows)
    differences = np.array([float(np.abs(difference).max(initial=0.0)) for difference in polynomials])
    assert (differences <= EQUAL_COEFFICIENTS * sizes + noise).all()
    # Nor may it cancel so much that a term could hide in its rounding.
    assert (noise <= EQUAL_COEFFICIENTS * sizes.max(initial=0.0)).all()
