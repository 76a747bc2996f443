"""An evaluation as a Result, and as JUnit XML for machines that run tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.motions.states import in_words
from gd_analyze.result import Column, Fact, Part, Result, Section, Table, columns_of, joint_columns
from gd_analyze.results.model_facts import drives_text, norms_text
from gd_analyze.results.motion_result import friction_tables, measured_table
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.results.rows import rows_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.model_torque import losses, model_torque, payload_effect
from gd_analyze.studies.evaluation import BesideMeasured, EvaluatedMotion, Evaluation
from gd_analyze.text import counted, joint_name, number, visible

# Smallest loss shown to people, as a share of peak torque.
_WORTH_A_LINE = 1e-4


def evaluation_result(
    found: Evaluation,
    payload: Link | None = None,
    unloaded: RobotArm | None = None,
    *,
    fit_friction: bool = False,
) -> Result:
    """The verdict, a row per motion, and each motion; also fitted friction if asked for.

    With a payload, which the evaluation's arm carries, errors of the `unloaded` arm stand beside. Along a
    motion without one the largest losses are listed, if dropped parts cause the error.
    """
    model, box, arm = found.model, found.box, found.motions[0].dynamics.arm
    accuracy = model.accuracy
    fitted_on = in_words(accuracy.fitted_on) if accuracy.fitted_on else "states not named"
    limits = {name: getattr(box, name) for name in ("lower", "upper", "velocity", "acceleration")}
    carried = payload and {"mass": payload.mass, "position": payload.com, "inertia": payload.inertia_com}
    asked = "" if found.fail_over is None else str(found.fail_over)
    is_judged = found.strict or any(one.most is not None for one in found.motions)
    judged = sum(len(one.fails) for one in found.motions if one.most is not None)
    one, joint = found.worst
    name = joint_name(joint + 1, arm.joints[joint].name)
    where = f"{len(found.motions)} motions" if len(found.motions) > 1 else one.dynamics.states.in_words
    broken = [each for each in found.motions if not each.keeps_promise.all()]
    times = max((share_of(each.errors.largest, each.accuracy.allowed).max() for each in broken), default=0.0)
    sections = [_Motion(each, found, unloaded, fit_friction) for each in found.motions]
    return Result(
        title=f"{arm.title or arm.name}: torque error of a model of {model.arm.name}",
        subtitle=", ".join(filter(None, [f"on {where}", drives_text(model.arm, model.drives)])),
        headline=found.verdict,
        facts=(
            Fact("arm", "", model.arm.name),
            Fact("drives", "", model.drives),
            Fact("level", "", model.level.name),
            Fact("fitted_on", "Model fitted on", dict(accuracy.fitted_on), text=fitted_on),
            Fact("budget", "Budget", accuracy.budget),
            Fact("promised", "", "measured" if accuracy.measured else "stated by the file"),
            Fact("promised_norms", "", [norm._asdict() for norm in accuracy.norms]),
            Fact("held_against", "", {"arm": arm.name, "drives": model.drives, "payload": carried}),
            Fact("fail_over", "", asked or None),
            Fact("strict", "", found.strict),
            Fact("passed", "", found.passed if is_judged and asked else None),
            Fact("", "Errors above it" * bool(found.failures), f"{len(found.failures)} of {judged}"),
            Fact(
                "",
                "Promise broken" * bool(broken),
                f"on {', '.join(each.name for each in broken[:3])}{', ...' * (len(broken) > 3)}",
                note=f"error up to {number(float(times))} times what the budget allowed",
            ),
            Fact("", "Worst", f"joint {name}, {one.name}: {one.error_text(joint)}"),
            Fact("box", "", {"where": box.where, **limits}),
            Fact("motions", "", [section.document() for section in sections]),
        ),
        parts=(
            *((_motions_table(found),) if len(found.motions) > 1 else ()),
            *(section.shown() for section in sections),
        ),
    )


def _motions_table(found: Evaluation) -> Table:
    motions = found.motions
    errors = [one.errors for one in motions]
    columns = [
        Column("", "motion", [one.name for one in motions], shown="name"),
        Column("", "set points", [len(one.judged) for one in motions], shown="count"),
        Column("", "of peak", [each.largest_share.max() for each in errors], shown="percent"),
        Column("", "joint", [each.worst + 1 for each in errors], shown="count"),
        Column("", "promise broken", [int((~one.keeps_promise).sum()) for one in motions], shown="count"),
        Column("", "outside box", [int(one.outside.sum()) for one in motions], shown="count"),
    ]
    if found.fail_over is not None:
        columns.append(Column("", "passed", [one.passed for one in motions], shown="flag"))
    note = "Of peak: largest error over peak torque. Promise broken: joints. Outside box: set points."
    return Table("", "All motions", tuple(columns), note)


class _Motion:
    """One motion, for people and for JSON."""

    def __init__(
        self, one: EvaluatedMotion, found: Evaluation, unloaded: RobotArm | None, fit_friction: bool
    ) -> None:
        self.one, self.found, self.fit_friction = one, found, fit_friction
        self.model = found.model.stating(one.accuracy)
        states = one.dynamics.states
        self.effect = payload_effect(self.model, states)
        self.bare = None if unloaded is None else model_torque(self.model, states, unloaded)
        along = one.trajectory is not None and unloaded is None
        self.lost = losses(self.model, one.dynamics) if along else ()

    def document(self) -> dict[str, Any]:
        """JSON values."""
        one, described, motion = self.one, self.one.dynamics.states.described, self.one.trajectory

        def beside(comparison: TorqueComparison) -> list[dict[str, Any]]:
            assert motion is not None  # measured torques are of a motion
            table = measured_torque_table(comparison, motion, fit_friction=self.fit_friction)
            return [dict(row) for row in rows_of(table, "joint")]

        measured = one.measured
        return {
            "trajectory": described.get("trajectory"),
            "set_points": len(one.judged) if "trajectory" in described else None,
            **{name: described.get(name) for name in ("box", "states", "seed")},
            "begin": None if motion is None else float(motion.time[0]),
            "end": None if motion is None else float(motion.time[-1]),
            "passed": one.passed,
            "judged": int(one.judged.sum()),
            "keeps_promise": bool(one.keeps_promise.all()),
            "joints": self.joints().rows(),
            "norms": [norm._asdict() for norm in one.norms],
            "mass_within_budget": self.effect.largest_mass,
            "limiting_joint": self.effect.limiting_joint,
            "largest_losses": Table(
                "", "", tuple(columns_of(self.lost, *((key, "", "number") for key in _LOSSES)))
            ).rows(),
            "outside_box": int(one.outside.sum()),
            "box_exits": self.exits().rows(),
            "measured_torque": measured
            and {"exact": beside(measured.exact), "simplified": beside(measured.simplified)},
        }

    def shown(self) -> Section:
        """The section that people see."""
        one, count = self.one, len(self.one.judged)
        parts: list[Part] = [self.joints(), *self.omissions()]
        if 0 < one.judged.sum() < count:
            parts.append(Fact("", "Judged", f"{int(one.judged.sum())} of {count} states"))
        if one.norms:
            parts.append(Fact("", "Norm, error/torque", norms_text(one.norms)))
        if self.bare is not None and self.bare.norms:
            parts.append(Fact("", "Norm without the payload", norms_text(self.bare.norms)))
        if (self.bare or one).within(one.accuracy.allowed).all() and self.effect.limiting_joint:
            label, note = "Point mass within the budget", f"joint {self.effect.limiting_joint} first"
            parts.append(Fact("", label, self.effect.largest_mass, "kg", note=note))
        if one.exits:
            note = "no certificate for these limits holds there"
            outside = f"{int(one.outside.sum())} of {count}"
            parts.append(Fact("", f"Set points outside {self.found.box.where}", outside, note=note))
            parts.append(self.exits())
        if one.measured is not None:
            parts += self.measured(one.measured)
        title = one.name if one.trajectory is None else f"{one.name}, {counted(count, 'set point')}"
        return Section("", title, tuple(parts))

    def joints(self) -> Table:
        """Errors by joint, beside what is allowed."""
        one, errors, arm, effect = self.one, self.one.errors, self.one.dynamics.arm, self.effect
        units, nothing = [joint.effort_unit for joint in arm.joints], [None] * arm.n_joints
        allowed, promised, bare = one.accuracy.allowed, one.accuracy.errors, self.bare
        is_judged = one.most is not None
        most, passed = (nothing, nothing) if one.most is None else (one.most, ~one.fails)
        unloaded: Sequence[Any] | FloatArray = nothing if bare is None else bare.errors.largest
        of_allowed = nothing if bare is None else share_of(bare.errors.largest, allowed)
        columns = [
            *joint_columns(arm.joints),
            Column("peak_torque", "peak", errors.peak_torque, units),
            Column("largest_error", "error", errors.largest, units),
            Column("largest_share_of_peak_here", "of peak", errors.largest_share, shown="percent"),
            Column("rms_error", "", errors.rms),
            Column("largest_error_at", "" if is_judged or one.trajectory is None else "at", one.at, "s"),
            Column("fail_over", "limit" if is_judged else "", most, units),
            Column("passed", "passed" if is_judged else "", passed, shown="flag"),
            Column("allowed_error", "" if is_judged else "promised", allowed, units),
            Column("largest_of_allowed", "of promised", share_of(errors.largest, allowed), shown="times"),
            Column("", "unloaded" if bare else "", of_allowed, shown="times"),
            Column("within_allowed", "", one.keeps_promise),
            Column("promised_of_allowed", "", share_of(promised.largest, allowed)),
            Column("peak_torque_fitted_on", "", promised.peak_torque),
            Column("largest_share_of_peak_fitted_on", "", share_of(errors.largest, promised.peak_torque)),
            Column("promised_largest_error", "", promised.largest),
            Column("largest_error_without_payload", "", unloaded),
            Column("torque_per_kg", "", effect.torque_per_kg),
            Column("mass_within_budget", "", effect.mass_within_budget),
        ]
        return Table("", "Torque error", tuple(columns))

    def omissions(self) -> list[Table]:
        """Dropped parts; people see them only if the error exceeds the promise."""
        one, arm, allowed = self.one, self.one.dynamics.arm, self.one.accuracy.allowed
        here, promised = (share_of(x.largest, allowed) for x in (one.errors, one.accuracy.errors))
        if not self.lost or not (here > promised.max()).any():
            return []
        lost = tuple(loss for loss in self.lost if loss.torque_share >= _WORTH_A_LINE)
        units = [arm.joints[loss.torque_joint - 1].effort_unit for loss in lost]
        shares = [loss.torque_peak / allowed[loss.torque_joint - 1] for loss in lost]
        columns = (
            Column("", "what", [loss.part for loss in lost], shown="text"),
            Column("", "torque", [loss.torque_peak for loss in lost], units),
            Column("", "joint", [loss.torque_joint for loss in lost], shown="count"),
            Column("", "of promised", shares, shown="times"),
        )
        return [Table("", "Omissions by torque of each alone", columns, top=5)]

    def exits(self) -> Table:
        """Limits of the box that the motion exceeds."""
        exits, farthest = self.one.exits, [each.farthest for each in self.one.exits]
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
        return Table("", f"Limits of {self.found.box.where} exceeded", columns)

    def measured(self, measured: BesideMeasured) -> list[Part]:
        """Exact and simplified torque side by side, each compared with the measured torque."""
        (exact, simplified), motion = measured, self.one.trajectory
        assert motion is not None  # measured torques are of a motion
        units = [joint.effort_unit for joint in exact.arm.joints]
        columns = [*joint_columns(exact.arm.joints), Column("", "measured peak", exact.peak_measured, units)]
        for heading, of in (("exact", exact), ("simplified", simplified)):
            columns.append(Column("", f"RMS to {heading}", of.rms, units))
            if self.fit_friction:
                columns.append(Column("", "beside friction", of.friction.rms, units))
        # To nine digits: the difference may be nothing but round-off.
        more = np.round(share_of(simplified.rms - exact.rms, exact.rms), 9) + 0.0
        columns.append(Column("", "more", more, shown="percent"))
        note = "RMS to exact, to simplified: RMS of measured minus model. More: simplified over exact."
        tables = [
            Table("", "Measured torque", tuple(columns), note),
            measured_table(measured_torque_table(exact, motion), exact.arm),
        ]
        if self.fit_friction:
            table = measured_torque_table(exact, motion, fit_friction=True)
            tables += friction_tables(table, exact.arm, " from the exact torque")
        return [replace(table, key="") for table in tables]


_LOSSES = ("part", "torque_peak", "torque_joint", "torque_share")


def junit_xml(evaluation: Evaluation) -> str:
    """Write a suite per motion with a case per joint: passed, failed with its error, or skipped.

    In names, characters that XML cannot hold or that act on a terminal are spelt out; others are escaped.
    """
    model = evaluation.model
    root = ElementTree.Element("testsuites", {"name": "gd-analyze evaluate"})
    for one in evaluation.motions:
        suite = ElementTree.SubElement(root, "testsuite", {"name": visible(one.name)})
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in {
            "arm": model.arm.name,
            "budget": model.accuracy.budget,
            "fail over": evaluation.fail_over or "none",
            "set points": len(one.judged),
            "set points judged": int(one.judged.sum()),
            "box": evaluation.box.where,
            "set points outside the box": int(one.outside.sum()),
            "joints beyond the promise": int((~one.keeps_promise).sum()),
        }.items():
            ElementTree.SubElement(properties, "property", name=name, value=visible(str(value)))
        for i, joint in enumerate(model.arm.joints):
            name = visible(f"joint {joint_name(i + 1, joint.name)}")
            case = ElementTree.SubElement(suite, "testcase", classname=visible(one.name), name=name)
            _outcome(case, evaluation, one, i)
        suite.attrib |= _counts([suite])
    root.attrib |= _counts(root.findall("testsuite"))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def _outcome(case: ElementTree.Element, evaluation: Evaluation, one: EvaluatedMotion, joint: int) -> None:
    """Fill in what became of one joint on one motion."""
    text = one.error_text(joint)
    why = "--fail-over none" if evaluation.fail_over is None else "the model states nothing for these states"
    if one.fails[joint]:
        ElementTree.SubElement(case, "failure", type="torque error", message=text).text = text
    elif evaluation.strict and not one.judged.all():
        text = f"not judged at {int((~one.judged).sum())} of {len(one.judged)} states; {text}"
        ElementTree.SubElement(case, "failure", type="not judged", message=text).text = text
    elif one.most is None:
        ElementTree.SubElement(case, "skipped", message=f"not judged: {why}; {text}")
    else:
        ElementTree.SubElement(case, "system-out").text = text


def _counts(suites: Sequence[ElementTree.Element]) -> dict[str, str]:
    """Numbers of cases, and of those failed and skipped."""
    of = {"tests": "testcase", "failures": "testcase/failure", "errors": "testcase/error"}
    of["skipped"] = "testcase/skipped"
    return {name: str(sum(len(suite.findall(path)) for suite in suites)) for name, path in of.items()}
