"""Results on motions: several motions, sensor readings, and measured torques."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.diagnosis.log_verdict import SENTENCES
from gd_analyze.figures.elements import LETTERS
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.result import (
    Column,
    Fact,
    Mark,
    Part,
    Section,
    SeenColumn,
    ShownColumn,
    Table,
    Value,
    for_pages,
    for_people,
    joint_columns,
    values_of_parts,
)
from gd_analyze.results.diagnosis_result import diagnosis_facts, diagnosis_tables
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import NEGLIGIBLE_VERDICTS, Row, effect_of, rows_of, table_of
from gd_analyze.results.verdict_lists import LISTS
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import SCHEMA_UNITS, declared_column
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.text import amount, joint_name, named_joints, number, percent, short_names, with_error

if TYPE_CHECKING:
    import xarray as xr

# What is stated of a column of a log, and the variable that declares it.
_OF_COLUMNS = {
    "column": "column",
    "role": "column_role",
    "joint": "column_joint",
    "unit": "column_unit",
    "why": "column_why",
}
# Most elements named in a fact.
_NAMED_ELEMENTS = 8
# Most motions with a column each.
MOST_MOTION_COLUMNS = 12
# A motion that allows a joint this many times less error than others is named: it may cost operations.
_STRICT_RATIO = 20.0


def measured_section(findings: Findings) -> Section | None:
    """Measured torque compared with the model's, and for JSON the diagnosis."""
    if "measured_torque" not in findings.tables:
        return None
    stated = findings.tables["measured_torque"].attrs
    parts: list[Part] = [
        Fact("verdict", "Log and file", stated["verdict"], shown="text"),
        Value("agreement", stated["agreement"]),
        Fact("compared", "Set points with measured torque", stated["compared"], shown="count"),
        *measured_tables(findings),
    ]
    if "diagnosis" in findings.tables:
        table = findings.tables["diagnosis"]
        diagnosis = (*diagnosis_facts(table), *diagnosis_tables(table, findings.arm))
        parts.append(Value("diagnosis", values_of_parts(diagnosis)))
    return Section("measured_torque", "", tuple(parts))


def measured_tables(findings: Findings) -> tuple[Table, ...]:
    """Measured and exact torque by joint, and fitted friction."""
    table = findings.tables["measured_torque"]
    return (measured_table(table, findings.arm), *friction_tables(table, findings.arm))


def measured_table(table: xr.Dataset, arm: RobotArm) -> Table:
    """Measured torque compared with the exact torque, joint by joint."""
    rows = [
        row | {"effort_unit": joint.effort_unit}
        for row, joint in zip(rows_of(table, "joint"), arm.joints, strict=True)
    ]
    names = ("rms_difference", "rms_beside_friction", "explained")
    return table_of("joints", "Measured and exact torque", rows, dict.fromkeys(names, "measured_torque"))


def friction_tables(table: xr.Dataset, arm: RobotArm, suffix: str = "") -> tuple[Table, ...]:
    """Friction and offset fitted to each joint's difference, with standard errors, if asked for."""
    if "coulomb" not in table:
        return ()
    rows, efforts = rows_of(table, "joint"), [joint.effort_unit for joint in arm.joints]
    units = {
        "coulomb": efforts,
        "viscous": [SCHEMA_UNITS["viscous"][unit == "N m"] for unit in efforts],
        "offset": efforts,
    }
    columns = [*joint_columns(arm.joints)]
    for name, of_joints in units.items():
        cells = [
            "–" if row[name] is None else f"{with_error(row[name], row[f'{name}_error'] or 0.0, 1)} {unit}"
            for row, unit in zip(rows, of_joints, strict=True)
        ]
        columns.append(for_people(declared_column("measured_torque", name, cells)))
    title = f"Friction and offset fitted to the difference{suffix}, with standard errors"
    return (Table("", title, tuple(columns)),)


def agreement_sentence(findings: Findings) -> str:
    """The verdict on log and file, with a space behind it; "" if no torques were measured."""
    if "measured_torque" not in findings.tables:
        return ""
    return f"{SENTENCES[findings.tables['measured_torque'].attrs['verdict']]} "


def motion_rows(findings: Findings) -> list[Row]:
    """One row per motion: set points, duration, torques and errors of the joints, and the worst of these.

    `used` is the largest error of every joint over the error allowed along the motion, `worst` the largest of
    these and `joint` its joint, from 1; `proven` is the largest proven share near the motion.
    """
    table = findings.tables["motions"]
    used_share = share_of(table.largest_error.values, table.allowed_error.values)
    renamed = table.rename(motion_origin="origin")
    names = ("motion", "origin", "set_points", "duration")
    per_joint = ("peak_torque", "allowed_error", "largest_error", "rms_error")
    return [
        {
            **{name: renamed[name].values[k].tolist() for name in (*names, *per_joint)},
            "used": used_share[k].tolist(),
            "worst": float(used_share[k].max()),
            "joint": int(used_share[k].argmax()) + 1,
            "certified": table.certified.values[k].tolist(),
            "proven": float(share_of(table.certified.values, table.allowed_error.values)[k].max()),
        }
        for k in range(table.sizes["motion"])
    ]


