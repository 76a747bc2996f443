"""A study of control as a Result: verdict, errors by joint, rate and speed, torques, bounds, and drawings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    Axis,
    Curve,
    Figure,
    LegendKey,
    Panel,
    decades_axis,
    ends_named,
    time_axis,
    value_axis,
)
from gd_analyze.result import Column, Drawing, Fact, Result, Section, Table, joint_columns
from gd_analyze.studies import control_law as laws
from gd_analyze.studies.control import ControlStudy
from gd_analyze.studies.control_bounds import CertifiedTracking
from gd_analyze.studies.control_law import CONTINUOUS, CONTROLLERS, EXACT, FIXED_GAINS, SIMPLIFIED, Controller
from gd_analyze.studies.control_loop import TrackedLoop
from gd_analyze.studies.study_files import inputs_stated
from gd_analyze.text import number, percent, rounded_up

# Colour and dashes of each controller, so that grey print tells them apart as well.
_LOOKS: dict[Controller, tuple[str, tuple[float, ...]]] = {
    EXACT: ("ink", ()),
    SIMPLIFIED: ("series-3", ()),
    FIXED_GAINS: ("series-3", (4.0, 1.6)),
    laws.WITHOUT_H: ("series-2", ()),
    laws.PD: ("series-1", (1.2, 1.4)),
}
# Expected errors beyond this, rad (m), are not of first order.
_LARGEST_FIRST_ORDER_ERROR = 1.0
# Decades of errors, below the largest, that the figure shows.
_SHOWN_DECADES = 5


def good_enough(study: ControlStudy) -> Controller | None:
    """Simplified controller that keeps every joint within the tolerance."""
    possible = (SIMPLIFIED, FIXED_GAINS) if study.feedback.is_enough else (FIXED_GAINS,)
    return next((law for law in possible if _usual(study, law).within(study.tolerance)), None)


def control_result(study: ControlStudy) -> Result:
    """Facts, tables and drawings of a study."""
    settings, arm = study.settings, study.arm
    carrying = "" if arm.name == study.model.arm.name else " (the payload unknown to every controller)"
    rates = [_worst(study, _rate_label(rate), rate, settings.usual_speed) for rate in settings.rates]
    speeds = [_worst(study, f"{speed:g}×", settings.usual_rate, speed) for speed in settings.speeds]
    worst = "Largest tracking error of any joint by"
    tracking = (
        _by_joint(study, "peak", "Largest tracking error", "peak_error"),
        _by_joint(study, "rms", "RMS tracking error", "rms_error"),
        _by_controller("by_rate", f"{worst} loop rate", rates),
        _by_controller("by_speed", f"{worst} speed of the motion, {_rate(study)}", speeds),
    )
    drawings = (
        Drawing("errors", "Tracking error of every joint over time", tracking_figure(study)),
        Drawing("speeds", "Largest tracking error over the speed of the motion", speed_figure(study)),
    )
    named = "Computed-torque controllers are named by their model of the arm."
    torques = (_torque_table(study), _bounds_table(study), _rest_table(study))
    scale = "" if settings.limits in (None, 1.0) else f", times {settings.limits:g}"
    limited = np.isfinite(study.limits).any()
    return Result(
        title=arm.title or arm.name,
        subtitle=f"controlled along {study.motion.name}{carrying}",
        headline=_headline(study),
        facts=(*_facts(study), *_hidden_facts(study)),
        parts=(
            Section("tracking", "Tracking errors", tracking, note=named),
            Section("drawings", "Over time and speed", drawings),
            Section("torques", "Torques and bounds", torques),
        ),
        notices=study.warnings,
        provenance={
            "gains": f"bandwidth {settings.bandwidth:g} rad/s, damping {settings.damping:g}",
            "torque limits": f"those of the drives{scale}" if limited else "none",
            "friction": "the drives', unknown to every controller" if settings.friction else "none",
            "drives": "inertia included" if study.model.drives else "links alone",
            "model": f"level {study.model.level.name}, budget {study.model.accuracy.budget}",
            **inputs_stated(arm, study.motion),
            **study.provenance,
        },
    )


def _usual(study: ControlStudy, controller: Controller) -> TrackedLoop:
    return study.loop(controller, study.settings.usual_rate, study.settings.usual_speed)


def _judged(study: ControlStudy) -> Controller:
    """The law that judges the simplified model: one that is good enough, or else the better one."""

    def worst(controller: Controller) -> float:
        return float((_usual(study, controller).peak_error / study.tolerance).max())

    return good_enough(study) or min((SIMPLIFIED, FIXED_GAINS), key=worst)


def _rate(study: ControlStudy) -> str:
    rate = study.settings.usual_rate
    return "in continuous time" if rate == CONTINUOUS else f"at {rate:g} Hz"


def _rate_label(rate: float) -> str:
    return "continuous" if rate == CONTINUOUS else f"{rate:g} Hz"


def _usual_conditions(study: ControlStudy) -> str:
    speed = study.settings.usual_speed
    return _rate(study) + ("" if speed == 1.0 else f", at {speed:g} times the speed")


def _unit(study: ControlStudy, joint: int) -> str:
    """Unit of a joint's tracking error for people, a thousandth of that of the study; joint from 0."""
    return "mrad" if study.arm.is_revolute[joint] else "mm"


