"""The appendices of the main report, the same on page and PDF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gd_analyze.dynamics.verdict_lists import LISTS
from gd_analyze.figures.arm import views_figure
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.elements import LETTERS, Look, vector_figure
from gd_analyze.figures.joints import (
    contributions_figure,
    error_figure,
    measured_figure,
    measured_joints,
    motion_figure,
    recording_figure,
)
from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.writing import part_symbol, term_formula, torque_legend, torque_symbol
from gd_analyze.report.model_sections import beyond_section, founding_section, made_of, model_section
from gd_analyze.result import Column, Drawing, Equations, Fact, Part, Section, Table, joint_columns
from gd_analyze.results import motion_result
from gd_analyze.results import rows as row_parts
from gd_analyze.results.diagnosis_result import causes_table, faults_table, where_drawing, worst_joint
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import norms_text
from gd_analyze.results.rows import dominance_note, effect_of, element_rows, joint_rows, rows_of, table_of
from gd_analyze.results.run_result import not_worth_keeping, text_comparison
from gd_analyze.robots.parts import Joint
from gd_analyze.robots.plausibility import inconsistent_inertias
from gd_analyze.text import amount, given, number, percent, pretty, short_names

# Rows of the ranking of terms.
_TERMS = 40
_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c", "torque": "τ"}


def sections(findings: Findings) -> tuple[Section, ...]:
    """All appendices that have something to show, in order."""
    candidates = (
        _torque(findings),
        _motion(findings),
        _recording(findings) if "recording" in findings.tables else None,
        _measured(findings) if measured_joints(findings) else None,
        _ranking(findings),
        _motions(findings) if findings.trajectory.motions else None,
        _terms(findings),
        model_section(findings),
        beyond_section(findings),
        founding_section(findings) if made_of(findings) != "parts" else None,
        _equations(findings),
        _data(findings),
    )
    return tuple(section for section in candidates if section is not None)


def _motion(findings: Findings) -> Section:
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
    title, rows = (
        "Torque and error of every joint along this trajectory",
        joint_rows(findings, "simplified_model"),
    )
    path = "Time runs from light to dark; the end effector moves from the open circle to the filled one."
    sampled = "Torque and error of every joint, sampled at the set points."
    parts = (
        Drawing("views", "The arm along the axes of its base frame.", views_figure(findings), path),
        Drawing("motion", "The motion of every joint.", motion_figure(findings)),
        Drawing("errors", sampled, error_figure(findings)),
        table_of("torques", title, rows, labels, note),
    )
    return Section("motion", "Motion, torque and error over time", parts)


def _recording(findings: Findings) -> Section:
    table = findings.tables["recording"]
    (readings,) = motion_result.recording_parts(findings)
    assert isinstance(readings, Section)
    names = ("column", "column_role", "column_joint", "column_unit", "column_why")
    rows = list(zip(*(table[name].values.tolist() for name in names), strict=True))
    used = zip(*(row for row in rows if row[1] != "unused"), strict=True)
    heads = ("column", "holds", "joint", "unit", "understood by")
    columns = tuple(_words(head, cells) for head, cells in zip(heads, used, strict=False))
    unused = [f"{name} ({reason})" if reason else name for name, role, *_, reason in rows if role == "unused"]
    drawing = Drawing(
        "recording",
        "Left: readings and smoothed motion. Right: their difference near the joint's largest acceleration.",
        recording_figure(findings),
        "Noise looks the same at all times; a slow swing is motion that the smoothing removed.",
    )
    note = f"Unused: {', '.join(unused)}." if unused else ""
    log = Table("columns", "Columns of the log that are used", columns, note)
    inside = (part for part in readings.parts if isinstance(part, Fact | Table) and part.key != "columns")
    treatment = [f"{line[:1].upper()}{line[1:]}." for line in table.attrs["treatment"].split("\n") if line]
    parts: tuple[Part, ...] = (*inside, drawing, *([log] if columns else []))
    return Section("recording", "Readings behind the motion", parts, "\n".join(treatment))


def _measured(findings: Findings) -> Section:
    table = findings.tables["measured_torque"]
    alike = ", both filtered equally" if table.attrs["filter"] else ""
    figure = measured_figure(findings)
    parts: tuple[Part, ...] = (
        Drawing("measured", "Measured and exact torque, and their difference.", figure),
        motion_result.measured_table(table, findings.arm),
        *motion_result.friction_tables(table, findings.arm),
        *_diagnosis(findings),
    )
    note = f"Compared at {table.attrs['compared']} set points with measured torque{alike}."
    return Section("measured", "Measured torque and the model's", parts, note)


def _diagnosis(findings: Findings) -> Iterator[Part]:
    """What a log that contradicts the arm tells: causes tried, and the worst joint's residuals."""
    if "diagnosis" not in findings.tables:
        return
    table = findings.tables["diagnosis"]
    joint = worst_joint(table)
    drawings = () if joint is None else (where_drawing(table, findings.arm, [joint]),)
    parts = (*drawings, *causes_table(table), *faults_table(table))
    yield Section("", "Why log and arm contradict each other", parts, str(table.attrs["answer"]))


