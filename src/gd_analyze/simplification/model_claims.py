"""Check of a model file's statements against the model itself."""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning, ModelError
from gd_analyze.harmonics.expansion import TooLongError, expanded
from gd_analyze.harmonics.identity import largest_difference
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.operations.program import plain_program
from gd_analyze.robots.limits import box_limits
from gd_analyze.simplification.accuracy import (
    Accuracy,
    AlongMotion,
    ErrorTable,
    NormShare,
    Proven,
    norm_shares,
    norms_by_kind,
    share_at,
)
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.simplification.exact_dynamics import ExactDynamics, allowed_by
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.torque_program import ROUGH

WRITE_AGAIN = "write the model again with `gd-analyze ROBOT TRAJECTORY` or `gd-analyze simplify ROBOT -o`"


@dataclass(frozen=True, kw_only=True)
class _ClaimSettings:
    """How closely a model file's claims are compared with what is measured again."""

    # Largest difference of a number in two programs of the same terms, relative to the row: the search for
    # common parts treats coefficients that differ by 1e-9 as equal, up to ten of which add up in a number.
    equal_coefficients: float = 1e-8
    # Programs too long to be written out treat nothing as equal: they differ by 1e-15 of the torque.
    equal_torques: float = 1e-11
    six_digits: float = 5e-6  # a budget is written with six digits, least precise as 1.00000
    # Rounding of a mean of thousands of squares; of gamma, times the condition number of D.
    rounding: float = 1e3 * float(np.finfo(float).eps)
    measured_states: int = 10_000  # most drawn states at which errors are measured again: a tenth of a second
    # States at which a certificate is tested; `certify --check` proves it again.
    certificate_states: int = 1000
    # Share of these states that are at ends of q; as many are at ends of qd, and of qdd.
    corner_share: float = 0.5


_SETTINGS = _ClaimSettings()


def require_equal(where: str, stated: Any, value: Any) -> None:
    """Raise a ModelError if a statement of a file does not match the model."""
    if stated != value:
        text = str(stated)[:120]
        raise ModelError("the model file contradicts itself", where=where, expected=str(value), found=text)


def require_terms_computed(model: SimplifiedModel) -> None:
    """Raise a ModelError if a program, written out, differs from its terms at any state."""

    def misfit(expected: str, value: str) -> ModelError:
        message = "the program does not compute the terms"
        return ModelError(message, where="steps", expected=expected, found=value, next_step=WRITE_AGAIN)

    n = model.arm.n_joints
    if len(model.program.outputs) != n:
        raise misfit(f"{n} outputs", f"{len(model.program.outputs)}")
    rewritten = model.level.write(model.form, model.terms, ROUGH)
    if plain_program(rewritten) == plain_program(model.program):
        return
    sliding, unit = [not turns for turns in model.arm.is_revolute], np.ones(n)
    try:
        stated, runs = expanded(rewritten, sliding), expanded(model.program, sliding)
        sizes = np.array([float(np.abs(row.coefficients).sum()) for row in stated.rows])
        noise = stated.round_off(unit, unit, unit) + runs.round_off(unit, unit, unit)
        rows = zip(stated.rows, runs.rows, strict=True)
        polynomials = (TrigonometricPolynomial.summed([a, -1.0 * b]).coefficients for a, b in rows)
        differences = np.array([float(np.abs(difference).max(initial=0.0)) for difference in polynomials])
        tolerance = _SETTINGS.equal_coefficients
    except TooLongError:  # compared at random states
        noise, tolerance = np.zeros(n), _SETTINGS.equal_torques
        differences, sizes = largest_difference(model.program, rewritten, model.arm.is_revolute, tolerance)
    # Nor may it cancel so much that a term could hide in its rounding.
    fits = (differences <= tolerance * sizes + noise) & (noise <= tolerance * sizes.max())
    if not fits.all():
        joint = int(np.argmin(fits))
        expected = f"joint {joint + 1} within {tolerance * sizes[joint]:.3g} of its terms"
        rounding = f", and rounding of {noise[joint]:.3g}" if noise[joint] else ""
        raise misfit(expected, f"{differences[joint]:.3g} apart{rounding}")


def require_consistent(model: SimplifiedModel) -> None:
    """Raise a ModelError if numbers of an accuracy contradict each other or the budget."""
    _require_of(model, model.accuracy)
    for smaller, larger in pairwise(sorted(model.accuracy.norms, key=lambda norm: norm.states)):
        if smaller.share > larger.share:
            raise _impossible_norm(smaller, f"at most that of more states, {larger.share:.6g}")
    over_all = model.accuracy.errors.peak_torque
    for motion in model.accuracy.motions:
        _require_of(model, motion, f" along {motion.name}")
        name, peak = f"peak_torque along {motion.name}", motion.errors.peak_torque
        _require(model, name, peak <= over_all, peak, "at most that over all motions")


