"""What a model file states of its model, held against what follows from the model itself.

What is cheap is made again: the arm's fingerprint, the operations, the allowed error that budget and peak
torque come to, and peak torque and errors where the states can be had at which they were measured. What
cannot be made again must not contradict itself, and remains a statement of the file.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import isclose
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning, ModelError
from gd_analyze.harmonics.expansion import TooLongError, expanded
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.motions.read import read_trajectory, shipped_trajectories
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.operations.program import Program, written
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import Accuracy, AlongMotion, ErrorTable
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.exact import ExactDynamics, allowed_by
from gd_analyze.simplification.measures import NormShare, share_at
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.program_cache import inputs_of, some_states

# Largest difference of a number in two programs of the same terms, over all numbers of the row: to find what
# terms share, coefficients that differ by 1e-9 are taken for equal, up to ten of which add up in a number.
_SAME = 1e-8


def require_terms_computed(model: SimplifiedModel) -> None:
    """Refuse, with a ModelError, a program that is not its terms at every state: both written out."""
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


# A budget is written with six digits, the least precise of which are 1.00000.
_SIX_DIGITS = 5e-6
_CANNOT_BE = "what the model file states of its errors cannot be"
_WRITE_AGAIN = "write the model again with `gd-analyze simplify`"
# Most drawn states at which errors are measured again: a tenth of a second.
_MOST_STATES = 10_000


def require_equal(what: str, stated: Any, found: Any) -> None:
    """Refuse what a file states of itself if it is not so."""
    if stated != found:
        raise ModelError(
            "the model file contradicts itself", where=what, expected=str(found), found=str(stated)[:120]
        )


def require_consistent(model: SimplifiedModel) -> None:
    """Refuse, with a ModelError, an accuracy that contradicts itself.

    No torque or error is negative, root mean squares are at most the largest error, that at most the allowed
    one, which is what budget and peak torque come to; shares of the norm grow with the states and keep the
    budget.
    """
    _require_of(model, model.accuracy)
    _require_norms(model)
    for motion in model.accuracy.motions:
        _require_of(model, motion, f" along {motion.name}")
        over_all = model.accuracy.errors.peak_torque
        below = motion.errors.peak_torque <= over_all
        what = f"peak_torque along {motion.name}"
        _require(model, what, below, motion.errors.peak_torque, "at most that over all motions")


def _require_of(model: SimplifiedModel, stated: Accuracy | AlongMotion, along: str = "") -> None:
    """Refuse what is promised over all states, or along one of several motions."""
    errors, spread = stated.errors, stated.uncertainty
    most = 1.0 + 1e3 * float(np.finfo(float).eps)  # a mean of thousands of squares
    _require(model, f"peak_torque{along}", errors.peak_torque >= 0.0, errors.peak_torque, "0 or more")
    if spread is not None:
        _require(model, f"uncertainty{along}", spread >= 0.0, spread, "0 or more")
    _require(model, f"rms_error{along}", errors.rms >= 0.0, errors.rms, "0 or more")
    within = errors.rms <= most * errors.largest
    _require(model, f"rms_error{along}", within, errors.rms, "at most the largest error")
    budget = model.accuracy.asked
    # Along a motion what is allowed is a quotient, and rounded. A budget of the norm is of no joint alone.
    within = errors.largest <= (most if along else 1.0) * stated.allowed
    if budget.norm is None:
        _require(model, f"largest_error{along}", within, errors.largest, "at most the allowed error")
    comes_to = allowed_by(budget, ReferenceTorques(model.arm, errors.peak_torque, spread))
    # Of states without torque the allowed error is their round-off, which only they tell; of a joint that
    # needs none along one of several motions, it is what the others allow.
    unknown = errors.peak_torque == 0.0 if along else not errors.peak_torque.any()
    fits = (np.abs(stated.allowed - comes_to) <= _SIX_DIGITS * comes_to) | unknown
    _require(model, f"allowed_error{along}", fits, stated.allowed, f"what {model.accuracy.budget} comes to")


def _require_norms(model: SimplifiedModel) -> None:
    """Refuse shares of the norm that contradict one another, or the budget."""
    norms, asked = sorted(model.accuracy.norms, key=lambda norm: norm.states), model.accuracy.asked.norm
    for few, many in pairwise(norms):
        if few.share > many.share:
            raise _impossible(few, f"at most that of more states, {many.share:.6g}")
    if asked is None:
        return
    stated = next((norm for norm in norms if isclose(norm.states, asked.states)), None)
    # The budget is written with twelve digits.
    if stated is None or stated.share > asked.share * (1.0 + 1e-11):
        raise _impossible(stated or NormShare(np.inf, asked.states), f"at most {asked.share:.6g}, the budget")


def _require_norms_measured(
    model: SimplifiedModel, exact: ExactDynamics, torque: FloatArray, slack: float
) -> None:
    """Refuse shares of the norm that are not those of torques (N, n) within a slack of each."""
    measure = exact.norm_measure(NormShare(1.0))
    shares = measure.shares((torque - exact.torque).T)
    with np.errstate(divide="ignore"):
        off = slack * np.sqrt(model.arm.n_joints) / measure.norms.min(axis=0)
    low, high = np.where(np.isfinite(off), shares - off, 0.0), shares + off
    for norm in model.accuracy.norms:
        if not share_at(low, norm.states) <= norm.share <= share_at(high, norm.states):
            found = share_at(shares, norm.states)
            raise _impossible(norm, f"{found:.6g}, as measured at {exact.states.in_words}")


def _impossible(norm: NormShare, expected: str) -> ModelError:
    return ModelError(
        _CANNOT_BE,
        where=f"norms at {norm.states:.10g} of the states",
        expected=expected,
        found=f"{norm.share:.6g}",
        next_step=_WRITE_AGAIN,
    )


def measured_where_possible(model: SimplifiedModel) -> SimplifiedModel:
    """Measure the errors again if the states can be had, see `measured_at`; mark them as stated otherwise."""
    states = _states_at_hand(model.arm, model.accuracy.fitted_on)
    if states is None:
        return replace(model, accuracy=replace(model.accuracy, measured=False))
    return measured_at(model, states)


def measured_at(model: SimplifiedModel, states: States) -> SimplifiedModel:
    """Measure errors again at the states that a model was fitted on; a ModelError where it states others."""
    accuracy = model.accuracy
    exact = ExactDynamics.of(model.arm, states, model.drives)
    torque = model.torque(*states.arrays)
    measured = ErrorTable.of(exact.torque, torque)
    # On another machine either sum may be rounded otherwise.
    slack = 10 * ROUND_OFF_SHARE * float(measured.peak_torque.max())
    found_uncertainty = np.zeros(model.arm.n_joints) if exact.uncertainty is None else exact.uncertainty
    stated_uncertainty = found_uncertainty if accuracy.uncertainty is None else accuracy.uncertainty
    for name, stated, found in (
        ("peak_torque", accuracy.errors.peak_torque, measured.peak_torque),
        ("largest_error", accuracy.errors.largest, measured.largest),
        ("rms_error", accuracy.errors.rms, measured.rms),
        ("uncertainty", stated_uncertainty, found_uncertainty),
    ):
        fits = np.abs(stated - found) <= slack
        joint = int(np.argmin(fits))
        _require(model, name, fits, stated, f"{found[joint]:.6g}, as measured at {states.in_words}")
    _require_norms_measured(model, exact, torque, slack)
    norms = exact.norms_of(torque, accuracy.asked.norm)
    return replace(
        model, accuracy=replace(accuracy, measured=True, uncertainty=exact.uncertainty, norms=norms)
    )


def _require(
    model: SimplifiedModel, what: str, holds: NDArray[np.bool_], stated: FloatArray, expected: str
) -> None:
    if not np.all(holds):
        joint = int(np.argmin(holds))
        raise ModelError(
            _CANNOT_BE,
            where=f"{what} of joint {joint + 1}, {model.arm.joints[joint].name}",
            expected=expected,
            found=f"{stated[joint]:.6g}",
            next_step=_WRITE_AGAIN,
        )


def _states_at_hand(arm: RobotArm, fitted_on: Mapping[str, str | int]) -> States | None:
    """States a model was made for, if they are drawn from the arm's limits or a shipped trajectory's."""
    count, seed = fitted_on.get("states"), fitted_on.get("seed")
    name = fitted_on.get("trajectory")
    # Another arm may bear the name of one that a motion was planned for, and limits that it breaks.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        found = None
        try:
            if isinstance(count, int) and isinstance(seed, int):
                found = states_in_box(arm, count, seed) if 0 < count <= _MOST_STATES and seed >= 0 else None
            elif name in shipped_trajectories():
                found = states_of(read_trajectory(str(name), arm))
        except GdAnalyzeError:
            return None
    return found if found is not None and dict(found.described) == dict(fitted_on) else None
