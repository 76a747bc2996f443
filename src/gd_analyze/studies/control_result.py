"""A study of control as a Result: verdict, errors by joint, rate and speed, torques, bounds, and drawings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.figure import (
    WIDTH,
    Axis,
    Curve,
    Figure,
    Key,
    Panel,
    decades_axis,
    ends_named,
    time_axis,
    value_axis,
)
from gd_analyze.result import Column, Drawing, Fact, Result, Section, Table, joint_columns
from gd_analyze.studies.control import ControlStudy, TrackedLoop
from gd_analyze.studies.control_law import CONTINUOUS, CONTROLLERS, Controller
from gd_analyze.studies.study_files import inputs_stated
from gd_analyze.text import number, rounded_up

EXACT, SIMPLIFIED, FIXED_GAINS, WITHOUT_H = CONTROLLERS[:4]

# Colour and dashes of each controller, so that grey print tells them apart as well.
_LOOKS: dict[Controller, tuple[str, tuple[float, ...]]] = dict(
    zip(
        CONTROLLERS,
        (
            ("ink", ()),
            ("series-3", ()),
            ("series-3", (4.0, 1.6)),
            ("series-2", ()),
            ("series-1", ()),
            ("series-7", ()),
            ("series-1", (4.0, 1.6)),
            ("series-4", (1.2, 1.4)),
            ("series-5", (4.0, 1.6)),
        ),
        strict=True,
    )
)
_COLUMNS = (
    ("computed torque with a model", CONTROLLERS[:4]),
    ("without a model's D, and PD", CONTROLLERS[4:]),
)
# Expected errors beyond this, rad (m), are of a D that is nearly singular; errors below this share of the
# largest would leave no room in the figure for the others.
_FARTHEST, _DECADES = 1.0, 5


def good_enough(study: ControlStudy) -> Literal["computed torque", "fixed gains", ""]:
    """Law by which the simplified model keeps every joint within the tolerance; "" where there is none."""
    if study.feedback.is_enough and _usual(study, SIMPLIFIED).within(study.tolerance):
        return "computed torque"
    return "fixed gains" if _usual(study, FIXED_GAINS).within(study.tolerance) else ""


def judged(study: ControlStudy) -> Controller:
    """The law by which the simplified model is judged: one that is good enough, or the better."""
    law = good_enough(study)
    if law:
        return SIMPLIFIED if law == "computed torque" else FIXED_GAINS
    laws = (SIMPLIFIED, FIXED_GAINS)
    return min(laws, key=lambda one: float((_usual(study, one).peak_error / study.tolerance).max()))


def control_result(study: ControlStudy) -> Result:
    """Facts, tables and drawings of a study."""
    settings, arm = study.settings, study.arm
    carrying = "" if arm.name == study.model.arm.name else " (the payload unknown to every controller)"
    return Result(
        title=arm.title or arm.name,
        subtitle=f"controlled along {study.motion.name}{carrying}",
        headline=_headline(study),
        facts=(*_facts(study), *_hidden_facts(study)),
        parts=(
            Section(
                "tracking",
                "Tracking errors",
                (
                    _joint_table(study, "peak", "Largest tracking error", "peak_error"),
                    _joint_table(study, "rms", "RMS tracking error", "rms_error"),
                    _rates_table(study),
                    _speeds_table(study),
                ),
                note="Controllers of computed torque are named by what they know of the arm.",
            ),
            Section(
                "drawings",
                "Over time and speed",
                (
                    Drawing("errors", "Tracking error of every joint over time", error_figure(study)),
                    Drawing(
                        "speeds", "Largest tracking error over the speed of the motion", speed_figure(study)
                    ),
                ),
            ),
            Section(
                "torques",
                "Torques and bounds",
                (_torque_table(study), _bounds_table(study), _rest_table(study)),
            ),
        ),
        notices=study.warnings,
        provenance={
            "gains": f"bandwidth {settings.bandwidth:g} rad/s, damping {settings.damping:g}",
            "torque limits": _limits_stated(study),
            "friction": "the drives', unknown to every controller" if settings.friction else "none",
            "drives": "inertia included" if study.model.drives else "links alone",
            "model": f"level {study.model.level.name}, budget {study.model.accuracy.budget}",
            **inputs_stated(arm, study.motion),
            **study.provenance,
        },
    )


def _usual(study: ControlStudy, controller: Controller) -> TrackedLoop:
    return study.loop(controller, study.usual_rate, study.usual_speed)


def _here(study: ControlStudy) -> str:
    speed = study.usual_speed
    return _rate_stated(study.usual_rate) + ("" if speed == 1.0 else f", at {speed:g} times the speed")


def _rate_stated(rate: float) -> str:
    return "in continuous time" if rate == CONTINUOUS else f"at {rate:g} Hz"


def _scale(study: ControlStudy, joint: int) -> tuple[float, str]:
    """Factor and unit of a joint's tracking error for people; joint from 0."""
    return 1e3, "mrad" if study.arm.is_revolute[joint] else "mm"


