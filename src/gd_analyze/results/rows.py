"""Rows of the tables that several views show, beside what belongs to them from other tables."""

from __future__ import annotations

from typing import Any, NamedTuple

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.simplification.element import kept_effects

Row = dict[str, Any]


def joint_rows(findings: Findings, *groups: str) -> list[Row]:
    """One row per joint, of tables that have the dimension, with the unit of its torque."""
    tables = [rows_of(findings.tables[group], "joint") for group in groups]
    return [
        {key: value for row in rows for key, value in row.items()} | {"effort_unit": joint.effort_unit}
        for joint, *rows in zip(findings.arm.joints, *tables, strict=True)
    ]


def element_rows(findings: Findings) -> list[Row]:
    """One row per element, ranked.

    To the table "dominance" come the rank, what the model by the founding text's own method keeps, and the
    founding text's verdict, "" where it has none.
    """
    reference = text_verdicts(findings.arm.name)
    kept = kept_effects(findings.arm.n_joints, findings.element_model.terms)
    verdicts = reference.verdicts if reference else {}
    return [
        {"rank": rank, **row, "kept": kept[row["element"]], "text_verdict": verdicts.get(row["element"], "")}
        for rank, row in enumerate(rows_of(findings.dominance, "element"), start=1)
    ]


class DroppedParts(NamedTuple):
    """What the founding text's own method leaves out, by reason: rows of the table "parts".

    Parameters
    ----------
    costing
        Makes torque; largest share of peak torque first.
    zero
        Is zero along the trajectory, but for round-off.
    idle
        Makes no torque, as the joints it acts on do not accelerate.
    """

    costing: list[Row]
    zero: list[Row]
    idle: list[Row]


def dropped_parts(findings: Findings) -> DroppedParts:
    """Sort what was left out by reason."""
    gone = [row for row in rows_of(findings.tables["parts"], "part") if not row["kept"]]
    return DroppedParts(
        sorted((row for row in gone if row["torque_peak"]), key=lambda row: -row["torque_share"]),
        [row for row in gone if not row["peak"]],
        [row for row in gone if row["peak"] and not row["torque_peak"]],
    )


def trade_off_rows(findings: Findings) -> list[Row]:
    """One row per budget, its operations and shares in the order of the kinds."""
    table = findings.tables["trade_off"]
    return [
        row
        | {
            "asked": row["factor"] == 1.0,
            "operations": table.operations.values[:, k].tolist(),
            "largest_share": table.largest_share.values[:, k].tolist(),
        }
        for k, row in enumerate(rows_of(table, "factor"))
    ]


def budget_rows(findings: Findings) -> list[Row]:
    """One row per multiple of the budget; `kept` holds ranks of torque terms, or labels of parts, if any."""
    table = findings.tables["budgets"]
    plain = ("factor", "budget", "operations", "multiplications", "additions")
    kept: list[list[Any]] = [[] for _ in table.factor.values]
    for name, dim in (("kept", "rank"), ("kept_parts", "part")):
        if name in table:
            kept = [table[dim].values[row].tolist() for row in table[name].values]
    return [
        {name: table[name].values[k].item() for name in plain}
        | {"largest_error": table.largest_error.values[k].tolist(), "kept": kept[k]}
        for k in range(table.sizes["factor"])
    ]
