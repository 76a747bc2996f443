"""Every term of D, h and c by what it does to torque: alone, and together with all that matter less."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import term_formula
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import candidates_of, eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.text import html_of, percent

# Terms shown in a notebook.
_MOST_SHOWN = 12
_WHOLE = Budget.parse("100%")


@dataclass(frozen=True)
class RankedTerm:
    """One term in the ranking; shares are of the joint's peak torque, joints count from 1."""

    rank: int  # 1 is what is missed most
    term: Any  # of the kind its level has
    weight: float  # its coefficient
    alone_torque: float  # its own largest, N m, at the joint where that is most of the peak torque
    alone_joint: int
    alone_share: float
    without_share: float  # largest error if it and everything ranked below it are left out
    without_joint: int
    below_uncertainty: bool | None  # its own torque is, at every joint; None where no uncertainty is stated


@dataclass(frozen=True)
class TermRanking:
    """Terms, the most important first, and how many of the last are within the parameters' uncertainty."""

    terms: tuple[RankedTerm, ...] = ()
    uncertainty: tuple[float, ...] | None = None  # largest standard one of every joint's torque, N m
    not_worth_keeping: int = 0  # terms, from the last, that may all go with every error below that
    unlisted: int = 0  # the smallest of very many terms, not ranked
    unlisted_share: float = 0.0  # largest torque of these together, over the joint's peak torque

    def __repr__(self) -> str:
        return f"TermRanking({len(self.terms)} of {self.total} terms)"

    def _repr_html_(self) -> str:
        """The first, for a notebook."""
        plain, rows = Plain(), []
        for ranked in self.terms[:_MOST_SHOWN]:
            formula = term_formula(ranked.term, ranked.weight)
            symbol, term = plain.symbol(formula.left), plain.right(formula)
            shares = percent(ranked.alone_share), percent(ranked.without_share)
            joints = str(ranked.alone_joint), str(ranked.without_joint)
            rows.append([str(ranked.rank), symbol, term, shares[0], joints[0], shares[1], joints[1]])
        headings = ["", "in", "term", "alone, of peak torque", "joint", "without it and all below", "joint"]
        more = self.total - len(rows)
        return html_of("Terms by what they do to torque", headings, rows, f"{more} more." if more else "")

    @property
    def total(self) -> int:
        """Number of terms there are."""
        return len(self.terms) + self.unlisted


def rank_terms(exact: ExactDynamics, level: Level = TERM) -> TermRanking:
    """Rank the terms of an arm's dynamics by the torque they make at given states.

    Of very many states some thousand stand for all. Terms go one by one, each time the one whose loss adds
    the least squared torque error to all that went before, each joint's error taken relative to its peak
    torque. The last to go ranks first.

    Parameters
    ----------
    exact
        Exact dynamics at the states that count.
    level
        A level of harmonic terms: of the torques or of the energies.

    Returns
    -------
    TermRanking
        Of no terms, all of them unlisted, where no joint needs any torque at the states.
    """
    exact = exact.all_alike.thinned()
    if not exact.needs_torque:
        return TermRanking(unlisted=len(level.terms(exact.form)))
    whole = exact.allowed(_WHOLE)
    candidates = candidates_of(exact, level, whole, np.inf)
    elimination = eliminate(candidates, by_cost=False)
    listed = 1.0 - candidates.swept
    errors = listed * elimination.errors() + candidates.swept
    alone = listed * np.abs(candidates.effects).max(axis=2, initial=0.0)
    limit = exact.uncertainty
    terms = list(candidates.terms.items())
    rows = []
    for rank, (k, without) in enumerate(
        zip(reversed(elimination.order), errors[:0:-1], strict=True), start=1
    ):
        joint, worst = int(alone[k].argmax()), int(without.argmax())
        rows.append(
            RankedTerm(
                rank,
                *terms[k],
                alone_torque=float(alone[k, joint] * whole[joint]),
                alone_joint=joint + 1,
                alone_share=float(alone[k, joint]),
                without_share=float(without[worst]),
                without_joint=worst + 1,
                below_uncertainty=None if limit is None else bool((alone[k] * whole <= limit).all()),
            )
        )
    unlisted = candidates.total - len(rows), candidates.swept
    if limit is None:
        return TermRanking(tuple(rows), None, 0, *unlisted)
    beyond = (errors * whole > limit).any(axis=1)
    # The first row is of no term gone: of many terms, those that are not listed may be beyond it already.
    may_go = max(int(beyond.argmax()) - 1, 0) if beyond.any() else len(errors) - 1
    return TermRanking(tuple(rows), tuple(limit.tolist()), may_go, *unlisted)