def _torque(findings: Findings) -> Section:
    parts = (
        Drawing(
            "dominance",
            "Verdict on each element of D and h over time.",
            dominance_figure(findings),
            dominance_note(findings),
        ),
        Drawing(
            "gravity_loading",
            "Gravity loading c, which acts on masses only and has no rotational part.",
            vector_figure(findings, "gravity_loading", Look(x="set point")),
        ),
        Drawing(
            "contributions",
            "Torque by contribution over time.",
            contributions_figure(findings),
            "Positive parts are stacked above zero, negative ones below it; the line is their sum.",
        ),
    )
    return Section("torque", "Verdicts and torque over time", parts)


def _symbol(label: str) -> Symbol:
    return part_symbol(*label.split())


def _ranking(findings: Findings) -> Section:
    text = text_comparison(findings)
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
        **({"sure": ("probability", "", "text")} if "robustness" in findings.tables else {}),
        **({"beside": ("[FGL87]", "", "text")} if text else {}),
    }
    rows = []
    for row in element_rows(findings):
        effect, text_verdict = effect_of(row), row["text_verdict"]
        cells = {
            "symbol": _symbol(row["element"]),
            "verdict": f"{effect} {effect}",
            "sure": row_parts.sure_text(row),
            "beside": f"{'✓' if text_verdict == row['dominant'] else '≠'} {text_verdict}"
            if text_verdict
            else "–",
        }
        if row["quantity"] == "gravity_loading":
            split = ("part_peak", "change_without")
            cells |= {f"{name}_{effect}": None for name in split for effect in ("translation", "rotation")}
        rows.append(row | cells)
    parts: list[Part] = [table_of("ranking", "Elements by torque", rows, labels)]
    if text:
        sentences = [
            f"{text['agreed']} of {text['given']} verdicts of [FGL87] agree with ours on this "
            "trajectory (✓). It states neither its trajectory nor its inertial parameters; verdicts depend "
            "on both."
        ]
        if text["remarks"]:
            sentences.append(f"[FGL87] contradicts itself on {len(text['remarks'])} of them:")
        for row, remark, finding in text["remarks"]:
            moving, turning = (number(row[f"part_peak_{effect}"]) for effect in ("translation", "rotation"))
            sentences.append(
                f"{row['element']}, called {row['text_verdict']} dominant: {remark}. Here its translation "
                f"peaks at {moving} and its rotation at {turning} {row['unit']}: {finding}."
            )
        sentences.append(f"[FGL87] {text['source']}.")
        parts.append(Section("", "Comparison with [FGL87]", (), "\n".join(sentences)))
    note = (
        f"Largest torque of each element{', of the links alone' if findings.model.drives else ''}, as a "
        "share of the joint's peak torque; it exceeds 100 % where elements cancel. "
        f"Verdict: {row_parts.threshold_text(findings)}."
    )
    return Section("ranking", "Elements ranked by torque", tuple(parts), note)


