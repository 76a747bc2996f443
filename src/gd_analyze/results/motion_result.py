"""Results on motions: several motions, sensor readings, and measured torques."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.figures.elements import LETTERS
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.result import (
    Fact,
    Mark,
    Part,
    Section,
    Table,
    Value,
    attributes_of,
    joint_values,
    values_of,
    values_of_parts,
)
from gd_analyze.results.beside_log import as_good_within_log, has_log, joints_beside_log
from gd_analyze.results.diagnosis_result import diagnosis_facts, diagnosis_tables
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import NEGLIGIBLE_VERDICTS, Row, rows_of, values_along
from gd_analyze.results.verdict_lists import LISTS
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import GROUPS, SCHEMA_UNITS, declared_columns, declared_table
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.text import amount, joint_name, named_joints, number, percent, short_names, with_error

if TYPE_CHECKING:
    import xarray as xr

# What is stated of a column of a log, by the variable that declares it.
_OF_COLUMNS = {
    "column": "column",
    "column_role": "role",
    "column_joint": "joint",
    "column_unit": "unit",
    "column_why": "why",
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
        Value("verdict", stated["verdict"]),
        Value("agreement", stated["agreement"]),
        Value("compared", stated["compared"]),
        joints_beside_log(findings),
        *friction_tables(findings.tables["measured_torque"], findings.arm, key="friction"),
    ]
    if "diagnosis" in findings.tables:
        table = findings.tables["diagnosis"]
        diagnosis = (*diagnosis_facts(table), *diagnosis_tables(table, findings.arm))
        parts.append(Value("diagnosis", values_of_parts(diagnosis)))
    return Section("measured_torque", "", tuple(parts))


def measured_table(table: xr.Dataset, arm: RobotArm, key: str | None = "joints") -> Table:
    """Measured torque compared with the exact torque, joint by joint."""
    values = {**values_along(table, "joint"), "effort_unit": [joint.effort_unit for joint in arm.joints]}
    names = ["joint", "rms_difference", "rms_beside_friction", "explained"]
    return declared_table("measured_torque", key, "Measured and exact torque", values, names)


def friction_tables(
    table: xr.Dataset, arm: RobotArm, suffix: str = "", key: str | None = None
) -> tuple[Table, ...]:
    """Friction and offset fitted to each joint's difference, with standard errors, if asked for."""
    if "coulomb" not in table:
        return ()
    values, seen = joint_values(arm.joints), dict[str, list[str]]()
    for name in FRICTION_TERMS:
        units = SCHEMA_UNITS[GROUPS["measured_torque"][name].unit]
        values |= {column: table[column].values.tolist() for column in (name, f"{name}_error")}
        seen[name] = [
            "–" if math.isnan(value) else f"{with_error(value, error)} {units[is_revolute]}"
            for value, error, is_revolute in zip(
                values[name], np.nan_to_num(values[f"{name}_error"]), arm.is_revolute, strict=True
            )
        ]
    title = f"Friction and offset fitted to the difference{suffix}, with standard errors"
    return (declared_table("measured_torque", key, title, values, ["joint", *FRICTION_TERMS], seen=seen),)


def agreement_sentence(findings: Findings) -> str:
    """The verdict on log and file, and on a model within the log's budget; "" of a plan."""
    if not has_log(findings):
        return ""
    return f"{findings.tables['measured_torque'].attrs['opening']} {as_good_within_log(findings)}"


