"""Elements of D, h and c by effect against the set points: the founding text's Figs 3.10 and 3.11."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gd_analyze.elements import Element, elements
from gd_analyze.formatting import pretty
from gd_analyze.report.colours import GREY, INK, ON_PAPER
from gd_analyze.report.element_curves import element_curves, rank_of
from gd_analyze.report.panel import (
    CURVES,
    PAGE_HEIGHT,
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
from gd_analyze.results.words import LETTERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SUBSCRIPTS = str.maketrans("0123456789,", "₀₁₂₃₄₅₆₇₈₉ ")


def inertia_figure(findings: Findings) -> Figure:
    """Upper triangle of D by effect against the set points, each panel at its place in the matrix."""
    arm = findings.arm
    n = arm.n_joints
    pitch = min(WIDTH / n, 165.0)
    row = min(1.3 * pitch, PAGE_HEIGHT / n, 130.0)
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
            named_unit=not all(arm.is_revolute),
            roomy=roomy,
            set_points=element.i == element.j,
        )
    return figure


def vector_figure(findings: Findings, quantity: str) -> Figure:
    """Elements of a vector, h_1..h_n by effect or c_1..c_n, against the set points."""
    arm = findings.arm
    chosen = [e for e in elements(arm.n_joints) if e.quantity == quantity]
    columns = min(len(chosen), 3 if len(chosen) <= 9 else 4)
    rows = -(-len(chosen) // columns)
    pitch = WIDTH / max(columns, 3)
    row, foot = min(0.42 * PAGE_HEIGHT / rows, 132.0), 12.0
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
            set_points=below,
        )
    return figure


def _element_panel(
    figure: Figure,
    findings: Findings,
    element: Element,
    box: tuple[float, float, float, float],
    *,
    named_unit: bool = True,
    roomy: bool = True,
    set_points: bool = True,
) -> None:
    """One element's translation, rotation and both together, titled by its label and verdict."""
    left, bottom, width, row = box
    dominance, rank = findings.dominance, rank_of(findings, element)
    unit, peak = str(dominance.unit.values[rank]) if named_unit else "", float(dominance.peak.values[rank])
    drawn = element_curves(findings, element)
    curves = {effect: drawn[effect] for effect in CURVES if effect in drawn}
    zero = peak == 0.0
    # An element that is zero but for round-off must not fill its panel with noise.
    span = (-1.0, 1.0) if zero else value_range(*curves.values())
    power = power_of_ten(span)
    count = findings.trajectory.n_set_points
    numbers = 1.0 + findings.drawn[0].astype(float)
    panel = Panel(left, bottom + 3, width, row - (19 if roomy else 23), whole_range(numbers), span)
    add_frame(
        figure,
        panel,
        x_ticks=[1.0, float(count)] if count > 1 else [1.0],
        y_ticks=[0.0] if zero else ticks(span, 4),
        labels="x" * set_points + "y" * roomy,
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
        verdict = str(dominance.dominant.values[rank])
        colour = ON_PAPER.get(f"{verdict}-text", INK)
        add_text(
            figure,
            left + width,
            top + (4 if roomy else 8.5),
            LETTERS[verdict],
            title_size - 1,
            ha="right",
            color=colour,
            weight="bold",
        )
    if roomy:
        middle = left + (16 if len(index) < 3 else 22)
        add_text(figure, middle, top + 4, scaled(unit, power), note_size, color=GREY)
    else:
        said = pretty(f"peak {peak:.1e}").replace(" × ", "×")
        add_text(figure, left, top + 2, said, note_size - 0.5, color=GREY)