def _worst_text(study: ControlStudy, errors: FloatArray, *, bound: bool = False) -> str:
    """The joint whose error, rad (m), is the largest share of its tolerance, and that error."""
    joint = int((errors / study.tolerance).argmax())
    scale, unit = _scale(study, joint)
    value = scale * float(errors[joint])
    if not math.isfinite(value):
        return f"lost (joint {joint + 1})"
    return f"{number(rounded_up(value) if bound else value)} {unit} (joint {joint + 1})"


def _headline(study: ControlStudy) -> str:
    law = good_enough(study)
    if not _usual(study, EXACT).within(study.tolerance):
        verdict = "Not even the exact model keeps the tolerance"
    elif law:
        verdict = f"The simplified model is good enough to control this arm, by {law}"
    else:
        verdict = "The simplified model is not good enough to control this arm"
    within = study.settings.tolerance.in_words(study.arm)
    simplified, exact = (_worst_text(study, _usual(study, c).peak_error) for c in (judged(study), EXACT))
    return (
        f"{verdict}. Largest tracking error {_here(study)}: {simplified} with the simplified model, {exact} "
        f"with the exact one; tolerance {within}."
    )


def _facts(study: ControlStudy) -> Iterator[Fact]:
    """Figures for people, most of them also in JSON."""
    names = {judged(study): "simplified model", EXACT: "exact model", WITHOUT_H: "exact model without h"}
    for controller, name in names.items():
        worst = _worst_text(study, _usual(study, controller).peak_error)
        law = " with fixed gains" * (controller == FIXED_GAINS)
        yield Fact("", f"Tracking error, {name}{law}", worst, shown="text")
    fastest = max(study.settings.speeds)
    for controller, name in names.items():
        speed = study.tracks_up_to(controller, study.usual_rate)
        text = "none" if speed is None else f"{number(speed)}×" if speed < math.inf else f"≥ {fastest:g}×"
        yield Fact("", f"Speed within tolerance, {name}", speed, text=text)
    yield from _bound_facts(study)
    feedback = study.feedback
    if not feedback.is_enough:
        joints = ", ".join(map(str, feedback.joints))
        label = "Feedback left by the model's D, least"
        yield Fact("", label, max(feedback.share, 0.0), shown="percent", note=f"of joints {joints}")
    if study.too_slow_for_fixed_gains:
        rates = ", ".join(f"{rate:g}" for rate in study.too_slow_for_fixed_gains)
        note = f"gains up to {number(study.fixed_excess)} times too high in some direction"
        yield Fact("", "Loop rates unstable with fixed gains, Hz", rates, shown="text", note=note)
    shares = _saturation(study)
    if shares:
        text = ", ".join(f"{100 * share:.2g} % at {speed:g}×" for speed, share in shares.items())
        yield Fact("", "Time at the torque limit, longest", text, shown="text")
    limit = study.fastest_within_limits
    if max(study.settings.speeds) > limit * (1 + 1e-9):
        label = "Speed within the arm's limits"
        yield Fact("", label, limit, text=f"{math.floor(1e3 * limit) / 1e3:g}×")