def verdict_rows(findings: Findings) -> list[Row]:
    """One row per element, ranked over all motions: verdict and torque share along each, and changes.

    An element that is zero along one motion and negligible along another has not changed.
    """
    table = findings.tables["motions"]
    names = ("element", "quantity", "verdict", "torque_share")
    rows = []
    for element, quantity, by_motion, shares in zip(
        *(table[name].values.tolist() for name in names), strict=True
    ):
        verdicts = [effect_of({"quantity": quantity}, verdict) for verdict in by_motion]
        changes = len({"" if verdict in NEGLIGIBLE_VERDICTS else verdict for verdict in verdicts}) > 1
        rows.append({"element": element, "verdicts": verdicts, "torque_shares": shares, "changes": changes})
    return rows


def _worst_fact(rows: Sequence[Row]) -> Fact:
    """The largest share of the budget along any motion, from rows of `motion_rows`."""
    worst = max(rows, key=lambda row: row["worst"])
    where = f"joint {worst['joint']} along {worst['motion']}"
    label = "Largest share of the budget"
    return Fact("worst_of_allowed", label, worst["worst"], shown="percent", note=where)


def motions_section(findings: Findings, top: int | None = None) -> Section | None:
    """Errors along each of several motions, and the verdicts that change between them."""
    if "motions" not in findings.tables:
        return None
    rows, verdicts = motion_rows(findings), verdict_rows(findings)
    changing = [row["element"] for row in verdicts if row["changes"]]
    parts: list[Part] = [
        _worst_fact(rows),
        Fact("changing", "Verdicts that differ by motion", changing, text=_named(changing)),
        _each_motion(findings, rows),
        Value("verdicts", verdicts),
    ]
    if changing:
        parts.append(_changing_verdicts(rows, verdicts, top))
    return Section("motions", "", tuple(parts))


def _each_motion(findings: Findings, rows: Sequence[Row]) -> Table:
    """Error over allowed error along each motion: the worst joint's, and on pages every joint's."""
    columns: dict[str, str | SeenColumn] = {
        **dict.fromkeys(("motion", "set_points", "duration"), "motions"),
        "worst": Column("worst", "error of allowed", [row["worst"] for row in rows], shown="percent"),
        "joint": Column("joint", "joint", [row["joint"] for row in rows], shown="count"),
    }
    proven = [row["proven"] for row in rows]
    if np.isfinite(proven).all():
        columns["proven"] = Column("proven", f"near it, {findings.proof}", proven, shown="bound_percent")
    names = short_names([joint.name for joint in findings.arm.joints])
    for i, joint in enumerate(findings.arm.joints):
        label = joint_name(i + 1, names[i])
        cells = [
            f"{percent(row['used'][i])}, {amount(row['peak_torque'][i], joint.effort_unit)}" for row in rows
        ]
        meaning = "error over allowed error, and peak torque"
        columns[label] = ShownColumn(label, cells, shown="text", meaning=meaning, pages_only=True)
    return table_of("each", "Each motion by itself", rows, columns)


def _changing_verdicts(rows: Sequence[Row], verdicts: Sequence[Row], top: int | None) -> Table:
    """Verdicts that differ by motion: one along each, or how often each is met along many."""
    changing = [row for row in verdicts if row["changes"]]
    names = [row["element"] for row in changing]
    columns = [ShownColumn("element", names, shown="text", drawn=[part_symbol(name) for name in names])]
    title = f"{len(changing)} of {len(verdicts)} elements have a verdict that depends on the motion"
    if len(rows) > MOST_MOTION_COLUMNS:
        columns += [
            ShownColumn(verdict, [row["verdicts"].count(verdict) for row in changing], shown="count")
            for verdict in LISTS
        ]
        return Table("verdicts_by_motion", title, tuple(columns), top=top)
    for k, motion in enumerate(rows):
        effects = [row["verdicts"][k] for row in changing]
        letters = [LETTERS[effect] for effect in effects]
        marks = [Mark(*pair) for pair in zip(effects, letters, strict=True)]
        columns.append(ShownColumn(motion["motion"] or f"motion {k + 1}", letters, shown="text", drawn=marks))
    note = "T translation, R rotation, J drive, – negligible"
    return Table("verdicts_by_motion", f"{title}: {note}", tuple(columns), top=top)


def _elements_fact(key: str, label: str, names: Sequence[str]) -> Fact | Value:
    """Elements with a remark, for people only if there are any."""
    return Fact(key, label, names, text=_named(names)) if names else Value(key, names)


def _named(names: Sequence[str]) -> str:
    remark = f" and {len(names) - _NAMED_ELEMENTS} more" if len(names) > _NAMED_ELEMENTS else ""
    return f"{len(names)}: {', '.join(names[:_NAMED_ELEMENTS])}{remark}" if names else "none"


