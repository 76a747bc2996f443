"""Appendices of the main report, the same on page and PDF."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gd_analyze.diagnosis.log_verdict import DISPUTED
from gd_analyze.figures.arm import views_figure
from gd_analyze.figures.diagnosis import compared_joints
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.elements import MOST_MARKED_SET_POINTS, Look, inertia_figure, vector_figure
from gd_analyze.figures.joints import (
    contributions_figure,
    error_figure,
    followed_figure,
    measured_figure,
    measured_joints,
    motion_figure,
    recording_figure,
)
from gd_analyze.formulas.writing import torque_legend
from gd_analyze.result import Drawing, Equations, Part, Section
from gd_analyze.results import motion_result
from gd_analyze.results.beside_log import has_log, joints_beside_log, left_in_words, shown_joints
from gd_analyze.results.diagnosis_result import causes_table, faults_table, where_drawing
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import norms_text
from gd_analyze.results.rows import dominance_note
from gd_analyze.results.run_facts import errors_table
from gd_analyze.results.shown_tables import (
    difference_table,
    not_worth_keeping,
    ranked_terms_table,
    ranking_table,
    text_comparison,
)
from gd_analyze.robots.inspection import arm_tables
from gd_analyze.robots.plausibility import inconsistent_inertias
from gd_analyze.text import given, number


def effect_drawings(findings: Findings) -> tuple[Drawing, Drawing]:
    """D and h by effect against the set points, in the order of [FGL87] Figs. 3.10 and 3.11."""
    is_marked = findings.trajectory.n_set_points <= MOST_MARKED_SET_POINTS
    hidden = "combined", "centrifugal", "coriolis"
    look = Look(x="set point", marked=is_marked, hidden=hidden)
    is_shown = text_comparison(findings) is not None
    orders = [f" In the order of Fig. {k} of [FGL87]." if is_shown else "" for k in ("3.10", "3.11")]
    marks = "Marks on curves and ticks below them: set points." if is_marked else ""
    matrix = "D by effect. At the right of a title: the verdict (J: drive, –: negligible, 0: zero)."
    vector = "h by effect."
    return (
        Drawing("inertia", f"{matrix}{orders[0]}", inertia_figure(findings, look), marks),
        Drawing(
            "coriolis_centrifugal",
            f"{vector}{orders[1]}",
            vector_figure(findings, "coriolis_centrifugal", look),
        ),
    )


def torque_appendix(findings: Findings) -> Section:
    """Verdicts and contributions over time."""
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


def motion_appendix(findings: Findings) -> Section:
    """Motion, torque and error of every joint."""
    norms = findings.model.accuracy.norms
    note = f"Norm of the error over norm of the torque: {norms_text(norms)}." if norms else ""
    torques = replace(errors_table(findings), note=note)
    path = "Time runs from light to dark; the end effector moves from the open circle to the filled one."
    sampled = "Torque and error of every joint, sampled at the set points."
    parts = (
        Drawing("views", "The arm along the axes of its base frame.", views_figure(findings), path),
        Drawing("motion", "The motion of every joint.", motion_figure(findings)),
        Drawing("errors", sampled, error_figure(findings)),
        torques,
    )
    return Section("motion", "Motion, torque and error over time", parts)


def recording_appendix(findings: Findings) -> Section | None:
    """The readings of a log, how they became a motion, and what their noise does."""
    readings = motion_result.recording_section(findings)
    if readings is None:
        return None
    drawing = Drawing(
        "recording",
        "Left: readings and smoothed motion. Right: their difference near the joint's largest acceleration.",
        recording_figure(findings),
        "Noise looks the same at all times; a slow swing is motion that the smoothing removed.",
    )
    lines = findings.tables["recording"].attrs["treatment"].split("\n")
    note = "\n".join(f"{line[:1].upper()}{line[1:]}." for line in lines if line)
    return replace(readings, title="Readings behind the motion", parts=(*readings.parts, drawing), note=note)


def measured_appendix(findings: Findings) -> Section | None:
    """Measured torque and the model's, and what is left of the difference."""
    if not measured_joints(findings):
        return None
    table = findings.tables["measured_torque"]
    alike = ", both filtered equally" if table.attrs["filter"] else ""
    figure = measured_figure(findings)
    parts: tuple[Part, ...] = (
        Drawing("measured", "Measured and exact torque, and their difference.", figure),
        *motion_result.friction_tables(table, findings.arm),
        *_diagnosis(findings),
    )
    note = f"{table.attrs['agreement']} Compared at {table.attrs['compared']} set points{alike}."
    return Section("measured", "Measured torque and the model's", parts, note)


