"""Rows of the tables: as frames, as plain values, and joined with related ones."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.dominance_over_time import stretches
from gd_analyze.dynamics.verdicts import verdict_definition
from gd_analyze.results.findings import Findings
from gd_analyze.schema import GROUPS
from gd_analyze.text import percent

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Row = dict[str, Any]
# Verdicts of elements that do not matter.
NEGLIGIBLE_VERDICTS = {"negligible", "zero"}


def joint_rows(findings: Findings, *groups: str) -> list[Row]:
    """One row per joint, with the unit of its torque, from tables with the dimension `joint`."""
    rows: list[Row] = [{} for _ in findings.arm.joints]
    units = [{"effort_unit": joint.effort_unit} for joint in findings.arm.joints]
    for group_rows in (*(rows_of(findings.tables[group], "joint") for group in groups), units):
        rows = [row | new for row, new in zip(rows, group_rows, strict=True)]
    return rows


# A verdict less probable than this is marked.
SURE = 0.95


def element_rows(findings: Findings) -> list[Row]:
    """One row per element, ranked.

    The table "dominance" is extended by the rank, [FGL87]'s verdict ("" if it has none), the
    changes of the verdict over time, and the probability of the dominant effect over the motion (None if no
    uncertainty is stated).
    """
    reference = text_verdicts(findings.arm.name)
    verdicts = reference.verdicts if reference else {}
    motion = findings.trajectory
    starts = [float(motion.time[part.first]) for part in motion.motions]
    changes = stretches(findings.tables["dominance_over_time"], starts)
    robustness = findings.tables.get("robustness")
    probable = {} if robustness is None else robustness.over_motion.to_series().to_dict()
    return [
        {
            "rank": rank,
            **row,
            "text_verdict": verdicts.get(row["element"], ""),
            "stretches": changes[row["element"]],
            # Of two parts that are both zero, none dominates.
            "probability": None
            if row["verdict"] == "zero"
            else probable.get((row["element"], row["dominant"])),
        }
        for rank, row in enumerate(rows_of(findings.dominance, "element"), start=1)
    ]


def is_doubtful(row: Row) -> bool:
    """Whether the verdict over the motion is less probable than `SURE`, given the stated uncertainties."""
    return row["probability"] is not None and row["probability"] < SURE


def sure_text(row: Row) -> str:
    """Probability of the verdict over the motion, marked if it is low; "" if it is unknown."""
    if row["probability"] is None:
        return ""
    # Never rounded up to certainty.
    return f"{math.floor(100 * row['probability']):d} %{' (?)' if is_doubtful(row) else ''}"


def dominance_note(findings: Findings) -> str:
    """Key to the figure of dominance over time, and the doubtful verdicts."""
    doubtful = [f"{row['element']} {sure_text(row)}" for row in element_rows(findings) if is_doubtful(row)]
    definition = verdict_definition(findings.dominance.attrs["threshold"], findings.arm.n_joints)
    note = f"Coloured: {definition} (no colour)."
    motions, time = findings.trajectory.motions, findings.trajectory.time
    if motions:
        begins = [f"{motion.name} from {time[motion.rows.start]:.3g} s" for motion in motions]
        note += f" One motion after the other: {', '.join(begins)}."
    if doubtful:
        note += f" Less than {percent(SURE)} sure because parameters are uncertain: {', '.join(doubtful)}."
    return note


def changes_text(row: Row) -> str:
    """When the verdict on an element changes: "both until 0.96 s, then rotation"; "" if never."""
    *earlier, last = row["stretches"]
    words = []
    for stretch in earlier:
        preposition = "until" if stretch["begin"] < stretch["end"] else "at"
        words.append(f"{stretch['verdict']} {preposition} {stretch['end']:.3g} s")
    return f"{', '.join(words)}, then {last['verdict']}" if earlier else ""


class DroppedParts(NamedTuple):
    """Parts that [FGL87]'s own method drops, by reason: rows of the table "parts"."""

    costing: list[Row]  # with torque; largest share of peak torque first
    zero: list[Row]  # zero along the trajectory, up to round-off
    idle: list[Row]  # without torque, as its joints do not accelerate


def dropped_parts(findings: Findings) -> DroppedParts:
    """Sort the dropped parts by reason."""
    gone = [row for row in rows_of(findings.tables["parts"], "part") if not row["kept_by_element"]]
    return DroppedParts(
        sorted((row for row in gone if row["torque_peak"]), key=lambda row: -row["torque_share"]),
        [row for row in gone if not row["peak"]],
        [row for row in gone if row["peak"] and not row["torque_peak"]],
    )


def budget_rows(findings: Findings) -> list[Row]:
    """One row per budget; `kept` holds ranks of torque terms, or labels of parts, if any."""
    table = findings.tables["budgets"]
    names = [name for name in GROUPS["budgets"] if not name.startswith("kept")]
    columns = {name: table[name].values.tolist() for name in ("position", *names)}
    columns["kept"] = [[] for _ in table.position]
    for name, dim in (("kept", "rank"), ("kept_parts", "part")):
        if name in table:
            columns["kept"] = [table[dim].values[row].tolist() for row in table[name].values]
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def frame_of(table: xr.Dataset, *dims: str) -> pd.DataFrame:
    """Extract rows of a table along one dimension, or for every pair of labels of two.

    Labels are the first columns. With one dimension, a variable with a second one gives a column per label of
    that, such as "part_peak_translation"; units that differ between rows have their own columns.
    """
    import pandas as pd

    if len(dims) > 1:
        return table.to_dataframe(dim_order=list(dims)).reset_index()
    return pd.DataFrame(values_along(table, dims[0]))


def rows_of(table: xr.Dataset, *dims: str) -> list[Row]:
    """Extract the same rows as plain JSON values; nan becomes None."""
    columns: Any = values_along(table, dims[0]) if len(dims) == 1 else frame_of(table, *dims)
    plain = {name: np.asarray(columns[name]).tolist() for name in columns}
    return [
        {name: None if isinstance(x, float) and x != x else x for name, x in zip(plain, row, strict=True)}
        for row in zip(*plain.values(), strict=True)
    ]


def values_along(table: xr.Dataset, dim: str) -> dict[str, np.ndarray]:
    """Values of a table along one dimension by name, as `frame_of` has them."""
    columns: dict[str, np.ndarray] = {dim: table[dim].values}
    for name, array in (*table.data_vars.items(), *table.coords.items()):
        if array.dims == (dim,):
            columns[str(name)] = array.values
        elif len(array.dims) == 2 and array.dims[0] == dim:
            labels = table[array.dims[1]].values
            columns |= {f"{name}_{label}": array.values[:, k] for k, label in enumerate(labels)}
    return columns
