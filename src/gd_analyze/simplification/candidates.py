"""Candidates for dropping: the terms of a level, with their torques and costs at states.

An arm of seven general joints has tens of thousands of terms. Those too small to be weighed one by one are
dropped together beforehand, within a share of the budget.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effects import Mask, TermTorques
from gd_analyze.simplification.exact import MOST_TERMS, ExactForm, has_more_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel, Level, Terms
from gd_analyze.simplification.selection import Selection, TermChoice
from gd_analyze.simplification.torque_program import Effort
from gd_analyze.text import SINE_PRICE

# Number of terms beyond which the smallest are dropped beforehand.
MANY_TERMS = 1000
# Share of the budget that the terms dropped beforehand may take together.
SWEPT_ERROR_SHARE = 0.4


@dataclass(frozen=True, kw_only=True)
class _SweepSettings:
    """How an arm's very many terms become those that a search can weigh."""

    most_terms: int = 4000  # most terms that a search can weigh
    numbers_at_once: int = 3_000_000  # numbers held at a time while very many terms are evaluated: 24 MB


_SWEEP = _SweepSettings()


class TooManyTermsError(UsageError):
    """More terms matter than a search can weigh."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Terms that may be dropped.

    Parameters
    ----------
    level, form
        What they are terms of.
    terms
        Terms and coefficients, K in number.
    choice
        Their torques over the allowed error, and their costs.
    stays
        Terms that are never dropped, shape (K,).
    total
        Number of all terms, those dropped beforehand included.
    sine_price
        Multiplications and additions that a sine or cosine counts as.
    """

    level: CandidateLevel
    form: ExactForm
    terms: Terms
    choice: TermChoice
    stays: Mask
    total: int
    sine_price: int = SINE_PRICE

    def __len__(self) -> int:
        return len(self.terms)

    def chosen(self, selected: Mask, scale: FloatArray | None = None) -> dict[Any, float]:
        """Terms of a selection, shape (K,), their coefficients times factors, shape (K,)."""
        factors = np.ones(len(self)) if scale is None else scale
        rows = zip(self.terms.items(), selected.tolist(), factors.tolist(), strict=True)
        return {term: factor * weight for (term, weight), is_chosen, factor in rows if is_chosen}

    def selection(self, terms: Terms | None = None) -> Selection:
        """Selection of some terms, by default all; those that stay are always part of it."""
        if terms is None:
            return Selection(self.choice, np.ones(len(self), dtype=bool))
        return Selection(
            self.choice, np.array([term in terms for term in self.terms], dtype=bool) | self.stays
        )

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
    if not isinstance(level, CandidateLevel):
        message = f"level {level.name} has no single terms to choose from"
        raise UsageError(message, where="level", expected="term or energy", found=level.name)
    require_few_terms(exact, level)
    all_terms = level.terms(exact.form)
    listed = list(all_terms)
    torques = _every_torque(level, exact.form)
    needed = level.indispensable(exact.form, listed)
    stays = np.array([term in needed for term in listed], dtype=bool)
    remaining, base = np.arange(len(listed)), np.zeros((exact.arm.n_joints, len(exact.states)))
    if len(listed) > MANY_TERMS:
        weighed = stays | np.array([term in included for term in listed], dtype=bool)
        remaining, base = _swept(torques, exact.states, allowed, weighed)
        if len(remaining) > _SWEEP.most_terms:
            message = f"too many of the {len(listed)} terms of {exact.arm.name} matter within that budget"
            next_step = 'allow a larger error, such as "1% or 0.5% limit", or use --level fast'
            raise TooManyTermsError(
                message,
                where="budget",
                expected=f"at most {_SWEEP.most_terms}",
                found=str(len(remaining)),
                next_step=next_step,
            )
    terms = {listed[k]: all_terms[listed[k]] for k in remaining.tolist()}
    choice = TermChoice(
        torques.at(exact.states, remaining).over(allowed),
        base,
        level.costs(exact.form, list(terms), sine_price),
    )
    return Candidates(level, exact.form, terms, choice, stays[remaining], len(listed), sine_price)


def require_few_terms(exact: ExactDynamics, level: CandidateLevel) -> None:
    """Raise a TooManyTermsError if an arm has too many terms to be written out."""
    if not has_more_terms(exact.form, MOST_TERMS):
        return
    message = f"the exact torque of {exact.arm.name} has too many terms to choose from"
    where, expected = f"level {level.name}", f"at most {MOST_TERMS} torque terms"
    next_step = "`gd-analyze simplify ROBOT --level fast` simplifies such an arm, `gd-analyze "
    next_step += "equations ROBOT --element D12 --min-share 1%` prints the largest terms of an element"
    raise TooManyTermsError(message, where=where, expected=expected, found="more", next_step=next_step)


@lru_cache(maxsize=4)
def _every_torque(level: CandidateLevel, form: ExactForm) -> TermTorques:
    """Torques of all terms, the same in every round of a search."""
    return level.term_torques(form, level.terms(form))


def terms_beyond(exact: ExactDynamics, level: CandidateLevel, allowed: FloatArray) -> int:
    """Number of terms whose torque alone exceeds the allowed error, N m, shape (n,), at some state.

    A model keeps about as many: dropped terms rarely cancel.

    Raises
    ------
    TooManyTermsError
        If the arm has too many terms to be written out.
    """
    require_few_terms(exact, level)
    return int((_peaks(_every_torque(level, exact.form), exact.states, allowed) > 1.0).sum())


def largest_terms(
    torques: TermTorques, states: States, allowed: FloatArray, count: int, needed: Mask
) -> tuple[NDArray[np.intp], FloatArray]:
    """Terms with the largest torques over the allowed ones, and needed ones; error of all others, (n, N)."""
    peaks = _peaks(torques, states, allowed)
    chosen = np.union1d(np.argsort(-peaks, kind="stable")[:count], np.flatnonzero(needed))
    unlisted = np.setdiff1d(np.arange(torques.count), chosen)
    return chosen, torques.together(states, unlisted) / allowed[:, None]


def _swept(
    torques: TermTorques, states: States, allowed: FloatArray, stays: Mask
) -> tuple[NDArray[np.intp], FloatArray]:
    """Terms that remain without the smallest, and the error of these over the allowed one, (n, N)."""
    order = np.argsort(np.where(stays, np.inf, _peaks(torques, states, allowed)), kind="stable")
    # The largest number of smallest terms that are within the share together, by bisection.
    fewest_dropped, most_dropped = 0, len(order) - max(MANY_TERMS, int(stays.sum()))
    base = np.zeros((len(allowed), len(states)))
    error = torques.together(states, order[:most_dropped]) / allowed[:, None]
    if np.abs(error).max() <= SWEPT_ERROR_SHARE:
        return np.sort(order[most_dropped:]), error
    while most_dropped - fewest_dropped > 1:
        middle = (fewest_dropped + most_dropped) // 2
        error = base + torques.together(states, order[fewest_dropped:middle]) / allowed[:, None]
        if np.abs(error).max() <= SWEPT_ERROR_SHARE:
            fewest_dropped, base = middle, error
        else:
            most_dropped = middle
    return np.sort(order[fewest_dropped:]), base


def _peaks(torques: TermTorques, states: States, allowed: FloatArray) -> FloatArray:
    """Largest torque of every term over the allowed error, shape (K,)."""
    out = np.zeros(torques.count)
    for block, effects in torques.in_blocks(states, _SWEEP.numbers_at_once):
        out[block] = effects.largest(np.abs(effects.torque).max(axis=1) / allowed[effects.joint])
    return out
