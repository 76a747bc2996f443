"""The cheapest terms within a budget: a descent, attempts to improve it, and a usable D."""

from __future__ import annotations

import math
import numbers
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arguments import require_flags_of
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError, require_type
from gd_analyze.harmonics.terms import EnergyTerm
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.candidates import Candidates, candidates_of
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.inertia_error import InertiaTerms
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.search_time import UNLIMITED, SearchTime
from gd_analyze.simplification.selection import (
    Selection,
    descend,
    improve,
    repair,
)
from gd_analyze.simplification.torque_program import ROUGH
from gd_analyze.text import SINE_PRICE

# Largest gamma at the states of a search: other states reach more.
LARGEST_GAMMA = 0.9

_MOST_DIRECTIONS = 40  # most directions at every position in which D is limited
_CONTINUED_SHARE = 0.25  # attempts after a direction is added, as a share of the usual
# Number of directions after which there are no attempts: descents alone end sooner.
_DIRECTIONS_WITH_ATTEMPTS = 12


@dataclass(frozen=True)
class SearchOptions:
    """Options of a search."""

    level: Level = TERM
    thorough: bool = True  # attempts after the first descent; without them, the descent alone
    effort: float = 1.0  # number of attempts, relative to the usual
    same_velocities: bool = False  # keep the velocities in which the terms of the exact dynamics are
    most_terms: float = math.inf  # the first search that ends with more is the last
    sine_price: int = SINE_PRICE  # multiplications and additions that a sine or cosine counts as
    time: SearchTime = UNLIMITED  # after which a search closes with what holds

    def __post_init__(self) -> None:
        require_flags_of(self)
        level = level_named(self.level)
        object.__setattr__(self, "level", level)
        for name, kind, expected in (
            ("effort", numbers.Real, "a number above 0"),
            ("sine_price", numbers.Real, "a number of operations"),
        ):
            require_type(getattr(self, name), kind, name, expected)
        if not self.effort > 0.0:
            value = str(self.effort)
            raise UsageError("the effort is not positive", where="effort", expected="above 0", found=value)
        if self.sine_price < 0:
            value = str(self.sine_price)
            raise UsageError("the price is negative", where="sine_price", expected="0 or more", found=value)

    @property
    def stage(self) -> str:
        """What work it is, for whoever waits for it, and how long it may take."""
        limit = f", at most {self.time.seconds:g} s" if math.isfinite(self.time.seconds) else ""
        return f"searching at level {self.level}{limit}"


class SelectedTerms(NamedTuple):
    """The terms that a search keeps, and its steps."""

    terms: Terms
    steps: tuple[SearchStep, ...]


def selected_terms(
    exact: ExactDynamics,
    allowed: FloatArray,
    options: SearchOptions,
    start: Terms | None = None,
) -> SelectedTerms:
    """Search for the terms to keep, from `start` if given; a TooManyTermsError if too many matter."""
    candidates = candidates_of(
        exact, options.level, allowed, sine_price=options.sine_price, included=start or {}
    )
    selection = candidates.selection(start)
    repair(selection)
    descend(selection, candidates.stays)
    steps = [SearchStep("descent", _operations(candidates, selection))]
    inertia = _inertia_terms(candidates, exact)
    usable = _with_usable_inertia(candidates, selection, inertia, exact)
    if usable is not None:
        candidates, selection = usable
    if options.thorough:
        selection = _cheapest(
            candidates, improve(selection, candidates.stays, options.time, effort=options.effort)
        )
        if usable is not None:
            shorter = _CONTINUED_SHARE * options.effort
            improved = _with_usable_inertia(candidates, selection, inertia, exact, options.time, shorter)
            # Attempts that leave no usable D are of no use where there was one.
            candidates, selection = improved or usable
        steps.append(SearchStep("search", _operations(candidates, selection)))
    return SelectedTerms(candidates.chosen(selection.selected), tuple(steps))


def _inertia_terms(candidates: Candidates, exact: ExactDynamics) -> tuple[InertiaTerms, NDArray[np.intp]]:
    """The terms of D' at the states, and the candidate of each."""
    level, elements, rows = candidates.level, list[EnergyTerm](), list[int]()
    for row, term in enumerate(candidates.terms):
        element = level.inertia_term(term)
        if element is not None:
            elements.append(element)
            rows.append(row)
    weights = np.array(list(candidates.terms.values()))[rows]
    velocities = exact.form.velocities
    return InertiaTerms(velocities, elements, weights, exact.states.q), candidates.numbers[rows]


def _with_usable_inertia(
    candidates: Candidates,
    selection: Selection,
    inertia: tuple[InertiaTerms, NDArray[np.intp]],
    exact: ExactDynamics,
    time: SearchTime = UNLIMITED,
    improving: float = 0.0,
) -> tuple[Candidates, Selection] | None:
    """Select anew until gamma is below 1 at every state; None if that fails within the budget.

    Where gamma is too large, what D lacks in the worst direction joins the errors that a selection limits.
    With `improving` there are attempts after each, of that effort.
    """
    inertia_terms, places = inertia
    for turn in range(_MOST_DIRECTIONS):
        excess = inertia_terms.excess(exact.inertia, selection.selected[places], LARGEST_GAMMA)
        if excess is None:
            return candidates, selection
        added, remainder = (values / LARGEST_GAMMA for values in excess)
        candidates = replace(candidates, choice=candidates.choice.joined_by(places, added, remainder))
        selection = Selection(candidates.choice, selection.selected)
        repair(selection)
        descend(selection, candidates.stays)
        if improving and turn < _DIRECTIONS_WITH_ATTEMPTS:
            selection = _cheapest(candidates, improve(selection, candidates.stays, time, effort=improving))
    return None


def _cheapest(candidates: Candidates, selections: list[Selection]) -> Selection:
    """The selection with the fewest operations, counted."""
    return min(
        selections, key=lambda selection: candidates.price(candidates.chosen(selection.selected), ROUGH)
    )


def _operations(candidates: Candidates, selection: Selection) -> int:
    return candidates.level.operations(candidates.form, candidates.chosen(selection.selected), ROUGH)
