"""Models that are proven to keep their budget at every state of a box or a tube.

A model is fitted on some states and certified over the region. If the bound of a joint exceeds the budget,
the worst state found joins the states and the budget of that joint shrinks; a few rounds suffice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.simplification.accuracy import LevelTried, SearchStep
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, no_dearer
from gd_analyze.simplification.simplify import simplify_exact

# Most rounds; rounds in which the budget shrinks by a constant share; that share.
_ROUNDS, _PATIENT, _SLIGHTLY = 16, 4, 0.96
# Share of a usual search in each round.
_EFFORT = 0.25


def simplify_certified(
    exact: ExactDynamics,
    budget: Budget | str,
    region: Box | Tube,
    *,
    level: Level | None = None,
    effort: float = 1.0,
    provenance: Mapping[str, str] | None = None,
    progress: Callable[[int], None] | None = None,
) -> tuple[SimplifiedModel, Certificate]:
    """Simplify as far as a budget allows at every state of a box, or of a tube around a motion.

    Parameters
    ----------
    exact
        Exact dynamics at the first states; shares in the budget are of their peak torque.
    budget
        Allowed torque error per joint.
    region
        The states.
    level, effort, provenance
        As for `simplify_exact`. Terms are not refitted: coefficients fitted on some states err by the whole
        budget at many of them, and by more between them.
    progress
        Called with 1 after every round.

    Returns
    -------
    tuple
        The model, and the certificate that proves its budget; the exact model if none with fewer operations
        was found.

    Raises
    ------
    UsageError
        If the budget is below the round-off of the bound, so that not even the exact model can be certified,
        or if the budget is of the norm, which holds for a share of states only.
    """
    budget = Budget.of(budget).require_per_joint(
        "a certified model", "leave --certified away, and bound the model's errors with `gd-analyze certify`"
    )
    exact = exact.under(budget)
    allowed, stated = exact.allowed(budget), str(budget)
    share = np.ones(len(allowed))
    known, how = exact, SearchOptions(level, write=False, effort=effort * _EFFORT, dearer=True)
    for turn in range(_ROUNDS):
        model = simplify_exact(known, Budget.of_torques(share * allowed), how, provenance=provenance)
        if turn == 0:
            # The cheapest level of the first round is kept.
            levels, how = model.accuracy.levels, replace(how, level=model.level)
        model = replace(model, accuracy=replace(model.accuracy, levels=levels))
        certificate = certify(model, region, harmonics=exact.form.harmonics)
        if progress is not None:
            progress(1)
        if certificate.within(allowed).all():
            finished = _finished(model, exact, allowed, stated)
            if finished.program is not model.program:
                # This other program is the one that runs.
                certificate = certify(finished, region, harmonics=exact.form.harmonics)
            model = finished
        beyond = ~certificate.within(allowed)
        if not beyond.any():
            if model.saves:
                return proven(model, certificate), certificate
            break
        known = known.at(known.states.joined_by(*(states[beyond] for states in certificate.worst_states)))
        needed = 0.98 * allowed / np.where(beyond, certificate.certified, allowed)
        # Each model takes long where numbers are refitted.
        patient = turn < _PATIENT and not model.level.always_refits
        share = np.where(beyond, np.minimum(share, _SLIGHTLY) if patient else share * needed, share)
    everything = replace(exactly(exact, model.level, allowed, stated), provenance=dict(provenance or {}))
    certificate = certify(everything, region, harmonics=exact.form.harmonics)
    if certificate.within(allowed).all():
        return proven(everything, certificate), certificate
    raise UsageError(
        "not even the exact model can be certified within that budget",
        where="budget",
        expected=f"errors of at most {', '.join(f'{x:.3g}' for x in allowed)} over all the states",
        found=f"round-off bounded by {', '.join(f'{x:.3g}' for x in certificate.certified)}",
        next_step="allow a larger error, or fewer states: a smaller box, or smaller margins",
    )


def proven(model: SimplifiedModel, certificate: Certificate) -> SimplifiedModel:
    """The model with what is proven of it."""
    return replace(model, accuracy=replace(model.accuracy, certificate=certificate.stated))


def _finished(
    model: SimplifiedModel, exact: ExactDynamics, allowed: FloatArray, stated: str
) -> SimplifiedModel:
    """State the budget, and write the program with few operations."""
    if model.terms:
        model = replace(model, program=model.level.write(model.form, model.terms, THOROUGH))
    operations = model.program.count.total
    steps = model.accuracy.steps
    if steps and operations < steps[-1].operations:
        steps = (*steps, SearchStep("rewriting", operations))
    levels = []
    for tried in model.accuracy.levels:
        if tried.level == model.level.name:
            tried = tried._replace(operations=operations)
        elif tried.operations is not None:
            # Other levels were searched without a proof.
            tried = LevelTried(tried.level, None, f"without a proof it took {tried.operations} operations")
        levels.append(tried)
    accuracy = replace(model.accuracy, allowed=allowed, budget=stated, steps=steps, levels=tuple(levels))
    accuracy = exact.held(accuracy, model.torque(*exact.states.arrays))
    return no_dearer(exact, replace(model, accuracy=accuracy))
