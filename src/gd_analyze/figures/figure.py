"""A figure as a value: panels with axes, curves, areas and marks, in units of the drawn numbers.

`gd_analyze.figures.svg` draws it for page and paper, `gd_analyze.figures.axes` with matplotlib. One table of
colours serves these, the page's style and Typst's templates: translation and rotation have Okabe and Ito's
blue and vermillion, which all forms of colour vision distinguish, lightened on dark paper; colours of text
have a contrast of 4.5 to 1.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.parts import Joint
from gd_analyze.text import joint_name, prefixed, pretty, short_names

# Name: colour on light and on dark paper.
COLOURS: dict[str, list[str]] = json.loads(
    (Path(__file__).parent / "colours.json").read_text(encoding="utf-8")
)
ON_PAPER = {name: light for name, (light, _) in COLOURS.items()}
# Width of the type area of a page, pt.
FIGURE_WIDTH = 493.0

# Hatching of what makes a torque; translation has none.
HATCHING = {"rotation": "/", "both": "/\\", "gravity": "|", "drive": "-", "drives": "-"}
# Distance of the lines, pt.
_HATCH_SPACING = 2.6
# Height of a row of cells; the rest separates it from the next.
CELL_HEIGHT = 0.9

Anchor = Literal["start", "middle", "end"]
Marker = Literal["circle", "square", "triangle", "diamond", "cross", "star"]
Margins = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through points, interrupted where y is nan."""

    x: FloatArray  # (N,)
    y: FloatArray  # (N,)
    colour: str = "ink"  # name in `COLOURS`
    width: float = 1.1  # pt; 0 for marks only
    dashes: tuple[float, ...] = ()
    label: str = ""  # meaning of the line, whose values a page shows; "" for a line without data
    role: str = ""  # word with which a page shows and hides it
    hidden: bool = False  # whether it is shown only when asked for
    marker: Marker | None = None  # at every point
    size: float = 3.6  # of marks, pt
    hollow: bool = False
    tips: tuple[str, ...] = ()  # text of each mark on a page
    opacity: float = 1.0  # from 0 to 1
    space: FloatArray | None = None  # (N, 3), m: points of the line in space, for a page that turns them


@dataclass(frozen=True, eq=False)
class Area:
    """Area between two curves over x, shape (N,) each; interrupted where nan."""

    x: FloatArray
    near: FloatArray
    far: FloatArray
    colour: str
    label: str = ""
    hatching: str = ""  # slopes of its lines, see `hatching`


@dataclass(frozen=True, eq=False)
class Cells:
    """Rows of coloured cells over x: row k begins at y = k."""

    x: FloatArray  # edges, (N + 1,)
    colours: np.ndarray  # names of colours, "" for an empty cell, (R, N)
    opacity: FloatArray  # (R, N), from 0 to 1
    words: tuple[str, ...]  # text of a row's cells on a page, with {0}, {1}, ... for their numbers
    numbers: FloatArray  # (R, N, numbers), as shown
    hatching: Mapping[str, str] = field(default_factory=dict)  # slopes of lines by colour


@dataclass(frozen=True)
class FigureWords:
    """Text at a point of a panel, moved by some pt to the right and up."""

    x: float
    y: float
    text: str
    colour: str = "soft"
    anchor: Anchor = "start"
    size: float = 6.0
    right: float = 0.0
    up: float = 0.0
    bold: bool = False
    italic: bool = False
    space: tuple[float, float, float] | None = None


Item = Curve | Area | Cells | FigureWords


@dataclass(frozen=True)
class Axis:
    """A range of numbers with ticks, and the unit of their labels."""

    low: float
    high: float
    ticks: tuple[float, ...] = ()  # values with a label
    unit: str = ""  # of labels
    factor: float = 1.0  # one unit of the labels in units of the numbers
    is_logarithmic: bool = False  # whether equal distances are equal ratios
    grid: bool = False  # whether every tick has a line across the panel
    dashes: tuple[float, ...] = ()  # values marked by a short dash without a label
    names: tuple[str, ...] = ()  # labels that are not numbers

    def place(self, values: FloatArray) -> FloatArray:
        """Position of values, from 0 at the low end to 1 at the high end."""
        if self.is_logarithmic:
            low, high = math.log10(self.low), math.log10(self.high)
            return (np.log10(np.maximum(values, self.low)) - low) / (high - low)
        return (np.asarray(values) - self.low) / (self.high - self.low)

    @property
    def labels(self) -> tuple[str, ...]:
        """Text of every tick."""
        return self.names or tuple(tick_label(value / self.factor) for value in self.ticks)


