"""Operations against error: what every level gives for smaller and larger budgets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gd_analyze.report.colours import GREY, INK, OF_LEVEL, ON_PAPER, PALE
from gd_analyze.report.panel import (
    WIDTH,
    Panel,
    add_line,
    add_segments,
    add_text,
    new_figure,
    tick_label,
)
from gd_analyze.results import Findings
from gd_analyze.results.words import kind_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 180.0

# Errors below this share of the largest stand at the axis: they would leave no room for the others.
_DECADES = 4

_MARKERS = {"square": "s", "circle": "o", "diamond": "D"}


@dataclass(frozen=True)
class _Axis:
    """A range of positive values on a logarithmic axis, or of any from 0 on a linear one."""

    low: float
    high: float
    is_logarithmic: bool

    @classmethod
    def around(cls, values: list[float], decades: float = math.inf) -> _Axis:
        positive = [value for value in values if 0 < value < math.inf]
        if not positive:
            return cls(0.0, 1.0, False)
        high = max(positive)
        low = min(value for value in positive if value >= high / 10**decades)
        if min(values) <= 0 and decades == math.inf:
            return cls(0.0, 1.1 * high, False)
        room = max((high / low) ** 0.07, 1.15)
        return cls(low / room, high * room, True)

    def place(self, value: float) -> float:
        """From 0 at the low end to 1 at the high one; what lies outside stands at the end."""
        value = min(max(value, self.low), self.high)
        if self.is_logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    @property
    def ticks(self) -> list[float]:
        """Round values: 1, 2 and 5 of every decade, or of the decade alone where that is enough."""
        if not self.is_logarithmic:
            return [self.low, self.high / 1.1] if self.high > 1.0 else [0.0]
        decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        chosen = (1, 2, 5) if len(decades) < 6 else (1,)
        return [f * 10.0**d for d in decades for f in chosen if self.low <= f * 10.0**d <= self.high]


def trade_off_figure(findings: Findings) -> Figure:
    """Operations against largest error, one line per level and refit, and the report's own model."""
    model, table = findings.model, findings.tables["trade_off"]
    errors, operations = 100 * table.largest_share.values, table.operations.values.astype(float)
    own = (100 * float(model.promise.errors.largest_share.max(initial=0.0)), float(model.operations.total))
    exact = findings.model.operations_full.total
    across = _Axis.around([own[0], *errors.ravel()], _DECADES)
    upward = _Axis.around([own[1], *operations.ravel(), float(exact)])
    figure = new_figure(WIDTH, HEIGHT)
    panel = Panel(34.0, 24.0, WIDTH - 34.0 - 96.0, HEIGHT - 24.0 - 16.0, (0.0, 1.0), (0.0, 1.0))
    _frame(figure, panel, across, upward)
    height = upward.place(exact)
    add_line(figure, panel, (0, 1), (height, height), color=INK, linewidth=0.8, dashes=(1, 1.6))
    names = [(height, f"exact: {exact}", INK)]
    for level, refit, error, count in zip(
        table.level.values, table.refit.values, errors, operations, strict=True
    ):
        x, y = [*map(across.place, error)], [*map(upward.place, count)]
        series, mark = OF_LEVEL[level]
        colour, name = ON_PAPER[series], kind_name(level, refit)
        add_line(
            figure,
            panel,
            x,
            y,
            color=colour,
            linewidth=1.3,
            marker=_MARKERS[mark],
            markersize=3.6,
            markeredgecolor=colour,
            markeredgewidth=0.9,
            label=name,
            zorder=3,
            linestyle=(0, (3.2, 1.6)) if refit else "-",
            markerfacecolor="white" if refit else colour,
        )
        names.append((y[-1], name, colour))
    add_line(
        figure,
        panel,
        (across.place(own[0]),),
        (upward.place(own[1]),),
        color=ON_PAPER["accent"],
        linestyle="none",
        marker="*",
        markersize=11,
        markeredgecolor="white",
        markeredgewidth=0.7,
        label="this report's model",
        zorder=5,
    )
    _name(figure, panel, names)
    return figure


def _frame(figure: Figure, panel: Panel, across: _Axis, upward: _Axis) -> None:
    left, bottom = panel.left, panel.bottom
    right, top = left + panel.width, bottom + panel.height
    x_at = {value: left + across.place(value) * panel.width for value in across.ticks}
    y_at = {value: bottom + upward.place(value) * panel.height for value in upward.ticks}
    grid = [(left, y, right, y) for y in y_at.values()] + [(x, bottom, x, top) for x in x_at.values()]
    add_segments(figure, grid, color=PALE, linewidth=0.5, zorder=1)
    add_segments(figure, [(left, bottom, right, bottom)], color=GREY, linewidth=0.6, zorder=1)
    for value, y in y_at.items():
        add_text(figure, left - 4, y - 2.2, tick_label(value), 6.5, ha="right", color=GREY)
    for value, x in x_at.items():
        add_text(figure, x, bottom - 9, tick_label(value), 6.5, ha="center", color=GREY)
    add_text(figure, 0, HEIGHT - 8, "operations (multiplications and additions)", 7.5)
    add_text(figure, right, 4, "largest error along the trajectory, % of peak torque", 7.5, ha="right")


def _name(figure: Figure, panel: Panel, names: list[tuple[float, str, str]]) -> None:
    """Write the lines' names beside their right ends, none over another."""
    gap, right = 9.0, panel.left + panel.width
    below = -math.inf
    for height, name, colour in sorted(names):
        y = max(panel.bottom + height * panel.height - 2.5, below + gap)
        add_text(figure, right + 6, y, name, 7, color=colour)
        below = y
