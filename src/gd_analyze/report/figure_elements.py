"""Elements of D, h and c by effect against the set points: the founding text's Figs 3.10 and 3.11."""

from __future__ import annotations

from typing import Any

from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.report.canvas import Canvas
from gd_analyze.report.colours import COLOURS
from gd_analyze.report.element_curves import element_curves, rank_of
from gd_analyze.report.panel import (
    PAGE_HEIGHT,
    WIDTH,
    Panel,
    Scale,
    add_curve,
    add_frame,
    ticks,
    value_range,
    whole_range,
)
from gd_analyze.report.thinning import breaks
from gd_analyze.results.findings import Findings
from gd_analyze.results.words import LETTERS
from gd_analyze.text import figures

# Dash and width tell curves apart in greyscale.
_CURVES: dict[str, tuple[float, dict[str, Any]]] = {
    "combined": (2.6, {}),
    "translation": (1.1, {}),
    "rotation": (1.1, {"dashes": (3.0, 1.5)}),
}
_SUBSCRIPTS = str.maketrans("0123456789,", "₀₁₂₃₄₅₆₇₈₉ ")


def inertia_figure(findings: Findings) -> Canvas:
    """Upper triangle of D by effect over time, each panel at its place in the matrix."""
    arm = findings.arm
    n = arm.n_joints
    pitch = min(WIDTH / n, 165.0)
    row = min(1.3 * pitch, PAGE_HEIGHT / n, 130.0)
    roomy = n <= 7
    foot = 12.0
    canvas = Canvas(n * pitch, n * row + foot)
    for element in elements(n):
        if element.quantity != "inertia" or element.j is None:
            continue
        left = element.j * pitch + (21 if roomy else 3)
        bottom = foot + (n - 1 - element.i) * row
        box = (left, bottom, pitch - (25 if roomy else 7), row)
        _element_panel(canvas, findings, element, box, roomy=roomy, seconds=element.i == element.j)
    return canvas


def vector_figure(findings: Findings, quantity: str) -> Canvas:
    """Elements of a vector, h_1..h_n by effect or c_1..c_n, over time."""
    arm = findings.arm
    chosen = [e for e in elements(arm.n_joints) if e.quantity == quantity]
    columns = min(len(chosen), 3 if len(chosen) <= 9 else 4)
    rows = -(-len(chosen) // columns)
    pitch = WIDTH / max(columns, 3)
    row, foot = min(0.4 * PAGE_HEIGHT / rows, 120.0), 12.0
    canvas = Canvas(columns * pitch, rows * row + foot)
    for k, element in enumerate(chosen):
        left = (k % columns) * pitch + 26
        bottom = foot + (rows - 1 - k // columns) * row
        below = k + columns >= len(chosen)
        _element_panel(canvas, findings, element, (left, bottom, pitch - 34, row), seconds=below)
    return canvas


def _element_panel(
    canvas: Canvas,
    findings: Findings,
    element: Element,
    box: tuple[float, float, float, float],
    *,
    roomy: bool = True,
    seconds: bool = True,
) -> None:
    """One element's translation, rotation and both together, titled by its label and verdict."""
    left, bottom, width, row = box
    dominance, rank = findings.dominance, rank_of(findings, element)
    unit, peak = str(dominance.unit.values[rank]), float(dominance.peak.values[rank])
    drawn = element_curves(findings, element)
    curves = {effect: drawn[effect] for effect in _CURVES if effect in drawn}
    zero = peak == 0.0
    # An element that is zero but for round-off must not fill its panel with noise.
    span = (-1.0, 1.0) if zero else value_range(*curves.values())
    scale = Scale.of((0.0, peak), unit)
    points, motion = findings.drawn[0], findings.trajectory
    time, gaps = motion.time[points], breaks(points, motion.gaps)
    panel = Panel(left, bottom + 3, width, row - (19 if roomy else 23), whole_range(time), span)
    add_frame(
        canvas,
        panel,
        x_ticks=ticks(panel.x, 2),
        y_ticks=[0.0] if zero else ticks(span, 4),
        labels="x" * seconds + "y" * roomy,
        scale=scale,
        size=6 if roomy else 4.5,
    )
    for effect, curve in curves.items():
        thickness, look = _CURVES[effect]
        label = f"{element.label} {effect}"
        add_curve(
            canvas,
            panel,
            time,
            curve,
            effect,
            thickness * (1.0 if roomy else 0.6),
            label=label,
            gaps=gaps,
            **look,
        )
    _title(canvas, panel, element, str(dominance.dominant.values[rank]), scale.unit, roomy)
    if not roomy:
        said = f"peak {figures(peak / scale.factor)} {scale.unit}"
        canvas.text(left, panel.top + 2, said, 4.5, colour="soft")


def _title(canvas: Canvas, panel: Panel, element: Element, verdict: str, unit: str, roomy: bool) -> None:
    """Label, unit and the letter of the dominant effect above a panel, none over another."""
    size, y = (8.5 if roomy else 7.0), panel.top + (4 if roomy else 8.5)
    symbol, index = element.label[0], element.label[1:].translate(_SUBSCRIPTS)
    canvas.text(panel.left, y, symbol + index, size, style="italic")
    letters = LETTERS[verdict] if element.quantity != "gravity_loading" else ""
    if letters:
        colour = f"{verdict}-text" if f"{verdict}-text" in COLOURS else "ink"
        canvas.text(panel.right, y, letters, size - 1, colour=colour, anchor="end", weight="bold")
    if roomy:
        # Half an em for a letter or a digit, two thirds for a capital.
        start = panel.left + (16 if len(index) < 3 else 22)
        room = panel.right - start - 0.67 * (size - 1) * len(letters) - 2
        fitting = min(6.5, room / (0.5 * len(unit)))
        canvas.text(start, y, unit, fitting, colour="soft")