def _bound_facts(study: ControlStudy) -> Iterator[Fact]:
    """Bound on the error by the model's torque error: proven, or expected to first order."""
    controller = judged(study)
    found = study.certified.get(study.usual_speed) if controller == SIMPLIFIED else None
    simulated = study.loop(controller, max(study.settings.rates), study.usual_speed)
    label = "Tracking error by the model error"
    if found is not None:
        text = f"at most {_worst_text(study, found.error, bound=True)}"
        yield Fact("", f"{label}, proven", text, shown="text")
    elif controller != FIXED_GAINS or simulated.rate not in study.too_slow_for_fixed_gains:
        text = "unbounded: the model's D is nearly singular"
        if (simulated.expected < _FARTHEST).all():
            text = f"at most {_worst_text(study, simulated.expected)}"
        yield Fact("", f"{label}, to first order", text, shown="text")


def _saturation(study: ControlStudy) -> dict[float, float]:
    """Largest share of time at the torque limit by speed, of loops that kept the motion."""
    shares: dict[float, float] = {}
    for loop in study.loops:
        share = float(loop.saturated.max())
        if share and loop.lost_at is None and loop.controller in (EXACT, SIMPLIFIED):
            shares[loop.speed] = max(share, shares.get(loop.speed, 0.0))
    return shares


def _hidden_facts(study: ControlStudy) -> Iterator[Fact]:
    """Everything else, for JSON: SI units and full precision."""
    settings, motion = study.settings, study.motion
    residuals = [abs(loop.energy_residual) for loop in study.loops if loop.lost_at is None]
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
        "usual": {"rate": study.usual_rate, "speed": study.usual_speed},
        "good_enough": good_enough(study) or None,
        "feedback": {"share": study.feedback.share, "joints": study.feedback.joints},
        "fixed_excess": study.fixed_excess,
        "energy_residual": max(residuals, default=0.0),
        "tracks_up_to": {c.title: _up_to(study, c) for c in CONTROLLERS},
        "joints": _joints(study),
        "loops": [_loop(loop) for loop in study.loops],
    }
    for key, value in values.items():
        yield Fact(key, "", value)


def _up_to(study: ControlStudy, controller: Controller) -> dict[str, float | bool | None]:
    """Speed up to which the tolerance holds, None for no speed, and whether it holds at every speed tried."""
    speed = study.tracks_up_to(controller, study.usual_rate)
    known = None if speed is None else min(speed, max(study.settings.speeds))
    return {"speed": known, "at_every_speed": speed == math.inf}


def _joints(study: ControlStudy) -> list[dict[str, Any]]:
    return [
        {
            "joint": i + 1,
            "joint_name": joint.name,
            "unit": joint.unit,
            "effort_unit": joint.effort_unit,
            "tolerance": study.tolerance[i],
            "inertia": study.diagonal[i],
            "stiffness": study.stiffness[i],
            "torque_limit": study.limits[i],
            "error_at_rest": {c.title: error[i] for c, error in study.at_rest.items()},
            "certified": [
                {"speed": speed, "torque_error": bound.torque_error[i], "error": bound.error[i]}
                for speed, bound in study.certified.items()
            ],
        }
        for i, joint in enumerate(study.arm.joints)
    ]


def _loop(loop: TrackedLoop) -> dict[str, Any]:
    controller = loop.controller
    known = {"controller": controller.title, "law": controller.law, "knows": controller.knows}
    names = (
        *("rate", "speed", "lost_at", "peak_error", "rms_error", "expected", "peak_torque", "rms_torque"),
        *("saturated", "work", "dissipated", "energy_residual"),
    )
    return known | {name: getattr(loop, name) for name in names}


def _limits_stated(study: ControlStudy) -> str:
    if not np.isfinite(study.limits).any():
        return "none"
    scale = study.settings.limits
    return "those of the drives" + ("" if scale in (None, 1.0) else f", times {scale:g}")


