"""Terms of an arm's dynamics, ranked by their torque at given states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import term_formula
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import MANY_TERMS, largest_terms, require_few_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics, require_exact, warn_of_torques
from gd_analyze.simplification.harmonic import TERM, HarmonicLevel
from gd_analyze.simplification.level import Terms
from gd_analyze.text import html_of, percent
from gd_analyze.threads import one_thread

# Number of terms shown in a notebook.
_MOST_SHOWN = 12
_WHOLE = Budget.parse("100%")


@dataclass(frozen=True)
class RankedTerm:
    """One term in the ranking; shares are of the joint's peak torque, joints count from 1."""

    rank: int  # 1 is the most important
    term: Any  # of its level's type
    weight: float  # its coefficient
    alone_torque: float  # its largest torque, N m, at the joint where its share of peak torque is largest
    alone_joint: int
    alone_share: float
    without_share: float  # largest error without it and everything ranked below it
    without_joint: int
    below_uncertainty: bool | None  # whether its torque is, at every joint; None if no uncertainty is stated


@dataclass(frozen=True)
class TermRanking:
    """Terms, the most important first, and the number of last ones within the parameters' uncertainty."""

    terms: tuple[RankedTerm, ...] = ()
    uncertainty: tuple[float, ...] | None = None  # largest standard uncertainty of every joint's torque, N m
    # Number of last terms that may be dropped with every error below it; None without uncertainty
    not_worth_keeping: int | None = None
    unlisted: int = 0  # number of smallest terms that are not ranked
    unlisted_share: float = 0.0  # largest torque of these together, over the joint's peak torque

    def __repr__(self) -> str:
        return f"TermRanking({len(self.terms)} of {self.total} terms)"

    def _repr_html_(self) -> str:
        """The first terms, for a notebook."""
        plain, rows = Plain(), []
        for ranked in self.terms[:_MOST_SHOWN]:
            formula = term_formula(ranked.term, ranked.weight)
            symbol, term = plain.symbol(formula.left), plain.right(formula)
            shares = percent(ranked.alone_share), percent(ranked.without_share)
            joints = str(ranked.alone_joint), str(ranked.without_joint)
            rows.append([str(ranked.rank), symbol, term, shares[0], joints[0], shares[1], joints[1]])
        headings = ["", "in", "term", "alone, of peak torque", "joint", "without it and all below", "joint"]
        not_shown = self.total - len(rows)
        return html_of("Terms ranked by torque", headings, rows, f"{not_shown} more." if not_shown else "")

    @property
    def total(self) -> int:
        """Number of terms there are."""
        return len(self.terms) + self.unlisted


@one_thread()
def rank_terms(
    exact: ExactDynamics, level: HarmonicLevel = TERM, *, included: Sequence[Terms] = ()
) -> TermRanking:
    """Rank the terms of an arm's dynamics by their torque at given states.

    Very many states are represented by some thousand. Terms are dropped one by one, each time the one whose
    loss adds least to the squared torque error of all dropped so far, relative to each joint's peak torque.
    The term dropped last ranks first.

    Parameters
    ----------
    exact
        Exact dynamics at the states.
    level
        A level of harmonic terms: of the torques or of the energies.
    included
        Terms that are ranked however small they are; of very many others the largest are.

    Returns
    -------
    TermRanking
        Terms with torques, N m (N), and shares; empty if no joint needs torque at the states.

    Raises
    ------
    TooManyTermsError
        If the arm has too many terms to be written out.
    """
    require_exact(exact)
    warn_of_torques(exact)
    require_few_terms(exact, level)
    exact = exact.weighed(None).thinned()
    all_terms = level.terms(exact.form)
    if not exact.needs_torque:
        return TermRanking(unlisted=len(all_terms))
    whole = exact.allowed(_WHOLE)
    torques = level.term_torques(exact.form, all_terms).at(exact.states)
    included_terms = {term for terms in included for term in terms}
    needed = np.array([term in included_terms for term in all_terms], dtype=bool)
    chosen, unlisted_error = largest_terms(torques, whole, MANY_TERMS, needed)
    of_chosen = torques.effects(chosen).over(whole)
    del torques  # of all terms: 50 MB for a long arm
    effects = of_chosen.dense()
    order = _order_of_elimination(effects)
    # Largest errors with the first of the order dropped, one more each time, (K + 1, n).
    error, errors = unlisted_error.copy(), [np.abs(unlisted_error).max(axis=1, initial=0.0)]
    for k in order:
        error += effects[k]
        errors.append(np.abs(error).max(axis=1, initial=0.0))
    largest_effect = np.maximum(effects.max(axis=2, initial=0.0), -effects.min(axis=2, initial=0.0))
    limit = exact.uncertainty
    listed = list(all_terms.items())
    rows = []
    for rank, (k, without) in enumerate(zip(reversed(order), reversed(errors), strict=False), start=1):
        joint, worst = int(largest_effect[k].argmax()), int(without.argmax())
        term, weight = listed[chosen[k]]
        rows.append(
            RankedTerm(
                rank=rank,
                term=term,
                weight=weight,
                alone_torque=float(largest_effect[k, joint] * whole[joint]),
                alone_joint=joint + 1,
                alone_share=float(largest_effect[k, joint]),
                without_share=float(without[worst]),
                without_joint=worst + 1,
                below_uncertainty=None if limit is None else bool((largest_effect[k] * whole <= limit).all()),
            )
        )
    unlisted = len(all_terms) - len(rows), float(np.abs(unlisted_error).max(initial=0.0))
    if limit is None:
        return TermRanking(tuple(rows), None, None, *unlisted)
    exceeds = (np.array(errors) * whole > limit).any(axis=1)
    # The first row is without any dropped term; unlisted terms may exceed it already.
    may_go = max(int(exceeds.argmax()) - 1, 0) if exceeds.any() else len(errors) - 1
    return TermRanking(tuple(rows), tuple(limit.tolist()), may_go, *unlisted)


def _order_of_elimination(effects: FloatArray) -> list[int]:
    """Terms, of effects (K, n, N), in the order in which each adds least to the squared error so far."""
    flat = effects.reshape(len(effects), -1)
    gram = flat @ flat.T
    size, slope = np.diag(gram), np.zeros(len(gram))
    remaining: NDArray[np.intp] = np.arange(len(gram))
    order: list[int] = []
    while len(remaining):
        place = int((size[remaining] + 2.0 * slope[remaining]).argmin())
        term = int(remaining[place])
        order.append(term)
        slope += gram[term]
        remaining = np.delete(remaining, place)
    return order
