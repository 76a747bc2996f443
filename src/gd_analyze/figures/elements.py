"""Elements of D, h and c by effect over time: [FGL87]'s Figs 3.10 and 3.11."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.errors import UsageError
from gd_analyze.figures.figure import (
    COLOURS,
    FIGURE_WIDTH,
    Axis,
    Curve,
    Figure,
    Item,
    LegendKey,
    Marker,
    Panel,
    in_columns,
    over_time,
    ticks,
    time_axis,
    value_axis,
)
from gd_analyze.figures.run import Elements
from gd_analyze.text import prefixed, pretty

# Short marks of verdicts; a drive has the symbol of its inertia.
LETTERS = {
    "translation": "T",
    "rotation": "R",
    "both": "T+R",
    "gravity": "✓",
    "drive": "J",
    "negligible": "–",
    "zero": "0",
}

# Width, dashes and marker distinguish curves in grey print.
_LOOKS: dict[str, tuple[float, tuple[float, ...]]] = {
    "combined": (2.4, ()),
    "translation": (0.9, ()),
    "rotation": (0.9, (3.4, 2.0)),
    "centrifugal": (1.0, (1.0, 1.2)),
    "coriolis": (1.0, (4.0, 1.5, 1.0, 1.5)),
}
# Marker, size (pt) and step: a marker at every set point would hide the dashes of rotation.
_MARKS: dict[str, tuple[Marker, float, int]] = {
    "translation": ("circle", 1.9, 1),
    "rotation": ("diamond", 2.9, 3),
}
_LEGEND = (
    LegendKey("translation", "translation", marker="circle"),
    LegendKey("rotation", "rotation", dashes=_LOOKS["rotation"][1], marker="diamond"),
    LegendKey("both together", "combined"),
)
_SUBSCRIPTS = str.maketrans("0123456789,", "₀₁₂₃₄₅₆₇₈₉ ")


@dataclass(frozen=True)
class Look:
    """How elements are drawn."""

    elements: tuple[str, ...] = ()  # labels; empty for all
    x: str = "time"  # or "set point"
    effects: tuple[str, ...] = tuple(_LOOKS)  # names of curves
    marked: bool = False  # whether set points are marked
    hidden: tuple[str, ...] = ("centrifugal", "coriolis")  # curves that a page shows only when asked for

    def __post_init__(self) -> None:
        for field_name, words, allowed in (
            ("x", (self.x,), ABSCISSAE),
            ("effects", self.effects, tuple(_LOOKS)),
        ):
            for name in words:
                if name not in allowed:
                    expected = ", ".join(allowed)
                    raise UsageError(
                        f"there is no {name!r} to draw", where=field_name, expected=expected, found=name
                    )

    def chosen(self, run: Elements, quantity: str) -> list[Element]:
        """Elements of a quantity that are asked for; UsageError for an unknown label."""
        by_label = {e.label: e for e in elements(run.n_joints) if e.quantity == quantity}
        for label in self.elements:
            if label not in by_label:
                expected = f"one of {', '.join(by_label)}"
                raise UsageError("there is no such element", where="elements", expected=expected, found=label)
        return [by_label[label] for label in self.elements or by_label]


ABSCISSAE = ("time", "set point")
# Most set points that are marked.
MOST_MARKED_SET_POINTS = 50
# Most elements of a vector in one row.
_MOST_PANELS_PER_ROW = 7
# Height of all panels of D and h, pt: a page without its captions and legends.
_PAGE_HEIGHT = 600.0
USUAL_LOOK = Look()


def inertia_figure(run: Elements, look: Look = USUAL_LOOK) -> Figure:
    """Elements of D by effect, row by row of the upper triangle; [FGL87] Fig. 3.10."""
    return _in_rows(run, "Mass matrix by effect", look.chosen(run, "inertia"), look)


def vector_figure(run: Elements, quantity: str, look: Look = USUAL_LOOK) -> Figure:
    """Elements of a vector, "coriolis_centrifugal" ([FGL87] Fig. 3.11) or "gravity_loading"."""
    words = {"coriolis_centrifugal": "Coriolis and centrifugal vector by effect"}
    return _in_rows(run, words.get(quantity, "Gravity loading vector"), look.chosen(run, quantity), look)


def _in_rows(run: Elements, label: str, chosen: Sequence[Element], look: Look) -> Figure:
    """Panels of one size, so that all of D and h fill one page."""
    n = run.n_joints
    most = max(math.isqrt(n * (n + 3) // 2), 3)
    of_vector = n if n <= _MOST_PANELS_PER_ROW else most
    rows = -(-n * (n + 1) // 2 // most) + -(-n // of_vector)
    columns = min(len(chosen), most if chosen[0].quantity == "inertia" else of_vector)
    panels = [_panel(run, element, FIGURE_WIDTH / columns, look) for element in chosen]
    legend = _legend(look) if chosen[0].quantity != "gravity_loading" else ()
    return in_columns(label, panels, columns, min(_PAGE_HEIGHT / rows, 110.0), legend)


def _legend(look: Look) -> tuple[LegendKey, ...]:
    return tuple(key for key in _LEGEND if key.colour in look.effects and key.colour not in look.hidden)


def element_curves(run: Elements, element: Element) -> dict[str, FloatArray]:
    """Values of an element at the set points that are drawn, shape (N,) each.

    "combined" for every element, "translation" and "rotation" for D and h, and the shares "centrifugal" and
    "coriolis" for h. A part that is zero in the ranking is zero here.
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


