"""The budget slider: models on one path, and the terms that each keeps."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from gd_analyze.formulas.formula import NOTHING, Formula, Product
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.formulas.writing import carried, grouped, powers, torque_symbol, velocity_powers
from gd_analyze.harmonics.terms import Torques, TorqueTerm, quantity_of
from gd_analyze.report.model_sections import made_of
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row, budget_rows
from gd_analyze.text import pretty

# Decades of the axis of errors over the budget.
_LOW, _HIGH = -2, 1
_MATHS = PageMathML()
_PAREN = '<math class="paren"><mo stretchy="false">{}</mo></math>'
_LETTERS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}


@dataclass(frozen=True)
class BudgetPath:
    """Models for increasing budgets."""

    rows: list[Row]  # of `gd_analyze.results.rows.budget_rows`
    # By rank of a term or label of a part that any budget keeps: "1" or "0" for each budget
    flags: dict[Any, str]
    asked: int  # index of the budget asked for

    @classmethod
    def of(cls, findings: Findings) -> BudgetPath:
        """Read the table."""
        rows = budget_rows(findings)
        kept = [set(row["kept"]) for row in rows]
        everything = sorted(set().union(*kept))
        flags = {one: "".join("1" if one in of_row else "0" for of_row in kept) for one in everything}
        return cls(rows, flags, [row["factor"] for row in rows].index(1.0))

    @property
    def moves(self) -> bool:
        """Whether any budget gives a model other than the one asked for."""
        return len({row["operations"] for row in self.rows}) > 1

    def data(self, findings: Findings) -> dict[str, Any]:
        """Values for the page's script; positions of errors are percent of their axis."""
        model, allowed, whole = findings.model, findings.model.accuracy.allowed, findings.model.accuracy.whole
        errors = np.array([row["largest_error"] for row in self.rows])
        counts = [row["operations"] for row in self.rows]
        ratio = np.divide(errors, allowed, out=np.zeros_like(errors), where=allowed > 0.0)
        return {
            "factor": [row["factor"] for row in self.rows],
            "label": [budget_words(row["budget"]) for row in self.rows],
            "operations": counts,
            "kept": [len(row["kept"]) for row in self.rows],
            "keeps": {"terms": model.level.keeps, "parts": "parts"}.get(made_of(findings), ""),
            "exact": model.operations_full.total,
            "largest_error": [[float(f"{error:.4g}") for error in row] for row in errors],
            "place": [[place(share) for share in row] for row in ratio],
            "limit": [place(row["factor"]) for row in self.rows],
            "allowed": allowed.tolist(),
            "whole": whole.tolist(),
            "shares_of": model.accuracy.asked.shares_of,
            "unit": [joint.effort_unit for joint in findings.arm.joints],
        }


def place(ratio: float) -> float:
    """Position of the ratio of error to budget on the axis of the joints' errors, percent from the left."""
    decade = math.log10(ratio) if ratio > 0.0 else _LOW
    return round(100 * (min(max(decade, _LOW), _HIGH) - _LOW) / (_HIGH - _LOW), 2)


def budget_words(budget: str) -> str:
    """A budget with the reference of its percentages, numbers to three digits."""
    rounded = re.sub(r"\d+(\.\d+)?(e[+-]?\d+)?", lambda found: f"{float(found[0]):.3g}", budget)
    words = re.sub(r"% (?=limit|friction|uncertainty)", " % of ", pretty(rounded))
    return re.sub(r"%(?=$|,| or)", " % of peak torque", words)


class _Group(NamedTuple):
    """Terms with the same velocities: in brackets before these, or alone, with nothing `behind`."""

    terms: list[tuple[TorqueTerm, str]]  # each with its formula without sign
    behind: str
    negative: bool  # of the bracket


