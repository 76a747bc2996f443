"""The cheapest terms within a budget: a descent, attempts to improve it, a usable D, and a refit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.terms import EnergyTerm
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.candidates import Candidates, candidates_of
from gd_analyze.simplification.effort import COUNTING, POINT, ROUGH, THOROUGH
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.inertia_error import InertiaTerms
from gd_analyze.simplification.level import CandidateLevel, Found
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.refit import refitted
from gd_analyze.simplification.selection import (
    USUAL,
    Selection,
    SelectionSettings,
    descend,
    improve,
    repair,
)

# Called with the number of terms dropped since the last call.
Progress = Callable[[int], None] | None

# Largest gamma at the states of a search: other states reach more.
LARGEST_GAMMA = 0.9
# Most directions of every position in which D is limited, and attempts after each, as a share of the usual.
_DIRECTIONS, _AFTER_D = 12, 0.25


def selected_terms(
    exact: ExactDynamics,
    level: CandidateLevel,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
) -> Found:
    """Search for the terms to keep; a TooManyTermsError if too many matter.

    A search that continues, see `SearchOptions.way`, begins from the terms of the last one.
    """
    start = how.way[-1] if how.way else None
    candidates = candidates_of(exact, level, allowed, sine_price=how.sine_price, also=start or {})
    settings = USUAL.scaled(how.effort)
    selection = candidates.selection(start)
    repair(selection, settings)
    descend(selection, candidates.stays, settings)
    steps = [("descent", selection)]
    if how.thorough:
        selection = _cheapest(candidates, improve(selection, candidates.stays, settings))
        steps.append(("search", selection))
    candidates, usable = with_usable_inertia(candidates, selection, exact, settings)
    if usable is not selection:
        steps.append(("usable D", usable))
        selection = usable
    terms, is_refitted = candidates.chosen(selection.selected), False
    stages = [SearchStep(name, _operations(candidates, each)) for name, each in steps]
    if how.refit:
        fitted = refitted(candidates, selection.selected, candidates.stays)
        if fitted is not None:
            terms, is_refitted = candidates.chosen(*fitted), True
            stages.append(SearchStep("refit", level.operations(exact.form, terms, COUNTING)))
    if progress is not None:
        progress(candidates.total - len(terms))
    if how.way is not None:
        how.way.append(terms)
    program = candidates.write(terms, THOROUGH if how.write else POINT)
    return Found(terms, program, is_refitted, tuple(stages))


def with_usable_inertia(
    candidates: Candidates, selection: Selection, exact: ExactDynamics, settings: SelectionSettings = USUAL
) -> tuple[Candidates, Selection]:
    """Select anew until gamma is below 1 at every state; unchanged if that fails within the budget.

    Where gamma is too large, what D lacks in the worst direction joins the errors that a selection limits.
    """
    level, form = candidates.level, exact.form
    of_inertia = [(k, own) for k, term in enumerate(candidates.terms) if (own := level.inertia_term(term))]
    places = np.array([k for k, _ in of_inertia], dtype=np.intp)
    elements: list[EnergyTerm] = [own for _, own in of_inertia]
    weights = np.array(list(candidates.terms.values()))[places]
    inertia_terms = InertiaTerms(form.velocities, elements, weights, exact.states.q)
    extended, trial = candidates, selection
    for _ in range(_DIRECTIONS):
        excess = inertia_terms.excess(exact.inertia, trial.selected[places], LARGEST_GAMMA)
        if excess is None:
            return extended, trial
        added, rest = (values / LARGEST_GAMMA for values in excess)
        extended = replace(extended, choice=extended.choice.joined_by(places, added, rest))
        trial = Selection(extended.choice, trial.selected)
        repair(trial, settings)
        descend(trial, candidates.stays, settings)
        trial = _cheapest(extended, improve(trial, candidates.stays, settings.scaled(_AFTER_D)))
    return candidates, selection


def _cheapest(candidates: Candidates, selections: list[Selection]) -> Selection:
    """The selection with the fewest operations, counted."""
    return min(selections, key=lambda one: candidates.price(candidates.chosen(one.selected), ROUGH))


def _operations(candidates: Candidates, selection: Selection) -> int:
    return candidates.level.operations(candidates.form, candidates.chosen(selection.selected), ROUGH)


def quick_count(exact: ExactDynamics, level: CandidateLevel, allowed: FloatArray) -> Callable[[float], int]:
    """Estimate operations of the torque for multiples of a budget from descents alone."""
    candidates = candidates_of(exact, level, allowed)

    def count(factor: float) -> int:
        selection = candidates.selection()
        descend(selection, candidates.stays, limit=factor)
        return candidates.write(candidates.chosen(selection.selected), COUNTING).count.total

    return count