def _by_controller(key: str, title: str, columns: Sequence[Column]) -> Table:
    titles = Column("", "controller", [controller.title for controller in CONTROLLERS], shown="text")
    return Table(key, title, (titles, *columns))


def _errors(
    study: ControlStudy, label: str, errors: Sequence[float] | FloatArray, joints: Sequence[int]
) -> Column:
    """Errors, rad (m), in the unit of the joint (from 0) of each row; nothing of loops that were lost."""
    pairs = [(_scale(study, joint), float(error)) for error, joint in zip(errors, joints, strict=True)]
    shown = [scale * error if math.isfinite(error) else None for (scale, _), error in pairs]
    return Column("", label, shown, [unit for (_, unit), _ in pairs])


def _joint_table(study: ControlStudy, key: str, title: str, values: str) -> Table:
    """An error of every controller by joint."""
    rows = np.array([getattr(_usual(study, controller), values) for controller in CONTROLLERS])
    joints = range(study.arm.n_joints)
    columns = [_errors(study, f"joint {i + 1}", rows[:, i], [i] * len(rows)) for i in joints]
    return _by_controller(key, f"{title} {_here(study)}", columns)


def _worst(study: ControlStudy, label: str, rate: float, speed: float) -> Column:
    """Largest error of any joint of every controller."""
    loops = [study.loop(controller, rate, speed) for controller in CONTROLLERS]
    joints = [int((loop.peak_error / study.tolerance).argmax()) for loop in loops]
    errors = [float(loop.peak_error[joint]) for loop, joint in zip(loops, joints, strict=True)]
    return _errors(study, label, errors, joints)


def _rates_table(study: ControlStudy) -> Table:
    rates, speed = study.settings.rates, study.usual_speed
    columns = [_worst(study, _rate_label(rate), rate, speed) for rate in rates]
    return _by_controller("by_rate", "Largest tracking error of any joint by loop rate", columns)


def _speeds_table(study: ControlStudy) -> Table:
    rate, speeds = study.usual_rate, study.settings.speeds
    columns = [_worst(study, f"{speed:g}×", rate, speed) for speed in speeds]
    title = f"Largest tracking error of any joint by speed of the motion, {_rate_stated(rate)}"
    return _by_controller("by_speed", title, columns)


def _rate_label(rate: float) -> str:
    return "continuous" if rate == CONTINUOUS else f"{rate:g} Hz"


def _torque_table(study: ControlStudy) -> Table:
    loops = [_usual(study, controller) for controller in (EXACT, SIMPLIFIED, WITHOUT_H)]
    units = [joint.effort_unit for joint in study.arm.joints]
    limits = [limit if math.isfinite(limit) else None for limit in study.limits.tolist()]
    saturated = np.max([loop.saturated for loop in loops], axis=0)
    columns = (
        *_joints_shown(study),
        Column("", "limit", limits, units),
        *(Column("", f"peak, {loop.controller.title}", loop.peak_torque, units) for loop in loops),
        *(Column("", f"RMS, {loop.controller.title}", loop.rms_torque, units) for loop in loops[:2]),
        Column("", "time at limit", saturated, shown="percent"),
    )
    return Table("torque", f"Torque of computed torque {_here(study)}", columns)


def _joints_shown(study: ControlStudy) -> tuple[Column, ...]:
    return joint_columns(study.arm.joints)[-1:]


def _bounds_table(study: ControlStudy) -> Table:
    """Error by the model's torque error: bounds, and what is simulated."""
    speed, rates, controller = study.usual_speed, study.settings.rates, judged(study)
    joints = range(study.arm.n_joints)
    loops = [study.loop(controller, rate, speed) for rate in rates]
    found = study.certified.get(speed) if controller == SIMPLIFIED else None
    proven = [] if found is None else [replace(_errors(study, "proven", found.error, joints), shown="bound")]
    columns = (
        *_joints_shown(study),
        *proven,
        _errors(study, "expected", loops[0].expected, joints),
        *(_errors(study, _rate_label(loop.rate), loop.peak_error, joints) for loop in loops),
    )
    law = " with fixed gains" * (controller == FIXED_GAINS)
    title = f"Tracking error caused by the simplified model's torque error{law}, at most, and simulated"
    note = "Expected: to first order. Proven: in continuous time, within the torque limits."
    return Table("bounds", title, columns, note)


