"""Candidates for dropping: the terms of a level, with their torques and costs at states.

Terms that cancel in the printed equations are one candidate: without the others each would print what no
equation of the arm has. An arm of seven general joints has tens of thousands of terms. Those too small to be
weighed one by one are dropped together beforehand, within a share of the budget.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.errors import UsageError
from gd_analyze.harmonics.terms import TorqueTerm
from gd_analyze.operations.program import Program
from gd_analyze.robots.bodies import MOST_JOINTS_WITH_TERMS
from gd_analyze.simplification.effects import IntegerArray, Mask, TermTorques, TorquesAtStates
from gd_analyze.simplification.exact import MOST_TERMS, ExactForm, too_many_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import HarmonicLevel
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.selection import Costs, Selection, TermChoice
from gd_analyze.simplification.torque_program import Effort
from gd_analyze.text import SINE_PRICE

# Number of terms beyond which the smallest are dropped beforehand.
MANY_TERMS = 1000
# Share of the budget that the terms dropped beforehand may take together.
SWEPT_ERROR_SHARE = 0.4

_MOST_TERMS = 4000  # most terms that a search can weigh
_NUMBERS_AT_ONCE = 500_000  # numbers held at a time while very many terms are evaluated: 4 MB
_STATES_AT_ONCE = 256  # states at which very many terms are evaluated at a time: some 20 MB


class TooManyTermsError(UsageError):
    """More terms matter than a search can weigh."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Terms that may be dropped, as K candidates: single terms, and terms that go together.

    Parameters
    ----------
    level, form
        What they are terms of.
    terms
        Terms and coefficients, T in number.
    numbers
        Candidate of every term, shape (T,).
    choice
        Torques of the candidates over the allowed error, and their costs.
    stays
        Candidates that are never dropped, shape (K,).
    total
        Number of all terms, those dropped beforehand included.
    sine_price
        Multiplications and additions that a sine or cosine counts as.
    """

    level: HarmonicLevel
    form: ExactForm
    terms: Terms
    numbers: IntegerArray
    choice: TermChoice
    stays: Mask
    total: int
    sine_price: int = SINE_PRICE

    def __len__(self) -> int:
        return len(self.choice)

    def chosen(self, selected: Mask) -> dict[Any, float]:
        """Terms of a selection, shape (K,), and their coefficients."""
        rows = zip(self.terms.items(), selected[self.numbers].tolist(), strict=True)
        return {term: weight for (term, weight), is_chosen in rows if is_chosen}

    def selection(self, terms: Terms | None = None) -> Selection:
        """Selection of some terms, by default all; those that stay are always part of it."""
        if terms is None:
            return Selection(self.choice, np.ones(len(self), dtype=bool))
        return Selection(self.choice, of_any(terms, self.terms, self.numbers) | self.stays)

    def price(self, terms: Terms, effort: Effort) -> int:
        """Operations of these terms as the level counts them, with the price of sines and cosines."""
        angles = self.level.angles(self.form, terms)
        return self.level.operations(self.form, terms, effort) + 2 * self.sine_price * len(angles)

    def write(self, terms: Terms, effort: Effort) -> Program:
        """Write the torque of these terms as a program."""
        return self.level.write(self.form, terms, effort)


def candidates_of(
    exact: ExactDynamics,
    level: Level,
    allowed: FloatArray,
    *,
    sine_price: int = SINE_PRICE,
    included: Terms = MappingProxyType({}),
) -> Candidates:
    """Make the candidates of a level at states, with the allowed error of each joint, N m, shape (n,).

    Terms of `included` are candidates, however small.

    Raises
    ------
    UsageError
        If the level's models are not chosen term by term.
    TooManyTermsError
        If too many terms matter within the budget.
    """
    if not isinstance(level, HarmonicLevel):
        message = f"level {level.name} has no single terms to choose from"
        raise UsageError(message, where="level", expected="term or energy", found=level.name)
    require_few_terms(exact, level)
    all_terms = level.terms(exact.form)
    listed, numbers = list(all_terms), numbers_of(level, exact.form, all_terms)
    torques = _every_torque(level, exact.form).at(exact.states)
    stays = of_any(level.indispensable(exact.form, listed), listed, numbers)
    remaining, base = np.arange(torques.count), np.zeros((exact.arm.n_joints, len(exact.states)))
    if torques.count > MANY_TERMS:
        weighed = stays | of_any(included, listed, numbers)
        remaining, base = _swept(torques, allowed, weighed)
        if len(remaining) > _MOST_TERMS:
            message = f"too many of the {len(listed)} terms of {exact.arm.name} matter within that budget"
            next_step = 'allow a larger error, such as "1% or 0.5% limit", or take the exact torque, '
            next_step += f"{exact.form.operations.in_words}: `gd-analyze export ROBOT --to c`"
            raise TooManyTermsError(
                message,
                where="budget",
                expected=f"at most {_MOST_TERMS}",
                found=str(len(remaining)),
                next_step=next_step,
            )
    rows = np.flatnonzero(np.isin(numbers, remaining))
    terms = {listed[k]: all_terms[listed[k]] for k in rows.tolist()}
    numbers = np.searchsorted(remaining, numbers[rows])
    choice = TermChoice(
        torques.effects(remaining).over(allowed),
        base,
        costs_together(level.costs(exact.form, list(terms), sine_price), numbers),
    )
    return Candidates(level, exact.form, terms, numbers, choice, stays[remaining], len(listed), sine_price)


def numbers_of(level: HarmonicLevel, form: ExactForm, terms: Iterable[Any]) -> IntegerArray:
    """Candidates of terms, from 0 in the order of their first terms, shape (T,)."""
    together = _together(level, form)
    first = [together.get(term, term) for term in terms]
    number = {term: k for k, term in enumerate(dict.fromkeys(first))}
    return np.array([number[term] for term in first], dtype=int)


def costs_together(costs: Costs, numbers: IntegerArray) -> Costs:
    """Costs of candidates from those of their terms."""
    candidate, out = numbers.tolist(), defaultdict[frozenset[int], int](int)
    for terms, price in costs.items():
        out[frozenset(candidate[term] for term in terms)] += price
    return {candidates: price for candidates, price in out.items() if price}


def of_any(chosen: Container[Any], terms: Iterable[Any], numbers: IntegerArray) -> Mask:
    """Candidates with any of the chosen terms, shape (K,)."""
    out = np.zeros(int(numbers.max(initial=-1)) + 1, dtype=bool)
    out[numbers[[k for k, term in enumerate(terms) if term in chosen]]] = True
    return out


@lru_cache(maxsize=8)
def _together(level: HarmonicLevel, form: ExactForm) -> dict[Any, Any]:
    """A term of those that stay or go together, by each of the others."""
    printed, users = form.printed(form.torques), dict[TorqueTerm, Any]()
    pairs = (
        (users.setdefault(impossible, term), term)
        for term in level.terms(form)
        for impossible in form.printed(level.source(form, term))
        if impossible not in printed
    )
    return _joined(pairs)


def _joined(pairs: Iterable[tuple[Any, Any]]) -> dict[Any, Any]:
    """One of every set of things that pairs join, directly or not, by all others of the set."""
    out: dict[Any, Any] = {}

    def representative(thing: Any) -> Any:
        while thing in out:
            thing = out[thing]
        return thing

    for pair in pairs:
        first, second = map(representative, pair)
        if first != second:
            out[second] = first
    return {thing: representative(thing) for thing in out}


def require_few_terms(exact: ExactDynamics, level: Level) -> None:
    """Raise a TooManyTermsError if an arm has too many terms to be written out."""
    reason = too_many_terms(exact.form)
    if not reason:
        return
    message = f"the exact torque of {exact.arm.name} has too many terms to choose from"
    where = f"level {level.name}"
    expected = f"at most {MOST_JOINTS_WITH_TERMS} joints and {MOST_TERMS} torque terms"
    next_step = (
        "take fewer joints (`lock='JOINT=0'`), or the exact torque: `gd-analyze export ROBOT --to c`; "
    )
    next_step += "`gd-analyze equations ROBOT --element D12 --min-share 1%` prints an element's largest terms"
    raise TooManyTermsError(message, where=where, expected=expected, found=reason, next_step=next_step)


@lru_cache(maxsize=4)
def _every_torque(level: HarmonicLevel, form: ExactForm) -> TermTorques:
    """Torques of all candidates, the same in every round of a search."""
    terms = level.terms(form)
    return level.term_torques(form, terms, numbers_of(level, form, terms))


def terms_beyond(exact: ExactDynamics, level: HarmonicLevel, allowed: FloatArray) -> int:
    """Number of terms whose torque alone exceeds the allowed error, N m, shape (n,), at some state.

    A model keeps about as many: dropped terms rarely cancel.

    Raises
    ------
    TooManyTermsError
        If the arm has too many terms to be written out.
    """
    require_few_terms(exact, level)
    torques = _every_torque(level, exact.form)
    exceeds = np.zeros(torques.count, dtype=bool)
    for block in chunks(len(exact.states), _STATES_AT_ONCE):
        exceeds |= _peaks(torques.at(exact.states.at(block)), allowed) > 1.0
    return int(exceeds.sum())


def largest_terms(
    torques: TorquesAtStates, allowed: FloatArray, count: int, needed: Mask
) -> tuple[NDArray[np.intp], FloatArray]:
    """Terms with the largest torques over the allowed ones, and needed ones; error of all others, (n, N)."""
    peaks = _peaks(torques, allowed)
    chosen = np.union1d(np.argsort(-peaks, kind="stable")[:count], np.flatnonzero(needed))
    unlisted = np.setdiff1d(np.arange(torques.count), chosen)
    return chosen, torques.together(unlisted) / allowed[:, None]


def _swept(torques: TorquesAtStates, allowed: FloatArray, stays: Mask) -> tuple[NDArray[np.intp], FloatArray]:
    """Terms that remain without the smallest, and the error of these over the allowed one, (n, N)."""
    order = np.argsort(np.where(stays, np.inf, _peaks(torques, allowed)), kind="stable")
    # The largest number of smallest terms that are within the share together, by bisection.
    fewest_dropped, most_dropped = 0, len(order) - max(MANY_TERMS, int(stays.sum()))
    base = np.zeros((len(allowed), len(torques.states)))
    error = torques.together(order[:most_dropped]) / allowed[:, None]
    if np.abs(error).max() <= SWEPT_ERROR_SHARE:
        return np.sort(order[most_dropped:]), error
    while most_dropped - fewest_dropped > 1:
        middle = (fewest_dropped + most_dropped) // 2
        error = base + torques.together(order[fewest_dropped:middle]) / allowed[:, None]
        if np.abs(error).max() <= SWEPT_ERROR_SHARE:
            fewest_dropped, base = middle, error
        else:
            most_dropped = middle
    return np.sort(order[fewest_dropped:]), base


def _peaks(torques: TorquesAtStates, allowed: FloatArray) -> FloatArray:
    """Largest torque of every term over the allowed error, shape (K,)."""
    out = np.zeros(torques.count)
    for block, effects in torques.in_blocks(_NUMBERS_AT_ONCE):
        out[block] = effects.largest(np.abs(effects.torque).max(axis=1) / allowed[effects.joint])
    return out