def _worst_text(study: ControlStudy, errors: FloatArray, *, bound: bool = False) -> str:
    """The joint whose error, rad (m), is the largest share of its tolerance, and that error."""
    joint = int((errors / study.tolerance).argmax())
    value = 1e3 * float(errors[joint])
    if not math.isfinite(value):
        return f"lost (joint {joint + 1})"
    return f"{number(rounded_up(value) if bound else value)} {_unit(study, joint)} (joint {joint + 1})"


def _headline(study: ControlStudy) -> str:
    law = good_enough(study)
    if not _usual(study, EXACT).within(study.tolerance):
        verdict = "Not even the exact model keeps the tolerance"
    elif law:
        verdict = f"The simplified model is good enough to control this arm, by {law.law.replace('_', ' ')}"
    else:
        verdict = "The simplified model is not good enough to control this arm"
    tolerance = study.settings.tolerance.in_words(study.arm)
    simplified, exact = (_worst_text(study, _usual(study, c).peak_error) for c in (_judged(study), EXACT))
    return (
        f"{verdict}. Largest tracking error {_usual_conditions(study)}: {simplified} with the simplified "
        f"model, {exact} with the exact one; tolerance {tolerance}."
    )


def _speed_text(speed: float, fastest: float) -> str:
    """Write a multiple of the planned speed; infinite is at least the fastest that was tried."""
    return f"{number(speed)}×" if speed < math.inf else f"≥ {fastest:g}×"


def _facts(study: ControlStudy) -> Iterator[Fact]:
    """Figures for people, most of them also in JSON."""
    settings, judged = study.settings, _judged(study)
    names = {judged: "simplified model", EXACT: "exact model", laws.WITHOUT_H: "exact model without h"}
    for controller, name in names.items():
        worst = _worst_text(study, _usual(study, controller).peak_error)
        law = " with fixed gains" if controller == FIXED_GAINS else ""
        yield Fact("", f"Tracking error, {name}{law}", worst, shown="text")
    fastest = max(settings.speeds)
    for controller, name in names.items():
        speed = study.tracks_up_to(controller, settings.usual_rate)
        text = "none" if speed is None else _speed_text(speed, fastest)
        yield Fact("", f"Speed within tolerance, {name}", speed, text=text)
    label = "Tracking error from model error"
    first_order = study.expected[judged, settings.usual_speed]
    certified = _certified(study, judged)
    if certified is not None:
        text = f"at most {_worst_text(study, certified.error, bound=True)}"
        yield Fact("", f"{label}, bound, D sampled", text, shown="text")
    elif judged != FIXED_GAINS or max(settings.rates) not in study.too_slow_for_fixed_gains:
        is_small = (first_order < _LARGEST_FIRST_ORDER_ERROR).all()
        text = f"at most {_worst_text(study, first_order)}" if is_small else _why_unbounded(study, judged)
        yield Fact("", f"{label}, to first order", text, shown="text")
    if not study.feedback.is_enough:
        note = f"of joints {', '.join(map(str, study.feedback.joints))}"
        share = max(study.feedback.share, 0.0)
        yield Fact("", "Least feedback left by the model's D", share, shown="percent", note=note)
    if study.too_slow_for_fixed_gains:
        rates = ", ".join(f"{rate:g}" for rate in study.too_slow_for_fixed_gains)
        note = f"gains up to {number(study.fixed_excess)} times too high in some direction"
        yield Fact("", "Loop rates unstable with fixed gains, Hz", rates, shown="text", note=note)
    saturated: dict[float, float] = {}
    for loop in study.loops:
        share = float(loop.saturated.max())
        if share and loop.lost_at is None and loop.controller in (EXACT, SIMPLIFIED):
            saturated[loop.speed] = max(share, saturated.get(loop.speed, 0.0))
    if saturated:
        text = ", ".join(f"{percent(share)} at {speed:g}×" for speed, share in saturated.items())
        yield Fact("", "Longest time at the torque limit", text, shown="text")
    limit = study.fastest_within_limits
    if fastest > limit * (1 + 1e-9):
        yield Fact("", "Speed within the arm's limits", limit, text=f"{math.floor(1e3 * limit) / 1e3:g}×")


