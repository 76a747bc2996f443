"""Elements of D, h and c by effect over time: the founding text's Figs 3.10 and 3.11."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.figures.colours import COLOURS
from gd_analyze.figures.figure import (
    WIDTH,
    Axis,
    Curve,
    Figure,
    Key,
    Panel,
    broken,
    in_columns,
    time_axis,
    value_axis,
)
from gd_analyze.text import prefixed, pretty

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings

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


def inertia_figure(findings: Findings) -> Figure:
    """Upper triangle of D by effect, each panel at its place in the matrix."""
    n = findings.arm.n_joints
    rows: list[list[Panel | None]] = [[None] * n for _ in range(n)]
    pitch = min(WIDTH / n, 165.0)
    for element in elements(n):
        if element.quantity == "inertia" and element.j is not None:
            rows[element.i][element.j] = _panel(findings, element, pitch)
    height = min(1.3 * pitch, 645.0 / n, 130.0)
    return Figure("Inertia matrix by effect", tuple(map(tuple, rows)), pitch, height, _LEGEND)


def vector_figure(findings: Findings, quantity: str) -> Figure:
    """Elements of a vector over time, "coriolis_centrifugal" or "gravity_loading"."""
    chosen = [e for e in elements(findings.arm.n_joints) if e.quantity == quantity]
    columns = 3 if len(chosen) <= 9 else 4
    height = min(250.0 / -(-len(chosen) // columns), 110.0)
    panels = [_panel(findings, element, WIDTH / columns) for element in chosen]
    words = {"coriolis_centrifugal": "Coriolis and centrifugal vector by effect"}
    return in_columns(words.get(quantity, "Gravity loading vector"), panels, columns, height)


def element_curves(findings: Findings, element: Element) -> dict[str, FloatArray]:
    """Values of an element at the set points that are drawn, shape (N,) each.

    "combined" of every element, "translation" and "rotation" of D and h, and the shares "centrifugal" and
    "coriolis" of h. A part that the ranking calls zero is zero here.
    """
    _, dataset = findings.drawn
    zero = findings.dominance.part_peak.values[_rank(findings, element), :, None] == 0.0
    parts = np.where(zero, 0.0, element.parts(dataset))
    curves = {"combined": parts.sum(axis=0)}
    if element.quantity != "gravity_loading":
        curves |= dict(zip(EFFECTS, parts, strict=True))
    if element.quantity == "coriolis_centrifugal":
        for share in ("centrifugal", "coriolis"):
            values = dataset[share].values[:, :, element.i].T
            curves[share] = np.where(zero, 0.0, values).sum(axis=0)
    return curves


def _rank(findings: Findings, element: Element) -> int:
    return int(np.flatnonzero(findings.dominance.element.values == element.label)[0])


def _panel(findings: Findings, element: Element, pitch: float) -> Panel:
    """Translation, rotation and both together, titled by label, unit and dominant effect."""
    dominance, rank = findings.dominance, _rank(findings, element)
    unit, peak = str(dominance.unit.values[rank]), float(dominance.peak.values[rank])
    curves = element_curves(findings, element)
    points, motion = findings.drawn[0], findings.trajectory
    gaps = np.unique(np.searchsorted(points, motion.gaps))
    # An element that is zero but for round-off must not fill its panel with noise.
    factor, shown = prefixed(peak, unit)
    y = Axis(-1.0, 1.0, (0.0,), pretty(unit)) if peak == 0.0 else value_axis(unit, *curves.values())
    if peak:
        y = Axis(y.low, y.high, y.ticks, pretty(shown), factor)
    is_narrow = pitch < 60.0
    letters = LETTERS[str(dominance.dominant.values[rank])] if element.quantity != "gravity_loading" else ""
    verdict = str(dominance.dominant.values[rank])
    items = tuple(
        Curve(
            broken(motion.time[points], gaps),
            broken(curve, gaps),
            role,
            _LOOKS[role][0] * (0.6 if is_narrow else 1.0),
            _LOOKS[role][1],
            label=role,
            role=role,
            hidden=role in ("centrifugal", "coriolis"),
        )
        for role, curve in curves.items()
    )
    return Panel(
        element.label,
        element.label[0] + element.label[1:].translate(_SUBSCRIPTS),
        time_axis(motion.time[points], 2),
        y,
        items,
        letters,
        f"{verdict}-text" if f"{verdict}-text" in COLOURS else "ink",
        margins=(14.0, 8.0, 2.0, 9.0) if is_narrow else (22.0, 11.0, 5.0, 13.0),
        text=4.0 if is_narrow else 6.0,
    )