def _require_of(model: SimplifiedModel, stated: Accuracy | AlongMotion, along: str = "") -> None:
    """Check statements over all states, or along one of several motions."""
    errors, spread, budget = stated.errors, stated.uncertainty, model.accuracy.asked
    # Along a motion the allowed error is a rounded quotient.
    is_allowed = errors.largest <= (1.0 + _SETTINGS.rounding if along else 1.0) * stated.allowed
    comes_to = allowed_by(budget, ReferenceTorques(model.arm, errors.peak_torque, spread))
    # Without torque the allowed error is the states' round-off, unknown here; a joint without torque along
    # one of several motions is allowed the error of the others.
    unknown = errors.peak_torque == 0.0 if along else not errors.peak_torque.any()
    fits = (np.abs(stated.allowed - comes_to) <= _SETTINGS.six_digits * comes_to) | unknown
    uncertainty = np.zeros(model.arm.n_joints) if spread is None else spread
    is_root = errors.rms <= (1.0 + _SETTINGS.rounding) * errors.largest
    for name, holds, values, expected in (
        ("peak_torque", errors.peak_torque >= 0.0, errors.peak_torque, "0 or more"),
        ("uncertainty", uncertainty >= 0.0, uncertainty, "0 or more"),
        ("rms_error", errors.rms >= 0.0, errors.rms, "0 or more"),
        ("rms_error", is_root, errors.rms, "at most the largest error"),
        ("largest_error", is_allowed, errors.largest, "at most the allowed error"),
        ("allowed_error", fits, stated.allowed, f"the error that {model.accuracy.budget} allows"),
    ):
        _require(model, f"{name}{along}", holds, values, expected)


def with_states_named(model: SimplifiedModel) -> SimplifiedModel:
    """Name the states of a certificate by its numbers."""
    stated = model.accuracy.certificate
    if stated is None:
        return model
    if stated.margin:
        margin = Margin.parse(stated.margin).in_words(model.arm)
        where = f"{margin} of {model.accuracy.fitted_on.get('trajectory')}"
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GdAnalyzeWarning)  # given when the arm is read
            *limits, remark = vars(box_limits(model.arm)).values()
        stated_limits = stated.lower, stated.upper, stated.velocity, stated.acceleration
        is_all = all(np.array_equal(a, b) for a, b in zip(stated_limits, limits, strict=True))
        where = f"the arm's limits{remark}" if is_all else "the box"
    return model.stating(replace(model.accuracy, certificate=replace(stated, where=where)))


def require_not_refuted(model: SimplifiedModel) -> None:
    """Raise a ModelError if states drawn from its region, or the fitted ones, refute a certificate."""
    stated, fitted = model.accuracy.certificate, model.accuracy.errors.largest
    if stated is None:
        return
    _require(model, "certificate", stated.lower <= stated.upper, stated.lower, "a range of positions")
    if stated.pieces is None:
        lower = np.array([[stated.lower, -stated.velocity, -stated.acceleration]])
        upper = np.array([[stated.upper, stated.velocity, stated.acceleration]])
    else:
        named = model.accuracy.fitted_on.get("trajectory_fingerprint")
        require_equal("trajectory_fingerprint of certificate", stated.trajectory_fingerprint, named)
        _require_pieces(model, stated)
        _require(model, "certificate", fitted <= stated.certified, stated.certified, "at least largest_error")
        lower, upper = stated.pieces.swapaxes(0, 1)
    rng = np.random.default_rng()
    count = _SETTINGS.certificate_states
    chosen, shape = rng.integers(len(lower), size=count), (count, *lower.shape[1:])
    # A torque's error is largest at ends of the velocities and accelerations, and in small pieces at corners.
    at_corner = rng.random((count, 3, 1)) < _SETTINGS.corner_share
    shares = np.where(at_corner, rng.integers(0, 2, shape), rng.random(shape))
    drawn = np.clip(lower[chosen] + shares * (upper - lower)[chosen], lower[chosen], upper[chosen])
    states = States(*drawn.swapaxes(0, 1))
    exact = ExactDynamics.of(model.arm, states, model.drives)
    errors = np.abs(model.torque(*states.arrays) - exact.torque).max(axis=0) - exact.round_off
    _require(model, "certificate", errors <= stated.certified, stated.certified, "at least the error found")