def _rest_table(study: ControlStudy) -> Table:
    joints = range(study.arm.n_joints)
    stiff = ["N m/rad" if revolute else "N/m" for revolute in study.arm.is_revolute]
    columns = (
        *_joints_shown(study),
        Column("", "stiffness", study.stiffness, stiff),
        *(_errors(study, controller.title, error, joints) for controller, error in study.at_rest.items()),
    )
    title = "Error of PD at rest at the worst position of the motion: uncompensated gravity over stiffness"
    return Table("rest", title, columns)


def error_figure(study: ControlStudy) -> Figure:
    """Tracking error of every joint over time, at the usual rate and speed."""
    rows = []
    for i, joint in enumerate(study.arm.joints):
        panels = []
        for title, controllers in _COLUMNS:
            loops = [_usual(study, controller) for controller in controllers]
            panels.append(_error_panel(study, i, f"{i + 1} {joint.name}: {title}", loops))
        rows.append(tuple(panels))
    legend = tuple(Key(c.title, colour, dashes=dashes) for c, (colour, dashes) in _LOOKS.items())
    height = min(max(620.0 / len(rows), 80.0), 130.0)
    return Figure("Tracking error of every joint over time", tuple(rows), WIDTH / 2, height, legend)


def _error_panel(study: ControlStudy, joint: int, title: str, loops: Sequence[TrackedLoop]) -> Panel:
    scale, unit = _scale(study, joint)
    # Of a loop that was lost what is drawn ends where the motion was lost.
    curves = [scale * loop.error[:, joint] for loop in loops]
    items = tuple(
        Curve(loop.time, curve, *_look(loop.controller), label=loop.controller.title)
        for loop, curve in zip(loops, curves, strict=True)
    )
    time = max((loop.time for loop in loops), key=lambda times: float(times[-1]))
    y = value_axis(unit, *curves, floor=1e-12)
    return Panel(f"joint-{joint + 1}", title, time_axis(time), y, items)


def _look(controller: Controller) -> tuple[str, float, tuple[float, ...]]:
    colour, dashes = _LOOKS[controller]
    return colour, 1.1, dashes


def speed_figure(study: ControlStudy) -> Figure:
    """Largest error of any joint, as a multiple of the tolerance, over speed; both axes logarithmic."""
    speeds = np.array(sorted(study.settings.speeds))
    shares = {
        c: np.array(
            [float((study.loop(c, study.usual_rate, s).peak_error / study.tolerance).max()) for s in speeds]
        )
        for c in CONTROLLERS
    }
    positive = [x for row in shares.values() for x in row if 0 < x < math.inf] or [1.0]
    high = 1.4 * max(*positive, 1.0)
    y = decades_axis(max(min(*positive, 1.0) / 1.4, high / 10**_DECADES), high)
    x = Axis(speeds[0] / 1.05, speeds[-1] * 1.05, tuple(speeds.tolist()), is_logarithmic=True)
    items: list[Curve] = [Curve(np.array([x.low, x.high]), np.ones(2), "ink", 0.8, (1.0, 1.6))]
    ends = [(1.0, "tolerance", "soft")]
    for controller, row in shares.items():
        known = (row > 0) & np.isfinite(row)
        if not known.any():
            continue
        values, (colour, width, dashes) = np.maximum(row[known], y.low), _look(controller)
        name = controller.title
        items.append(
            Curve(speeds[known], values, colour, width, dashes, label=name, marker="circle", size=3.2)
        )
        ends.append((float(values[-1]), name, colour))
    title = "largest tracking error, times the tolerance"
    panel = Panel("speeds", title, x, y, tuple(items), margins=(34.0, 26.0, 110.0, 16.0))
    label = "Largest tracking error over the speed of the motion"
    return ends_named(label, panel, ends, "speed, times the planned one", 230.0)
