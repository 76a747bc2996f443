"""Harmonic terms as the page shows them: the model's equations, what it keeps of how many, the ranking."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from markupsafe import Markup

from gd_analyze.findings import Findings
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.equations import equations
from gd_analyze.harmonics.terms import Rate, Torques, TorqueTerm
from gd_analyze.harmonics.torque_mathml import (
    element_mathml,
    torque_legend_mathml,
    torque_term_mathml,
    torques_to_mathml,
)
from gd_analyze.models import HarmonicModel
from gd_analyze.report.context import Context
from gd_analyze.simplification import RankedTerm

# A page that writes out more exact terms than this would be for no one to read.
MOST_EXACT_TERMS = 2000


@dataclass(frozen=True)
class Lines:
    """What one quantity adds to a torque: formulas that a line may break between."""

    quantity: str
    pieces: tuple[Markup, ...]


@dataclass(frozen=True)
class TorqueView:
    """Equation of one joint's torque."""

    left: Markup
    lines: tuple[Lines, ...]


@dataclass(frozen=True)
class Tally:
    """How many of an entry's terms the model keeps, and what the entry is called."""

    quantity: str
    what: str
    kept: int
    total: int


@dataclass(frozen=True)
class TermRow:
    """One row of the ranking of single terms; `kept` is None for a model that is not made of terms."""

    ranked: RankedTerm
    row: int
    formula: Markup
    kept: bool | None


@dataclass(frozen=True)
class ExactTerm:
    """One term of an exact element, and where it comes from."""

    formula: Markup
    effect: str
    links: str


@dataclass(frozen=True)
class ExactElement:
    """One exact element of D or c."""

    left: Markup
    terms: tuple[ExactTerm, ...]


def exact_torques(findings: Findings) -> Torques:
    """Every torque term of the exact model and its weight."""
    return {
        ranked.term: ranked.weight
        for ranked in findings.terms.terms
        if isinstance(ranked.term, TorqueTerm)  # the main job ranks those of the torques
    }


def torque_views(findings: Findings) -> tuple[TorqueView, ...]:
    """Equations of a model of harmonic terms; none for another."""
    model = findings.model
    if not isinstance(model, HarmonicModel):
        return ()
    return tuple(
        TorqueView(
            Markup(joint.left),
            tuple(Lines(share.quantity, tuple(map(Markup, share.pieces))) for share in joint.shares),
        )
        for joint in torques_to_mathml(AbsoluteRates.of(findings.arm), model.torques)
    )


def torque_legend(findings: Findings, exact: Torques) -> tuple[Markup, ...]:
    """Meaning of the names in the model's equations, or of those in the ranking where it has none."""
    model = findings.model
    used = model.torques if isinstance(model, HarmonicModel) else exact
    return tuple(map(Markup, torque_legend_mathml(AbsoluteRates.of(findings.arm), used)))


def shared_accelerations(findings: Findings) -> tuple[Markup, ...]:
    """Meaning of the accelerations that add up those of parallel joints."""
    basis = AbsoluteRates.of(findings.arm)
    inner = [joint for run in basis.runs for joint in run[1:]]
    used = [TorqueTerm(0, (Rate(2, joint),), ()) for joint in inner]
    return tuple(map(Markup, torque_legend_mathml(basis, used)))


def tallies(findings: Findings, exact: Torques) -> tuple[tuple[Tally, ...], ...]:
    """Terms kept and terms there are, by row: one entry per acceleration, then h, then c."""
    model = findings.model
    if not isinstance(model, HarmonicModel):
        return ()
    n = findings.arm.n_joints
    kept, total = (Counter(map(_place, torques)) for torques in (model.torques, exact))
    columns = [("inertia", j, f"with acceleration {j + 1}") for j in range(n)]
    columns += [("coriolis_centrifugal", -1, "Coriolis and centrifugal"), ("gravity_loading", -1, "gravity")]
    return tuple(
        tuple(
            Tally(quantity, f"Joint {i + 1}, {what}", kept[i, quantity, j], total[i, quantity, j])
            for quantity, j, what in columns
        )
        for i in range(n)
    )


def _place(term: TorqueTerm) -> tuple[int, str, int]:
    """Row, quantity and the acceleration's joint, -1 without one."""
    return term.row, term.quantity, term.rates[0].joint if term.quantity == "inertia" else -1


def term_rows(findings: Findings, context: Context) -> tuple[TermRow, ...]:
    """Rows of the ranking with their formulas."""
    model = findings.model
    kept = model.torques if isinstance(model, HarmonicModel) else None
    return tuple(
        TermRow(
            ranked,
            ranked.term.row + 1,
            Markup(torque_term_mathml(ranked.term, ranked.weight)),
            None if kept is None else ranked.term in kept,
        )
        for ranked in context.terms
        if isinstance(ranked.term, TorqueTerm)
    )


def exact_elements(findings: Findings) -> tuple[ExactElement, ...]:
    """D and c written out; nothing where that would be too long to read."""
    harmonics = findings.harmonics
    if harmonics is None:
        return ()
    if sum(map(len, (*harmonics.inertia.values(), *harmonics.gravity_loading))) > MOST_EXACT_TERMS:
        return ()
    out = []
    for equation in equations(harmonics):
        left, formulas = element_mathml(equation)
        origins = [(term.effect, ", ".join(map(str, term.links))) for term in equation.terms]
        gravity = equation.symbol.startswith("c")
        out.append(
            ExactElement(
                Markup(left),
                tuple(
                    ExactTerm(Markup(formula), "gravity" if gravity else effect, links)
                    for formula, (effect, links) in zip(formulas, origins, strict=True)
                ),
            )
        )
    return tuple(out)
