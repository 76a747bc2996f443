"""A plot panel on a drawing: range, frame, ticks and curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.report.canvas import Canvas, Frame
from gd_analyze.report.thinning import breaks, broken, thinned
from gd_analyze.text import prefixed, pretty

# Set points to draw of a long trajectory: some four per point (1/72 in) of a wide panel.
MOST_POINTS = 500

# Type area of the page, pt; a heading and a legend stand above the figure.
WIDTH, PAGE_HEIGHT = 493.0, 660.0


@dataclass(frozen=True)
class Panel:
    """Where a plot is on its figure (pt from the lower left corner) and what range it shows."""

    left: float
    bottom: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    @property
    def top(self) -> float:
        """Upper end, pt."""
        return self.bottom + self.height

    @property
    def right(self) -> float:
        """Right end, pt."""
        return self.left + self.width

    def across(self, x: FloatArray) -> FloatArray:
        """Where values of the abscissa stand, pt."""
        return self.left + (np.asarray(x) - self.x[0]) * (self.width / (self.x[1] - self.x[0]))

    def upward(self, y: FloatArray) -> FloatArray:
        """Where values of the ordinate stand, pt."""
        return self.bottom + (np.asarray(y) - self.y[0]) * (self.height / (self.y[1] - self.y[0]))

    def place(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Where points stand, pt, shape (N, 2)."""
        return np.stack([self.across(x), self.upward(y)], axis=-1)


@dataclass(frozen=True)
class Scale:
    """Unit in which a range is labelled, and what one of it is in the unit of the values."""

    factor: float
    unit: str

    @classmethod
    def of(cls, span: tuple[float, float], unit: str) -> Scale:
        """Choose the prefix that keeps tick labels short."""
        factor, unit = prefixed(max(abs(span[0]), abs(span[1])), unit)
        return cls(factor, pretty(unit))

    def label(self, value: float) -> str:
        """Shortest text of a round value, with a true minus sign."""
        return tick_label(value / self.factor)


PLAIN = Scale(1.0, "")


def add_curve(
    canvas: Canvas,
    panel: Panel,
    x: FloatArray,
    y: FloatArray,
    colour: str,
    width: float,
    *,
    dashes: Sequence[float] = (),
    label: str = "",
    gaps: Sequence[int] | NDArray[np.intp] = (),
) -> None:
    """Draw a curve over the set points, thinned where it is long, and broken before those of `gaps`."""
    chosen = thinned(y[None], MOST_POINTS)
    points = broken(panel.place(x[chosen], y[chosen]), breaks(chosen, gaps))
    canvas.line(points, colour, width, dashes=dashes, label=label)


def add_frame(
    canvas: Canvas,
    panel: Panel,
    *,
    x_ticks: Sequence[float] = (),
    y_ticks: Sequence[float] = (),
    labels: str = "xy",
    scale: Scale = PLAIN,
    size: float = 6,
) -> None:
    """Draw baseline, zero line, ticks and the labels of the axes named; those of y in units of the scale."""
    canvas.frames.append(Frame((panel.left, panel.bottom, panel.width, panel.height), panel.x, panel.y))
    left, right, bottom = panel.left, panel.right, panel.bottom
    x_at, y_at = panel.across(np.array(x_ticks)).tolist(), panel.upward(np.array(y_ticks)).tolist()
    canvas.segments([(left, y, right, y) for y in y_at], "line", 0.5)
    if panel.y[0] < 0 < panel.y[1]:
        zero = float(panel.upward(np.array(0.0)))
        canvas.segments([(left, zero, right, zero)], "soft", 0.5)
    base = [(left, bottom, right, bottom), *((x, bottom, x, bottom - 2) for x in x_at)]
    canvas.segments(base, "soft", 0.6)
    if "x" in labels:
        for x, value in zip(x_at, x_ticks, strict=True):
            canvas.text(x, bottom - size - 2.5, tick_label(value), size, colour="soft", anchor="middle")
    if "y" in labels:
        for y, value in zip(y_at, y_ticks, strict=True):
            canvas.text(left - 2.5, y - 0.32 * size, scale.label(value), size, colour="soft", anchor="end")


def value_range(*curves: FloatArray, floor: float = 0.0) -> tuple[float, float]:
    """Range that holds the curves and zero, with room at both ends; (-1, 1) where nothing exceeds `floor`."""
    low = min(0.0, *(float(np.min(c)) for c in curves))
    high = max(0.0, *(float(np.max(c)) for c in curves))
    if max(high, -low) <= floor or high == low:
        return (-1.0, 1.0)
    room = 0.07 * (high - low)
    return (low - room, high + room)


def ticks(span: tuple[float, float], most: int = 3) -> list[float]:
    """Return round values inside a range: 1, 2 or 5 of a decade apart, and at most one more than so many."""
    width = span[1] - span[0]
    # A round value may have come out a rounding outside the range whose end it is.
    low, high = span[0] - 1e-9 * width, span[1] + 1e-9 * width
    decade = 10.0 ** (math.floor(math.log10(width / most)) - 1)
    found: list[float] = []
    for lead in (5, 10, 20, 50, 100):
        step = lead * decade
        found = [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
        if len(found) <= most + 1:
            break
    return found


def tick_label(value: float) -> str:
    """Shortest text of a round value, with a true minus sign."""
    return f"{round(value, 9) + 0.0:g}".replace("-", "−")


def whole_range(values: FloatArray) -> tuple[float, float]:
    """First to last value; some width around a single one."""
    first, last = float(values[0]), float(values[-1])
    return (first, last) if last > first else (first - 0.5, first + 0.5)
