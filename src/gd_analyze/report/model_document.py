"""What the PDF says of the model: operations, what it keeps, the founding text's method, the trade-off."""

from __future__ import annotations

from typing import Any

from gd_analyze.figures.trade_off import kind_name
from gd_analyze.formulas.languages import Typst
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.operations.program import OperationCount
from gd_analyze.report.cells import formatted, in_fitting_units, share, torque
from gd_analyze.report.harmonic_data import equation_data
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import Row, dropped_parts, trade_off_rows
from gd_analyze.text import inertia_label, joined, percent, percent_cell, pretty

# The longest budget that a table has room for.
_LONGEST_BUDGET = 12
_TYPST = Typst()


def kept_matrix(kept: dict[str, str], n_joints: int) -> list[list[str]]:
    """What is kept of D, h and c in the row of every joint."""
    every = range(n_joints)
    return [
        [kept[inertia_label(i, j)] for j in every] + [kept[f"{vector}{joined((i,))}"] for vector in "hc"]
        for i in every
    ]


def operations(full: OperationCount, left: OperationCount) -> list[dict[str, str]]:
    """Operations of the exact torque and of a model, and what is saved, by kind."""
    return [
        {
            "what": what,
            "full": str(before),
            "model": str(after),
            "saved": percent_cell(1 - after / before) if before else "0",
        }
        for what, before, after in (
            ("multiplications", full.multiplications, left.multiplications),
            ("additions", full.additions, left.additions),
            ("both", full.total, left.total),
            ("sines and cosines", full.sines_cosines, left.sines_cosines),
        )
    ]


def founding_method(findings: Findings) -> dict[str, Any]:
    """The model by the founding text's own method, and what it leaves out by reason."""
    model, dropped = findings.element_model, dropped_parts(findings)
    costing = formatted(
        in_fitting_units(dropped.costing, "torque_unit", "torque_peak"),
        "torque_joint",
        "torque_unit",
        torque_peak=torque("torque_peak"),
        torque_share=share("torque_share", findings, "torque_joint"),
    )
    for row, shown in zip(dropped.costing, costing, strict=True):
        within = row["torque_peak"] <= model.accuracy.allowed[row["torque_joint"] - 1]
        shown["math"] = _part(row)
        shown["why"] = "within the allowance by itself" if within else "cancels against other dropped parts"
    return {
        "equations": [equation_data(formula) for formula in model.formulas],
        "budget": model.accuracy.budget,
        "operations": operations(model.operations_full, model.operations),
        "saves": model.saves,
        "count": model.operations.total,
        "exact": model.operations_full.total,
        "costing": costing,
        "zero": [*map(_part, dropped.zero)],
        "idle": [*map(_part, dropped.idle)],
    }


def _part(row: Row) -> str:
    return _TYPST.symbol(part_symbol(*row["part"].split()))


def trade_off(findings: Findings) -> dict[str, Any]:
    """Describe operations and error of every kind of model, by budget."""
    model, kinds = findings.model, rows_of(findings.tables["trade_off"], "kind")
    return {
        "nothing": summary.nothing_to_trade(findings),
        "kinds": [kind_name(kind["level"], kind["refit"]) for kind in kinds],
        "rows": [
            {
                "budget": pretty(row["budget"])
                if len(row["budget"]) <= _LONGEST_BUDGET
                else f"budget × {row['factor']:g}",
                "asked": row["asked"],
                "operations": [*map(str, row["operations"])],
                "errors": [*map(percent_cell, row["largest_share"])],
            }
            for row in trade_off_rows(findings)
        ],
        "operations": model.operations.total,
        "exact": model.operations_full.total,
        "error": percent(float(model.accuracy.shares.max(initial=0.0))),
        "shares_of": model.accuracy.asked.shares_of,
    }
