"""Tracking errors of controllers over time, and over the speed of the motion."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gd_analyze.report.canvas import Canvas
from gd_analyze.report.panel import (
    WIDTH,
    Panel,
    add_curve,
    add_frame,
    tick_label,
    ticks,
    value_range,
    whole_range,
)
from gd_analyze.studies.control_verdict import error_scale
from gd_analyze.studies.controllers import CONTROLLERS, Controller
from gd_analyze.studies.study import ControlStudy, TrackedLoop

# Colour and dashes of each, so that grey print tells them apart as well.
LOOKS: dict[Controller, tuple[str, tuple[float, ...]]] = dict(
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
_HEAD, _FOOT, _NAMES = 12.0, 16.0, 66.0
_SPEED_HEIGHT, _LABELS, _PITCH = 210.0, 110.0, 9.0
# Errors below this share of the largest would leave no room for the others.
_DECADES = 5


def error_figure(study: ControlStudy) -> Canvas:
    """Tracking error of every joint over time, at the usual rate and speed."""
    n = study.arm.n_joints
    row, half = min(560.0 / n, 110.0), (WIDTH - _NAMES) / 2
    canvas = Canvas(WIDTH, n * row + _HEAD + _FOOT)
    canvas.text(_NAMES + 8, _FOOT - 5.5, "time, s", 6.5, colour="soft", anchor="end")
    for c, (title, controllers) in enumerate(_COLUMNS):
        loops = [study.loop(one, study.usual_rate, study.usual_speed) for one in controllers]
        canvas.text(_NAMES + c * half + 26, _FOOT + n * row + 4, title, 7.5)
        for i, joint in enumerate(study.arm.joints):
            bottom = _FOOT + (n - 1 - i) * row
            if c == 0:
                name = joint.name if len(joint.name) <= 17 else joint.name[:16] + "…"
                canvas.text(0, bottom + 0.5 * row, f"joint {i + 1}", 7.5, weight="bold")
                canvas.text(0, bottom + 0.5 * row - 8, name, 7, colour="soft")
            _errors(canvas, study, loops, i, (_NAMES + c * half + 26, bottom + 3, half - 32, row - 13))
    return canvas


def _errors(
    canvas: Canvas,
    study: ControlStudy,
    loops: Sequence[TrackedLoop],
    joint: int,
    place: tuple[float, float, float, float],
) -> None:
    """Draw one joint's errors of some loops into a panel at left, bottom, of a width and height."""
    scale, unit = error_scale(study, joint)
    # Of a loop that was lost what is drawn ends where the motion was lost.
    curves = [(loop, scale * loop.error[:, joint]) for loop in loops]
    known = [(loop, loop.time[ok := np.isfinite(curve)], curve[ok]) for loop, curve in curves]
    span = value_range(*(curve for _, _, curve in known), floor=1e-12)
    time = whole_range(max((loop.time for loop in loops), key=lambda times: float(times[-1])))
    panel = Panel(*place, time, span)
    is_last = joint == study.arm.n_joints - 1
    add_frame(canvas, panel, x_ticks=ticks(time, 5), y_ticks=ticks(span, 4), labels="xy" if is_last else "y")
    canvas.text(panel.left, panel.top + 2, unit, 6.5, colour="soft")
    for loop, times, curve in known:
        colour, dashes = LOOKS[loop.controller]
        add_curve(
            canvas,
            panel,
            times,
            curve,
            colour,
            1.1,
            dashes=dashes,
            label=f"{loop.controller.title} {joint + 1}",
        )


def speed_figure(study: ControlStudy) -> Canvas:
    """Largest error of any joint, as a multiple of the tolerance, over speed; both axes logarithmic."""
    speeds = sorted(study.settings.speeds)
    shares = {
        c: [float((study.loop(c, study.usual_rate, s).peak_error / study.tolerance).max()) for s in speeds]
        for c in CONTROLLERS
    }
    positive = [x for row in shares.values() for x in row if 0 < x < math.inf] or [1.0]
    high = math.log10(max(*positive, 1.0)) + 0.15
    low = max(math.log10(min(*positive, 1.0)) - 0.15, high - _DECADES)
    x = whole_range(np.log10(speeds))
    room = 0.04 * (x[1] - x[0])
    canvas = Canvas(WIDTH, _SPEED_HEIGHT)
    panel = Panel(
        34.0, 24.0, WIDTH - 34.0 - _LABELS, _SPEED_HEIGHT - 40.0, (x[0] - room, x[1] + room), (low, high)
    )
    _speed_frame(canvas, panel, speeds)
    ends = [(float(panel.upward(np.array(0.0))), "tolerance", "soft")]
    for controller, row in shares.items():
        colour, dashes = LOOKS[controller]
        known = [
            (math.log10(s), max(math.log10(v), low))
            for s, v in zip(speeds, row, strict=True)
            if 0 < v < math.inf
        ]
        if not known:
            continue
        at = np.array(known)
        points = panel.place(at[:, 0], at[:, 1])
        canvas.line(points, colour, 1.3, dashes=dashes, order=3, label=controller.title)
        canvas.mark(points, colour, 3.2, order=3.1)
        ends.append((float(points[-1, 1]), controller.title, colour))
    for y, name, colour in _apart(sorted(ends), panel.top + 6.0):
        canvas.text(panel.right + 6, y - 2.4, name, 7, colour=colour)
    return canvas


def _apart(ends: Sequence[tuple[float, str, str]], top: float) -> list[tuple[float, str, str]]:
    """Move names, from the lowest on, apart and below `top`."""
    places, above = [], top + _PITCH
    low = -math.inf
    for y, *_ in ends:
        low = max(y, low + _PITCH)
        places.append(low)
    for k in reversed(range(len(places))):
        above = places[k] = min(places[k], above - _PITCH)
    return [(y, name, colour) for y, (_, name, colour) in zip(places, ends, strict=True)]


def _speed_frame(canvas: Canvas, panel: Panel, speeds: Sequence[float]) -> None:
    """Draw the axes, and the tolerance."""
    decades = range(math.ceil(panel.y[0]), math.floor(panel.y[1]) + 1)
    for decade in decades:
        y = float(panel.upward(np.array(float(decade))))
        canvas.segments([(panel.left, y, panel.right, y)], "line", 0.5)
        canvas.text(panel.left - 4, y - 2.2, tick_label(10.0**decade), 6.5, colour="soft", anchor="end")
    for speed in speeds:
        x = float(panel.across(np.array(math.log10(speed))))
        canvas.segments([(x, panel.bottom, x, panel.top)], "line", 0.5)
        canvas.text(x, panel.bottom - 9, tick_label(speed), 6.5, colour="soft", anchor="middle")
    canvas.segments([(panel.left, panel.bottom, panel.right, panel.bottom)], "soft", 0.6)
    at = float(panel.upward(np.array(0.0)))
    canvas.line(
        np.array([[panel.left, at], [panel.right, at]]), "ink", 0.8, dashes=(1, 1.6), label="tolerance"
    )
    canvas.text(0, _SPEED_HEIGHT - 8, "largest tracking error, times the tolerance", 7.5)
    canvas.text(panel.right, 4, "speed, times the planned one", 7.5, anchor="end")