class _Writer(NamedTuple):
    """The torques of a model of terms, with all terms that any budget keeps."""

    torques: Torques  # coefficients
    flags: dict[TorqueTerm, str]  # "1" for every budget that keeps the term
    now: Torques  # the report's own model, which is shown without scripts

    def group(self, terms: list[TorqueTerm]) -> _Group:
        """Bracket several terms with velocities; the sign of the first one shown precedes the bracket."""
        velocities = velocity_powers(terms[0].velocities)
        bracketed = len(terms) > 1 and bool(velocities)
        negative = (
            bracketed and self.torques[next((term for term in terms if term in self.now), terms[0])] < 0
        )
        inside = () if bracketed else velocities
        products = [Product(self.torques[term], powers(term.monomial) + inside) for term in terms]
        bodies = [f"<math>{_MATHS.product(product)}</math>" for product in products]
        behind = f"<math>{_MATHS.apart.join(map(_MATHS.power, velocities))}</math>" if bracketed else ""
        return _Group(list(zip(terms, bodies, strict=True)), behind, negative)

    def shown(self, group: _Group) -> list[TorqueTerm]:
        return [term for term, _ in group.terms if term in self.now]

    def html(self, group: _Group, *, first: bool) -> str:
        """A group; its sign is hidden if it is the `first` of a torque."""
        shown = self.shown(group)
        leads = shown[:1] if first or group.behind else []
        out = []
        for term, body in group.terms:
            negative = (self.torques[term] < 0) != group.negative
            kind = "term" + " first" * (term in leads) + " negative" * negative
            hidden = "" if term in self.now else " hidden"
            inside = f"<wbr>{_sign(negative)}{body}"
            out.append(f'<span class="{kind}" data-kept="{self.flags[term]}"{hidden}>{inside}</span>')
        if not group.behind:
            return "".join(out)
        single = len(shown) == 1 and (self.torques[shown[0]] < 0) == group.negative
        kind = "bracket" + " first" * first + " single" * single + " negative" * group.negative
        return (
            f'<span class="{kind}"{"" if shown else " hidden"}><wbr>{_sign(group.negative)}'
            f"{_PAREN.format('(')}{''.join(out)}{_PAREN.format(')')}{group.behind}</span>"
        )

    def torque(self, joint: int, carries: str, lines: dict[str, list[_Group]]) -> str:
        """Lines of one torque: torque of outer joints, then D, h and c."""
        is_first, rows = not carries, [f'<p class="line carried">{carries}</p>\n' if carries else ""]
        for quantity, groups in lines.items():
            out = []
            for group in groups:
                out.append(self.html(group, first=is_first and bool(self.shown(group))))
                is_first = is_first and not self.shown(group)
            hidden = "" if any(map(self.shown, groups)) else " hidden"
            name = quantity.replace("_", " and ", 1)
            rows.append(
                f'<p class="line {quantity}"{hidden}><b title="{name}">{_LETTERS[quantity]}</b>'
                f"{''.join(out)}</p>\n"
            )
        left = _MATHS.left(Formula(torque_symbol(joint), NOTHING))
        return (
            f'<div class="torque" role="group" aria-label="Torque of joint {joint + 1}">\n'
            f'<p class="left">{left}</p>\n<div>{"".join(rows)}<p class="line nothing"'
            f"{'' if is_first else ' hidden'}><math><mn>0</mn></math></p></div>\n</div>\n"
        )


def budget_equations(findings: Findings, path: BudgetPath) -> Markup:
    """Write the torques of a model of terms with all terms that any budget keeps.

    Coefficients are the model's, refitted if it is, and the exact ones for terms that it drops.
    """
    model, velocities = findings.model, findings.model.form.velocities
    ranked = enumerate(findings.ranked_terms, start=1)
    flags = {term: path.flags[rank] for rank, term in ranked if rank in path.flags}
    torques = {term: findings.ranked_terms[term] for term in flags} | dict(model.torques)
    # Terms that cancel in the exact torque are not ranked, but a model of energies may have them.
    here = "".join("1" if k == path.asked else "0" for k in range(len(path.rows)))
    writer = _Writer(torques, dict.fromkeys(model.torques, here) | flags, model.torques)
    out = []
    for joint, groups in enumerate(grouped(velocities.n_joints, torques)):
        lines: dict[str, list[_Group]] = {}
        for before, terms in groups:
            lines.setdefault(quantity_of(before), []).append(writer.group(terms))
        outer = Formula(torque_symbol(joint), tuple(carried(velocities, joint)))
        carries = f"<math>{_MATHS.right(outer)}</math>" if outer.pieces else ""
        out.append(writer.torque(joint, carries, lines))
    return Markup("".join(out))


def _sign(negative: bool) -> str:
    kind, sign = ("minus", "−") if negative else ("plus", "+")
    return f'<math class="sign {kind}"><mo rspace=".25em">{sign}</mo></math>'
