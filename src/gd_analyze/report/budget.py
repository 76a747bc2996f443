"""The budget slider: models on one path, and the terms of D, h and c that each keeps."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.formula import Formula, Power, Product, Symbol
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.harmonics.terms import Torques
from gd_analyze.operations.program import OperationCount
from gd_analyze.report.document import legend_of
from gd_analyze.report.model_sections import made_of
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import structure_note, worst_error
from gd_analyze.results.near_motion import near_bound
from gd_analyze.results.rows import Row, budget_rows
from gd_analyze.results.run_facts import stop_rows
from gd_analyze.simplification.accuracy import gamma_size
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.text import percent, pretty, share_up, thousands

_MATHS = PageMathML()
_QUANTITIES = {"D": "inertia", "J": "drive", "h": "coriolis_centrifugal", "c": "gravity_loading"}


@dataclass(frozen=True)
class BudgetPath:
    """Models for increasing budgets."""

    rows: list[Row]  # of `gd_analyze.results.rows.budget_rows`
    asked: int  # index of the budget asked for

    @classmethod
    def of(cls, findings: Findings) -> BudgetPath:
        """Read the table."""
        return cls(budget_rows(findings), int(findings.tables["budgets"].attrs["asked"]))

    @property
    def moves(self) -> bool:
        """Whether any budget gives a model other than the one asked for."""
        return len({(row["operations"], len(row["kept"])) for row in self.rows}) > 1

    def torques(self, findings: Findings, k: int) -> Torques:
        """Torque terms of the model at a position; the report's own coefficients where it has the term."""
        model = findings.model
        if k == self.asked:
            return model.torques
        ranked = [*findings.ranked_terms.items()]
        kept_terms = (ranked[rank - 1] for rank in self.rows[k]["kept"])
        return TERM.torques(model.form, {term: model.terms.get(term, weight) for term, weight in kept_terms})

    def formulas(self, findings: Findings, k: int) -> tuple[Formula, ...]:
        """Elements of the model at a position."""
        return findings.model.by_element(self.torques(findings, k)).formulas

    def proofs(self, findings: Findings) -> list[str]:
        """What is known of each model near the motion."""
        out = ["Errors are sampled at the set points, not proven."] * len(self.rows)
        for row in stop_rows(findings):
            share, gamma = row["proven_share"], row["gamma"]
            if row["position"] >= 0 and share is not None and share <= 1.0:
                used = percent(share_up(share))
                sentence = f"Near the motion the model uses at most {used} of this budget ({findings.proof})."
                out[row["position"]] = (
                    sentence if gamma is None else f"{sentence} Mass matrix within {gamma_size(gamma)}."
                )
        bound = near_bound(findings)
        if bound is not None:
            worst = worst_error(findings.model, bound)
            sentence = f"Torque error at most {worst.text} near the motion ({findings.proof})."
            # A wider budget may have the same model.
            own_terms = self.rows[self.asked]["kept"]
            out = [
                sentence if row["kept"] == own_terms else text
                for row, text in zip(self.rows, out, strict=True)
            ]
        return out

    def data(self, findings: Findings) -> dict[str, Any]:
        """Models by position, for the page and its script."""
        model, whole = findings.model, findings.model.accuracy.whole
        of_peak = model.accuracy.asked.shares_of == "peak torque"
        errors, limits = (
            np.array([row[name] for row in self.rows]) for name in ("largest_error", "allowed_error")
        )
        return {
            "asked": self.asked,
            "label": [budget_words(row["budget"]) for row in self.rows],
            "operations": [row["operations"] for row in self.rows],
            "angles": [row["sines_cosines"] for row in self.rows],
            "apart": [row["operations_apart"] for row in self.rows],
            "angles_apart": [row["sines_cosines_apart"] for row in self.rows],
            "kept": [len(row["kept"]) for row in self.rows],
            "proof": self.proofs(findings),
            "keeps": {"terms": model.level.keeps, "parts": "parts"}.get(made_of(findings), ""),
            "largest_error": [[float(f"{error:.4g}") for error in row] for row in errors],
            "used": [used(*row, findings.round_off) for row in zip(errors, limits, strict=True)],
            "allowed": limits.tolist(),
            "whole": [whole.tolist() if of_peak else row for row in limits.tolist()],
            "shares_of": model.accuracy.asked.shares_of,
            "unit": [joint.effort_unit for joint in findings.arm.joints],
        }


def budget_data(findings: Findings) -> dict[str, Any]:
    """The slider: named budgets, models by position, and the exact counts beside theirs.

    Without other models "path" is None, and "reason" says why.
    """
    model, kind, path = findings.model, made_of(findings), BudgetPath.of(findings)
    reason = ""
    if not path.moves and len(path.rows) > 1 and kind != "exact":
        low, high = (budget_words(path.rows[k]["budget"]) for k in (0, -1))
        same = "the model stays the same" if model.saves else "dropping terms would not save an operation"
        reason = f"No other model from {low} to {high}: {same}."
    apart = model.form.functions.operations if path.moves and kind == "terms" else None
    return {
        "stops": [
            {"position": row["position"], "own": row["own"], "words": row["words"]}
            | {"budget": budget_words(row["budget"])}
            for row in stop_rows(findings)
        ],
        "path": path.data(findings) if path.moves else None,
        "reason": reason,
        "made_of": kind,
        "kept_of": thousands(model.size[1]),
        "torque_full": _counts(model.operations_full),
        "apart_full": None if apart is None else _counts(apart),
        "worst": percent(float(model.accuracy.shares.max(initial=0.0))),
    }


def _counts(operations: OperationCount) -> dict[str, int]:
    return {"operations": operations.total, "angles": operations.sines_cosines}