def _rank(run: Elements, element: Element) -> int:
    return int(np.flatnonzero(run.dominance.element.values == element.label)[0])


def _panel(run: Elements, element: Element, pitch: float, look: Look) -> Panel:
    """Translation, rotation and both together, titled by label, unit and verdict."""
    rank = _rank(run, element)
    unit, peak, verdict = (run.dominance[name].values[rank] for name in ("unit", "peak", "verdict"))
    curves, points = element_curves(run, element), run.drawn[0]
    curves = {role: curve for role, curve in curves.items() if role in look.effects}
    time, gaps = run.time[points], run.gaps_among(points)
    axis = time_axis(time, 2)
    if look.x == "set point":
        time = 1.0 + points.astype(float)
        last = float(time[-1])
        # Labels in the first half leave room for the name of the axis behind the last one.
        between = ticks(1.0, last, 3) if last > 1.0 and pitch > 90.0 else []
        labels = (1.0, *(k for k in between if 1.0 < k <= last / 2), last)
        axis = Axis(0.5, last + 0.5, tuple(dict.fromkeys(labels)), "set point")
    if look.marked:
        axis = replace(axis, dashes=tuple(time.tolist()))
    # An element that is zero up to round-off must not fill its panel with noise.
    factor, unit_text = prefixed(float(peak), str(unit))
    y = value_axis(unit, *curves.values()) if peak else Axis(-1.0, 1.0, (0.0,))
    y = replace(y, unit=pretty(unit_text), factor=factor)
    items: list[Item] = []
    for role, curve in curves.items():
        width, dashes = _LOOKS[role]
        more = {"dashes": dashes, "label": role, "role": role, "hidden": role in look.hidden}
        items.append(over_time(time, curve, gaps, role, width, **more))
        if look.marked and role in _MARKS:
            marker, size, step = _MARKS[role]
            look_of_marks: dict[str, Any] = {"marker": marker, "size": size, "hollow": role == "rotation"}
            items.append(Curve(time[::step], curve[::step], role, 0.0, role=role, **look_of_marks))
    return Panel(
        element.label,
        subscripted(element.label),
        axis,
        y,
        tuple(items),
        LETTERS[verdict] if element.quantity != "gravity_loading" else "",
        f"{verdict}-text" if f"{verdict}-text" in COLOURS else "ink",
        margins=(22.0, 11.0, 5.0, 13.0),
    )
