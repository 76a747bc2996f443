"""A plot panel placed by hand on a figure: range, frame, ticks and curves.

A report has some fifty panels. As matplotlib Axes they would take longer than everything else in the
report together; as artists put straight on the figure they take a tenth of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.formatting import pretty
from gd_analyze.report.colours import GREY, INK, ON_PAPER, PALE
from gd_analyze.report.thinning import thinned
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Transform


# Set points to draw of a long trajectory: some four per point (1/72 in) of a wide panel.
MOST_POINTS = 500

# Type area of the page, pt; a heading and a legend stand above the figure.
WIDTH, PAGE_HEIGHT = 493.0, 660.0

# Dash and width tell curves apart in greyscale.
CURVES: dict[str, dict[str, Any]] = {
    "combined": {"color": ON_PAPER["combined"], "linewidth": 2.6, "solid_capstyle": "butt"},
    "translation": {"color": ON_PAPER["translation"], "linewidth": 1.1},
    "rotation": {"color": ON_PAPER["rotation"], "linewidth": 1.1, "dashes": (3.0, 1.5)},
}


@dataclass(frozen=True)
class Panel:
    """Where a plot is on its figure (pt from the lower left corner) and what range it shows."""

    left: float
    bottom: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    def transform(self, figure: Figure) -> Transform:
        """From data to the figure."""
        from matplotlib.transforms import Affine2D

        to_points = (
            Affine2D()
            .translate(-self.x[0], -self.y[0])
            .scale(self.width / (self.x[1] - self.x[0]), self.height / (self.y[1] - self.y[0]))
            .translate(self.left, self.bottom)
            .scale(1 / 72)
        )
        return to_points + figure.dpi_scale_trans


_IN_POINTS = Panel(0, 0, 1, 1, (0, 1), (0, 1))


def new_figure(width: float, height: float) -> Figure:
    """Empty figure, sizes in pt."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / 72, height / 72), dpi=72)


def add_text(figure: Figure, x: float, y: float, text: str, size: float = 7, **style: Any) -> None:
    """Write at a place in pt; a dollar sign is a dollar sign."""
    style.setdefault("color", INK)
    style.setdefault("va", "baseline")
    width, height = figure.get_size_inches() * 72
    figure.text(x / width, y / height, text, fontsize=size, parse_math=False, rotation_mode="anchor", **style)


def add_line(figure: Figure, panel: Panel, x: Any, y: Any, **style: Any) -> None:
    """Draw a line in the panel's coordinates; a single point is drawn as a dot."""
    from matplotlib.lines import Line2D

    if len(x) == 1:
        style.setdefault("marker", "o")
        style.setdefault("markersize", 2.0 + style.get("linewidth", 1.0))
    figure.add_artist(Line2D(x, y, transform=panel.transform(figure), **style))


def add_curve(figure: Figure, panel: Panel, x: FloatArray, y: FloatArray, **style: Any) -> None:
    """Draw a curve over the set points, thinned where it is long."""
    chosen = thinned(y[None], MOST_POINTS)
    add_line(figure, panel, x[chosen], y[chosen], **style)


def add_segments(figure: Figure, segments: Sequence[tuple[float, float, float, float]], **style: Any) -> None:
    """Draw straight lines from (x, y) to (x, y), in pt, as one artist: each costs as much as a curve."""
    if not segments:
        return
    ends = np.full((len(segments), 3, 2), np.nan)
    ends[:, :2] = np.reshape(segments, (-1, 2, 2))
    add_line(figure, _IN_POINTS, *ends.reshape(-1, 2)[:-1].T, **style)


def add_frame(
    figure: Figure,
    panel: Panel,
    *,
    x_ticks: Sequence[float] = (),
    y_ticks: Sequence[float] = (),
    labels: str = "xy",
    power: int = 0,
    size: float = 6,
) -> None:
    """Draw baseline, zero line, ticks and the labels of the axes named; those of y in units of 10^power."""
    left, bottom, top = panel.left, panel.bottom, panel.bottom + panel.height
    right = left + panel.width
    x_at = np.interp(x_ticks, panel.x, (left, right))
    y_at = np.interp(y_ticks, panel.y, (bottom, top))
    add_segments(figure, [(left, y, right, y) for y in y_at], color=PALE, linewidth=0.5, zorder=1)
    if panel.y[0] < 0 < panel.y[1]:
        zero = float(np.interp(0.0, panel.y, (bottom, top)))
        add_segments(figure, [(left, zero, right, zero)], color=GREY, linewidth=0.5, zorder=1)
    add_segments(
        figure,
        [(left, bottom, right, bottom), *((x, bottom, x, bottom - 2) for x in x_at)],
        color=GREY,
        linewidth=0.6,
        zorder=1,
    )
    if "x" in labels:
        for x, value in zip(x_at, x_ticks, strict=True):
            add_text(figure, x, bottom - size - 2.5, tick_label(value), size, ha="center", color=GREY)
    if "y" in labels:
        for y, value in zip(y_at, y_ticks, strict=True):
            label = tick_label(value / 10.0**power)
            add_text(figure, left - 2.5, y - 0.32 * size, label, size, ha="right", color=GREY)


def value_range(*curves: FloatArray, floor: float = 0.0) -> tuple[float, float]:
    """Range that holds the curves and zero, with room at both ends; (-1, 1) where nothing exceeds `floor`."""
    low = min(0.0, *(float(np.min(c)) for c in curves))
    high = max(0.0, *(float(np.max(c)) for c in curves))
    if max(high, -low) <= floor or high == low:
        return (-1.0, 1.0)
    room = 0.07 * (high - low)
    return (low - room, high + room)


def ticks(span: tuple[float, float], most: int = 3) -> list[float]:
    """Return few round values inside a range."""
    from matplotlib.ticker import MaxNLocator

    values = MaxNLocator(most, steps=[1, 2, 5, 10]).tick_values(*span)
    slack = 1e-9 * (span[1] - span[0])
    return [float(v) for v in values if span[0] - slack <= v <= span[1] + slack]


def power_of_ten(span: tuple[float, float]) -> int:
    """Power of ten to set apart so that tick labels stay short; 0 where they are short without."""
    exponent = int(np.floor(np.log10(max(abs(span[0]), abs(span[1])))))
    return 0 if -1 <= exponent <= 3 else exponent


def tick_label(value: float) -> str:
    """Shortest text of a round value, with a true minus sign."""
    return f"{round(value, 9):g}".replace("-", "−")


def whole_range(values: FloatArray) -> tuple[float, float]:
    """First to last value; some width around a single one."""
    first, last = float(values[0]), float(values[-1])
    return (first, last) if last > first else (first - 0.5, first + 0.5)


def scaled(unit: str, power: int) -> str:
    """Write the unit, with its power of ten where one was set apart."""
    unit = pretty(unit)
    return unit if power == 0 else pretty(f"1e{power:+d}").removeprefix("1 ") + f" {unit}"