def _motions(findings: Findings) -> Section:
    rows, verdicts = motion_result.motion_rows(findings), motion_result.verdict_rows(findings)
    columns = [
        Column("", "no.", range(1, len(rows) + 1), shown="count"),
        Column("", "motion", [row["motion"] for row in rows], shown="name"),
        Column("", "set points", [row["set_points"] for row in rows], shown="count"),
        Column("", "duration", [row["duration"] for row in rows], "s"),
    ]
    names = short_names([joint.name for joint in findings.arm.joints])
    for i, joint in enumerate(findings.arm.joints):
        peaks = [pretty(amount(row["peak_torque"][i], joint.effort_unit)) for row in rows]
        cells = [f"{percent(row['used'][i])}, {peak}" for row, peak in zip(rows, peaks, strict=True)]
        columns.append(_words(f"{i + 1} {names[i]}", cells))
    title = "Each motion by itself: error over allowed error, and peak torque, by joint"
    parts: list[Part] = [motion_result.worst_fact(rows), Table("motions", title, tuple(columns))]
    changing = [row for row in verdicts if row["changes"]]
    if changing:
        columns = [Column("", "element", [_symbol(row["element"]) for row in changing], shown="math")]
        if len(rows) <= motion_result.MOST_COLUMNS:
            for k, motion in enumerate(rows):
                motion_verdicts = [row["verdicts"][k] for row in changing]
                marks = [f"{verdict} {LETTERS[verdict]}" for verdict in motion_verdicts]
                columns.append(Column("", f"{k + 1} {motion['motion']}", marks, shown="effect"))
        else:
            for verdict in LISTS:
                counts = [row["verdicts"].count(verdict) for row in changing]
                columns.append(Column("", verdict, counts, shown="count"))
        title = f"{len(changing)} of {len(verdicts)} elements have a verdict that depends on the motion"
        parts.append(Table("verdicts", title, tuple(columns)))
    note = "The budget is measured along each motion by itself, and holds on each."
    note = f"{note}\n{motion_result.strict_notice(findings)}".rstrip()
    return Section("motions", "Motion by motion", tuple(parts), note)


def _terms(findings: Findings) -> Section:
    table, title = findings.tables["terms"], "Single terms ranked by torque"
    if not table.attrs["written_out"]:
        rank = f"`gd-analyze rank {findings.arm.name}`"
        return Section(
            "terms", title, (), f"Too many terms to rank here; {rank} ranks those that matter most."
        )
    total, stated = table.attrs["total"], not_worth_keeping(findings)
    kept_terms = findings.model.torques if made_of(findings) == "terms" else None
    rows = []
    ranked_rows = rows_of(table.isel(rank=slice(_TERMS)), "rank")
    for row, (term, weight) in zip(ranked_rows, findings.ranked_terms.items(), strict=False):
        cells = {
            "of": _SYMBOLS[row["quantity"]],
            "in": torque_symbol(term.row),
            "term": Formula(Symbol(""), term_formula(term, weight).pieces),
            "kept": "" if kept_terms is None else "✓" if term in kept_terms else "–",
            "above": "–" if row["below_uncertainty"] else "✓",
        }
        rows.append(row | cells)
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
        **({} if kept_terms is None else {"kept": ("kept", "", "text")}),
        **({} if stated is None else {"above": ("above uncertainty", "", "text")}),
    }
    note = (
        f"The exact torques are a sum of {total} terms. The ranking removes, one by one, the term whose loss "
        "adds least to the squared error; the term removed last ranks first. All terms below the row whose "
        "error is acceptable may be dropped together."
    )
    if stated is not None:
        note += (
            f"\nThe lowest {stated} of {total} terms together change no torque by more than its standard "
            "uncertainty, which follows from the stated uncertainties of the arm's parameters."
        )
    parts: list[Part] = [
        table_of("terms", f"The {len(rows)} terms that matter most, of {total}", rows, labels)
    ]
    if kept_terms is None:  # else the model explains its symbols
        legend = torque_legend(findings.model.form.velocities, findings.ranked_terms)
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
        "Generalized d'Alembert equations of motion of K. S. Fu, R. C. Gonzalez, C. S. G. Lee, Robotics, "
        "1987 [FGL87], for revolute joints; a prismatic joint contributes its axis where a revolute one "
        "contributes axis × arm. z: axes of joints; p: origins of frames; r, c: centres of mass from the "
        "base and from the preceding joint; m, I: mass and central inertia of a link; R: rotations."
    )
    return Section("equations", "Equations and cross-check", (check,), note)


