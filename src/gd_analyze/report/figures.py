"""What every joint does against time: its motion, its torque and the simplified model's error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.findings import Findings
from gd_analyze.report.document import round_off
from gd_analyze.report.panel import (
    BLUE,
    GREEN,
    GREY,
    INK,
    VERMILLION,
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
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def motion_figure(findings: Findings) -> Figure:
    """Position, rate and acceleration of every joint against time, one joint per row."""
    arm, trajectory = findings.arm, findings.trajectory
    n = arm.n_joints
    row, head, foot, name_width = min(350.0 / n, 84.0), 12.0, 16.0, 66.0
    height = n * row + head + foot
    figure = new_figure(WIDTH, height)
    column = (WIDTH - name_width) / 3
    time = whole_range(trajectory.time)
    units = "deg" if all(arm.is_revolute) else "deg or m"
    for c, (title, values) in enumerate(
        (
            (f"position q, {units}", trajectory.q),
            (f"rate q̇, {units} per s", trajectory.qd),
            (f"acceleration q̈, {units} per s²", trajectory.qdd),
        )
    ):
        left = name_width + c * column + 24
        add_text(figure, left, height - 8, title, 7.5)
        for i, joint in enumerate(arm.joints):
            curve = np.degrees(values[:, i]) if joint.kind == "revolute" else values[:, i]
            bottom = foot + (n - 1 - i) * row
            span = value_range(curve) if c else _around(curve)
            panel = Panel(left, bottom + 3, column - 30, row - 8, time, span)
            add_frame(
                figure,
                panel,
                x_ticks=ticks(time, 4),
                x_labels=i == n - 1,
                y_ticks=ticks(span, 3 if row > 40 else 2),
                power=power_of_ten(span),
            )
            label = ("q", "qd", "qdd")[c] + str(i + 1)
            add_curve(figure, panel, trajectory.time, curve, color=INK, linewidth=1.1, label=label)
    for i, joint in enumerate(arm.joints):
        middle = foot + (n - 0.5 - i) * row
        add_text(figure, 0, middle, f"joint {i + 1}", 7.5, weight="bold")
        add_text(figure, 0, middle - 8, _clipped(joint.name, 17), 7, color=GREY)
    add_text(figure, name_width + 8, foot - 5.5, "time, s", 6.5, ha="right", color=GREY)
    return figure


def torque_figure(findings: Findings) -> Figure:
    """Exact and simplified torque of every joint, and the error beside what is allowed."""
    arm, evaluation = findings.arm, findings.evaluation
    n = arm.n_joints
    row, head, foot = min(620.0 / n, 110.0), 12.0, 16.0
    height = n * row + head + foot
    figure = new_figure(WIDTH, height)
    name_width, half = 66.0, (WIDTH - 66.0) / 2
    seconds, noise = findings.trajectory.time, round_off(findings)
    time = whole_range(seconds)
    add_text(figure, name_width + 26, height - 8, "torque: exact and simplified", 7.5)
    add_text(figure, name_width + half + 26, height - 8, "error: simplified − exact, allowed band", 7.5)
    for i, joint in enumerate(arm.joints):
        bottom = foot + (n - 1 - i) * row
        exact, simplified = evaluation.exact[:, i], evaluation.simplified[:, i]
        error, allowed = simplified - exact, float(findings.model.promise.allowed[i])
        spans = (
            value_range(exact, simplified, floor=noise),
            value_range(error, np.array([-allowed, allowed]), floor=noise),
        )
        powers = [power_of_ten(span) for span in spans]
        panels = [
            Panel(name_width + c * half + 26, bottom + 5, half - 32, row - 15, time, span)
            for c, span in enumerate(spans)
        ]
        if allowed > noise:
            _band(figure, panels[1], allowed)
        for panel, span, power in zip(panels, spans, powers, strict=True):
            last = i == n - 1
            add_frame(
                figure, panel, x_ticks=ticks(time, 5), x_labels=last, y_ticks=ticks(span, 4), power=power
            )
            unit = scaled(joint.effort_unit, power)
            add_text(figure, panel.left, panel.bottom + panel.height + 2, unit, 6.5, color=GREY)
        add_curve(
            figure, panels[0], seconds, exact, color=BLUE, linewidth=2.6, alpha=0.55, label=f"exact {i + 1}"
        )
        add_curve(
            figure, panels[0], seconds, simplified, color=INK, linewidth=0.9, label=f"simplified {i + 1}"
        )
        add_curve(figure, panels[1], seconds, error, color=VERMILLION, linewidth=1.2, label=f"error {i + 1}")
        middle = bottom + 0.5 * row
        add_text(figure, 0, middle, f"joint {i + 1}", 7.5, weight="bold")
        add_text(figure, 0, middle - 8, _clipped(joint.name, 17), 7, color=GREY)
    add_text(figure, name_width + 8, foot - 3.5, "time, s", 6.5, ha="right", color=GREY)
    return figure


def _band(figure: Figure, panel: Panel, allowed: float) -> None:
    from matplotlib.patches import Rectangle

    band = Rectangle(
        (panel.x[0], -allowed),
        panel.x[1] - panel.x[0],
        2 * allowed,
        facecolor=GREEN,
        alpha=0.18,
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


def _clipped(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"