def strict_notice(findings: Findings) -> str:
    """Name a joint to which one motion allows far less error than another, and the remedy; "" if none."""
    if "motions" not in findings.tables:
        return ""
    table, arm, budget = findings.tables["motions"], findings.arm, findings.model.accuracy.asked
    allowed, names = table.allowed_error.values, table.motion.values
    ratio = allowed.max(axis=0) / allowed.min(axis=0)
    if not (ratio >= _STRICT_RATIO).any() or not budget.wholes & {"peak", "uncertainty"}:
        return ""
    joint = int(ratio.argmax())
    least_motion, most_motion = int(allowed[:, joint].argmin()), int(allowed[:, joint].argmax())
    torque_text = amount(float(table.peak_torque.values[least_motion, joint]), arm.joints[joint].effort_unit)
    text = (
        f"Joint {joint + 1} needs up to {torque_text} along {names[least_motion]} and is allowed "
        f"{number(float(ratio[joint]))} times less error than along {names[most_motion]}, which may cost "
        "operations."
    )
    if findings.model.notice:
        return text
    friction = ReferenceTorques(arm, np.zeros(arm.n_joints)).all("friction")
    if len(budget.entries) == 1 and np.isfinite(friction).all():
        return f'{text} --budget "{budget} or 10% friction" sets a floor.'
    return f"{text} An amount in N m in --budget, or a share of friction, sets a floor."


def _noise_rows(findings: Findings) -> list[Row]:
    """Cut-off and noise of every joint, and the resulting torque noise over the budget."""
    table = findings.tables["recording"][["cutoff", "noise_q", "noise_qdd", "torque_noise"]]
    allowed = findings.model.accuracy.allowed.tolist()
    return [
        row
        | {
            "joint_name": joint.name,
            "unit": joint.unit,
            "qdd_unit": f"{joint.unit}/s^2",
            "effort_unit": joint.effort_unit,
            "allowed": budget,
            "of_allowed": row["torque_noise"] / budget,
        }
        for row, joint, budget in zip(rows_of(table, "joint"), findings.arm.joints, allowed, strict=True)
    ]


def recording_section(findings: Findings) -> Section | None:
    """Treatment of a measured motion's readings, and effect of their noise."""
    if "recording" not in findings.tables:
        return None
    table = findings.tables["recording"]
    within, undecided = (
        table.element.values[table[name].values].tolist() for name in ("within_noise", "verdict_open")
    )
    noise_rows = _noise_rows(findings)
    noisy = f"Elements of D within twice the noise, of {np.count_nonzero(table.element_noise.values)}"
    columns: dict[str, str | SeenColumn] = {
        **dict.fromkeys(("cutoff", "noise_q", "noise_qdd", "torque_noise"), "recording"),
        "of_allowed": Column(
            "of_allowed", "of allowed", [row["of_allowed"] for row in noise_rows], shown="percent"
        ),
    }
    uses = [
        {key.removeprefix("column_"): value for key, value in row.items()} for row in rows_of(table, "column")
    ]
    open_ = "Elements whose verdict the noise decides"
    parts = (
        Value("treatment", table.attrs["treatment"].split("\n")),
        _elements_fact("within_noise", noisy, within),
        _elements_fact("verdict_open", open_, undecided),
        table_of("joints", "Noise of the readings (standard deviation)", noise_rows, columns),
        Value("elements", rows_of(table[["element_noise", "within_noise", "verdict_open"]], "element")),
        for_pages(columns_table([ColumnUse(**use) for use in uses])),
    )
    return Section("recording", "", parts)


def columns_table(uses: Sequence[ColumnUse]) -> Table:
    """How the columns of a log were understood."""
    columns = (
        declared_column("recording", name, [getattr(use, key) for use in uses], key=key)
        for key, name in _OF_COLUMNS.items()
    )
    return Table("columns", "Columns of the log", tuple(columns))


def recording_notices(findings: Findings) -> list[str]:
    """Notices that the motion was measured, and where its noise exceeds the budget; none for a plan."""
    if "recording" not in findings.tables:
        return []
    table, rows = findings.tables["recording"], _noise_rows(findings)
    smoothed = table.attrs["treatment"].split("\n")[-1].partition(";")[0]
    if findings.trajectory.motions:
        lowest = number(float(table.cutoff.values.min()))
        smoothed = f"readings smoothed without delay, cut-off {lowest} Hz or higher"
    texts = [f"Measured motion, not a plan: {smoothed}."]
    beyond = [row["joint"] for row in rows if row["of_allowed"] > 1.0]
    if beyond:
        texts.append(
            "Noise left in the accelerations exceeds the allowed torque error at "
            f"{named_joints(beyond, len(rows))}: models for this budget follow the noise, too. A lower "
            "--cutoff leaves less noise."
        )
    return texts
