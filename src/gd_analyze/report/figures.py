"""What every joint does against time: its motion, its torque and the simplified model's error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.report.canvas import Canvas
from gd_analyze.report.motion import motion_curve, motion_unit
from gd_analyze.report.panel import WIDTH, Panel, Scale, add_curve, add_frame, ticks, value_range, whole_range
from gd_analyze.report.reading_curves import ReadingCurves
from gd_analyze.report.thinning import breaks
from gd_analyze.results.findings import Findings
from gd_analyze.results.torque_curves import measured_joints, torque_curves
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import pretty

# Above, below and beside the rows of a figure.
_HEAD, _FOOT, _NAME_WIDTH = 12.0, 16.0, 66.0


def motion_figure(findings: Findings) -> Canvas:
    """Position, rate and acceleration of every joint against time, one joint per row."""
    arm, trajectory = findings.arm, findings.trajectory
    n = arm.n_joints
    row, column = min(350.0 / n, 84.0), (WIDTH - _NAME_WIDTH) / 3
    canvas = _canvas_of_rows(arm, row)
    time = whole_range(trajectory.time)
    for c, (name, title) in enumerate(
        (("q", "position q"), ("qd", "rate q̇"), ("qdd", "acceleration q̈")),
    ):
        units = " or ".join(dict.fromkeys(pretty(motion_unit(joint, name)) for joint in arm.joints))
        left = _NAME_WIDTH + c * column + 24
        canvas.text(left, _FOOT + n * row + 4, f"{title}, {units}", 7.5)
        for i, joint in enumerate(arm.joints):
            curve = motion_curve(trajectory, joint, name, i)
            bottom = _FOOT + (n - 1 - i) * row
            span = value_range(curve) if c else _around(curve)
            panel = Panel(left, bottom + 3, column - 30, row - 8, time, span)
            add_frame(
                canvas,
                panel,
                x_ticks=ticks(time, 4),
                y_ticks=ticks(span, 3 if row > 40 else 2),
                labels="xy" if i == n - 1 else "y",
            )
            add_curve(
                canvas,
                panel,
                trajectory.time,
                curve,
                "ink",
                1.1,
                label=f"{name}{i + 1}",
                gaps=trajectory.gaps,
            )
    return canvas


def torque_figure(findings: Findings) -> Canvas:
    """Exact and simplified torque of every joint, and the error beside what is allowed."""
    arm, table = findings.arm, findings.tables["simplified_model"]
    n = arm.n_joints
    row, half = min(540.0 / n, 110.0), (WIDTH - _NAME_WIDTH) / 2
    canvas = _canvas_of_rows(arm, row)
    seconds, noise, gaps = findings.trajectory.time, findings.round_off, findings.trajectory.gaps
    time = whole_range(seconds)
    for c, title in enumerate(("torque: exact and simplified", "error: simplified − exact")):
        canvas.text(_NAME_WIDTH + c * half + 26, _FOOT + n * row + 4, title, 7.5)
    for i, joint in enumerate(arm.joints):
        bottom = _FOOT + (n - 1 - i) * row
        exact, simplified = findings.exact_torque[:, i], findings.simplified_torque[:, i]
        error, allowed = table.torque_error.values[:, i], float(table.allowed_error[i])
        when, proven = _proven(findings, i)
        spans = (
            value_range(exact, simplified, floor=noise),
            value_range(error, proven, -proven, np.array([-allowed, allowed]), floor=noise),
        )
        panels = [
            Panel(_NAME_WIDTH + c * half + 26, bottom + 3, half - 32, row - 13, time, span)
            for c, span in enumerate(spans)
        ]
        if allowed > noise:
            _band(canvas, panels[1], allowed)
        for panel, span in zip(panels, spans, strict=True):
            scale = Scale.of(span, joint.effort_unit)
            shown = "xy" if i == n - 1 else "y"
            add_frame(
                canvas, panel, x_ticks=ticks(time, 5), y_ticks=ticks(span, 4), labels=shown, scale=scale
            )
            canvas.text(panel.left, panel.top + 2, scale.unit, 6.5, colour="soft")
        for panel, curve, label, colour, width in (
            (panels[0], exact, "exact", "combined", 2.6),
            (panels[0], simplified, "simplified", "accent", 0.9),
            (panels[1], error, "error", "accent", 1.2),
        ):
            add_curve(canvas, panel, seconds, curve, colour, width, label=f"{label} {i + 1}", gaps=gaps)
        # What is proven of a piece is drawn as its two ends; where the next begins later, nothing is proven.
        between = 2 * np.flatnonzero(when[2::2] > when[1:-1:2]) + 2
        for sign in (1.0, -1.0) if len(when) else ():
            name = f"proven {i + 1}"
            add_curve(canvas, panels[1], when, sign * proven, "inertia", 0.8, label=name, gaps=between)
    return canvas


def recording_figure(findings: Findings) -> Canvas:
    """Readings of every joint and the smoothed motion, and their difference where the joint is fastest."""
    arm, motion = findings.arm, findings.trajectory
    n = arm.n_joints
    row, half = min(400.0 / n, 80.0), (WIDTH - _NAME_WIDTH) / 2
    canvas = _canvas_of_rows(arm, row)
    for c, title in enumerate(("readings and smoothed motion", "readings minus smoothed, where fastest")):
        canvas.text(_NAME_WIDTH + c * half + 26, _FOOT + n * row + 4, title, 7.5)
    for i, joint in enumerate(arm.joints):
        drawn, bottom = ReadingCurves.of(findings, i), _FOOT + (n - 1 - i) * row
        near = motion.time[drawn.near]
        columns = (
            (whole_range(motion.time), _around(drawn.read), "xy" if i == n - 1 else "y"),
            # Each joint is fastest at a time of its own.
            (whole_range(near), value_range(drawn.difference), "xy"),
        )
        panels = []
        for c, (time, span, labels) in enumerate(columns):
            panel = Panel(_NAME_WIDTH + c * half + 26, bottom + 6, half - 34, row - 19, time, span)
            add_frame(canvas, panel, x_ticks=ticks(time, 4), y_ticks=ticks(span, 3), labels=labels, size=5)
            canvas.text(panel.left, panel.top + 2, pretty(motion_unit(joint, "q")), 6, colour="soft")
            panels.append(panel)
        for curve, label, colour, width in (
            (drawn.read, "readings", "combined", 2.6),
            (drawn.smooth, "smoothed", "accent", 0.9),
        ):
            name = f"{label} {i + 1}"
            add_curve(canvas, panels[0], motion.time, curve, colour, width, label=name, gaps=motion.gaps)
        add_curve(canvas, panels[1], near, drawn.difference, "combined", 0.7, label=f"difference {i + 1}")
    return canvas


def _proven(findings: Findings, i: int) -> tuple[FloatArray, FloatArray]:
    """Steps of what is proven of a joint's error near each piece of the motion; none where nothing is."""
    tube = findings.tables["tube"]
    along = tube.tube_along.values[:, i]
    if not np.isfinite(along).all():
        return np.empty(0), np.zeros(1)
    when = np.stack([tube.segment_from.values, tube.segment_to.values], axis=1).ravel()
    return when, np.repeat(along, 2)


