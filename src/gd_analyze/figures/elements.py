"""Elements of D, h and c by effect over time: the founding text's Figs 3.10 and 3.11."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.figures.figure import (
    COLOURS,
    WIDTH,
    Axis,
    Figure,
    Key,
    Panel,
    in_columns,
    over_time,
    time_axis,
    value_axis,
)
from gd_analyze.figures.run import Run
from gd_analyze.text import prefixed, pretty

# What is kept of an element, or dominates it, where there is no room for words.
LETTERS = {"translation": "T", "rotation": "R", "both": "T+R", "neither": "0", "gravity": "✓"}

# Dash and width tell curves apart in grey.
_LOOKS: dict[str, tuple[float, tuple[float, ...]]] = {
    "combined": (2.6, ()),
    "translation": (1.1, ()),
    "rotation": (1.1, (3.0, 1.5)),
    "centrifugal": (1.0, (1.0, 1.2)),
    "coriolis": (1.0, (4.0, 1.5, 1.0, 1.5)),
}
_LEGEND = (
    Key("translation", "translation"),
    Key("rotation", "rotation", dashes=(3.0, 1.5)),
    Key("both together", "combined"),
)
_SUBSCRIPTS = str.maketrans("0123456789,", "₀₁₂₃₄₅₆₇₈₉ ")


def inertia_figure(run: Run) -> Figure:
    """Upper triangle of D by effect, each panel at its place in the matrix."""
    n = run.arm.n_joints
    rows: list[list[Panel | None]] = [[None] * n for _ in range(n)]
    pitch = min(WIDTH / n, 165.0)
    for element in elements(n):
        if element.quantity == "inertia" and element.j is not None:
            rows[element.i][element.j] = _panel(run, element, pitch)
    height = min(1.3 * pitch, 580.0 / n, 130.0)  # with heading and note on a page
    return Figure("Inertia matrix by effect", tuple(map(tuple, rows)), pitch, height, _LEGEND)


def vector_figure(run: Run, quantity: str) -> Figure:
    """Elements of a vector over time, "coriolis_centrifugal" or "gravity_loading"."""
    chosen = [e for e in elements(run.arm.n_joints) if e.quantity == quantity]
    columns = 3 if len(chosen) <= 9 else 4
    height = min(250.0 / -(-len(chosen) // columns), 110.0)
    panels = [_panel(run, element, WIDTH / columns) for element in chosen]
    words = {"coriolis_centrifugal": "Coriolis and centrifugal vector by effect"}
    return in_columns(words.get(quantity, "Gravity loading vector"), panels, columns, height)


def element_curves(run: Run, element: Element) -> dict[str, FloatArray]:
    """Values of an element at the set points that are drawn, shape (N,) each.

    "combined" of every element, "translation" and "rotation" of D and h, and the shares "centrifugal" and
    "coriolis" of h. A part that the ranking calls zero is zero here.
    """
    _, dataset = run.drawn
    zero = run.dominance.part_peak.values[_rank(run, element), :, None] == 0.0
    parts = np.where(zero, 0.0, element.parts(dataset))
    curves = {"combined": parts.sum(axis=0)}
    if element.quantity != "gravity_loading":
        curves |= dict(zip(EFFECTS, parts, strict=True))
    if element.quantity == "coriolis_centrifugal":
        for share in ("centrifugal", "coriolis"):
            values = dataset[share].values[:, :, element.i].T
            curves[share] = np.where(zero, 0.0, values).sum(axis=0)
    return curves


def subscripted(label: str) -> str:
    """An element's label with its joints as subscripts."""
    return label[0] + label[1:].translate(_SUBSCRIPTS)


def _rank(run: Run, element: Element) -> int:
    return int(np.flatnonzero(run.dominance.element.values == element.label)[0])


def _panel(run: Run, element: Element, pitch: float) -> Panel:
    """Translation, rotation and both together, titled by label, unit and dominant effect."""
    rank, is_narrow = _rank(run, element), pitch < 60.0
    unit, peak, verdict = (run.dominance[name].values[rank] for name in ("unit", "peak", "dominant"))
    curves, points = element_curves(run, element), run.drawn[0]
    time, gaps = run.trajectory.time[points], run.gaps_among(points)
    # An element that is zero but for round-off must not fill its panel with noise.
    factor, shown = prefixed(float(peak), str(unit))
    y = value_axis(unit, *curves.values()) if peak else Axis(-1.0, 1.0, (0.0,))
    y = replace(y, unit=pretty(shown), factor=factor)
    items = []
    for role, curve in curves.items():
        width, dashes = _LOOKS[role]
        hidden, width = role in ("centrifugal", "coriolis"), width * (0.6 if is_narrow else 1.0)
        look = {"dashes": dashes, "label": role, "role": role, "hidden": hidden}
        items.append(over_time(time, curve, gaps, role, width, **look))
    return Panel(
        element.label,
        subscripted(element.label),
        time_axis(time, 2),
        y,
        tuple(items),
        LETTERS[verdict] if element.quantity != "gravity_loading" else "",
        f"{verdict}-text" if f"{verdict}-text" in COLOURS else "ink",
        margins=(14.0, 8.0, 2.0, 9.0) if is_narrow else (22.0, 11.0, 5.0, 13.0),
        text=4.0 if is_narrow else 6.0,
    )