def _why_unbounded(study: ControlStudy, controller: Controller) -> str:
    """Why the first order says nothing: the model's D is of no use, or the motion needs too much torque."""
    if controller == SIMPLIFIED and not study.feedback.is_enough:
        return "unbounded: the model's D leaves too little feedback"
    shares = study.needed / study.limits
    joint = int(shares.argmax())
    if shares[joint] > 1.0:
        return f"unbounded: joint {joint + 1} needs {number(shares[joint])} times its torque limit"
    return "unbounded: the model's torque error is too large for the bandwidth"


def _certified(study: ControlStudy, controller: Controller) -> CertifiedTracking | None:
    """Proven bound of computed torque with the simplified model; other controllers have none."""
    return study.certified.get(study.settings.usual_speed) if controller == SIMPLIFIED else None


def _hidden_facts(study: ControlStudy) -> Iterator[Fact]:
    """Everything else, for JSON: SI units and full precision."""
    settings, motion, law = study.settings, study.motion, good_enough(study)
    residuals = [abs(loop.energy_residual) for loop in study.loops if loop.lost_at is None]
    reached = {c.title: study.tracks_up_to(c, settings.usual_rate) for c in CONTROLLERS}
    values: dict[str, Any] = {
        "arm": study.model.arm.name,
        "moved": study.arm.name,
        "trajectory": motion.name,
        "duration": float(motion.time[-1] - motion.time[0]),
        "level": study.model.level.name,
        "budget": study.model.accuracy.budget,
        "drives": study.model.drives,
        "friction": settings.friction,
        "bandwidth": settings.bandwidth,
        "damping": settings.damping,
        "loop_rates": settings.rates,
        "speeds": settings.speeds,
        "fastest_within_limits": study.fastest_within_limits,
        "usual": {"rate": settings.usual_rate, "speed": settings.usual_speed},
        "good_enough": law and law.law.replace("_", " "),
        "feedback": {"share": study.feedback.share, "joints": study.feedback.joints},
        "fixed_excess": study.fixed_excess,
        "energy_residual": max(residuals, default=0.0),
        "tracks_up_to": {
            title: {"speed": speed and min(speed, max(settings.speeds)), "at_every_speed": speed == math.inf}
            for title, speed in reached.items()
        },
        "joints": [
            {
                "joint": i + 1,
                "joint_name": joint.name,
                "unit": joint.unit,
                "effort_unit": joint.effort_unit,
                "tolerance": study.tolerance[i],
                "torque_for_tolerance": study.torque_for_tolerance[i],
                "inertia": study.diagonal[i],
                "stiffness": settings.gains.stiffness * study.diagonal[i],
                "torque_limit": study.limits[i],
                "error_at_rest": study.at_rest[i],
                "certified": [
                    {"speed": speed, "torque_error": bound.torque_error[i], "error": bound.error[i]}
                    for speed, bound in study.certified.items()
                ],
            }
            for i, joint in enumerate(study.arm.joints)
        ],
        "loops": [
            {x.name: getattr(loop, x.name) for x in fields(loop) if x.name not in ("end", "time", "error")}
            | {
                "controller": loop.controller.title,
                "law": loop.controller.law,
                "knows": loop.controller.knows,
            }
            | {"expected": study.expected[loop.controller, loop.speed]}
            for loop in study.loops
        ],
    }
    for key, value in values.items():
        yield Fact(key, "", value)


