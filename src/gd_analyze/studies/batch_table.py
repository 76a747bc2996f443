"""The table of a batch: a line per row, and what people see of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gd_analyze.dynamics.dominance import elements
from gd_analyze.errors import UsageError
from gd_analyze.figures.batch import effort_units
from gd_analyze.result import Column, Result, Table, Value, value_text
from gd_analyze.robots.arm_numbers import ArmNumber
from gd_analyze.schema import declared_columns, declared_table
from gd_analyze.studies.batch_rows import KEYS, BatchRow, varied_in
from gd_analyze.text import short_name

if TYPE_CHECKING:
    import pandas as pd

# What people see of every row.
_ROWS = [
    "row", "state", "arm", "trajectory", "model_operations", "exact_operations", "sampled_error",
    "proven_error",
]  # fmt: skip


def batch_table(rows: Sequence[BatchRow], entries_of_rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Rows in their order: state and error, options, varied numbers in their columns' units, and results."""
    import pandas as pd

    used_keys = [key for key in KEYS if any(key in row for row in rows)]
    varied_names = list(dict.fromkeys(key for row in rows for key in varied_in(row)))
    lines, first_entries = [], dict[tuple[str, str], Mapping[str, Any]]()
    for number, (row, entries) in enumerate(zip(rows, entries_of_rows, strict=True), start=1):
        line = {"row": number, "state": entries["state"], "error": entries["error"]}
        line |= {key: str(row[key]) if key in row else "" for key in used_keys}
        line |= {name: _value_of(row, name) for name in varied_names}
        line |= entries
        if varied_names and entries["state"] == "done":
            first = first_entries.setdefault((str(row["arm"]), str(row["trajectory"])), entries)
            line["changed_verdicts"] = _changed_verdicts(first, entries)
        lines.append(line)
    order = dict.fromkeys(key for line in lines for key in line if key not in ("files", "warnings"))
    return pd.DataFrame(lines, columns=[*order, "files", "warnings"]).convert_dtypes()


def _value_of(row: BatchRow, name: str) -> float | None:
    """A varied number in the unit of its column; None where the row has none that can be read."""
    number = ArmNumber.named(name)
    try:
        return None if number is None or name not in row else number.read(row[name])
    except UsageError:
        return None


def _changed_verdicts(first: Mapping[str, Any], entries: Mapping[str, Any]) -> str:
    """Verdicts of a row that differ from those of another: "D22 translation, h3 both"."""
    labels = [element.label for element in elements(entries["joints"])]
    return ", ".join(f"{label} {entries[label]}" for label in labels if entries[label] != first.get(label))


def varied_column(rows: Sequence[BatchRow]) -> str:
    """Column over which a figure shows the rows: the only one that varies if it is a number, else "row"."""
    names = dict.fromkeys(key for row in rows for key in row)
    differing = [name for name in names if len({str(row.get(name)) for row in rows}) > 1]
    return differing[0] if len(differing) == 1 and ArmNumber.named(differing[0]) else "row"


def batch_result(table: pd.DataFrame, most: int = 20) -> Result:
    """Counts, the first rows, and the failed rows."""
    failed, done_count = table[table.state == "failed"], int((table.state == "done").sum())
    cells = table.reindex(columns=[*_ROWS, "sampled_error_of", "proven_error_of"]).astype(object)
    cells = cells.where(cells.notna(), None)
    values = {name: cells[name].tolist() for name in _ROWS}
    references = {name: cells[name].tolist() for name in ("sampled_error_of", "proven_error_of")}
    seen = {
        name: [
            _error_text(error, of, is_bound=name == "proven_error")
            for error, of in zip(values[name], references[f"{name}_of"], strict=True)
        ]
        for name in ("sampled_error", "proven_error")
    }
    lines = [short_name(text.splitlines()[0], 70) for text in failed.error]
    numbers = [number for number in map(ArmNumber.named, table.columns) if number is not None]
    failures = {"row": failed.row.tolist(), "error": failed.error.tolist()}
    failed_table = declared_table(
        "batch", "failures", "Failed", failures, ["row", "error"], top=most, seen={"error": lines}
    )
    return Result(
        title="Batch",
        headline=f"{done_count} of {len(table)} rows done.",
        facts=(Value("rows", len(table)), Value("done", done_count), Value("failed", len(failed))),
        parts=(
            declared_table("batch", "table", "Rows", values | references, _ROWS, top=most, seen=seen),
            *([_varied_table(table, numbers, most)] if numbers else []),
            *([failed_table] if len(failed) else []),
        ),
    )


def _error_text(error: float | None, of: str | None, *, is_bound: bool) -> str:
    """An error as its row states it: "0.99 %" of peak torque, "76 % of budget" or "0.085 N m"."""
    if of in ("N m", "N"):
        return value_text(error, of, "bound" if is_bound else "number")
    share = value_text(error, "", "bound_percent" if is_bound else "percent")
    return f"{share} of budget" if of == "the budget" else share


def _varied_table(table: pd.DataFrame, numbers: Sequence[ArmNumber], most: int) -> Table:
    """Peak torques and changed verdicts by the varied numbers."""
    torques = effort_units(table[table.state == "done"]).items()
    changed = table["changed_verdicts"].fillna("") if "changed_verdicts" in table else [""] * len(table)
    labels = {number.name: (number.name, number.unit) for number in numbers}
    labels |= {name: (name.replace("_torque_", " "), unit) for name, unit in torques}
    values = {
        "row": table.row.tolist(),
        **{name: table[name].astype(float).tolist() for name in labels},
        "changed_verdicts": list(changed),
    }
    first, last = declared_columns("batch", values, ["row", "changed_verdicts"])
    between = (Column(label, values[name], unit) for name, (label, unit) in labels.items())
    return Table("varied", "Numbers varied, and peak torques", (first, *between, last), "", most, values)