def _require_pieces(model: SimplifiedModel, stated: Proven) -> None:
    """Raise a ModelError for pieces of a tube that are empty, outside its box or thinner than its margin."""
    assert stated.pieces is not None  # as of every tube
    lower, upper = stated.pieces.swapaxes(0, 1)
    lowest = np.array([stated.lower, -stated.velocity, -stated.acceleration])
    highest = np.array([stated.upper, stated.velocity, stated.acceleration])
    is_inside = ((lowest <= lower) & (lower <= upper) & (upper <= highest)).all(axis=(1, 2))
    _require(
        model, "piece of certificate", is_inside, stated.certified, "a piece within the certificate's box"
    )
    margin = Margin.parse(stated.margin)
    position = np.where(model.arm.is_revolute, margin.revolute, margin.prismatic)
    is_wide = (upper[:, 0] - lower[:, 0] >= (2.0 - _SETTINGS.six_digits) * position).all(axis=1)
    _require(model, "piece of certificate", is_wide, stated.certified, f"a piece as wide as {stated.margin}")


def measured_where_possible(model: SimplifiedModel) -> SimplifiedModel:
    """Measure errors again at states of a box or a shipped motion; mark errors at other states as stated."""
    accuracy, states = model.accuracy, None
    count, seed, name = (accuracy.fitted_on.get(key) for key in ("states", "seed", "trajectory"))
    # A different arm may have the name of one that a motion was planned for, with limits that it exceeds.
    with warnings.catch_warnings(), suppress(GdAnalyzeError):
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        if isinstance(count, int) and isinstance(seed, int):
            if 0 < count <= _SETTINGS.measured_states and seed >= 0:
                states = states_in_box(model.arm, count, seed)
        elif name in shipped_trajectories():
            states = states_of(read_trajectory(str(name), model.arm))
    if states is None or dict(states.described) != dict(accuracy.fitted_on):
        return model.stating(replace(accuracy, measured=False))
    return measured_at(model, states)


def measured_at(model: SimplifiedModel, states: States) -> SimplifiedModel:
    """Measure errors again at the states a model was fitted on; a ModelError if the stated ones differ."""
    accuracy = model.accuracy
    exact = ExactDynamics.of(model.arm, states, model.drives)
    torque = model.torque(*states.arrays)
    measured = ErrorTable.of(exact.torque, torque)
    # On another machine either sum may be rounded differently.
    slack = 10 * ROUND_OFF_SHARE * float(measured.peak_torque.max())
    spread = np.zeros(model.arm.n_joints) if exact.uncertainty is None else exact.uncertainty
    for name, stated, actual in (
        ("peak_torque", accuracy.errors.peak_torque, measured.peak_torque),
        ("largest_error", accuracy.errors.largest, measured.largest),
        ("rms_error", accuracy.errors.rms, measured.rms),
        ("uncertainty", spread if accuracy.uncertainty is None else accuracy.uncertainty, spread),
    ):
        fits = np.abs(stated - actual) <= slack
        was = actual[int(np.argmin(fits))]
        _require(model, name, fits, stated, f"{was:.6g}, as measured at {states.in_words}")
    turns = model.arm.is_revolute
    shares = norm_shares(torque - exact.torque, exact.torque, turns, exact.round_off)
    with np.errstate(divide="ignore"):
        off = slack * np.sqrt(model.arm.n_joints) / norms_by_kind(exact.torque, turns).min(axis=0)
    low, high = np.where(np.isfinite(off), shares - off, 0.0), shares + off
    for norm in accuracy.norms:
        if not share_at(low, norm.states) <= norm.share <= share_at(high, norm.states):
            was = share_at(shares, norm.states)
            raise _impossible_norm(norm, f"{was:.6g}, as measured at {states.in_words}")
    # At other states near these gamma may be larger.
    gamma, stated_gamma = model.gamma(exact), accuracy.gamma
    slack = _SETTINGS.rounding * float(np.linalg.cond(exact.inertia).max())
    if stated_gamma is not None and stated_gamma < gamma - slack:
        expected = f"at least {gamma:.6g}, as measured at {states.in_words}"
        raise _impossible("gamma", expected, f"{stated_gamma:.6g}")
    remeasured = replace(
        accuracy,
        measured=True,
        uncertainty=exact.uncertainty,
        norms=exact.norms_of(torque),
        gamma=gamma if stated_gamma is None else stated_gamma,
    )
    return model.stating(remeasured)


def _require(
    model: SimplifiedModel, name: str, holds: NDArray[np.bool_], stated: FloatArray, expected: str
) -> None:
    if not holds.all():
        joint = int(np.argmin(holds))
        where = f"{name} of joint {joint + 1}, {model.arm.joints[joint].name}"
        raise _impossible(where, expected, f"{stated[joint]:.6g}")


def _impossible_norm(norm: NormShare, expected: str) -> ModelError:
    return _impossible(f"norms at {norm.states:.10g} of the states", expected, f"{norm.share:.6g}")


def _impossible(where: str, expected: str, value: str) -> ModelError:
    message = "the model file states impossible errors"
    return ModelError(message, where=where, expected=expected, found=value, next_step=WRITE_AGAIN)