def _by_controller(key: str, title: str, columns: Sequence[Column]) -> Table:
    titles = Column("", "controller", [controller.title for controller in CONTROLLERS], shown="text")
    return Table(key, title, (titles, *columns))


def _errors(
    study: ControlStudy, label: str, errors: Sequence[float] | FloatArray, joints: Sequence[int]
) -> Column:
    """Errors, rad (m), in the unit of each row's joint (from 0); empty for lost loops."""
    values = [1e3 * error if math.isfinite(error) else None for error in errors]
    return Column("", label, values, [_unit(study, joint) for joint in joints])


def _by_joint(study: ControlStudy, key: str, title: str, values: str) -> Table:
    """An error of every controller by joint."""
    rows = np.array([getattr(_usual(study, controller), values) for controller in CONTROLLERS])
    columns = [_errors(study, f"joint {i + 1}", row, [i] * len(row)) for i, row in enumerate(rows.T)]
    return _by_controller(key, f"{title} {_usual_conditions(study)}", columns)


def _worst(study: ControlStudy, label: str, rate: float, speed: float) -> Column:
    """Largest error of any joint of every controller."""
    rows = [study.loop(controller, rate, speed).peak_error for controller in CONTROLLERS]
    joints = [int((row / study.tolerance).argmax()) for row in rows]
    return _errors(study, label, [row[joint] for row, joint in zip(rows, joints, strict=True)], joints)


def _torque_table(study: ControlStudy) -> Table:
    loops = [_usual(study, controller) for controller in (EXACT, SIMPLIFIED, laws.WITHOUT_H)]
    units = [joint.effort_unit for joint in study.arm.joints]
    limits = [limit if math.isfinite(limit) else None for limit in study.limits.tolist()]
    columns = (
        joint_columns(study.arm.joints)[-1],
        Column("", "limit", limits, units),
        *(Column("", f"peak, {loop.controller.title}", loop.peak_torque, units) for loop in loops),
        *(Column("", f"RMS, {loop.controller.title}", loop.rms_torque, units) for loop in loops[:2]),
        Column("", "time at limit", np.max([loop.saturated for loop in loops], axis=0), shown="percent"),
    )
    return Table("torque", f"Torque of computed torque {_usual_conditions(study)}", columns)


def _bounds_table(study: ControlStudy) -> Table:
    """Error from the model's torque error: bounds and simulation."""
    speed, controller, joints = study.settings.usual_speed, _judged(study), range(study.arm.n_joints)
    loops = [study.loop(controller, rate, speed) for rate in study.settings.rates]
    certified = _certified(study, controller)
    units = [joint.effort_unit for joint in study.arm.joints]
    proven = (
        []
        if certified is None
        else [replace(_errors(study, "bound, D sampled", certified.error, joints), shown="bound")]
    )
    columns = (
        joint_columns(study.arm.joints)[-1],
        *proven,
        _errors(study, "expected", study.expected[controller, speed], joints),
        *(_errors(study, _rate_label(loop.rate), loop.peak_error, joints) for loop in loops),
        Column("", "torque allowed", study.torque_for_tolerance, units),
    )
    law = " with fixed gains" if controller == FIXED_GAINS else ""
    title = f"Tracking error from the simplified model's torque error{law}: bound and simulation"
    bound = "Bound: torque error proven, D sampled along the motion; continuous, within the torque limits. "
    note = (
        f"Expected: to first order. {bound if proven else ''}To keep the tolerance: `gd-analyze simplify "
        f'--budget "{budget_for_tolerance(study)}"`, to first order, with fixed gains.'
    )
    return Table("bounds", title, columns, note)