def _diagnosis(findings: Findings) -> Iterator[Part]:
    """Causes tried, where something is left to explain, and faulty readings."""
    if findings.tables["measured_torque"].attrs["verdict"] not in DISPUTED:
        return
    table = findings.tables["diagnosis"]
    yield from causes_table(table)
    yield from faults_table(table)


def log_parts(findings: Findings) -> Iterator[Part]:
    """What a log says: torque of the joints that matter most, and a table by joint."""
    joints = shown_joints(findings) if has_log(findings) else []
    if not joints:
        return
    yield Drawing(
        "followed", f"Left after friction at {left_in_words(findings)}.", followed_figure(findings, joints)
    )
    yield joints_beside_log(findings)


def left_of_log(findings: Findings) -> Iterator[Drawing]:
    """Where to look for a cause of what is left at the joints that matter most."""
    table = findings.tables.get("diagnosis")
    if table is None:
        return
    joints = [i for i in shown_joints(findings) if i in compared_joints(table)]
    if joints:
        yield where_drawing(table, findings.arm, joints)


def ranking_appendix(findings: Findings) -> Section:
    """The ranking of elements, and [FGL87]'s verdicts."""
    text = text_comparison(findings)
    parts: list[Part] = [ranking_table(findings)]
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
        parts.append(Section(None, "Comparison with [FGL87]", (), "\n".join(sentences)))
    note = (
        f"Largest torque of each element{', of the links alone' if findings.model.drives else ''}, as a "
        "share of the joint's peak torque; it exceeds 100 % where elements cancel."
    )
    return Section("ranking", "Elements ranked by torque", tuple(parts), note)


def motions_appendix(findings: Findings) -> Section | None:
    """Errors and verdicts along each of several motions."""
    by_motion = motion_result.motions_section(findings)
    if by_motion is None:
        return None
    note = (
        "The budget is measured along each motion by itself, and holds on each. By joint: error over allowed "
        "error, and peak torque."
    )
    note = f"{note}\n{motion_result.strict_notice(findings)}".rstrip()
    return replace(by_motion, title="Motion by motion", note=note)


def terms_appendix(findings: Findings) -> Section:
    """The ranking of terms."""
    table, title = findings.tables["terms"], "Single terms ranked by torque"
    if not table.attrs["written_out"]:
        rank = f"`gd-analyze rank-terms {findings.arm.name}`"
        return Section(
            "terms", title, (), f"Too many terms to rank here; {rank} ranks those that matter most."
        )
    total, stated = table.attrs["total"], not_worth_keeping(findings)
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
    parts: list[Part] = [ranked_terms_table(findings)]
    if not findings.model.has_terms:  # else the model explains its symbols
        legend = torque_legend(findings.model.form.velocities, findings.ranked_terms)
        parts.append(Equations("names", "", (), (), legend))
    return Section("terms", title, tuple(parts), note)


def equations_appendix(findings: Findings) -> Section:
    """The equations of [FGL87], and how far an independent implementation differs."""
    note = (
        "Generalized d'Alembert equations of motion of K. S. Fu, R. C. Gonzalez, C. S. G. Lee, Robotics, "
        "1987 [FGL87], for revolute joints; a prismatic joint contributes its axis where a revolute one "
        "contributes axis × arm. z: axes of joints; p: origins of frames; r, c: centres of mass from the "
        "base and from the preceding joint; m, I: mass and central inertia of a link; R: rotations."
    )
    return Section("equations", "Equations and cross-check", (difference_table(findings),), note)


def data_appendix(findings: Findings) -> Section:
    """The arm, its sources, and the origin of the results."""
    arm = findings.arm
    gravity = f"Gravity ({', '.join(map(given, arm.gravity_vector))}) m/s² in the base frame."
    stated = [
        *arm.sources,
        *(f"Assumed: {line}" for line in arm.assumptions),
        *(f"Doubtful: {line}" for line in (*arm.doubts, *inconsistent_inertias(arm))),
    ]
    sources = (Section("sources", "Sources and assumptions", (), "\n".join(stated)),) if stated else ()
    return Section("data", "Data and provenance", (*arm_tables(arm), *sources), gravity)
