"""Do Tables 3.1, 3.4 and 3.5 of [FGL87] hold?

Sets the operations that our formulations carry out beside [FGL87]'s, row by row where our code has the same
parts, and says why they differ. Writes `tables_3_1_3_4_3_5.md` beside this file; run it again after any change:

    python analysis/tables_3_1_3_4_3_5.py
"""

from __future__ import annotations

import linecache
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple, get_args

from formulation_costs import (
    SIZES,
    Counted,
    Growth,
    TextCost,
    explanation,
    growth,
    text_costs,
)
from gd_analyze import dynamics
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.operations.counting import Tally
from gd_analyze.operations.program import OperationCount
from gd_analyze.operations.trace import Expression, Operation
from gd_analyze.studies.formulations import count_cost

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from chains import generic_chain

N = 6


class Place(NamedTuple):
    """Who asks for an operation: a function of the formulation's file, what its statement assigns to, the helper called; "" outside."""

    function: str
    target: str
    helper: str


Parts = Mapping[Place, OperationCount]


def count_by_place(method: str) -> Parts:
    """Count a formulation's torque on the generic chain, statement by statement of its file, sines and cosines apart."""
    file = str(Path(dynamics.__file__ or "").with_name(f"{method}.py"))
    kinds: dict[Place, Counter[Operation]] = defaultdict(Counter)

    def asking() -> Place:
        frame: FrameType | None = sys._getframe()
        callers = []
        while frame := frame.f_back if frame else None:
            callers += [frame] if frame.f_code.co_filename == file else []
        if not callers:
            return Place("", "", "")
        statement = linecache.getline(file, callers[-1].f_lineno).strip()
        helper = next(name for f in callers if not (name := f.f_code.co_name).startswith("<"))
        return Place(callers[-1].f_code.co_name, re.split(r" [-+]?= ", statement)[0], helper)

    class Located(Tally):
        """Every operation is booked to the place that asks for it as well."""

        def record(self, operation: Operation, *arguments: Any) -> Expression:
            if operation in ("add", "subtract", "multiply"):
                kinds[asking()][operation] += 1
            return super().record(operation, *arguments)

    tally = Located()
    METHODS[method].torque(generic_chain(N), *(tally.inputs(name, N) for name in ("q", "qd", "qdd")))
    return {place: OperationCount.of(counter) for place, counter in kinds.items()}


@dataclass(frozen=True)
class Row:
    """Part of our code: [FGL87]'s row it stands for ("" where [FGL87] has none), which places, and why it differs."""

    text: str
    ours: str
    belongs: Callable[[Place], bool]
    why: str


def lagrange_euler_rows() -> tuple[Row, ...]:
    """Parts of `lagrange_euler.py` in the order of Table 3.1."""
    in_solve = {"steps", "first, second"}
    return (
        Row(
            "products of A_i",
            "transforms and their derivatives",
            lambda p: p.function == "solve" and p.target in in_solve,
            "ours forms U_jk and U_jkm here, once each; [FGL87] counts their products in every trace",
        ),
        Row(
            "-m_j g U_ji r_j",
            "gravity loading",
            lambda p: p.target in ("lever", "gravity_loading[i]"),
            "ours holds the sum over j, [FGL87]'s next row",
        ),
        Row("its sum over j", "", lambda p: False, "in the row above"),
        Row(
            "Tr(U_jk J_j U_ji^T)",
            "J_j U_ji, and traces for D",
            lambda p: (
                p.target == "weighted" or (p.target == "inertia[i, k]" and p.helper == "_trace_of_product")
            ),
            "a trace takes 16 multiplications once its factors are formed, in [FGL87] four 4x4 products, 256",
        ),
        Row(
            "its sum over j, for D",
            "sum for D",
            lambda p: p.target == "inertia[i, k]" and p.helper == "solve",
            "ours sums all of D, [FGL87] the upper triangle",
        ),
        Row(
            "Tr(U_jkm J_j U_ji^T)",
            "traces for h",
            lambda p: p.target == "christoffel[i, k, m]" and p.helper == "_trace_of_product",
            "as for D; [FGL87] takes n times its row for D, ours one trace per h_ikm and link",
        ),
        Row(
            "its sum over j, for h",
            "sum for h",
            lambda p: p.target == "christoffel[i, k, m]" and p.helper == "solve",
            "[FGL87] takes n times its sum for D, ours sums every h_ikm",
        ),
        Row(
            "",
            "D qdd + h + c",
            lambda p: p.function in ("coriolis_centrifugal", ""),
            "[FGL87]'s table ends with the coefficients",
        ),
    )