@dataclass(frozen=True, eq=False)
class Panel:
    """One plot: title, axes, and what is drawn, in order."""

    key: str  # name of the panel, such as "D12"
    title: str  # above the panel, followed by the unit of y
    x: Axis
    y: Axis
    items: tuple[Item, ...]
    corner: str = ""  # text above its right end
    corner_colour: str = "soft"
    is_bare: bool = False  # whether no axes are drawn
    margins: Margins = (24.0, 12.0, 6.0, 13.0)  # left, below, right and above, pt
    text: float = 6.0  # size of the labels, pt


@dataclass(frozen=True)
class LegendKey:
    """Entry of a legend: look and meaning."""

    label: str
    colour: str
    kind: Literal["line", "area"] = "line"
    dashes: tuple[float, ...] = ()
    marker: Marker | None = None
    hatching: str = ""  # of an area, see `hatching`


@dataclass(frozen=True, eq=False)
class Figure:
    """Panels of one size in rows and columns, some places empty."""

    label: str  # alternative text for screen readers
    rows: tuple[tuple[Panel | None, ...], ...]  # panels by row
    width: float  # of a panel with its margins, pt
    height: float
    legend: tuple[LegendKey, ...] = ()  # above the panels

    @property
    def places(self) -> list[tuple[int, int, Panel]]:
        """Row, column and panel, row by row."""
        rows = enumerate(self.rows)
        return [(r, c, panel) for r, row in rows for c, panel in enumerate(row) if panel is not None]

    @property
    def panels(self) -> tuple[Panel, ...]:
        """All panels, row by row."""
        return tuple(panel for _, _, panel in self.places)

    @property
    def columns(self) -> int:
        """Panels side by side."""
        return max(map(len, self.rows), default=1)


def in_columns(
    label: str, panels: Sequence[Panel], columns: int, height: float, legend: tuple[LegendKey, ...] = ()
) -> Figure:
    """Arrange panels row by row over the width of a page, none wider than a third of it unless few."""
    rows = tuple(tuple(panels[k : k + columns]) for k in range(0, len(panels), columns))
    return Figure(label, rows, FIGURE_WIDTH / columns, height, legend)


def value_axis(unit: str, *curves: FloatArray, floor: float = 0.0, most: int = 4, zero: bool = True) -> Axis:
    """Axis that contains curves, with room at both ends; its labels have a suitable unit prefix.

    Values up to `floor` are round-off: a range of (-1, 1) shows them as zero.
    """
    values = np.concatenate([np.ravel(curve) for curve in curves] or [np.zeros(1)])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if max(high, -low) <= floor or not high > low:
        middle = 0.0 if zero or not values.size else low
        return Axis(middle - 1.0, middle + 1.0, (middle,), pretty(unit))
    room = max(0.07 * (high - low), 1e-6 * max(abs(low), abs(high)) * (not zero))
    low, high = low - room, high + room
    factor, prefixed_unit = prefixed(max(abs(low), abs(high)), unit)
    return Axis(low, high, tuple(ticks(low, high, most)), pretty(prefixed_unit), factor)


def time_axis(time: FloatArray, most: int = 4) -> Axis:
    """Axis from the first to the last time, s."""
    low, high = float(time[0]), float(time[-1])
    if high <= low:
        low, high = low - 0.5, low + 0.5
    return Axis(low, high, tuple(ticks(low, high, most)), "s")