def motion_rows(findings: Findings) -> list[Row]:
    """One row per motion: set points, duration, torques and errors of the joints, and the worst of these.

    `begin` is its first instant on the clock of all, s; `used` the largest error of every joint over that
    allowed along the motion, `worst` the largest of these and `joint` its joint, from 1; `proven` the largest
    proven share near the motion.
    """
    table = findings.tables["motions"]
    used_share = share_of(table.largest_error.values, table.allowed_error.values)
    renamed = table.rename(motion_origin="origin")
    names = ("motion", "origin", "set_points", "duration")
    time, parts = findings.trajectory.time, findings.trajectory.motions
    per_joint = ("peak_torque", "allowed_error", "largest_error", "rms_error")
    return [
        {
            **{name: renamed[name].values[k].tolist() for name in (*names, *per_joint)},
            "begin": float(time[parts[k].first]),
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
    names = ("element", "verdict", "torque_share")
    rows = []
    for element, verdicts, shares in zip(*(table[name].values.tolist() for name in names), strict=True):
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
    names = ["motion", "set_points", "duration", "worst", "joint", "proven"]
    values, by_joint = values_of(rows), dict[str, Any]()
    short = short_names([joint.name for joint in findings.arm.joints])
    for i, joint in enumerate(findings.arm.joints):
        by_joint[f"at_joint_{joint_name(i + 1, short[i])}"] = [
            f"{percent(row['used'][i])}, {amount(row['peak_torque'][i], joint.effort_unit)}" for row in rows
        ]
    proven = values["proven"] if np.isfinite(values["proven"]).all() else None
    return declared_table(
        "motions",
        "each",
        "Each motion by itself",
        values,
        names,
        [*names, *by_joint],
        seen={"proven": proven, **by_joint},
        words={"proven": findings.proof},
    )


def _changing_verdicts(rows: Sequence[Row], verdicts: Sequence[Row], top: int | None) -> Table:
    """Verdicts that differ by motion: one along each, or how often each is met along many."""
    changing = [row for row in verdicts if row["changes"]]
    values, drawn = values_of(changing, "element"), dict[str, Any]()
    drawn["element"] = [part_symbol(name) for name in values["element"]]
    title = f"{len(changing)} of {len(verdicts)} elements have a verdict that depends on the motion"
    if len(rows) > MOST_MOTION_COLUMNS:
        values |= {
            f"times_{verdict}": [row["verdicts"].count(verdict) for row in changing] for verdict in LISTS
        }
    else:
        title += ": T translation, R rotation, J drive, – negligible"
        for k, motion in enumerate(rows):
            effects, name = [row["verdicts"][k] for row in changing], motion["motion"] or f"motion {k + 1}"
            values[f"verdict_{name}"] = [LETTERS[effect] for effect in effects]
            drawn[f"verdict_{name}"] = [Mark(effect, LETTERS[effect]) for effect in effects]
    columns = declared_columns("motions", values, [*values], drawn=drawn)
    return Table("verdicts_by_motion", title, columns, top=top)


def _elements_fact(key: str, label: str, names: Sequence[str]) -> Fact | Value:
    """Elements with a remark, for people only if there are any."""
    return Fact(key, label, names, text=_named(names)).seen_if(bool(names))


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
    noisy = f"Elements of D within twice the noise, of {np.count_nonzero(table.element_noise.values)}"
    uses = zip(*(table[name].values.tolist() for name in _OF_COLUMNS), strict=True)
    noise = declared_table(
        "recording",
        "joints",
        "Noise of the readings (standard deviation)",
        values_of(_noise_rows(findings)),
        ["joint", "cutoff", "noise_q", "noise_qdd", "torque_noise", "of_allowed"],
    )
    open_ = "Elements whose verdict the noise decides"
    parts = (
        Value("treatment", table.attrs["treatment"].split("\n")),
        _elements_fact("within_noise", noisy, within),
        _elements_fact("verdict_open", open_, undecided),
        noise,
        Value("elements", rows_of(table[["element_noise", "within_noise", "verdict_open"]], "element")),
        columns_table([ColumnUse(*use) for use in uses], pages_only=True),
    )
    return Section("recording", "", parts)


def columns_table(uses: Sequence[ColumnUse], *, pages_only: bool = False) -> Table:
    """How the columns of a log were understood."""
    values = attributes_of(uses, *_OF_COLUMNS.values())
    seen = {name: values[key] for name, key in _OF_COLUMNS.items()}
    terminal = () if pages_only else [*seen]
    return declared_table("recording", "columns", "Columns of the log", values, terminal, [*seen], seen=seen)


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
            "Noise left in the accelerations makes more torque than the allowed error at "
            f"{named_joints(beyond, len(rows))}: a model this tight partly fits noise. A lower "
            "--cutoff leaves less noise."
        )
    return texts
