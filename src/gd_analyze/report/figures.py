"""The report's plots: motion, D and h by effect, torques and their errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.dominance import Element, elements
from gd_analyze.findings import Findings
from gd_analyze.formulations.generalized_dalembert import EFFECTS
from gd_analyze.report.panel import (
    BLUE,
    CURVES,
    GREEN,
    GREY,
    INK,
    PALE,
    VERMILLION,
    Panel,
    add_curve,
    add_frame,
    add_text,
    new_figure,
    power_of_ten,
    ticks,
    value_range,
)
from gd_analyze.report.units import inertia_unit, pretty
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 493.0
_SUBSCRIPTS = str.maketrans("0123456789,", "₀₁₂₃₄₅₆₇₈₉ ")
_SHORT = {"translation": "T", "rotation": "R", "both": "T+R", "neither": "0"}


def motion_figure(findings: Findings) -> Figure:
    """Position, rate and acceleration of every joint against time, one joint per row."""
    arm, trajectory = findings.arm, findings.trajectory
    n = arm.n_joints
    row, head, foot, name_width = float(np.clip(336 / n, 27, 84)), 12.0, 16.0, 66.0
    height = n * row + head + foot
    figure = new_figure(WIDTH, height)
    column = (WIDTH - name_width) / 3
    time = _span(trajectory.time)
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
                y_ticks=ticks(span, 2),
                power=power_of_ten(span),
            )
            label = ("q", "qd", "qdd")[c] + str(i + 1)
            add_curve(figure, panel, trajectory.time, curve, color=INK, linewidth=1.1, label=label)
    for i, joint in enumerate(arm.joints):
        middle = foot + (n - 0.5 - i) * row
        add_text(figure, 0, middle, f"joint {i + 1}", 7.5, weight="bold")
        add_text(figure, 0, middle - 8, _clipped(joint.name, 17), 7, color=GREY)
    add_text(figure, name_width, 1.5, "time, s", 7, ha="right")
    return figure


def inertia_figure(findings: Findings) -> Figure:
    """Upper triangle of D by effect against the set points, each panel at its place in the matrix."""
    arm = findings.arm
    n = arm.n_joints
    pitch = min(WIDTH / n, 165.0)
    row = float(np.clip(0.98 * pitch, 52, 110))
    roomy = n <= 7
    foot = 12.0
    figure = new_figure(n * pitch, n * row + foot)
    for element in elements(n):
        if element.quantity != "inertia" or element.j is None:
            continue
        left = element.j * pitch + (21 if roomy else 3)
        bottom = foot + (n - 1 - element.i) * row
        _element_panel(
            figure,
            findings,
            element,
            (left, bottom, pitch - (25 if roomy else 7), row),
            inertia_unit(arm, element.i, element.j),
            roomy=roomy,
            set_points=element.i == element.j,
        )
    return figure


def coriolis_figure(findings: Findings) -> Figure:
    """h_1..h_n by effect against the set points."""
    return _vector_figure(findings, "coriolis_centrifugal")


def gravity_figure(findings: Findings) -> Figure:
    """c_1..c_n against the set points."""
    return _vector_figure(findings, "gravity_loading")


def torque_figure(findings: Findings) -> Figure:
    """Exact and simplified torque of every joint, and the error beside what is allowed."""
    arm, evaluation = findings.arm, findings.evaluation
    n = arm.n_joints
    row, head, foot = float(np.clip(560 / n, 50, 100)), 12.0, 16.0
    height = n * row + head + foot
    figure = new_figure(WIDTH, height)
    name_width, half = 66.0, (WIDTH - 66.0) / 2
    seconds = findings.trajectory.time
    time = _span(seconds)
    add_text(figure, name_width + 26, height - 8, "torque: exact and simplified", 7.5)
    add_text(figure, name_width + half + 26, height - 8, "error: simplified − exact, allowed band", 7.5)
    for i, joint in enumerate(arm.joints):
        bottom = foot + (n - 1 - i) * row
        exact, simplified = evaluation.exact[:, i], evaluation.simplified[:, i]
        error, allowed = simplified - exact, float(findings.model.budget[i])
        spans = (value_range(exact, simplified), value_range(error, np.array([-allowed, allowed])))
        powers = [power_of_ten(span) for span in spans]
        panels = [
            Panel(name_width + c * half + 26, bottom + 5, half - 32, row - 15, time, span)
            for c, span in enumerate(spans)
        ]
        if allowed > 0:
            _band(figure, panels[1], allowed)
        for panel, span, power in zip(panels, spans, powers, strict=True):
            last = i == n - 1
            add_frame(
                figure, panel, x_ticks=ticks(time, 5), x_labels=last, y_ticks=ticks(span, 3), power=power
            )
            unit = _scaled(joint.effort_unit, power)
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
    add_text(figure, name_width, 1.5, "time, s", 7, ha="right")
    return figure


def _vector_figure(findings: Findings, quantity: str) -> Figure:
    arm = findings.arm
    chosen = [e for e in elements(arm.n_joints) if e.quantity == quantity]
    columns = min(len(chosen), 3 if len(chosen) <= 9 else 4)
    rows = -(-len(chosen) // columns)
    pitch = WIDTH / max(columns, 3)
    row, foot = 92.0, 12.0
    figure = new_figure(columns * pitch, rows * row + foot)
    for k, element in enumerate(chosen):
        left = (k % columns) * pitch + 26
        bottom = foot + (rows - 1 - k // columns) * row
        below = k + columns >= len(chosen)
        _element_panel(
            figure,
            findings,
            element,
            (left, bottom, pitch - 34, row),
            arm.joints[element.i].effort_unit,
            set_points=below,
        )
    return figure


def _element_panel(
    figure: Figure,
    findings: Findings,
    element: Element,
    box: tuple[float, float, float, float],
    unit: str,
    *,
    roomy: bool = True,
    set_points: bool = True,
) -> None:
    """One element's translation, rotation and both together, titled by its label and verdict."""
    left, bottom, width, row = box
    parts = element.parts(findings.decomposition)
    dominance = findings.dominance.sel(element=element.label)
    curves = {
        effect: part
        for effect, part in (*zip(EFFECTS, parts, strict=True), ("combined", parts.sum(axis=0)))
        if element.quantity != "gravity_loading" or effect == "combined"
    }
    zero = float(dominance.peak) == 0.0
    span = value_range(*curves.values(), floor=float(np.abs(parts).max()) if zero else 0.0)
    power = power_of_ten(span)
    count = findings.trajectory.n_set_points
    numbers = np.arange(1.0, count + 1)
    panel = Panel(left, bottom + 3, width, row - (19 if roomy else 23), _span(numbers), span)
    add_frame(
        figure,
        panel,
        x_ticks=[1.0, float(count)] if count > 1 else [1.0],
        x_labels=set_points,
        y_ticks=[0.0] if zero else ticks(span, 3),
        y_labels=roomy,
        power=power,
        size=6 if roomy else 4.5,
    )
    scale = 1.0 if roomy else 0.6
    for effect, curve in curves.items():
        style = CURVES[effect] | {"linewidth": CURVES[effect]["linewidth"] * scale}
        add_curve(figure, panel, numbers, curve, label=f"{element.label} {effect}", **style)
    top = panel.bottom + panel.height
    title_size, note_size = (8.5, 6.5) if roomy else (7, 5)
    symbol, index = element.label[0], element.label[1:].translate(_SUBSCRIPTS)
    add_text(figure, left, top + (4 if roomy else 8.5), symbol + index, title_size, style="italic")
    if element.quantity != "gravity_loading":
        verdict = str(dominance.dominant.values)
        colour = {"translation": BLUE, "rotation": VERMILLION}.get(verdict, INK)
        add_text(
            figure,
            left + width,
            top + (4 if roomy else 8.5),
            _SHORT[verdict],
            title_size - 1,
            ha="right",
            color=colour,
            weight="bold",
        )
    if roomy:
        middle = left + (16 if len(index) < 3 else 22)
        add_text(figure, middle, top + 4, _scaled(unit, power), note_size, color=GREY)
    else:
        peak = f"peak {float(dominance.peak):.1e}"
        add_text(figure, left, top + 2, pretty(peak).replace(" × ", "×"), note_size - 0.5, color=GREY)


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


def _span(values: FloatArray) -> tuple[float, float]:
    """First to last value; some width around a single one."""
    first, last = float(values[0]), float(values[-1])
    return (first, last) if last > first else (first - 0.5, first + 0.5)


def _around(values: FloatArray) -> tuple[float, float]:
    """Range around values that need not include zero."""
    low, high = float(values.min()), float(values.max())
    room = max(0.1 * (high - low), 1e-6 * max(abs(low), abs(high)), 1e-9)
    return (low - room, high + room) if high > low else (low - 1.0, high + 1.0)


def _scaled(unit: str, power: int) -> str:
    """Write the unit, with its power of ten where one was set apart."""
    unit = pretty(unit)
    return unit if power == 0 else pretty(f"1e{power:+d}").removeprefix("1 × ") + f" {unit}"


def _clipped(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"
