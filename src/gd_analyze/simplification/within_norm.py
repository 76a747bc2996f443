"""Models within a budget of the norm, by searches that know what every joint is allowed at every state.

What keeps |error_i| within a part of the torque's norm at the states that count, keeps the norm of the error
within a share of it. The part is widened and narrowed until the measure itself is just kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.budget import Budget, NormMeasure
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel
from gd_analyze.simplification.model import SimplifiedModel

# Finds a model whose every error, as it counts at its state, is within what is allowed, N m, shape (n,);
# thoroughly or not, and going on from a model where there is one and the level can.
Search = Callable[[ExactDynamics, FloatArray, bool, SimplifiedModel | None], SimplifiedModel]

# Searches done quickly, then thoroughly; how close to the budget is enough; how far a step goes at most.
_QUICK, _THOROUGH, _CLOSE, _STEP = 6, 2, 0.97, 3.0
# Steps in which allowances grow, and up to which.
_WIDER, _WIDEST = 1.25, 100.0
# A model and its error, N m, shape (n, N).
_Trial = tuple[SimplifiedModel, FloatArray]
# An error counts at most so many times what it does where the torque is largest.
_MOST = 1e6


def within_norm(
    exact: ExactDynamics, budget: Budget, search: Search, otherwise: SimplifiedModel
) -> SimplifiedModel:
    """Find the model of fewest operations within a budget of the norm, at states of one motion or of none.

    `otherwise` is the exact model, which states that budget.
    """
    if exact.states.motions:
        names = ", ".join(motion.name for motion in exact.states.motions)
        budget.require_per_joint("a model for several motions", f"simplify for one of them: {names}")
    assert budget.norm is not None  # the caller asks
    measure = exact.norm_measure(budget.norm)
    best = otherwise
    look = _widened if not isinstance(otherwise.level, CandidateLevel) else _closed_in
    for model, error in look(exact, measure, search):
        if measure.share(error) <= 1.0 and model.operations.total <= best.operations.total:
            asked = otherwise.accuracy
            accuracy = replace(model.accuracy, allowed=asked.allowed, budget=asked.budget)
            best = replace(model, accuracy=exact.held(accuracy, error.T + exact.torque))
    return best


def _closed_in(exact: ExactDynamics, measure: NormMeasure, search: Search) -> Iterator[_Trial]:
    """Search anew for narrower and wider allowances, quickly, and at the best of them thoroughly."""
    # At first those states are given up where the torque is least.
    shares, kept, broken, factor = -measure.norms.min(axis=0), 0.0, np.inf, 1.0
    for turn in range(_QUICK + _THOROUGH):
        weighed, allowed = _allowances(exact, measure, shares, factor)
        model, error = _spent(exact, measure, search(weighed, allowed, turn >= _QUICK, None))
        yield model, error
        shares, used = measure.shares(error), measure.share(error)
        if used <= 1.0:
            kept = max(kept, factor)
        else:
            broken = min(broken, factor)
        if np.isinf(broken) or not kept:
            factor *= float(np.clip(1.0 / max(used, 1.0 / _STEP), 1.0 / _STEP, _STEP))
        else:
            factor = float(np.sqrt(kept * broken)) if kept < _CLOSE * broken else kept


def _widened(exact: ExactDynamics, measure: NormMeasure, search: Search) -> Iterator[_Trial]:
    """Search for what is sure to do, and go on from there while allowances widen and the measure is kept."""
    harm, model = -measure.norms.min(axis=0), None
    factor = 1.0 / np.sqrt(len(measure.torque))
    while True:
        weighed, allowed = _allowances(exact, measure, harm, factor)
        model = search(weighed, allowed, True, model)
        error = (model.torque(*exact.states.arrays) - exact.torque).T
        yield model, error
        if measure.share(error) > 1.0 or model.operations.total == 0 or factor > _WIDEST:
            return
        # As many states as were given up are beyond what was allowed, and no others: the search can go on.
        counts, largest = _counts(measure)
        harm, factor = (counts * np.abs(error) / largest).max(axis=0), factor * _WIDER


def _spent(exact: ExactDynamics, measure: NormMeasure, model: SimplifiedModel) -> _Trial:
    """Let more terms go, while the measure itself is kept; the model, and its error (n, N)."""
    error = (model.torque(*exact.states.arrays) - exact.torque).T
    level, terms = model.level, list(model.terms)
    if measure.share(error) > 1.0 or not terms or not isinstance(level, CandidateLevel):
        return model, error
    effects = level.effects(exact, model.terms)
    gone, lost = set[int](), error
    for k in np.argsort([measure.share(error - effect) for effect in effects], kind="stable").tolist():
        if measure.share(lost - effects[k]) <= 1.0:
            gone.add(k)
            lost = lost - effects[k]
    left = {term: model.terms[term] for k, term in enumerate(terms) if k not in gone}
    program = level.write(model.form, left, THOROUGH)
    fewer = replace(model, terms=left, program=program)
    again = (fewer.torque(*exact.states.arrays) - exact.torque).T
    return (fewer, again) if measure.share(again) <= 1.0 else (model, error)


def _allowances(
    exact: ExactDynamics, measure: NormMeasure, harm: FloatArray, factor: float
) -> tuple[ExactDynamics, FloatArray]:
    """Let errors count by the torque's norm, and not at all at the states (N,) where they do most harm."""
    counts, largest = _counts(measure)
    if measure.exempt:
        counts[:, np.argsort(-harm, kind="stable")[: measure.exempt]] = 0.0
    return exact.weighed(counts.T), np.maximum(factor * measure.allowed * largest[:, 0], exact.round_off)


def _counts(measure: NormMeasure) -> tuple[FloatArray, FloatArray]:
    """How much errors count beside those where the norm is largest, (n, N), and that norm, (n, 1)."""
    norms = measure.norms[measure.group]
    largest = np.maximum(norms.max(axis=1, keepdims=True), np.finfo(float).tiny)
    return np.divide(largest, norms, out=np.full(norms.shape, _MOST), where=norms * _MOST > largest), largest