def decades_axis(low: float, high: float, unit: str = "", most: int = 6) -> Axis:
    """Logarithmic axis with ticks at 1, 2 and 5 of every decade, or at every decade if that is enough."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    leads = (1, 2, 5) if len(decades) < most else (1,)
    candidates = [lead * 10.0**decade for decade in decades for lead in leads]
    chosen = tuple(value for value in candidates if low <= value <= high)
    return Axis(low, high, chosen, unit, is_logarithmic=True, grid=True)


def ticks(low: float, high: float, most: int = 3) -> list[float]:
    """Round values inside a range, 1, 2 or 5 of a decade apart, at most one more than `most`.

    If that leaves a single one, which shows no scale, the next smaller step is used.
    """
    width = high - low
    # Rounding may put a round value at the end of the range outside it.
    low, high = low - 1e-9 * width, high + 1e-9 * width
    decade = 10.0 ** (math.floor(math.log10(width / most)) - 1)
    values: list[float] = []
    for lead in (5, 10, 20, 50, 100):
        step, finer = lead * decade, values
        values = [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
        if len(values) <= most + 1:
            return finer if len(values) < 2 and finer else values
    return values


def tick_label(value: float) -> str:
    """Shortest text of a round value, with a true minus sign."""
    return f"{round(value, 9) + 0.0:g}".replace("-", "−")


def hatching(x: FloatArray, near: FloatArray, far: FloatArray, slopes: str) -> FloatArray:
    r"""Lines across the area between two curves, which tell areas apart in grey print.

    `slopes` holds some of "/", "\", "-" and "|". Coordinates are in pt, x rises, shape (N,) each. Returns the
    lines' ends, shape (L, 2, 2); lines of neighbouring areas continue each other.
    """
    low, high = np.minimum(near, far), np.maximum(near, far)
    across = np.linspace(x[0], x[-1], 2 + math.ceil(2.0 * (x[-1] - x[0])))
    floor, top = np.interp(across, x, low), np.interp(across, x, high)
    lines = []
    for slope in slopes:
        pitch = _HATCH_SPACING if slope in "-|" else _HATCH_SPACING * math.sqrt(2.0)
        if slope == "|":
            at = pitch * np.arange(math.ceil(x[0] / pitch), x[-1] / pitch)
            lines.append(np.stack([[at, at], [np.interp(at, x, low), np.interp(at, x, high)]]).T)
            continue
        rise = {"/": 1.0, "-": 0.0, "\\": -1.0}[slope] * across
        starts = np.arange(math.ceil((floor - rise).min() / pitch), (top - rise).max() / pitch)
        height = pitch * starts[:, None] + rise
        inside = np.pad((floor < height) & (height < top), ((0, 0), (1, 1)))
        ends = np.diff(inside, axis=1)
        # Every line enters and leaves the area as often.
        line, place = np.nonzero(ends)
        place[1::2] -= 1
        lines.append(np.stack([across[place], height[line, place]], axis=-1).reshape(-1, 2, 2))
    return np.concatenate(lines) if lines else np.empty((0, 2, 2))


def broken(values: FloatArray, gaps: Sequence[int] | np.ndarray) -> FloatArray:
    """Insert nan before each set point of `gaps`, so that a curve is interrupted there."""
    places = np.asarray(gaps, dtype=int)
    return np.insert(np.asarray(values, dtype=float), places, np.nan, axis=-1) if places.size else values


def over_time(
    time: FloatArray,
    values: FloatArray,
    gaps: Sequence[int] | np.ndarray,
    colour: str = "ink",
    width: float = 1.1,
    **more: Any,
) -> Curve:
    """A curve interrupted before each set point of `gaps`; `more` are fields of `Curve`."""
    return Curve(broken(time, gaps), broken(values, gaps), colour, width, **more)


def short_joint_label(joints: Sequence[Joint], i: int, room: float, size: float = 7.0) -> str:
    """Number and short name of a joint, from 0; if too long for the width, pt, its distinctive end."""
    names = short_names([joint.name for joint in joints])
    name, most = names[i], max(int(room / (0.5 * size)) - 2, 3)
    ends = zip(*(text[::-1] for text in names), strict=False)
    alike = sum(1 for _ in takewhile(lambda signs: len(set(signs)) == 1, ends))
    if len(name) > most and len(joints) > 1 and alike:
        name = f"{name[:-alike]}…"
    return joint_name(i + 1, name if len(name) <= most else f"…{name[1 - most :]}")