def budget_for_tolerance(study: ControlStudy) -> str:
    """Budget of a model that keeps the tolerance with fixed gains: N m (N) by joint, rounded down."""
    return ",".join(f"{-rounded_up(-value):g}" for value in study.torque_for_tolerance)


def _rest_table(study: ControlStudy) -> Table:
    joints = range(study.arm.n_joints)
    units = ["N m/rad" if revolute else "N/m" for revolute in study.arm.is_revolute]
    columns = (
        joint_columns(study.arm.joints)[-1],
        Column("", "stiffness", study.settings.gains.stiffness * study.diagonal, units),
        _errors(study, laws.PD.title, study.at_rest, joints),
    )
    title = "Error of PD at rest at the worst position of the motion: uncompensated gravity over stiffness"
    return Table("rest", title, columns)


def tracking_figure(study: ControlStudy) -> Figure:
    """Tracking error of every joint over time, at the usual rate and speed."""
    groups = {
        "torque of a model": [_usual(study, c) for c in CONTROLLERS if c.law != "pd"],
        "PD": [_usual(study, c) for c in CONTROLLERS if c.law == "pd"],
    }

    def panel(i: int, title: str, loops: Sequence[TrackedLoop]) -> Panel:
        errors = [1e3 * loop.error[:, i] for loop in loops]
        items = []
        for loop, error in zip(loops, errors, strict=True):
            colour, dashes = _LOOKS[loop.controller]
            items.append(Curve(loop.time, error, colour, dashes=dashes, label=loop.controller.title))
        time = max((loop.time for loop in loops), key=lambda times: float(times[-1]))
        y = value_axis(_unit(study, i), *errors, floor=1e-12)
        heading = f"{i + 1} {study.arm.joints[i].name}: {title}"
        return Panel(f"joint-{i + 1}", heading, time_axis(time), y, tuple(items))

    rows = tuple(tuple(panel(i, *group) for group in groups.items()) for i in range(study.arm.n_joints))
    legend = tuple(LegendKey(c.title, colour, dashes=dashes) for c, (colour, dashes) in _LOOKS.items())
    height = min(max(620.0 / len(rows), 80.0), 130.0)
    return Figure("Tracking error of every joint over time", rows, FIGURE_WIDTH / 2, height, legend)


def speed_figure(study: ControlStudy) -> Figure:
    """Largest error of any joint, as a multiple of the tolerance, over speed; both axes logarithmic."""
    speeds = np.array(sorted(study.settings.speeds))
    shares = {c: study.shares(c, study.settings.usual_rate) for c in CONTROLLERS}
    positive = [x for row in shares.values() for x in row if 0 < x < math.inf]
    high = 1.4 * max([*positive, 1.0])
    y = decades_axis(max(min([*positive, 1.0]) / 1.4, high / 10**_SHOWN_DECADES), high)
    x = Axis(speeds[0] / 1.05, speeds[-1] * 1.05, tuple(speeds.tolist()), is_logarithmic=True)
    items: list[Curve] = [Curve(np.array([x.low, x.high]), np.ones(2), "ink", 0.8, (1.0, 1.6))]
    ends = [(1.0, "tolerance", "soft")]
    for controller, row in shares.items():
        is_drawn = (row > 0) & np.isfinite(row)
        if not is_drawn.any():
            continue
        (colour, dashes), name = _LOOKS[controller], controller.title
        curve = Curve(speeds[is_drawn], np.maximum(row[is_drawn], y.low), colour, dashes=dashes, label=name)
        items.append(replace(curve, marker="circle", size=3.2))
        ends.append((float(curve.y[-1]), name, colour))
    title = "largest tracking error, times the tolerance"
    panel = Panel("speeds", title, x, y, tuple(items), margins=(34.0, 26.0, 110.0, 16.0))
    label = "Largest tracking error over the speed of the motion"
    return ends_named(label, panel, ends, "speed, times the planned one", 230.0)