def _data(findings: Findings) -> Section:
    arm = findings.arm
    joints = [*joint_columns(arm.joints), _words("kind", [joint.kind for joint in arm.joints])]
    if arm.dh_table:
        rows = [
            (f"{given(math.degrees(r.theta))}°", given(r.d), given(r.a), f"{given(math.degrees(r.alpha))}°")
            for r in arm.dh_table
        ]
        # For the parameter that is the joint's variable, the cell is an offset.
        variable = {"θ": "revolute", "d, m": "prismatic"}
        for name, cells in zip(("θ", "d, m", "a, m", "α"), zip(*rows, strict=True), strict=True):
            moves = [joint.kind == variable.get(name) for joint in arm.joints]
            with_variable = [
                cell if not moving else f"q{k}" if cell.rstrip("°") in ("0", "−0") else f"q{k} + {cell}"
                for k, (cell, moving) in enumerate(zip(cells, moves, strict=True), start=1)
            ]
            joints.append(_words(name, with_variable))
    joints.append(_words("range", [_range(joint) for joint in arm.joints]))
    for quantity, per in (("velocity", "s"), ("acceleration", "s²")):
        limits = [(getattr(joint, f"{quantity}_limit"), f"{joint.unit}/{per}") for joint in arm.joints]
        texts = ["not given" if limit is None else f"{given(limit)} {unit}" for limit, unit in limits]
        joints.append(_words(f"{quantity} limit", texts))
    if arm.drives:
        units = ["kg m^2" if joint.kind == "revolute" else "kg" for joint in arm.joints]
        joints.append(Column("", "drive inertia", [drive.inertia for drive in arm.drives], units))
    geometry = f", {arm.convention} parameters" if arm.dh_table and arm.convention else ""
    gravity = f"Gravity ({', '.join(map(given, arm.gravity))}) m/s² in the base frame."
    entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    is_diagonal = all(
        np.array_equal(i, np.diag(np.diag(i))) for i in (link.inertia_com for link in arm.links)
    )
    links = [
        Column("", "link", [link.name for link in arm.links], shown="name"),
        _words("mass, kg", [given(link.mass) for link in arm.links]),
        _words("centre of mass, m", [", ".join(map(given, link.com)) for link in arm.links]),
    ]
    for a, b in entries[:3] if is_diagonal else entries:
        links.append(_words(f"I{'xyz'[a]}{'xyz'[b]}", [given(link.inertia_com[a, b]) for link in arm.links]))
    stated = [
        *arm.sources,
        *(f"Assumed: {line}" for line in arm.assumptions),
        *(f"Doubtful: {line}" for line in (*arm.doubts, *inconsistent_inertias(arm))),
    ]
    about = "Links in their own frames; inertia about the centre of mass, kg m²"
    parts: list[Part] = [
        Table("joints", f"Joints{geometry} and limits", tuple(joints), gravity),
        Table("links", about, tuple(links)),
    ]
    if stated:
        parts.append(Section("sources", "Sources and assumptions", (), "\n".join(stated)))
    return Section("data", "Data and provenance", tuple(parts))


def _range(joint: Joint) -> str:
    if joint.lower is None or joint.upper is None:
        return "not given"
    if joint.kind == "revolute":
        return f"{given(math.degrees(joint.lower))} to {given(math.degrees(joint.upper))}°"
    return f"{given(joint.lower)} to {given(joint.upper)} m"


def _words(label: str, cells: Sequence[str]) -> Column:
    return Column("", label, cells, shown="text")
