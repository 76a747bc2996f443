"""An evaluation as a Result, and as JUnit XML for machines that run tests; both read its one verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from gd_analyze.diagnosis.remedies import OF_GRAVITY
from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.motions.states import in_words
from gd_analyze.result import (
    Fact,
    Part,
    Result,
    Section,
    Shown,
    Table,
    Value,
    attributes_of,
    joint_values,
    value_text,
    values_of,
)
from gd_analyze.results.model_facts import drives_text, norms_text
from gd_analyze.results.motion_result import friction_tables, measured_table
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.results.rows import rows_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link
from gd_analyze.schema import declared_columns, declared_table
from gd_analyze.simplification.accuracy import STATED, share_of
from gd_analyze.simplification.model_torque import losses, model_torque, payload_effect
from gd_analyze.studies.evaluation import BesideMeasured, EvaluatedMotion, Evaluation, is_passed
from gd_analyze.text import counted, joint_name, visible

if TYPE_CHECKING:
    import xarray as xr

# What people see of the errors by joint.
_ERRORS = [
    "joint", "peak_torque", "largest_error", "largest_share_of_peak_here", "fail_over", "passed",
    "largest_error_at", "allowed_error", "largest_of_allowed", "unloaded_of_allowed",
]  # fmt: skip
# Smallest loss shown to people, as a share of peak torque.
_LEAST_SHOWN_LOSS = 1e-4


def evaluation_result(
    evaluation: Evaluation,
    payload: Link | None = None,
    unloaded: RobotArm | None = None,
    *,
    fit_friction: bool = False,
) -> Result:
    """The verdict, a row per motion, and each motion; also fitted friction if asked for.

    With a payload, which the evaluation's arm carries, errors of the `unloaded` arm stand beside. Along a
    motion without one the largest losses are listed, if dropped parts cause the error.
    """
    model, box, arm = evaluation.model, evaluation.box, evaluation.motions[0].dynamics.arm
    verdict = evaluation.log_verdict
    accuracy = model.accuracy
    fitted_on = in_words(accuracy.fitted_on) if accuracy.fitted_on else "states not named"
    limits = {name: getattr(box, name) for name in ("lower", "upper", "velocity", "acceleration")}
    carried = payload and {"mass": payload.mass, "position": payload.com, "inertia": payload.inertia_com}
    limit = "" if evaluation.fail_over is None else str(evaluation.fail_over)
    judged = sum(len(motion.fails) for motion in evaluation.motions if motion.most is not None)
    worst, joint = evaluation.worst
    name = joint_name(joint + 1, arm.joints[joint].name)
    count = len(evaluation.motions)
    motions_text = f"{count} motions" if count > 1 else worst.dynamics.states.in_words
    sections = [_Motion(motion, evaluation, unloaded, fit_friction) for motion in evaluation.motions]
    return Result(
        title=f"{arm.title or arm.name}: torque error of a model of {model.arm.name}",
        subtitle=", ".join(filter(None, [f"on {motions_text}", drives_text(model.arm, model.drives)])),
        headline=evaluation.in_words,
        facts=(
            Value("arm", model.arm.name),
            Value("drives", model.drives),
            Value("level", model.level.name),
            Fact("fitted_on", "Model fitted on", dict(accuracy.fitted_on), text=fitted_on),
            Fact("budget", "Budget", accuracy.budget, text=accuracy.asked.words),
            Value("promised", "measured" if accuracy.measured else STATED),
            Value("promised_norms", [norm._asdict() for norm in accuracy.norms]),
            Value("held_against", {"arm": arm.name, "drives": model.drives, "payload": carried}),
            Value("fail_over", limit or None),
            Value("strict", evaluation.strict),
            Value("passed", evaluation.passed),
            Value("limits", STATED if evaluation.unchecked else "checked here"),
            *(
                (Shown("Errors above it", f"{len(evaluation.failures)} of {judged}"),)
                if evaluation.failures
                else ()
            ),
            Shown("Worst", f"joint {name}, {worst.name}: {worst.error_text(joint)}"),
            *(() if verdict is None else (Fact("agreement", "Log and file", verdict.text, shown="text"),)),
            Value("box", {"where": box.where, **limits}),
            Value("motions", [section.document() for section in sections]),
        ),
        notices=_notices(evaluation),
        parts=(
            *((_motions_table(evaluation),) if len(evaluation.motions) > 1 else ()),
            *(section.shown() for section in sections),
        ),
    )


def _notices(evaluation: Evaluation) -> tuple[str, ...]:
    """Where an advised option is typed, and what checks limits that a file only states."""
    verdict, notices = evaluation.log_verdict, []
    if verdict is not None and OF_GRAVITY in verdict.text:
        notices.append(f"Gravity is the model's: `gd-analyze simplify` has {OF_GRAVITY}.")
    if not evaluation.unchecked:
        return tuple(notices)
    step = "`--fail-over 1%` takes one from the exact torque"
    if evaluation.model.accuracy.certificate is not None:
        step = f"`{evaluation.model.accuracy.command_to_check}` proves its bounds again"
    return (*notices, f"The limits are {STATED}, and were not checked here; {step}.")


def _motions_table(evaluation: Evaluation) -> Table:
    motions = evaluation.motions
    values = {
        "motion": [motion.name for motion in motions],
        "set_points": [len(motion.judged) for motion in motions],
        "largest_share": [motion.errors.largest_share.max() for motion in motions],
        "joint": [motion.errors.worst + 1 for motion in motions],
        "outside_box": [int(motion.outside.sum()) for motion in motions],
    }
    if evaluation.fail_over is not None:
        values["verdict"] = [motion.verdict for motion in motions]
    note = "Of peak: largest error over peak torque. Outside box: set points."
    return Table(None, "All motions", declared_columns("evaluated_motions", values, [*values]), note)


class _Motion:
    """One motion, for people and for JSON."""

    def __init__(
        self, motion: EvaluatedMotion, evaluation: Evaluation, unloaded: RobotArm | None, fit_friction: bool
    ) -> None:
        self.motion, self.evaluation, self.fit_friction = motion, evaluation, fit_friction
        self.model = evaluation.model.stating(motion.accuracy)
        states = motion.dynamics.states
        self.effect = payload_effect(self.model, states)
        self.bare = None if unloaded is None else model_torque(self.model, states, unloaded)
        along = motion.trajectory is not None and unloaded is None
        self.lost = losses(self.model, motion.dynamics) if along else ()

    def document(self) -> dict[str, Any]:
        """JSON values."""
        motion, trajectory = self.motion, self.motion.trajectory
        described = motion.dynamics.states.described

        def beside(comparison: TorqueComparison) -> list[dict[str, Any]]:
            table = self.measured_table(comparison, fit_friction=self.fit_friction)
            return [dict(row) for row in rows_of(table, "joint")]

        measured = motion.measured
        return {
            "trajectory": described.get("trajectory"),
            "set_points": len(motion.judged) if "trajectory" in described else None,
            **{name: described.get(name) for name in ("box", "states", "seed")},
            "begin": None if trajectory is None else float(trajectory.time[0]),
            "end": None if trajectory is None else float(trajectory.time[-1]),
            "passed": motion.passed,
            "judged": int(motion.judged.sum()),
            "joints": self.joints().rows(),
            "norms": [norm._asdict() for norm in motion.norms],
            "mass_within_budget": self.effect.largest_mass,
            "limiting_joint": self.effect.limiting_joint,
            "largest_losses": [asdict(loss) for loss in self.lost],
            "outside_box": int(motion.outside.sum()),
            "box_exits": self.exit_rows(),
            "measured_torque": measured
            and {"exact": beside(measured.exact), "simplified": beside(measured.simplified)},
        }

    def shown(self) -> Section:
        """The section that people see."""
        motion, count = self.motion, len(self.motion.judged)
        parts: list[Part] = [self.joints(), *self.omissions()]
        if 0 < motion.judged.sum() < count:
            parts.append(Shown("Judged", f"{int(motion.judged.sum())} of {count} states"))
        if motion.norms:
            parts.append(Shown("Norm, error/torque", norms_text(motion.norms)))
        if self.bare is not None and self.bare.norms:
            parts.append(Shown("Norm without the payload", norms_text(self.bare.norms)))
        if (self.bare or motion).within(motion.accuracy.allowed).all() and self.effect.limiting_joint:
            label, note = "Point mass within the budget", f"joint {self.effect.limiting_joint} first"
            parts.append(Shown(label, value_text(self.effect.largest_mass, "kg"), note))
        if motion.exits:
            note = "no certificate for these limits holds there"
            outside = f"{int(motion.outside.sum())} of {count}"
            parts.append(Shown(f"Set points outside {self.evaluation.box.where}", outside, note=note))
            parts.append(self.exits())
        if motion.measured is not None:
            parts += self.measured(motion.measured)
        title = motion.name if motion.trajectory is None else f"{motion.name}, {counted(count, 'set point')}"
        return Section(None, title, tuple(parts))

    def measured_table(self, comparison: TorqueComparison, *, fit_friction: bool = False) -> xr.Dataset:
        """A comparison with the torques measured along the motion, as a table."""
        trajectory, verdict = self.motion.trajectory, self.evaluation.log_verdict
        assert trajectory is not None  # measured torques are of a motion
        assert verdict is not None
        return measured_torque_table(comparison, trajectory, verdict, fit_friction=fit_friction)

    def joints(self) -> Table:
        """Errors by joint, beside what is allowed."""
        motion, errors, arm, effect = self.motion, self.motion.errors, self.motion.dynamics.arm, self.effect
        allowed, promised, empty = motion.accuracy.allowed, motion.accuracy.errors, [None] * arm.n_joints
        unloaded = None if self.bare is None else self.bare.errors.largest
        values = joint_values(arm.joints) | {
            "peak_torque": errors.peak_torque,
            "largest_error": errors.largest,
            "largest_share_of_peak_here": errors.largest_share,
            "rms_error": errors.rms,
            "largest_error_at": motion.at,
            "fail_over": empty if motion.most is None else motion.most,
            "passed": [is_passed(verdict) for verdict in motion.verdicts],
            "allowed_error": allowed,
            "largest_of_allowed": share_of(errors.largest, allowed),
            "promised_of_allowed": share_of(promised.largest, allowed),
            "peak_torque_fitted_on": promised.peak_torque,
            "largest_share_of_peak_fitted_on": share_of(errors.largest, promised.peak_torque),
            "promised_largest_error": promised.largest,
            "largest_error_without_payload": empty if unloaded is None else unloaded,
            "torque_per_kg": effect.torque_per_kg,
            "mass_within_budget": effect.mass_within_budget,
        }
        is_judged = motion.verdict != "not judged"
        left_out = ["largest_error_at", "allowed_error"] if is_judged else ["fail_over", "passed"]
        if motion.trajectory is None:
            left_out.append("largest_error_at")
        seen: dict[str, Any] = dict.fromkeys(left_out)
        seen["unloaded_of_allowed"] = None if unloaded is None else share_of(unloaded, allowed)
        note = "Allowed: by the budget, where the model was fitted."
        return declared_table("evaluation", None, "Torque error", values, _ERRORS, note=note, seen=seen)

    def omissions(self) -> list[Table]:
        """Dropped parts; people see them only if the error exceeds the promise."""
        motion, arm, allowed = self.motion, self.motion.dynamics.arm, self.motion.accuracy.allowed
        error_shares, promised_shares = (
            share_of(x.largest, allowed) for x in (motion.errors, motion.accuracy.errors)
        )
        if not self.lost or not (error_shares > promised_shares.max()).any():
            return []
        lost = tuple(loss for loss in self.lost if loss.torque_share >= _LEAST_SHOWN_LOSS)
        values = attributes_of(lost, "part", "torque_peak", "torque_joint")
        joints = [joint - 1 for joint in values["torque_joint"]]
        values["torque_unit"] = [arm.joints[joint].effort_unit for joint in joints]
        values["of_allowed"] = [loss.torque_peak / allowed[i] for i, loss in zip(joints, lost, strict=True)]
        names = ["part", "torque_peak", "torque_joint", "of_allowed"]
        columns = declared_columns("omissions", values, names)
        return [Table(None, "Omissions by torque of each alone", columns, top=5)]

    def exit_rows(self) -> list[dict[str, Any]]:
        """Limits of the box that the motion exceeds."""
        return [
            {
                "joint": box_exit.farthest.joint,
                "joint_name": box_exit.farthest.name,
                "quantity": box_exit.farthest.quantity,
                "unit": box_exit.farthest.unit,
                "limit": box_exit.farthest.limit,
                "farthest": box_exit.farthest.value,
                "farthest_at": box_exit.farthest.time,
                "set_points": box_exit.set_points,
                "first": box_exit.first,
                "longest_stretch": (box_exit.begin, box_exit.end),
            }
            for box_exit in self.motion.exits
        ]

    def exits(self) -> Table:
        """The same for people."""
        exits = self.motion.exits
        values = values_of(self.exit_rows()) | {
            "excess": [box_exit.farthest.excess for box_exit in exits],
            "longest": [f"{box_exit.begin:.4g} to {box_exit.end:.4g}" for box_exit in exits],
        }
        names = ["joint", "quantity", "limit", "excess", "set_points", "first", "longest"]
        title = f"Exceeded: {self.evaluation.box.where}"
        return Table(None, title, declared_columns("box_exits", values, names))

    def measured(self, measured: BesideMeasured) -> list[Part]:
        """Exact and simplified torque side by side, each compared with the measured torque."""
        exact, simplified = measured
        values = joint_values(exact.arm.joints) | {"peak_measured": exact.peak_measured}
        for name, comparison in (("exact", exact), ("simplified", simplified)):
            values[name] = comparison.rms
            if self.fit_friction:
                values[f"{name}_friction"] = comparison.friction.rms
        # To nine digits: the difference may be nothing but round-off.
        values["increase"] = np.round(share_of(simplified.rms - exact.rms, exact.rms), 9) + 0.0
        names = [name for name in values if name not in ("joint_name", "effort_unit")]
        columns = declared_columns("beside_measured", values, names)
        note = "RMS to exact, to simplified: RMS of measured minus model. More: simplified over exact."
        tables = [
            Table(None, "Measured torque", columns, note),
            measured_table(self.measured_table(exact), exact.arm, key=None),
        ]
        if self.fit_friction:
            table = self.measured_table(exact, fit_friction=True)
            tables += friction_tables(table, exact.arm, " from the exact torque")
        return [*tables]


def junit_xml(evaluation: Evaluation) -> str:
    """Write a suite per motion with a case per joint: passed, failed with its error, or skipped.

    In names, characters that XML cannot hold or that act on a terminal are spelt out; others are escaped.
    """
    model = evaluation.model
    root = ElementTree.Element("testsuites", {"name": "gd-analyze evaluate"})
    for motion in evaluation.motions:
        suite = ElementTree.SubElement(root, "testsuite", {"name": visible(motion.name)})
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in {
            "arm": model.arm.name,
            "budget": model.accuracy.budget,
            "fail over": evaluation.fail_over or "none",
            "set points": len(motion.judged),
            "set points judged": int(motion.judged.sum()),
            "box": evaluation.box.where,
            "set points outside the box": int(motion.outside.sum()),
            "verdict": motion.verdict,
            "limits": STATED if motion.limit.unchecked else "checked here",
        }.items():
            ElementTree.SubElement(properties, "property", name=name, value=visible(str(value)))
        for i, joint in enumerate(model.arm.joints):
            name = visible(f"joint {joint_name(i + 1, joint.name)}")
            case = ElementTree.SubElement(suite, "testcase", classname=visible(motion.name), name=name)
            _outcome(case, evaluation, motion, i)
        suite.attrib |= _counts([suite])
    root.attrib |= _counts(root.findall("testsuite"))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def _outcome(case: ElementTree.Element, evaluation: Evaluation, motion: EvaluatedMotion, joint: int) -> None:
    """Write the verdict on one joint along one motion into its test case."""
    text, verdict = motion.error_text(joint), motion.verdicts[joint]
    if verdict == "failed" and motion.fails[joint]:
        ElementTree.SubElement(case, "failure", type="torque error", message=text).text = text
    elif verdict == "failed":
        text = f"not judged at {int((~motion.judged).sum())} of {len(motion.judged)} states; {text}"
        ElementTree.SubElement(case, "failure", type="not judged", message=text).text = text
    elif verdict == "not judged":
        reason = f"the model states its error for {evaluation.stated_for} alone"
        if evaluation.fail_over is None:
            reason = "--fail-over none"
        ElementTree.SubElement(case, "skipped", message=visible(f"not judged: {reason}; {text}"))
    else:
        ElementTree.SubElement(case, "system-out").text = text


def _counts(suites: Sequence[ElementTree.Element]) -> dict[str, str]:
    """Numbers of cases, and of those failed and skipped."""
    paths = {"tests": "testcase", "failures": "testcase/failure", "errors": "testcase/error"}
    paths["skipped"] = "testcase/skipped"
    return {name: str(sum(len(suite.findall(path)) for suite in suites)) for name, path in paths.items()}
