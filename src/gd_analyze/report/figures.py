"""What every joint does against time: its motion, its torque and the simplified model's error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.formatting import pretty
from gd_analyze.report.colours import GREY, INK, ON_PAPER
from gd_analyze.report.motion import motion_curve, motion_unit
from gd_analyze.report.panel import (
    WIDTH,
    Panel,
    add_curve,
    add_frame,
    add_text,
    new_figure,
    power_of_ten,
    scaled,
    ticks,
    value_range,
    whole_range,
)
from gd_analyze.results import Findings
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Above, below and beside the rows of a figure.
_HEAD, _FOOT, _NAME_WIDTH = 12.0, 16.0, 66.0


def motion_figure(findings: Findings) -> Figure:
    """Position, rate and acceleration of every joint against time, one joint per row."""
    arm, trajectory = findings.arm, findings.trajectory
    n = arm.n_joints
    row, column = min(350.0 / n, 84.0), (WIDTH - _NAME_WIDTH) / 3
    figure = _figure_of_rows(arm, row)
    time = whole_range(trajectory.time)
    for c, (name, title) in enumerate(
        (("q", "position q"), ("qd", "rate q̇"), ("qdd", "acceleration q̈")),
    ):
        units = " or ".join(dict.fromkeys(pretty(motion_unit(joint, name)) for joint in arm.joints))
        left = _NAME_WIDTH + c * column + 24
        add_text(figure, left, _FOOT + n * row + 4, f"{title}, {units}", 7.5)
        for i, joint in enumerate(arm.joints):
            curve = motion_curve(trajectory, joint, name, i)
            bottom = _FOOT + (n - 1 - i) * row
            span = value_range(curve) if c else _around(curve)
            panel = Panel(left, bottom + 3, column - 30, row - 8, time, span)
            add_frame(
                figure,
                panel,
                x_ticks=ticks(time, 4),
                y_ticks=ticks(span, 3 if row > 40 else 2),
                labels="xy" if i == n - 1 else "y",
                power=power_of_ten(span),
            )
            add_curve(figure, panel, trajectory.time, curve, color=INK, linewidth=1.1, label=f"{name}{i + 1}")
    return figure


def torque_figure(findings: Findings) -> Figure:
    """Exact and simplified torque of every joint, and the error beside what is allowed."""
    arm, table = findings.arm, findings.tables["simplified_model"]
    n = arm.n_joints
    row, half = min(620.0 / n, 110.0), (WIDTH - _NAME_WIDTH) / 2
    figure = _figure_of_rows(arm, row)
    seconds, noise = findings.trajectory.time, findings.round_off
    time = whole_range(seconds)
    for c, title in enumerate(("torque: exact and simplified", "error: simplified − exact, allowed band")):
        add_text(figure, _NAME_WIDTH + c * half + 26, _FOOT + n * row + 4, title, 7.5)
    for i, joint in enumerate(arm.joints):
        bottom = _FOOT + (n - 1 - i) * row
        exact, simplified = findings.exact_torque[:, i], findings.simplified_torque[:, i]
        error, allowed = table.torque_error.values[:, i], float(table.allowed_error[i])
        spans = (
            value_range(exact, simplified, floor=noise),
            value_range(error, np.array([-allowed, allowed]), floor=noise),
        )
        powers = [power_of_ten(span) for span in spans]
        panels = [
            Panel(_NAME_WIDTH + c * half + 26, bottom + 3, half - 32, row - 13, time, span)
            for c, span in enumerate(spans)
        ]
        if allowed > noise:
            _band(figure, panels[1], allowed)
        for panel, span, power in zip(panels, spans, powers, strict=True):
            shown = "xy" if i == n - 1 else "y"
            add_frame(
                figure, panel, x_ticks=ticks(time, 5), y_ticks=ticks(span, 4), labels=shown, power=power
            )
            unit = scaled(joint.effort_unit, power)
            add_text(figure, panel.left, panel.bottom + panel.height + 2, unit, 6.5, color=GREY)
        for panel, curve, label, colour, width in (
            (panels[0], exact, "exact", "combined", 2.6),
            (panels[0], simplified, "simplified", "accent", 0.9),
            (panels[1], error, "error", "accent", 1.2),
        ):
            colour = ON_PAPER[colour]
            add_curve(figure, panel, seconds, curve, color=colour, linewidth=width, label=f"{label} {i + 1}")
    return figure


def _figure_of_rows(arm: RobotArm, row: float) -> Figure:
    """Make a figure of a named row per joint over a common axis of time."""
    n = arm.n_joints
    figure = new_figure(WIDTH, n * row + _HEAD + _FOOT)
    for i, joint in enumerate(arm.joints):
        middle = _FOOT + (n - 0.5 - i) * row
        name = joint.name if len(joint.name) <= 17 else joint.name[:16] + "…"
        add_text(figure, 0, middle, f"joint {i + 1}", 7.5, weight="bold")
        add_text(figure, 0, middle - 8, name, 7, color=GREY)
    add_text(figure, _NAME_WIDTH + 8, _FOOT - 5.5, "time, s", 6.5, ha="right", color=GREY)
    return figure


def _band(figure: Figure, panel: Panel, allowed: float) -> None:
    from matplotlib.patches import Rectangle

    band = Rectangle(
        (panel.x[0], -allowed),
        panel.x[1] - panel.x[0],
        2 * allowed,
        facecolor=ON_PAPER["accent-wash"],
        edgecolor="none",
        zorder=0.5,
        transform=panel.transform(figure),
        label="allowed",
    )
    figure.add_artist(band)


def _around(values: FloatArray) -> tuple[float, float]:
    """Range around values that need not include zero."""
    low, high = float(values.min()), float(values.max())
    room = max(0.1 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-9)
    return (low - room, high + room) if high > low else (low - 1.0, high + 1.0)
