"""Equations that follow the budget: every term that some budget keeps, with the budgets that keep it."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from gd_analyze.formulas.formula import NOTHING, Formula, Piece, Product
from gd_analyze.formulas.mathml import PageMathML
from gd_analyze.formulas.writing import carried, grouped, powers, rate_powers, torque_symbol
from gd_analyze.harmonics.terms import TorqueTerm, quantity_of
from gd_analyze.report.budget_path import BudgetPath
from gd_analyze.results import Findings

_MATHS = PageMathML()


@dataclass(frozen=True)
class Summand:
    """One term: its sign, the rest of it, at which budgets it is kept ("0" or "1" each), and whether now."""

    negative: bool
    body: Markup
    kept: str
    now: bool


@dataclass(frozen=True)
class Group:
    """Terms that are multiplied with the same rates, in brackets before these where there are several."""

    negative: bool
    behind: Markup
    terms: tuple[Summand, ...]

    @property
    def now(self) -> int:
        """How many stand there at the budget of the report."""
        return sum(term.now for term in self.terms)


@dataclass(frozen=True)
class TorqueLines:
    """Torque of a joint, a line per quantity."""

    left: Markup
    carried: Markup
    lines: tuple[tuple[str, tuple[Group, ...]], ...]

    @property
    def now(self) -> int:
        """How many terms stand there at the budget of the report."""
        return sum(group.now for _, groups in self.lines for group in groups)


def budget_equations(findings: Findings, path: BudgetPath) -> tuple[TorqueLines, ...]:
    """Write the torques of a model of terms with all that any of the budgets keeps.

    Coefficients are the model's, which may have been refitted, and of terms that it leaves out the exact ones.
    """
    model, rates = findings.model, findings.model.form.rates
    exact = {term: weight for term, weight in findings.ranked_terms.items() if "1" in path.kept.get(term, "")}
    torques = exact | model.torques
    out = []
    for joint, groups in enumerate(grouped(rates.n_joints, torques)):
        lines: dict[str, list[Group]] = {}
        for before, terms in groups:
            written = [_summand(term, torques[term], path, term in model.torques) for term in terms]
            lines.setdefault(quantity_of(before), []).append(_group(terms, written))
        first = carried(joint) if rates.carries_next(joint) else None
        out.append(
            TorqueLines(
                Markup(_MATHS.left(Formula(torque_symbol(joint), NOTHING))),
                Markup(f"<math>{_MATHS.body(first)}</math>") if first else Markup(""),
                tuple((quantity, tuple(groups)) for quantity, groups in lines.items()),
            )
        )
    return tuple(out)


def _group(terms: list[TorqueTerm], written: list[Summand]) -> Group:
    """Bracket terms; the first one's sign goes before the bracket."""
    behind = rate_powers(terms[0].rates)
    if not behind or len(terms) == 1:
        return Group(False, Markup(""), tuple(written))
    ...
