"""The appendices of the main report, the same on page and PDF."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gd_analyze.diagnosis.log_verdict import DISPUTED
from gd_analyze.figures.arm import views_figure
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.elements import Look, vector_figure
from gd_analyze.figures.joints import (
    contributions_figure,
    error_figure,
    measured_figure,
    measured_joints,
    motion_figure,
    recording_figure,
)
from gd_analyze.formulas.writing import torque_legend
from gd_analyze.report.model_sections import beyond_section, founding_section, made_of, model_section
from gd_analyze.result import Drawing, Equations, Part, Section
from gd_analyze.results import motion_result
from gd_analyze.results.diagnosis_result import causes_table, faults_table, where_drawing, worst_joint
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import joint_errors, norms_text
from gd_analyze.results.near_motion import tube_bound
from gd_analyze.results.rows import dominance_note
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
    norms = findings.model.accuracy.norms
    note = f"Norm of the error over norm of the torque: {norms_text(norms)}." if norms else ""
    torques = replace(
        joint_errors(findings.model, tube_bound(findings), "torques", findings.proof), note=note
    )
    path = "Time runs from light to dark; the end effector moves from the open circle to the filled one."
    sampled = "Torque and error of every joint, sampled at the set points."
    parts = (
        Drawing("views", "The arm along the axes of its base frame.", views_figure(findings), path),
        Drawing("motion", "The motion of every joint.", motion_figure(findings)),
        Drawing("errors", sampled, error_figure(findings)),
        torques,
    )
    return Section("motion", "Motion, torque and error over time", parts)


def _recording(findings: Findings) -> Section:
    (readings,) = motion_result.recording_parts(findings)
    assert isinstance(readings, Section)
    drawing = Drawing(
        "recording",
        "Left: readings and smoothed motion. Right: their difference near the joint's largest acceleration.",
        recording_figure(findings),
        "Noise looks the same at all times; a slow swing is motion that the smoothing removed.",
    )
    lines = findings.tables["recording"].attrs["treatment"].split("\n")
    treatment = [f"{line[:1].upper()}{line[1:]}." for line in lines if line]
    return Section(
        "recording", "Readings behind the motion", (*readings.parts, drawing), "\n".join(treatment)
    )


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
    note = f"{table.attrs['agreement']} Compared at {table.attrs['compared']} set points{alike}."
    return Section("measured", "Measured torque and the model's", parts, note)


def _diagnosis(findings: Findings) -> Iterator[Part]:
    """The worst joint's residuals and causes tried, where something is left to explain."""
    if findings.tables["measured_torque"].attrs["verdict"] not in DISPUTED:
        return
    table = findings.tables["diagnosis"]
    joint = worst_joint(table)
    drawings = () if joint is None else (where_drawing(table, findings.arm, [joint]),)
    parts = (*drawings, *causes_table(table), *faults_table(table))
    yield Section(None, "What is left of the measured torque", parts)


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


def _ranking(findings: Findings) -> Section:
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


def _motions(findings: Findings) -> Section:
    (motions,) = motion_result.motion_parts(findings)
    assert isinstance(motions, Section)
    note = (
        "The budget is measured along each motion by itself, and holds on each. By joint: error over allowed "
        "error, and peak torque."
    )
    note = f"{note}\n{motion_result.strict_notice(findings)}".rstrip()
    return Section("motions", "Motion by motion", motions.parts, note)


def _terms(findings: Findings) -> Section:
    table, title = findings.tables["terms"], "Single terms ranked by torque"
    if not table.attrs["written_out"]:
        rank = f"`gd-analyze rank {findings.arm.name}`"
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


def _equations(findings: Findings) -> Section:
    note = (
        "Generalized d'Alembert equations of motion of K. S. Fu, R. C. Gonzalez, C. S. G. Lee, Robotics, "
        "1987 [FGL87], for revolute joints; a prismatic joint contributes its axis where a revolute one "
        "contributes axis × arm. z: axes of joints; p: origins of frames; r, c: centres of mass from the "
        "base and from the preceding joint; m, I: mass and central inertia of a link; R: rotations."
    )
    return Section("equations", "Equations and cross-check", (difference_table(findings),), note)


def _data(findings: Findings) -> Section:
    arm = findings.arm
    gravity = f"Gravity ({', '.join(map(given, arm.gravity))}) m/s² in the base frame."
    stated = [
        *arm.sources,
        *(f"Assumed: {line}" for line in arm.assumptions),
        *(f"Doubtful: {line}" for line in (*arm.doubts, *inconsistent_inertias(arm))),
    ]
    sources = (Section("sources", "Sources and assumptions", (), "\n".join(stated)),) if stated else ()
    return Section("data", "Data and provenance", (*arm_tables(arm), *sources), gravity)
