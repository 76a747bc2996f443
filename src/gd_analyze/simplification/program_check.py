"""Whether a program computes the terms beside it, at every state there is.

A program of more terms than are written out, such as the exact recursion of an arm of general make, is tried
at some states.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import expanded
from gd_analyze.harmonics.torque_algebra import TooLongError
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.operations.program import Program
from gd_analyze.operations.written import written
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.kept_programs import inputs_of, some_states
from gd_analyze.simplification.model import SimplifiedModel

# Largest difference of a number in two programs of the same terms, over all numbers of the row: to find what
# terms share, coefficients that differ by 1e-9 are taken for equal, up to ten of which add up in a number.
_SAME = 1e-8


def require_terms_computed(model: SimplifiedModel) -> None:
    """Write the terms as a program again, and hold the two programs against each other, both written out.

    Raises
    ------
    ModelError
        If the program computes anything but its terms, at whatever state, or cannot be written out.
    """
    again, n = model.level.write(model.form, model.terms, ROUGH), model.arm.n_joints
    if len(model.program.outputs) != n:
        raise _other(f"{n} outputs", f"{len(model.program.outputs)}")
    if written(again) == written(model.program):
        return
    sliding, unit = [not turns for turns in model.arm.is_revolute], np.ones(n)
    try:
        wanted, runs = expanded(again, sliding), expanded(model.program, sliding)
    except TooLongError:
        _require_same_values(again, model)
        return
    sizes = np.array([float(np.abs(row.coefficients).sum()) for row in wanted.rows])
    noise = wanted.round_off(unit, unit, unit) + runs.round_off(unit, unit, unit)
    differences = (
        TrigonometricPolynomial.summed([a, -1.0 * b]).coefficients
        for a, b in zip(wanted.rows, runs.rows, strict=True)
    )
    apart = np.array([float(np.abs(difference).max(initial=0.0)) for difference in differences])
    # Nor may it add up and take away so much that a term could hide in its rounding.
    fits = (apart <= _SAME * sizes + noise) & (noise <= _SAME * sizes.max())
    if not fits.all():
        joint = int(np.argmin(fits))
        raise _other(
            f"coefficients of joint {joint + 1} within {_SAME * sizes[joint]:.3g} of those of its terms",
            f"{apart[joint]:.3g} apart, and rounding of {noise[joint]:.3g}",
        )


def _require_same_values(again: Program, model: SimplifiedModel) -> None:
    """Hold the torques of two programs against each other at some states."""
    inputs = inputs_of(some_states(model.arm.n_joints))
    with np.errstate(all="ignore"):
        wanted, torque = again.run(inputs), model.program.run(inputs)
        apart, allowed = np.abs(torque - wanted).max(axis=1), _SAME * np.abs(wanted).max()
    fits = apart <= allowed
    if not fits.all():
        joint = int(np.argmin(fits))
        raise _other(
            f"torques of joint {joint + 1} within {allowed:.3g} of those of its terms",
            f"{apart[joint]:.3g} apart",
        )


def _other(expected: str, found: str) -> ModelError:
    return ModelError(
        "the program does not compute the terms",
        where="steps",
        expected=expected,
        found=found,
        next_step="write the model again with `gd-analyze simplify`",
    )
