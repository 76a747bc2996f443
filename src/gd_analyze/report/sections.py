"""The main report as parts: its appendices, which page and paper show alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gd_analyze.figures.arm import views_figure
from gd_analyze.figures.elements import LETTERS, inertia_figure, vector_figure
from gd_analyze.figures.motion import motion_figure, recording_figure
from gd_analyze.figures.torques import error_figure, measured_figure, measured_joints
from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.writing import (
    part_symbol,
    term_formula,
    torque_legend,
    torque_symbol,
)
from gd_analyze.report.model_sections import beyond_section, founding_section, made_of, model_section
from gd_analyze.result import Column, Drawing, Equations, Fact, Part, Section, Table, joint_columns
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import norms_text
from gd_analyze.results.motion_result import (
    effect_of,
    friction_tables,
    is_recorded,
    mark_of,
    measured_table,
    motion_rows,
    recording_parts,
    strict_notice,
    verdict_rows,
)
from gd_analyze.results.rows import element_rows, joint_rows, rows_of, table_of
from gd_analyze.results.run_result import VERDICTS, not_worth_keeping, text_comparison
from gd_analyze.robots.plausibility import inconsistent_inertias
from gd_analyze.text import amount, given, number, percent, pretty

# Rows of rankings, and motions that have a column each.
_TERMS, _MOST_COLUMNS = 40, 12
_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c", "torque": "τ"}


def sections(findings: Findings) -> tuple[Section, ...]:
    """All appendices that have something to show, in order."""
    every = (
        _motion(findings),
        _recording(findings),
        _measured(findings),
        _effects(findings),
        _ranking(findings),
        _motions(findings),
        _terms(findings),
        model_section(findings),
        beyond_section(findings),
        founding_section(findings),
        _equations(findings),
        _data(findings),
    )
    return tuple(section for section in every if section is not None)


def _motion(findings: Findings) -> Section:
    rows = joint_rows(findings, "simplified_model")
    labels = {
        "peak_torque": ("peak torque", "@effort_unit"),
        "allowed_error": ("allowed error", "@effort_unit"),
        "largest_error": ("largest error", "@effort_unit"),
        "largest_share": ("of peak", "", "percent"),
        "rms_error": ("RMS error", "@effort_unit"),
        "rms_share": ("of peak", "", "percent"),
    }
    norms = findings.model.accuracy.norms
    note = f"Norm of the error over norm of the torque: {norms_text(norms)}." if norms else ""
    return Section(
        "motion",
        "Motion, torque and error over time",
        (
            Drawing("views", "The arm along the axes of its base frame.", views_figure(findings), _PATH),
            Drawing("motion", "The motion of every joint.", motion_figure(findings)),
            Drawing(
                "errors",
                "Torque and error of every joint, sampled at the set points.",
                error_figure(findings),
            ),
            table_of("torques", "Torque and error of every joint along this trajectory", rows, labels, note),
        ),
    )


_PATH = (
    "Poses from light to dark in time; the path of the end effector from the open circle to the filled one."
)


def _recording(findings: Findings) -> Section | None:
    if not is_recorded(findings):
        return None
    table = findings.tables["recording"]
    treatment = "\n".join(
        f"{line[:1].upper()}{line[1:]}." for line in table.attrs["treatment"].split("\n") if line
    )
    readings = recording_parts(findings)[0]
    assert isinstance(readings, Section)
    inside = [part for part in readings.parts if isinstance(part, Fact | Table)]
    names = ("column", "column_role", "column_joint", "column_unit", "column_why")
    used: list[tuple[str, ...]] = []
    unused: list[tuple[str, ...]] = []
    for row in zip(*(table[name].values.tolist() for name in names), strict=True):
        (unused if row[1] == "unused" else used).append(row)
    heads = ("column", "holds", "joint", "unit", "understood by")
    columns = [_words(head, cells) for head, cells in zip(heads, zip(*used, strict=True), strict=False)]
    left_out = ", ".join(f"{name} ({why})" if why else name for name, *_, why in unused)
    drawing = Drawing(
        "recording",
        "Left: readings and smoothed motion. Right: their difference near the joint's largest acceleration.",
        recording_figure(findings),
        "Noise looks alike at all times; a slow swing is motion that the smoothing removed.",
    )
    log = Table(
        "columns",
        "Columns of the log that are used",
        tuple(columns),
        f"Unused: {left_out}." if unused else "",
    )
    parts = (*(part for part in inside if part.key != "columns"), drawing, *([log] if columns else []))
    return Section("recording", "Readings behind the motion", parts, treatment)


def _measured(findings: Findings) -> Section | None:
    if not measured_joints(findings):
        return None
    table = findings.tables["measured_torque"]
    note = f"Compared at {table.attrs['compared']} set points with measured torque"
    note += ", both filtered alike." if table.attrs["filter"] else "."
    return Section(
        "measured",
        "Measured torque beside the model's",
        (
            Drawing(
                "measured", "Measured and exact torque, and their difference.", measured_figure(findings)
            ),
            measured_table(table, findings.arm),
            *friction_tables(table, findings.arm),
        ),
        note,
    )


def _effects(findings: Findings) -> Section:
    like = " Laid out after Fig {} of [FGL87]."
    is_text = text_comparison(findings) is not None
    drawings = (
        ("inertia", "Inertia matrix D by effect, each panel at its place in the matrix.", "3.10"),
        ("coriolis_centrifugal", "Coriolis and centrifugal vector h by effect.", "3.11"),
        ("gravity_loading", "Gravity loading c, which acts on masses only and has no rotational part.", ""),
    )
    return Section(
        "effects",
        "Inertia, velocity and gravity terms by effect",
        tuple(
            Drawing(
                name,
                title + (like.format(number) if is_text and number else ""),
                inertia_figure(findings) if name == "inertia" else vector_figure(findings, name),
            )
            for name, title, number in drawings
        ),
        "Each element is the sum of a part from moving the links' masses (translation) and a part "
        "from turning the links about their centres of mass (rotation). At the right of a title: what "
        "dominates, T or R. "
        "Parts that are zero but for round-off are drawn as zero.",
    )


def _symbol(label: str) -> Symbol:
    return part_symbol(*label.split())


def _ranking(findings: Findings) -> Section:
    text = text_comparison(findings)
    rows = [
        row
        | {
            "symbol": _symbol(row["element"]),
            "verdict": f"{effect_of(row)} {VERDICTS[effect_of(row)]}",
            "kept": f"{effect_of(row, 'kept')} {LETTERS[effect_of(row, 'kept')]}",
            "beside": _beside(row),
            **({} if row["quantity"] != "gravity_loading" else dict.fromkeys(_SPLIT)),
        }
        for row in element_rows(findings)
    ]
    labels = {
        "rank": ("rank", "", "count"),
        "symbol": ("element", "", "math"),
        "torque_share": ("of peak torque", "", "share"),
        "torque_peak": ("torque", "@torque_unit"),
        "torque_joint": ("joint", "", "count"),
        "peak": ("peak", "@unit"),
        "part_peak_translation": ("translation", "@unit"),
        "part_peak_rotation": ("rotation", "@unit"),
        "change_without_translation": ("without T", "", "percent"),
        "change_without_rotation": ("without R", "", "percent"),
        "verdict": ("verdict", "", "effect"),
        "kept": ("kept", "", "effect"),
        **({"beside": ("[FGL87]", "", "text")} if text else {}),
    }
    threshold = percent(float(findings.dominance.attrs["threshold"]))
    ranking = table_of("ranking", "Elements by the torque that they make", rows, labels)
    parts: list[Part] = [ranking]
    if text:
        remarks = [
            f"{row['element']}, called {row['text_verdict']} dominant: {remark}. Here its translation "
            f"peaks at "
            f"{number(row['part_peak_translation'])} and its rotation at {number(row['part_peak_rotation'])} "
            f"{row['unit']}: {finding}."
            for row, remark, finding in text["remarks"]
        ]
        note = (
            f"{text['agreed']} of {text['given']} verdicts of the founding text agree with ours on "
            "this trajectory (✓); it states neither its trajectory nor its inertial parameters, and "
            "verdicts depend on both."
        )
        more = (
            [f"The founding text contradicts itself on {len(remarks)} of them:", *remarks] if remarks else []
        )
        parts.append(
            Section(
                "", "Beside the founding text", (), "\n".join([note, *more, f"[FGL87] {text['source']}."])
            )
        )
    note = (
        "Largest torque of each element, as a share of the joint's peak torque; it exceeds 100 % "
        f"where elements cancel. An effect dominates an element that changes by at most {threshold} of "
        f"its peak "
        "without the other."
    )
    return Section("ranking", "Elements ranked by torque", tuple(parts), note)


_SPLIT = (
    "part_peak_translation",
    "part_peak_rotation",
    "change_without_translation",
    "change_without_rotation",
)


def _beside(row: dict[str, Any]) -> str:
    found = row["text_verdict"]
    return f"{'✓' if found == row['dominant'] else '≠'} {found}" if found else "–"


def _motions(findings: Findings) -> Section | None:
    if not findings.trajectory.motions:
        return None
    rows, verdicts, arm = motion_rows(findings), verdict_rows(findings), findings.arm
    changing = [row for row in verdicts if row["changes"]]
    worst = max(rows, key=lambda row: row["worst"])
    columns = [
        Column("", "no.", range(1, len(rows) + 1), shown="count"),
        Column("", "motion", [row["motion"] for row in rows], shown="name"),
        Column("", "set points", [row["set_points"] for row in rows], shown="count"),
        Column("", "duration", [row["duration"] for row in rows], "s"),
    ]
    for i, joint in enumerate(arm.joints):
        cells = [
            f"{percent(row['used'][i])}, {pretty(amount(row['peak_torque'][i], joint.effort_unit))}"
            for row in rows
        ]
        columns.append(_words(f"{i + 1} {joint.name}", cells))
    parts: list[Part] = [
        Fact(
            "worst",
            "Largest share of the allowed error",
            worst["worst"],
            shown="percent",
            note=f"joint {worst['joint']} along {worst['motion']}",
        ),
        Table(
            "motions", "Each motion by itself: error of allowed, and peak torque, by joint", tuple(columns)
        ),
    ]
    if changing:
        names = Column("", "element", [_symbol(row["element"]) for row in changing], shown="math")
        if len(rows) <= _MOST_COLUMNS:
            marks = [
                Column(
                    "",
                    f"{k} {row['motion']}",
                    [_mark(one["verdicts"][k - 1]) for one in changing],
                    shown="effect",
                )
                for k, row in enumerate(rows, start=1)
            ]
        else:
            marks = [
                Column("", word, [one["verdicts"].count(verdict) for one in changing], shown="count")
                for verdict, word in VERDICTS.items()
            ]
        title = f"{len(changing)} of {len(verdicts)} elements have a verdict that depends on the motion"
        parts.append(Table("verdicts", title, (names, *marks)))
    note = "The budget is measured along each motion by itself, and holds on each."
    strict = strict_notice(findings)
    return Section("motions", "Motion by motion", tuple(parts), f"{note}\n{strict}" if strict else note)


def _mark(verdict: str) -> str:
    return f"{verdict} {mark_of(verdict)}"


def _terms(findings: Findings) -> Section:
    table = findings.tables["terms"]
    total, title = table.attrs["total"], "Single terms ranked by torque"
    if not findings.is_written_out:
        name = findings.arm.name
        note = f"Too many terms to rank here; `gd-analyze rank {name}` ranks those that matter most."
        return Section("terms", title, (), note)
    rows, stated = [], not_worth_keeping(findings)
    kept = findings.model.torques if made_of(findings) == "terms" else None
    shown = rows_of(table.isel(rank=slice(_TERMS)), "rank")
    for row, (term, weight) in zip(shown, findings.ranked_terms.items(), strict=False):
        formula = term_formula(term, weight)
        rows.append(
            row
            | {
                "of": _SYMBOLS[row["quantity"]],
                "in": torque_symbol(term.row),
                "term": Formula(Symbol(""), formula.pieces),
                "kept": "" if kept is None else "✓" if term in kept else "–",
                "above": "–" if row["below_uncertainty"] else "✓",
            }
        )
    labels = {
        "rank": ("rank", "", "count"),
        "of": ("of", "", "text"),
        "in": ("in", "", "math"),
        "term": ("term", "", "math"),
        "alone_share": ("alone, of peak", "", "share"),
        "alone_torque": ("alone", "@alone_unit"),
        "alone_joint": ("joint", "", "count"),
        "without_share": ("without it and below", "", "percent"),
        "without_joint": ("joint", "", "count"),
        **({} if kept is None else {"kept": ("kept", "", "text")}),
        **({} if stated is None else {"above": ("above uncertainty", "", "text")}),
    }
    note = (
        f"The exact torques are a sum of {total} terms. The ranking removes the term whose loss adds "
        "least to the squared error of all removed before; the last to be removed ranks first. Everything "
        "below "
        "the row whose error is acceptable may go at once."
    )
    if stated is not None:
        note += (
            f"\nThe lowest {stated} of {total} terms together change no torque by more than its standard "
            "uncertainty, which follows from the stated uncertainties of the arm's parameters."
        )
    legend = (
        None if kept is not None else torque_legend(findings.model.form.velocities, findings.ranked_terms)
    )
    parts: list[Part] = [
        table_of("terms", f"The {len(rows)} terms that matter most, of {total}", rows, labels)
    ]
    if legend is not None:
        parts.append(Equations("names", "", (), (), legend))
    return Section("terms", title, tuple(parts), note)


def _equations(findings: Findings) -> Section:
    rows = [
        row | {"symbol": _SYMBOLS[row["quantity"]], "what": row["quantity"].replace("_", " ")}
        for row in rows_of(findings.tables["cross_check"], "comparison")
    ]
    labels = {
        "what": ("quantity", "", "text"),
        "largest_difference": ("largest difference", "@unit"),
        "round_off_bound": ("explained by round-off", "@unit"),
    }
    check = table_of("cross_check", "Difference from Pinocchio, an independent implementation", rows, labels)
    note = (
        "Generalized d'Alembert equations of motion of K. S. Fu, R. C. Gonzalez, C. S. G. Lee, "
        "Robotics, 1987 [FGL87], of revolute joints; a prismatic joint contributes its axis where a "
        "revolute one "
        "contributes axis × "
        "arm. z: axes of joints; p: origins of frames; r, c: centres of mass from the base and from "
        "the joint before; m, I: mass and inertia about it of a link; R: rotations."
    )
    return Section("equations", "Equations and cross-check", (check,), note)


def _data(findings: Findings) -> Section:
    arm = findings.arm
    joints = [
        *joint_columns(arm.joints),
        _words("kind", [joint.kind for joint in arm.joints]),
    ]
    if arm.dh_table:
        rows = [
            (f"{given(math.degrees(r.theta))}°", given(r.d), given(r.a), f"{given(math.degrees(r.alpha))}°")
            for r in arm.dh_table
        ]
        for name, cells in zip(("θ", "d, m", "a, m", "α"), zip(*rows, strict=True), strict=True):
            joints.append(_words(name, _with_variable(arm, name[0], cells)))
    joints += [
        _words("range", [_range(joint) for joint in arm.joints]),
        _words("velocity limit", [_limit(joint.velocity_limit, f"{joint.unit}/s") for joint in arm.joints]),
        _words(
            "acceleration limit",
            [_limit(joint.acceleration_limit, f"{joint.unit}/s²") for joint in arm.joints],
        ),
    ]
    if arm.drives:
        units = ["kg m^2" if joint.kind == "revolute" else "kg" for joint in arm.joints]
        joints.append(Column("", "drive inertia", [drive.inertia for drive in arm.drives], units))
    gravity = ", ".join(map(given, arm.gravity))
    geometry = f", {arm.convention} parameters" if arm.dh_table and arm.convention else ""
    title = f"Joints{geometry} and limits"
    inertias = [(f"I{'xyz'[a]}{'xyz'[b]}", a, b) for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    if not any(np.any(link.inertia_com != np.diag(np.diag(link.inertia_com))) for link in arm.links):
        inertias = inertias[:3]
    links = [
        Column("", "link", [link.name for link in arm.links], shown="name"),
        _words("mass, kg", [given(link.mass) for link in arm.links]),
        _words("centre of mass, m", [", ".join(map(given, link.com)) for link in arm.links]),
        *(_words(name, [given(link.inertia_com[a, b]) for link in arm.links]) for name, a, b in inertias),
    ]
    stated = [
        *arm.sources,
        *(f"Assumed: {line}" for line in arm.assumptions),
        *(f"Doubtful: {line}" for line in (*arm.doubts, *inconsistent_inertias(arm))),
    ]
    return Section(
        "data",
        "Data and provenance",
        (
            Table("joints", title, tuple(joints), f"Gravity ({gravity}) m/s² in the base frame."),
            Table(
                "links", "Links in their own frames; inertia about the centre of mass, kg m²", tuple(links)
            ),
            *([Section("sources", "Sources and assumptions", (), "\n".join(stated))] if stated else []),
        ),
    )


def _with_variable(arm: Any, name: str, cells: Sequence[str]) -> list[str]:
    """Cells of a Denavit-Hartenberg parameter, with the joint variable where it is one."""
    variable = {"θ": "revolute", "d": "prismatic"}
    out = []
    for k, (joint, cell) in enumerate(zip(arm.joints, cells, strict=True), start=1):
        if joint.kind == variable.get(name):
            cell = f"q{k}" if cell.rstrip("°") in ("0", "−0") else f"q{k} + {cell}"
        out.append(cell)
    return out


def _range(joint: Any) -> str:
    if joint.lower is None or joint.upper is None:
        return "not given"
    if joint.kind == "revolute":
        return f"{given(math.degrees(joint.lower))} to {given(math.degrees(joint.upper))}°"
    return f"{given(joint.lower)} to {given(joint.upper)} m"


def _limit(value: float | None, unit: str) -> str:
    return "not given" if value is None else f"{given(value)} {unit}"


def _words(label: str, cells: Sequence[str]) -> Column:
    return Column("", label, cells, shown="text")
