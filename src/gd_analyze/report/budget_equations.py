"""Equations that follow the budget: every term that some budget keeps, and which budgets these are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup

from gd_analyze.formulas.formula import NOTHING, Formula, Product
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.formulas.writing import carried, grouped, powers, torque_symbol, velocity_powers
from gd_analyze.harmonics.terms import Torques, TorqueTerm, quantity_of
from gd_analyze.report.budget_path import BudgetPath
from gd_analyze.results.findings import Findings

_MATHS = PageMathML()


class Summand(NamedTuple):
    """One term, written without its sign; `kept` has a "1" for every budget that keeps it, "0" otherwise."""

    term: TorqueTerm
    negative: bool
    body: Markup
    kept: str
    now: bool


@dataclass(frozen=True)
class Group:
    """Terms with the same rates: in brackets before these, or by themselves, with none `behind`."""

    terms: tuple[Summand, ...]
    behind: Markup
    negative: bool

    @property
    def shown(self) -> list[Summand]:
        """Terms that stand there at the budget of the report."""
        return [term for term in self.terms if term.now]


@dataclass(frozen=True)
class TorqueLines:
    """Torque of a joint: what it carries, and a line per quantity."""

    left: Markup
    carried: Markup
    lines: dict[str, list[Group]]

    @property
    def first(self) -> Summand | Group | None:
        """What the right-hand side begins with at the budget of the report, whose plus sign is not said."""
        if self.carried:
            return None
        groups = (group for groups in self.lines.values() for group in groups if group.shown)
        group = next(groups, None)
        return group if group is None or group.behind else group.shown[0]

    @property
    def is_nothing(self) -> bool:
        """Whether no term stands there at the budget of the report."""
        return not self.carried and self.first is None


def budget_equations(findings: Findings, path: BudgetPath) -> tuple[TorqueLines, ...]:
    """Write the torques of a model of terms with all that any of the budgets keeps.

    Coefficients are the model's, refitted where it is, and of terms that it leaves out the exact ones.
    """
    model, rates = findings.model, findings.model.form.velocities
    flags = {
        term: path.flags[rank]
        for rank, term in enumerate(findings.ranked_terms, start=1)
        if rank in path.flags
    }
    torques = {term: findings.ranked_terms[term] for term in flags} | dict(model.torques)
    # What cancels in the exact torque is not ranked, but a model of energies may have it.
    here = "".join("1" if k == path.asked else "0" for k in range(len(path.rows)))
    flags |= {term: here for term in model.torques if term not in flags}
    out = []
    for joint, groups in enumerate(grouped(rates.n_joints, torques)):
        lines: dict[str, list[Group]] = {}
        for before, terms in groups:
            made = _group(terms, torques, flags, model.torques)
            lines.setdefault(quantity_of(before), []).append(made)
        first = Formula(torque_symbol(joint), tuple(carried(rates, joint)))
        left = Markup(_MATHS.left(Formula(torque_symbol(joint), NOTHING)))
        out.append(TorqueLines(left, _math(_MATHS.right(first)) if first.pieces else Markup(""), lines))
    return tuple(out)


def _group(terms: list[TorqueTerm], torques: Torques, flags: dict[TorqueTerm, str], now: Torques) -> Group:
    """Bracket several terms that have rates; the sign of the first that is shown goes before the bracket."""
    rates = velocity_powers(terms[0].velocities)
    bracketed = len(terms) > 1 and bool(rates)
    outer = bracketed and torques[next((term for term in terms if term in now), terms[0])] < 0
    inside = () if bracketed else rates
    summands = tuple(
        Summand(
            term,
            (torques[term] < 0) != outer,
            _math(_MATHS.product(Product(torques[term], powers(term.monomial) + inside))),
            flags[term],
            term in now,
        )
        for term in terms
    )
    behind = _math(_MATHS.apart.join(map(_MATHS.power, rates))) if bracketed else Markup("")
    return Group(summands, behind, outer)


def _math(content: str) -> Markup:
    return Markup(f"<math>{content}</math>")
