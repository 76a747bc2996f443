"""A validation as a Result, and as JUnit XML for machines that run tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.motions.states import in_words
from gd_analyze.result import Column, Fact, Part, Result, Section, Table, joint_columns
from gd_analyze.results.model_facts import drives_text
from gd_analyze.results.motion_result import friction_tables, measured_table
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.results.rows import rows_of
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.studies.validation import BesideMeasured, ValidatedMotion, Validation
from gd_analyze.text import joint_name, visible


def validation_result(found: Validation, *, fit_friction: bool = False) -> Result:
    """The verdict, a row per motion, and each motion; also fitted friction if asked for."""
    model, box, failures = found.model, found.box, found.failures
    fitted_on = in_words(model.accuracy.fitted_on) if model.accuracy.fitted_on else "states not named"
    limits = {name: getattr(box, name) for name in ("lower", "upper", "velocity", "acceleration")}
    asked = "" if found.fail_over is None else str(found.fail_over)
    verdict = f"{'Passed' if found.passed else 'Failed'}: --fail-over {asked}."
    is_judged = asked and any(one.most is not None for one in found.motions)
    why = "the model states nothing for these states" if asked else "--report-only"
    one, joint = found.worst
    name = joint_name(joint + 1, model.arm.joints[joint].name)
    tried = len(found.motions) * model.arm.n_joints
    return Result(
        title=model.arm.title or model.arm.name,
        subtitle=", ".join(filter(None, ["model validated", drives_text(model.arm, model.drives)])),
        headline=verdict if is_judged else f"Not judged: {why}.",
        facts=(
            Fact("arm", "", model.arm.name),
            Fact("drives", "", model.drives),
            Fact("level", "", model.level.name),
            Fact("fitted_on", "Model fitted on", dict(model.accuracy.fitted_on), text=fitted_on),
            Fact("budget", "Budget", model.accuracy.budget),
            Fact("fail_over", "Fail over" * bool(asked), asked or None),
            Fact("passed", "", found.passed if is_judged else None),
            Fact("", "Errors above it" * bool(failures), f"{len(failures)} of {tried}"),
            Fact("", "Worst", f"joint {name} along {one.name}: {one.error_text(joint)}"),
            Fact("box", "", {"where": box.where, **limits}),
            Fact("motions", "", [_motion(each, found, fit_friction) for each in found.motions]),
        ),
        parts=(
            *((_motions_table(found),) if len(found.motions) > 1 else ()),
            *(_section(each, found, fit_friction) for each in found.motions),
        ),
    )


def _motion(one: ValidatedMotion, found: Validation, fit_friction: bool) -> dict[str, Any]:
    """One motion for JSON."""

    def beside(comparison: TorqueComparison) -> list[dict[str, Any]]:
        table = measured_torque_table(comparison, one.trajectory, fit_friction=fit_friction)
        return [dict(row) for row in rows_of(table, "joint")]

    measured = one.measured
    return {
        "trajectory": one.name,
        "set_points": one.trajectory.n_set_points,
        "begin": float(one.trajectory.time[0]),
        "end": float(one.trajectory.time[-1]),
        "passed": None if one.most is None else not one.fails.any(),
        "keeps_promise": bool(one.keeps_promise.all()),
        "joints": _joint_table(one).rows(),
        "norms": [norm._asdict() for norm in one.evaluation.norms],
        "set_points_outside_box": int(one.outside.sum()),
        "box_exits": _exits_table(one, found).rows(),
        "measured_torque": measured
        and {"exact": beside(measured.exact), "simplified": beside(measured.simplified)},
    }


def _motions_table(found: Validation) -> Table:
    motions = found.motions
    errors = [one.evaluation.errors for one in motions]
    columns = [
        Column("", "motion", [one.name for one in motions], shown="name"),
        Column("", "set points", [one.trajectory.n_set_points for one in motions], shown="count"),
        Column("", "of peak", [each.largest_share.max() for each in errors], shown="percent"),
        Column("", "joint", [each.worst + 1 for each in errors], shown="count"),
        Column("", "promise broken", [int((~one.keeps_promise).sum()) for one in motions], shown="count"),
        Column("", "outside box", [int(one.outside.sum()) for one in motions], shown="count"),
    ]
    if found.fail_over is not None:
        passed = [None if one.most is None else not one.fails.any() for one in motions]
        columns.append(Column("", "passed", passed, shown="flag"))
    note = "Of peak: largest error over peak torque. Promise broken: joints. Outside box: set points."
    return Table("", "All motions", tuple(columns), note)


def _section(one: ValidatedMotion, found: Validation, fit_friction: bool) -> Section:
    count = one.trajectory.n_set_points
    parts: list[Part] = [_joint_table(one)]
    if one.exits:
        label = f"Set points outside {found.box.where}"
        note = "no certificate for these limits holds there"
        parts.append(Fact("", label, f"{int(one.outside.sum())} of {count}", note=note))
        parts.append(_exits_table(one, found))
    if one.measured is not None:
        parts += _measured(one, one.measured, fit_friction)
    return Section("", f"{one.name}, {count} set points", tuple(parts))


def _joint_table(one: ValidatedMotion) -> Table:
    errors, arm = one.evaluation.errors, one.evaluation.dynamics.arm
    units, nothing = [joint.effort_unit for joint in arm.joints], [None] * arm.n_joints
    judged, allowed = one.most is not None, one.accuracy.allowed
    columns = [
        *joint_columns(arm.joints),
        Column("peak_torque", "peak", errors.peak_torque, units),
        Column("largest_error", "error", errors.largest, units),
        Column("largest_share_of_peak_here", "of peak", errors.largest_share, shown="percent"),
        Column("rms_error", "", errors.rms),
        Column("largest_error_at", "" if judged else "at", one.at, "s"),
        Column("fail_over", "limit" if judged else "", nothing if one.most is None else one.most, units),
        Column("passed", "passed" if judged else "", ~one.fails if judged else nothing, shown="flag"),
        Column("allowed_error", "" if judged else "promised", allowed, units),
        Column("", "promise kept", one.keeps_promise, shown="flag"),
        Column("within_allowed", "", errors.largest <= allowed),
        Column("largest_of_allowed", "", share_of(errors.largest, allowed)),
    ]
    return Table("", "Torque error", tuple(columns))


def _exits_table(one: ValidatedMotion, found: Validation) -> Table:
    exits, farthest = one.exits, [each.farthest for each in one.exits]
    units = [each.unit for each in farthest]
    columns = (
        Column("joint", "", [each.joint for each in farthest]),
        Column("joint_name", "", [each.name for each in farthest]),
        Column("", "joint", [joint_name(each.joint, each.name) for each in farthest], shown="name"),
        Column("quantity", "quantity", [each.quantity for each in farthest], shown="text"),
        Column("unit", "", units),
        Column("limit", "limit", [each.limit for each in farthest], units),
        Column("farthest", "", [each.value for each in farthest]),
        Column("farthest_at", "", [each.time for each in farthest]),
        Column("", "by", [each.excess for each in farthest], units),
        Column("set_points", "points", [each.set_points for each in exits], shown="count"),
        Column("first", "first", [each.first for each in exits], "s"),
        Column("longest_stretch", "", [(each.begin, each.end) for each in exits]),
        Column("", "longest", [f"{each.begin:.4g} to {each.end:.4g}" for each in exits], "s"),
    )
    return Table("", f"Limits of {found.box.where} exceeded", columns)


def _measured(one: ValidatedMotion, measured: BesideMeasured, fit_friction: bool) -> list[Part]:
    """Exact and simplified torque side by side, each compared with the measured torque."""
    exact, simplified = measured
    units = [joint.effort_unit for joint in exact.arm.joints]
    columns = [*joint_columns(exact.arm.joints), Column("", "measured peak", exact.peak_measured, units)]
    for heading, of in (("exact", exact), ("simplified", simplified)):
        columns.append(Column("", f"RMS to {heading}", of.rms, units))
        if fit_friction:
            columns.append(Column("", "beside friction", of.friction.rms, units))
    # To nine digits: the difference may be nothing but round-off.
    more = np.round(share_of(simplified.rms - exact.rms, exact.rms), 9) + 0.0
    columns.append(Column("", "more", more, shown="percent"))
    note = "RMS to exact, to simplified: RMS of measured minus model. More: simplified over exact."
    tables = [
        Table("", "Measured torque", tuple(columns), note),
        measured_table(measured_torque_table(exact, one.trajectory), exact.arm),
    ]
    if fit_friction:
        table = measured_torque_table(exact, one.trajectory, fit_friction=True)
        tables += friction_tables(table, exact.arm, " from the exact torque")
    return [replace(table, key="") for table in tables]


def junit_xml(validation: Validation) -> str:
    """Write a suite per motion with a case per joint; a failed joint is a failure with its error.

    In names, characters that XML cannot hold or that act on a terminal are spelt out; others are escaped.
    """
    model = validation.model
    root = ElementTree.Element("testsuites", {"name": "gd-analyze validate"} | _counts(validation.motions))
    for one in validation.motions:
        suite = ElementTree.SubElement(root, "testsuite", {"name": visible(one.name)} | _counts([one]))
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in {
            "arm": model.arm.name,
            "budget": model.accuracy.budget,
            "fail over": validation.fail_over or "",
            "set points": one.trajectory.n_set_points,
            "box": validation.box.where,
            "set points outside the box": int(one.outside.sum()),
            "joints beyond the promise": int((~one.keeps_promise).sum()),
        }.items():
            ElementTree.SubElement(properties, "property", name=name, value=visible(str(value)))
        for i, joint in enumerate(model.arm.joints):
            name = visible(f"joint {joint_name(i + 1, joint.name)}")
            case = ElementTree.SubElement(suite, "testcase", classname=visible(one.name), name=name)
            text = one.error_text(i)
            if one.fails[i]:
                ElementTree.SubElement(case, "failure", type="torque error", message=text).text = text
            else:
                ElementTree.SubElement(case, "system-out").text = text
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def _counts(motions: Sequence[ValidatedMotion]) -> dict[str, str]:
    tests = sum(len(one.fails) for one in motions)
    failures = sum(int(one.fails.sum()) for one in motions)
    return {"tests": str(tests), "failures": str(failures), "errors": "0", "skipped": "0"}
