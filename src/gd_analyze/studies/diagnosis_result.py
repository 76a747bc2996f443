"""A diagnosis as a result: the answer, what remains by joint, the ranking, and where to look for a cause."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.answer import QUANTITIES, answer, what_remains_follows
from gd_analyze.diagnosis.diagnose import Diagnosis
from gd_analyze.diagnosis.hypothesis import Problem
from gd_analyze.figures.figure import (
    Curve,
    Figure,
    LegendKey,
    Panel,
    in_columns,
    short_joint_label,
    value_axis,
)
from gd_analyze.result import Column, Drawing, Fact, Part, Result, Section, Table, joint_columns

# Causes that a person sees in the ranking.
_SHOWN = 6
_UNIT = ("rad", "rad/s", "rad/s^2", "s")


def diagnosis_result(found: Diagnosis, provenance: Mapping[str, str]) -> Result:
    """Facts, tables and drawings."""
    cause = found.cause
    facts = [
        Fact("cause", "", None if cause is None else cause.name),
        Fact("remedy", "Remedy", None if cause is None else cause.remedy, shown="text"),
        Fact("remains_before", "Torque that remains, as logged", found.before.remains, "of RMS", "percent"),
        Fact("remains_after", "Torque that remains, mended", found.after.remains, "of RMS", "percent"),
        Fact("masses_off", "File's torque off by", found.after.off, "", "percent"),
        Fact("tells", "Log tells more than friction", found.tells, shown="flag"),
        Fact("logs", "", list(found.logs)),
    ]
    parts: list[Part] = [_joints(found), *_causes(found), *_ranking(found), *_faults(found), *_figures(found)]
    return Result(
        title=found.arm.title or found.arm.name,
        subtitle=f"diagnosed with {', '.join(found.logs)}",
        headline=answer(found),
        facts=tuple(fact for fact in facts if fact.value is not None or not fact.label),
        parts=tuple(parts),
        provenance=dict(provenance),
    )


def _joints(found: Diagnosis) -> Table:
    is_compared = bool(found.corrected.moving)
    follows = what_remains_follows(found.corrected) if is_compared else [""] * found.arm.n_joints
    columns = (
        *joint_columns(found.arm.joints),
        Column("before", "remains", found.before.residuals, shown="percent"),
        Column("after", "with the causes", found.after.residuals, shown="percent"),
        Column("follows", "which follows", follows, shown="text"),
    )
    note = (
        "Residual of samples not fitted over the RMS of the joint's torque; –: rests, or has no torque. "
        "Links within the file's error, drive inertia and friction are fitted."
    )
    return Table("joints", "What remains, by joint", columns, note)


def _causes(found: Diagnosis) -> Iterator[Table]:
    if not found.causes:
        return
    rows = [*found.causes, *found.rivals]
    columns = (
        Column("name", "", [one.name for one in rows]),
        Column("what", "", [one.what for one in rows]),
        Column("remedy", "", [one.remedy for one in rows]),
        Column("unsure", "", [one.unsure for one in rows]),
        Column("rival", "", [one in found.rivals for one in rows]),
    )
    yield Table("causes", "", columns)


def _ranking(found: Diagnosis) -> Iterator[Table]:
    rows = found.ranking
    if not rows:
        return
    left = [None if one.fit is None else one.fit.remains for one in rows]
    columns = (
        Column("name", "", [one.name for one in rows]),
        Column("what", "cause tried", [one.what for one in rows], shown="text"),
        Column("remains", "remains", left, shown="percent"),
        Column("numbers", "numbers", [one.numbers for one in rows], shown="count"),
        Column("fall", "fall of score", [one.fall for one in rows], shown="count"),
        Column("remedy", "", [one.remedy for one in rows]),
    )
    settings = found.problem.settings
    note = (
        f"A fall of more than {settings.margin:g}, and of {settings.misfit:.0%} of what then remains "
        "unexplained, makes a cause; costs of fitted numbers are included."
    )
    yield Table("ranking", "Causes tried", columns, note, _SHOWN)


def _faults(found: Diagnosis) -> Iterator[Table]:
    rows = found.faults
    if rows:
        columns = (
            Column("name", "", [one.name for one in rows]),
            Column("joint", "", [one.joint + 1 for one in rows]),
            Column("what", "fault of readings", [one.what for one in rows], shown="text"),
            Column("remedy", "remedy", [one.remedy for one in rows], shown="text"),
            Column("share", "readings", [one.share for one in rows], shown="percent"),
        )
        yield Table("faults", "Faulty readings", columns, "These readings are not compared.")


def _figures(found: Diagnosis) -> Iterator[Section]:
    joints = found.problem.moving
    if not joints:
        return
    left = np.nan_to_num(found.before.residuals)
    worst = int(np.argmax(left))
    name = short_joint_label(found.arm.joints, worst, 150.0)
    drawings = [
        Drawing("torque", "Torque measured, and fitted as logged.", torque_figure(found.problem), ""),
        Drawing(
            "where",
            f"What remains at joint {name}, as logged and with the causes.",
            where_figure(found, worst),
            "A cause shows where what remains follows one of the four.",
        ),
    ]
    if found.causes:
        title = "The same with the causes."
        drawings.insert(1, Drawing("torque_after", title, torque_figure(found.corrected), ""))
    yield Section("", "Where to look", tuple(drawings))


def torque_figure(problem: Problem) -> Figure:
    """Samples of measured torque and of its fit, every joint over time."""
    measured, model = problem.torques()
    panels = []
    for i in problem.moving:
        time = problem.samples.time
        order = np.argsort(time, kind="stable")
        values, fit = measured[order, i], model[order, i]
        y = value_axis(problem.arm.joints[i].effort_unit, values, fit, most=3)
        items = (
            Curve(time[order], values, "combined", 2.0, label="measured"),
            Curve(time[order], fit, "accent", 0.8, label="fitted"),
        )
        x = value_axis("s", time, zero=False)
        panels.append(Panel(f"torque{i + 1}", short_joint_label(problem.arm.joints, i, 150.0), x, y, items))
    legend = (LegendKey("measured", "combined"), LegendKey("fitted", "accent"))
    return in_columns("Torque measured and fitted", panels, 2, 90.0, legend)


def where_figure(found: Diagnosis, joint: int) -> Figure:
    """A joint's residual against its position, velocity and acceleration and time, before and after."""

    def residual(problem: Problem) -> FloatArray:
        measured, model = problem.torques()
        return measured[:, joint] - model[:, joint]

    looks = {"as logged": ("series-1", found.problem)}
    if found.causes:
        looks["with the causes"] = ("accent", found.corrected)
    residuals = {label: residual(problem) for label, (_, problem) in looks.items()}
    y = value_axis(found.arm.joints[joint].effort_unit, *residuals.values(), most=3)
    q, qd, qdd, _ = found.problem.correction.states(found.problem.samples)
    across = (q[:, joint], qd[:, joint], qdd[:, joint], found.problem.samples.time)
    units = _UNIT if found.arm.is_revolute[joint] else ("m", "m/s", "m/s^2", "s")
    panels = [
        Panel(
            what,
            what,
            value_axis(unit, x, most=3, zero=False),
            y,
            tuple(
                Curve(x, residuals[label], colour, 0.0, label=label, marker="circle", size=1.6)
                for label, (colour, _) in looks.items()
            ),
        )
        for what, unit, x in zip(QUANTITIES, units, across, strict=True)
    ]
    legend = tuple(LegendKey(label, colour) for label, (colour, _) in looks.items())
    return in_columns(f"What remains at joint {joint + 1}", panels, 2, 90.0, legend)