def newton_euler_rows() -> tuple[Row, ...]:
    """Parts of `newton_euler_link.py` in the order of Table 3.4."""

    def assigns(target: str) -> Callable[[Place], bool]:
        return lambda p: p.target == target

    axis = "the joint's axis has any direction in our link frames"
    return (
        Row("angular velocity", "omega", assigns("omega"), f"{axis}: three products with it"),
        Row(
            "angular acceleration",
            "omega_dot",
            assigns("omega_dot"),
            f"{axis}: its products and a full cross product",
        ),
        Row(
            "acceleration of the frame",
            "acceleration",
            assigns("acceleration"),
            "[FGL87] has one addition more",
        ),
        Row(
            "acceleration of the centre of mass",
            "com_acceleration",
            assigns("com_acceleration"),
            "ours takes three cross products of 6 multiplications",
        ),
        Row("inertial force F", "inertial_force", assigns("inertial_force"), "the same"),
        Row("force f", "force", assigns("force"), "ours carries it on into the base frame"),
        Row("inertial moment N", "couple", assigns("couple"), "the same"),
        Row("moment n", "moment", assigns("moment"), "ours carries it on into the base frame"),
        Row("", "rotation matrices", assigns("steps"), "from sines and cosines; no row of [FGL87]'s"),
        Row("", "torque", assigns("out[i]"), "n . z or f . z with any axis; no row of [FGL87]'s"),
    )


def booked(parts: Parts, rows: Sequence[Row]) -> list[OperationCount]:
    """Operations of each row; every operation belongs to exactly one."""
    for place in parts:
        owners = [row.ours for row in rows if row.belongs(place)]
        if len(owners) != 1:
            raise ValueError(f"{place} belongs to {owners or 'no row'}")
    return [
        OperationCount(
            sum(count.multiplications for place, count in parts.items() if row.belongs(place)),
            sum(count.additions for place, count in parts.items() if row.belongs(place)),
            0,
        )
        for row in rows
    ]


def breakdown(table: str, method: str, rows: Sequence[Row]) -> list[str]:
    """One of [FGL87]'s tables beside ours, as Markdown."""
    text = {row.name: row for row in text_costs().rows if row.table == table}
    total = text_costs().of(method, table)
    assert total is not None  # the shipped reference has both tables
    ours = booked(count_by_place(method), rows)
    lines = [
        f"| [FGL87]'s row | multiplications | additions | at n = {N} | our part | at n = {N} | why they differ |",
        "|---|---|---|---|---|---|---|",
    ]
    for row, count in zip(rows, ours, strict=True):
        stated = text.get(row.text)
        lines.append(
            f"| {_cells(row.text, stated)} | {row.ours or '-'} | {_pair(count) if row.ours else '-'} | {row.why} |"
        )
    whole = OperationCount(
        sum(count.multiplications for count in ours), sum(count.additions for count in ours), 0
    )
    lines.append(f"| {_cells('**total**', total)} | **total** | {_pair(whole)} | |")
    executed = count_cost(METHODS[method], generic_chain(N)).executed
    assert (whole.multiplications, whole.additions) == (executed.multiplications, executed.additions)
    # Twelve values fix polynomials of the fourth degree.
    added = all(sum(row.at(n).total for row in text.values()) == total.at(n).total for n in SIZES)
    verdict = "add up to" if added else "do NOT add up to"
    return [*lines, "", f"[FGL87]'s rows {verdict} its total."]


