"""Elements of D, h and c by effect over time: the founding text's Figs 3.10 and 3.11."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.errors import UsageError
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

# Dash and width distinguish curves in grey print.
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


@dataclass(frozen=True)
class Look:
    """How elements are drawn."""

    elements: tuple[str, ...] = ()  # labels; empty for all
    x: str = "time"  # or "set point"
    effects: tuple[str, ...] = tuple(_LOOKS)  # names of curves
    marked: bool = False  # whether set points are marked

    def __post_init__(self) -> None:
        for what, given, known in (("x", (self.x,), ABSCISSAE), ("effects", self.effects, tuple(_LOOKS))):
            for name in given:
                if name not in known:
                    expected = ", ".join(known)
                    raise UsageError(
                        f"there is no {name!r} to draw", where=what, expected=expected, found=name
                    )

    def chosen(self, run: Run, quantity: str) -> list[Element]:
        """Elements of a quantity that are asked for; UsageError for an unknown label."""
        there = {e.label: e for e in elements(run.arm.n_joints) if e.quantity == quantity}
        for label in self.elements:
            if label not in there:
                expected = f"one of {', '.join(there)}"
                raise UsageError("there is no such element", where="elements", expected=expected, found=label)
        return [there[label] for label in self.elements or there]


ABSCISSAE = ("time", "set point")
# Most set points that are marked.
MARKED = 50
USUAL = Look()


def inertia_figure(run: Run, look: Look = USUAL) -> Figure:
    """Elements of D by effect: the whole upper triangle, each at its place in the matrix, or some in rows."""
    n, chosen = run.arm.n_joints, look.chosen(run, "inertia")
    if look.elements:
        return _in_rows(run, "Mass matrix by effect", chosen, look)
    rows: list[list[Panel | None]] = [[None] * n for _ in range(n)]
    pitch = min(WIDTH / n, 165.0)
    for element in chosen:
        i, j = element.index
        rows[i][j] = _panel(run, element, pitch, look)
    height = min(1.3 * pitch, 580.0 / n, 130.0)  # with heading and note on a page
    return Figure("Mass matrix by effect", tuple(map(tuple, rows)), pitch, height, _legend(look))


def vector_figure(run: Run, quantity: str, look: Look = USUAL) -> Figure:
    """Elements of a vector over time, "coriolis_centrifugal" or "gravity_loading"."""
    words = {"coriolis_centrifugal": "Coriolis and centrifugal vector by effect"}
    return _in_rows(run, words.get(quantity, "Gravity loading vector"), look.chosen(run, quantity), look)


def _in_rows(run: Run, label: str, chosen: Sequence[Element], look: Look) -> Figure:
    columns = min(len(chosen), 3 if len(chosen) <= 9 else 4)
    height = min(250.0 / -(-len(chosen) // columns), 110.0)
    panels = [_panel(run, element, WIDTH / columns, look) for element in chosen]
    legend = _legend(look) if look != USUAL and chosen[0].quantity != "gravity_loading" else ()
    return in_columns(label, panels, columns, height, legend)


def _legend(look: Look) -> tuple[Key, ...]:
    return tuple(key for key in _LEGEND if key.colour in look.effects)


def element_curves(run: Run, element: Element) -> dict[str, FloatArray]:
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


def _rank(run: Run, element: Element) -> int:
    return int(np.flatnonzero(run.dominance.element.values == element.label)[0])


def _panel(run: Run, element: Element, pitch: float, look: Look) -> Panel:
    """Translation, rotation and both together, titled by label, unit and verdict."""
    rank, is_narrow = _rank(run, element), pitch < 60.0
    unit, peak, verdict = (run.dominance[name].values[rank] for name in ("unit", "peak", "verdict"))
    curves, points = element_curves(run, element), run.drawn[0]
    curves = {role: curve for role, curve in curves.items() if role in look.effects}
    time, gaps = run.trajectory.time[points], run.gaps_among(points)
    axis = time_axis(time, 2)
    if look.x == "set point":
        time = 1.0 + points.astype(float)
        axis = replace(time_axis(time, 1 if pitch < 120.0 else 3), unit="set point")
    # An element that is zero up to round-off must not fill its panel with noise.
    factor, shown = prefixed(float(peak), str(unit))
    y = value_axis(unit, *curves.values()) if peak else Axis(-1.0, 1.0, (0.0,))
    y = replace(y, unit=pretty(shown), factor=factor)
    items = []
    for role, curve in curves.items():
        width, dashes = _LOOKS[role]
        hidden, width = role in ("centrifugal", "coriolis"), width * (0.6 if is_narrow else 1.0)
        more = {"dashes": dashes, "label": role, "role": role, "hidden": hidden and len(curves) > 2}
        is_marked = look.marked and (role != "combined" or len(curves) == 1)
        marks = {"marker": "circle", "size": width + (0.9 if is_narrow else 1.3)} if is_marked else {}
        items.append(over_time(time, curve, gaps, role, width, **more, **marks))
    return Panel(
        element.label,
        subscripted(element.label),
        axis,
        y,
        tuple(items),
        LETTERS[verdict] if element.quantity != "gravity_loading" else "",
        f"{verdict}-text" if f"{verdict}-text" in COLOURS else "ink",
        margins=(14.0, 8.0, 2.0, 9.0) if is_narrow else (22.0, 11.0, 5.0, 13.0),
        text=4.0 if is_narrow else 6.0,
    )