def used(errors: FloatArray, allowed: FloatArray, round_off: float) -> list[float]:
    """Errors of the joints over the allowed ones, to four digits; 0 where an error is round-off."""
    counts = (errors > round_off) & (allowed > 0.0)
    shares = np.divide(errors, allowed, out=np.zeros_like(errors), where=counts)
    return [float(f"{share:.4g}") for share in shares]


def budget_words(budget: str) -> str:
    """A budget with the reference of its percentages, numbers to three digits."""
    text = Budget.parse(budget).words
    rounded = re.sub(r"\d+(\.\d+)?(e[+-]?\d+)?", lambda match: f"{float(match[0]):.3g}", text)
    words = re.sub(r"% limit", " % of the torque limit", pretty(rounded))
    of_log = "the log's residual with fitted links"
    words = re.sub(r"^log", of_log, words.replace("% log", f" % of {of_log}"))
    words = re.sub(r"% (?=friction|uncertainty)", " % of ", words)
    return re.sub(r"%(?=$|,| or)", " % of peak torque", words)


class Summand(NamedTuple):
    """A summand of an element: its factors apart from velocities, the velocities, and the coefficient."""

    factors: tuple[Power, ...]
    velocities: tuple[Power, ...]
    weight: float


def summands(formula: Formula) -> Iterator[Summand]:
    """Split a formula of `element_formulas` into summands, brackets multiplied out."""
    bracket: list[Product] = []
    outer, is_open = 1.0, False
    for piece in formula.pieces:
        weight, powers = piece.product
        if piece.opens:
            is_open, outer = True, math.copysign(1.0, weight)
        if not is_open:
            velocities = tuple(power for power in powers if _is_velocity(power))
            yield Summand(tuple(power for power in powers if power not in velocities), velocities, weight)
            continue
        bracket.append(Product(weight if not bracket else outer * weight, powers))
        if piece.behind:
            yield from (Summand(powers, piece.behind, weight) for weight, powers in bracket)
            bracket, is_open = [], False


def _is_velocity(power: Power) -> bool:
    return isinstance(power.base, Symbol) and power.base.dots > 0


@dataclass
class _Term:
    """A summand with one coefficient, and the budgets whose models have it."""

    summand: Summand
    budgets: set[int] = field(default_factory=set)

    def data(self, path: BudgetPath, *, in_bracket: bool = False, turned: bool = False) -> dict[str, Any]:
        """For the page; in a bracket velocities stand behind it, and its sign may turn that of the term."""
        factors, velocities, weight = self.summand
        powers = factors if in_bracket else factors + velocities
        return {
            "mathml": f"<math>{_MATHS.product(Product(abs(weight), powers))}</math>",
            "negative": (weight < 0.0) != turned,
            "hidden": path.asked not in self.budgets,
            "kept": "".join("1" if k in self.budgets else "0" for k in range(len(path.rows))),
        }


# Terms of an element by velocities, by other factors, and by the coefficient as it is written.
_ByFactors = dict[tuple[Power, ...], dict[str, _Term]]
_Line = dict[tuple[Power, ...], _ByFactors]


def _group(path: BudgetPath, velocities: tuple[Power, ...], by_factors: _ByFactors) -> dict[str, Any]:
    """Terms with the same velocities, in a bracket if there are several; the first sign precedes it."""
    terms = [term for versions in by_factors.values() for term in versions.values()]
    if len(terms) == 1 or not velocities:
        return {"bracketed": False, "terms": [term.data(path) for term in terms]}
    first = next((term for term in terms if path.asked in term.budgets), terms[0])
    turned, space = first.summand.weight < 0.0, _MATHS.between_factors
    return {
        "bracketed": True,
        "terms": [term.data(path, in_bracket=True, turned=turned) for term in terms],
        "negative": turned,
        "velocities": f"<math>{space}{space.join(map(_MATHS.power, velocities))}</math>",
    }


def budget_equations(findings: Findings, path: BudgetPath) -> list[dict[str, Any]]:
    """Write D, J (drives), h and c by element, with all terms that any budget keeps.

    Coefficients are the model's, and the exact ones of terms that it drops.
    """
    elements: dict[Symbol, _Line] = defaultdict(lambda: defaultdict(lambda: defaultdict(dict)))
    # The report's own model first, so that its terms keep their order.
    for k in sorted(range(len(path.rows)), key=lambda k: abs(k - path.asked)):
        for formula in path.formulas(findings, k):
            for summand in summands(formula):
                written = _MATHS.product(Product(summand.weight))
                written += "-" if summand.weight < 0.0 else ""
                versions = elements[formula.left][summand.velocities][summand.factors]
                versions.setdefault(written, _Term(summand)).budgets.add(k)
    order = [*_QUANTITIES]
    return [
        {
            "quantity": _QUANTITIES[left.letter],
            "label": f"{left.letter}{left.index}",
            "left": _MATHS.left(Formula(left, ())),
            "groups": [
                _group(path, velocities, by_factors) for velocities, by_factors in elements[left].items()
            ],
        }
        for left in sorted(elements, key=lambda left: (order.index(left.letter), _joints(left)))
    ]


def terms_data(findings: Findings) -> dict[str, Any] | None:
    """The model's terms as the slider moves them, with what explains them; None without terms."""
    model = findings.model
    if made_of(findings) != "terms":
        return None
    structure, _, gamma = structure_note(model).partition("\n")
    return {
        "structure": structure,
        "gamma": gamma,
        "elements": budget_equations(findings, BudgetPath.of(findings)),
        "legend": legend_of(model.equations.legend),
        "own_coefficients": model.level is ENERGY,
    }


def _joints(left: Symbol) -> list[int]:
    """Joints of an element's index, for sorting."""
    joints = left.index.split(",") if "," in left.index else [*left.index]
    return [*map(int, joints)]