def table_3_5(grown: Growth) -> list[str]:
    """Table 3.5 with our counts in it."""
    at = SIZES.index(N)
    lines = [
        f"| formulation | kinematics | equations | order | [FGL87], multiplications | additions | at n = {N} "
        "| as executed | folded |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, method in METHODS.items():
        cost = grown.costs[name][at]
        stated = text_costs().of(name, "3.5")
        cells = (
            f"{stated.multiplications} | {stated.additions} | {_pair_of(stated)}" if stated else "- | - | -"
        )
        lines.append(
            f"| {method.title} | {method.kinematics} | {method.form} | {method.growth} | {cells} "
            f"| {_pair(cost.executed)} | {_pair(cost.folded)} |"
        )
    return lines


def growth_table(grown: Growth) -> list[str]:
    """Total operations over n, and the fitted exponents."""
    lines = [
        "| formulation | | " + " | ".join(str(n) for n in SIZES) + f" | slope from {N} |",
        "|---|---|" + "---|" * (len(SIZES) + 1),
    ]
    for name, method in METHODS.items():
        for k, which in enumerate(get_args(Counted)):
            label = {"executed": "as executed", "text": "[FGL87]"}.get(which, which)
            if counts := grown.counts(name, which):
                numbers = " | ".join(str(count.total) for count in counts)
                slope = grown.slope(name, which)
                lines.append(f"| {'' if k else method.title} | {label} | {numbers} | {slope:.2f} |")
    return lines


def report() -> str:
    """Write the study as Markdown."""
    grown = growth()
    costs = text_costs()
    lines = [
        "# Do Tables 3.1, 3.4 and 3.5 hold?",
        "",
        "Generated by `python analysis/tables_3_1_3_4_3_5.py`; do not edit.",
        "",
        f"[FGL87] ({costs.source}) states what its formulations cost. Here the same formulations are run on "
        "numbers that count every multiplication and addition, on a generic chain of n revolute joints (full "
        "inertia tensors, centres of mass off every axis, twists of +90 and -90 degrees, gravity in any "
        "direction). A pair is multiplications + additions; a subtraction counts as an addition, a change of "
        "sign is free, sines and cosines come on top.",
        "",
        f"**Answer.** {_answer(grown)}",
        "",
        "## Table 3.1: Lagrange-Euler",
        "",
        *breakdown("3.1", "lagrange_euler", lagrange_euler_rows()),
        "",
        "## Table 3.4: Newton-Euler",
        "",
        "[FGL87]'s rows are those of the recursion in link frames, and are stated for the PUMA.",
        "",
        *breakdown("3.4", "newton_euler_link", newton_euler_rows()),
        "",
        "## Table 3.5: the formulations side by side",
        "",
        "As executed: what the array code does as it stands. Folded: constants of the arm folded, products with "
        "0 and 1 gone, equal subexpressions evaluated once. Our generalized d'Alembert code has no breakdown "
        "like [FGL87]'s Table 3.5, which gives its total only; the base-frame recursion is not in it.",
        "",
        *table_3_5(grown),
        "",
        *(f"- {METHODS[c.name].title}, Table {c.table}: {c.remark}." for c in costs.totals if c.remark),
        f"- {costs.remark}",
        "",
        "## Growth with the number of joints",
        "",
        "Multiplications plus additions. The slope is that of log(operations) over log(n); lower powers, and "
        "the first links, which fold away most, still weigh at these sizes.",
        "",
        *growth_table(grown),
        "",
        "From three joints on, the operations as executed are exactly polynomials in n, of the order stated above:",
        "",
        "| formulation | multiplications | additions |",
        "|---|---|---|",
        *(f"| {METHODS[name].title} | {m} | {a} |" for name, (m, a) in grown.polynomials.items()),
        "",
        "## Where ours differ, and why",
        "",
        *(f"- **{METHODS[name].title}.** {explanation(name, grown)}" for name in METHODS),
        "",
    ]
    return "\n".join(lines)


def _answer(grown: Growth) -> str:
    at = SIZES.index(N)
    parts = []
    for name in METHODS:
        stated = text_costs().of(name, "3.5")
        if stated:
            cost = grown.costs[name][at]
            parts.append(
                f"{METHODS[name].title} takes {cost.executed.total / stated.at(N).total:.2f} times [FGL87]'s "
                f"operations as executed and {cost.folded.total / stated.at(N).total:.2f} times folded"
            )
    by_text = _ranked({n: c.at(N).total for n in METHODS if (c := text_costs().of(n, "3.5"))})
    by_ours = _ranked({n: grown.costs[n][at].executed.total for n in by_text})
    agree = "the same" if by_text == by_ours else "another"
    return f"At n = {N}: {'; '.join(parts)}. The ranking is {agree}: {' < '.join(METHODS[n].title for n in by_ours)}."


def _ranked(totals: Mapping[str, int]) -> list[str]:
    return sorted(totals, key=totals.__getitem__)


def _cells(name: str, stated: TextCost | None) -> str:
    if stated is None:
        return "- | - | - | -"
    return f"{name} | {stated.multiplications} | {stated.additions} | {_pair_of(stated)}"


def _pair_of(stated: TextCost) -> str:
    return _pair(stated.at(N))


def _pair(count: OperationCount) -> str:
    return f"{count.multiplications} + {count.additions}"


if __name__ == "__main__":
    Path(__file__).with_suffix(".md").write_text(report(), encoding="utf-8")
