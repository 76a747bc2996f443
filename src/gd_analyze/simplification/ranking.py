"""Every term of D, h and c by what it does to torque: alone, and together with all that matter less."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from gd_analyze.formulas.plain import Plain
from gd_analyze.formulas.writing import term_formula
from gd_analyze.harmonics.terms import EnergyTerm, TorqueTerm
from gd_analyze.models.harmonic import HarmonicLevel
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.uncertainty import torque_uncertainty
from gd_analyze.vectors import FloatArray

_WHOLE = Budget((1.0,), (True,))


@dataclass(frozen=True)
class RankedTerm:
    """One term in the ranking; shares are of the joint's peak torque, joints count from 1.

    Parameters
    ----------
    rank
        1 is what is missed most.
    label
        Where it stands: "tau2" or, at level energy, "D'12" and "U".
    quantity
        "inertia", "coriolis_centrifugal", "gravity_loading"; "kinetic" or "potential" at level energy.
    text
        The term as a person would write it.
    term, weight
        The term itself and its coefficient.
    alone_torque, alone_joint, alone_share
        Its own largest torque, N m, at the joint where that is most of the peak torque.
    without_share, without_joint
        Largest torque error if it and everything ranked below it are left out, and the joint of that.
    below_uncertainty
        Whether its own torque stays, at every joint, below what the arm's stated uncertainties make of the
        torque; None where none are stated.
    """

    rank: int
    label: str
    quantity: str
    text: str
    term: TorqueTerm | EnergyTerm
    weight: float
    alone_torque: float
    alone_joint: int
    alone_share: float
    without_share: float
    without_joint: int
    below_uncertainty: bool | None

    @property
    def plain(self) -> dict[str, str | int | float | bool | None]:
        """All of it but the term itself, as plain values."""
        names = (field.name for field in fields(self))
        return {name: getattr(self, name) for name in names if name != "term"}


@dataclass(frozen=True)
class TermRanking:
    """Terms, the most important first, and how many of the last are within the parameters' uncertainty.

    Parameters
    ----------
    terms
        One entry per term.
    uncertainty
        Largest standard uncertainty of every joint's torque at the states, N m; None where none is stated.
    not_worth_keeping
        How many terms, from the last, may all go with every joint's error below that.
    unlisted, unlisted_share
        How many of the smallest terms of an arm with very many are not ranked, and the largest torque they
        make together, over the joint's peak torque.
    """

    terms: tuple[RankedTerm, ...]
    uncertainty: tuple[float, ...] | None
    not_worth_keeping: int
    unlisted: int
    unlisted_share: float

    @classmethod
    def none(cls) -> TermRanking:
        """No term ranked."""
        return cls((), None, 0, 0, 0.0)


def rank_terms(exact: ExactDynamics, level: HarmonicLevel = "term", digits: int = 3) -> TermRanking:
    """Rank the terms of an arm's dynamics by the torque they make at given states.

    Of very many states some thousand stand for all. Terms go one by one, each time the one whose loss adds
    the least squared torque error to all that went before, each joint's error taken relative to its peak
    torque. The last to go ranks first.

    Parameters
    ----------
    exact
        Exact dynamics at the states that count.
    level
        Terms of the torques or of the energies.
    digits
        Significant digits in the terms' texts.
    """
    exact = exact.thinned()
    whole = exact.allowed(_WHOLE)
    candidates = candidates_of(exact, level, whole, np.inf)
    elimination = eliminate(candidates, by_cost=False)
    listed = 1.0 - candidates.swept
    errors = listed * elimination.errors() + candidates.swept
    alone = listed * np.abs(candidates.effects).max(axis=2, initial=0.0)
    spread = torque_uncertainty(exact.arm, exact.states, exact.drives)
    limit = None if spread is None else np.abs(spread).max(axis=0)
    labels = _written(exact, level, digits)
    rows = []
    went = zip(reversed(elimination.order), errors[:0:-1], strict=True)
    for rank, (k, without) in enumerate(went, start=1):
        joint, worst = int(alone[k].argmax()), int(without.argmax())
        label, quantity, text, term, weight = labels[candidates.members[k]]
        rows.append(
            RankedTerm(
                rank=rank,
                label=label,
                quantity=quantity,
                text=text,
                term=term,
                weight=weight,
                alone_torque=float(alone[k, joint] * whole[joint]),
                alone_joint=joint + 1,
                alone_share=float(alone[k, joint]),
                without_share=float(without[worst]),
                without_joint=worst + 1,
                below_uncertainty=None if limit is None else bool((alone[k] * whole <= limit).all()),
            )
        )
    return TermRanking(
        tuple(rows),
        None if limit is None else tuple(limit.tolist()),
        0 if limit is None else _first_beyond(errors * whole, limit),
        candidates.total - len(rows),
        candidates.swept,
    )


def _first_beyond(errors: FloatArray, limit: FloatArray) -> int:
    """How many terms may go before any joint's error exceeds its limit for the first time."""
    beyond = (errors > limit).any(axis=1)
    return int(beyond.argmax()) - 1 if beyond.any() else len(errors) - 1


def _written(
    exact: ExactDynamics, level: HarmonicLevel, digits: int
) -> list[tuple[str, str, str, TorqueTerm | EnergyTerm, float]]:
    """Label, quantity, text, term and weight of every candidate."""
    plain = Plain(digits)
    out = []
    terms: Mapping[Any, float] = exact.torques if level == "term" else exact.energy
    for term, weight in terms.items():
        formula = term_formula(term, weight)
        if isinstance(term, TorqueTerm):
            quantity = term.quantity
        else:
            quantity = "potential" if term.is_potential else "kinetic"
        out.append((plain.symbol(formula.left), quantity, plain.right(formula), term, weight))
    return out