def _canvas_of_rows(arm: RobotArm, row: float, joints: Sequence[int] | None = None) -> Canvas:
    """Make a drawing of a named row per joint, or of some, from 0, over a common axis of time."""
    joints = range(arm.n_joints) if joints is None else joints
    canvas = Canvas(WIDTH, len(joints) * row + _HEAD + _FOOT)
    for k, i in enumerate(joints):
        joint, middle = arm.joints[i], _FOOT + (len(joints) - 0.5 - k) * row
        name = joint.name if len(joint.name) <= 17 else joint.name[:16] + "…"
        canvas.text(0, middle, f"joint {i + 1}", 7.5, weight="bold")
        canvas.text(0, middle - 8, name, 7, colour="soft")
    canvas.text(_NAME_WIDTH + 8, _FOOT - 5.5, "time, s", 6.5, colour="soft", anchor="end")
    return canvas


def _band(canvas: Canvas, panel: Panel, allowed: float) -> None:
    """Shade what is allowed."""
    x, y = np.array(panel.x), np.array([-allowed, allowed])
    corners = panel.place(x[[0, 1, 1, 0]], y[[0, 0, 1, 1]])
    canvas.area(corners, "accent-wash", label="allowed")


def _around(values: FloatArray) -> tuple[float, float]:
    """Range around values that need not include zero."""
    low, high = float(values.min()), float(values.max())
    room = max(0.1 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-9)
    return (low - room, high + room) if high > low else (low - 1.0, high + 1.0)


def measured_figure(findings: Findings) -> Canvas:
    """Measured and exact torque of every joint that was measured, and what is between them."""
    arm, joints = findings.arm, measured_joints(findings)
    # The tables of the same appendix take a third of the page.
    row, half = min(350.0 / len(joints), 90.0), (WIDTH - _NAME_WIDTH) / 2
    canvas = _canvas_of_rows(arm, row, joints)
    time = whole_range(findings.trajectory.time)
    for c, title in enumerate(("torque: measured and exact", "difference: measured − exact")):
        canvas.text(_NAME_WIDTH + c * half + 26, _FOOT + len(joints) * row + 4, title, 7.5)
    for k, i in enumerate(joints):
        curves, bottom = torque_curves(findings, i), _FOOT + (len(joints) - 1 - k) * row
        seconds, parts = findings.trajectory.time[curves.points], [curves.difference]
        gaps = breaks(curves.points, findings.trajectory.gaps)
        left = [
            (curves.read, "read", "line", 0.6),
            (curves.measured, "measured", "combined", 2.2),
            (curves.exact, "exact", "accent", 1.0),
        ]
        right = [(curves.difference, "difference", "combined", 1.2)]
        if curves.friction is not None:
            left.append((curves.exact + curves.friction, "with friction", "rotation", 0.8))
            right.append((curves.friction, "friction", "rotation", 0.9))
            parts.append(curves.friction)
        spans = (value_range(curves.read, *(curve for curve, *_ in left)), value_range(*parts))
        for c, (span, drawn) in enumerate(zip(spans, (left, right), strict=True)):
            panel = Panel(_NAME_WIDTH + c * half + 26, bottom + 3, half - 32, row - 13, time, span)
            scale = Scale.of(span, arm.joints[i].effort_unit)
            shown = "xy" if k == len(joints) - 1 else "y"
            add_frame(
                canvas, panel, x_ticks=ticks(time, 5), y_ticks=ticks(span, 4), labels=shown, scale=scale
            )
            canvas.text(panel.left, panel.top + 2, scale.unit, 6.5, colour="soft")
            for curve, label, colour, width in drawn:
                add_curve(canvas, panel, seconds, curve, colour, width, label=f"{label} {i + 1}", gaps=gaps)
    return canvas
