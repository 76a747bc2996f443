"""Operations against error: what every level gives for smaller and larger budgets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gd_analyze.report.canvas import Canvas
from gd_analyze.report.colours import OF_LEVEL
from gd_analyze.report.panel import WIDTH, Panel, tick_label
from gd_analyze.results.findings import Findings
from gd_analyze.results.words import kind_name

HEIGHT = 180.0

# Errors below this share of the largest stand at the axis: they would leave no room for the others.
_DECADES = 4


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


def trade_off_figure(findings: Findings) -> Canvas:
    """Operations against largest error, one line per level and refit, and the report's own model."""
    model, table = findings.model, findings.tables["trade_off"]
    errors, operations = 100 * table.largest_share.values, table.operations.values.astype(float)
    own = (100 * float(model.accuracy.shares.max(initial=0.0)), float(model.operations.total))
    exact = findings.model.operations_full.total
    across = _Axis.around([own[0], *errors.ravel()], _DECADES)
    upward = _Axis.around([own[1], *operations.ravel(), float(exact)])
    canvas = Canvas(WIDTH, HEIGHT)
    panel = Panel(34.0, 24.0, WIDTH - 34.0 - 96.0, HEIGHT - 24.0 - 16.0, (0.0, 1.0), (0.0, 1.0))
    _frame(canvas, panel, across, upward)
    told = f"largest error along the trajectory, % of the {model.accuracy.asked.shares_of}"
    canvas.text(panel.right, 4, told, 7.5, anchor="end")
    height = upward.place(exact)
    at = float(panel.upward(np.array(height)))
    canvas.line(np.array([[panel.left, at], [panel.right, at]]), "ink", 0.8, dashes=(1, 1.6))
    names = [(height, f"exact: {exact}", "ink")]
    kinds = zip(table.level.values, table.refit.values, errors, operations, strict=True)
    for level, refit, error, count in kinds:
        points = panel.place(np.array([*map(across.place, error)]), np.array([*map(upward.place, count)]))
        (colour, shape), name = OF_LEVEL[level], kind_name(level, refit)
        canvas.line(points, colour, 1.3, dashes=(3.2, 1.6) if refit else (), order=3, label=name)
        canvas.mark(points, colour, 3.6, shape=shape, fill="paper" if refit else colour, edge=0.9, order=3.1)
        names.append((upward.place(count[-1]), name, colour))
    star = panel.place(np.array([across.place(own[0])]), np.array([upward.place(own[1])]))
    canvas.mark(
        star, "paper", 11, shape="star", fill="accent", edge=0.7, order=5, label="this report's model"
    )
    _name(canvas, panel, names)
    return canvas


def _frame(canvas: Canvas, panel: Panel, across: _Axis, upward: _Axis) -> None:
    left, bottom, right, top = panel.left, panel.bottom, panel.right, panel.top
    x_at = {value: left + across.place(value) * panel.width for value in across.ticks}
    y_at = {value: bottom + upward.place(value) * panel.height for value in upward.ticks}
    grid = [(left, y, right, y) for y in y_at.values()] + [(x, bottom, x, top) for x in x_at.values()]
    canvas.segments(grid, "line", 0.5)
    canvas.segments([(left, bottom, right, bottom)], "soft", 0.6)
    for value, y in y_at.items():
        canvas.text(left - 4, y - 2.2, tick_label(value), 6.5, colour="soft", anchor="end")
    for value, x in x_at.items():
        canvas.text(x, bottom - 9, tick_label(value), 6.5, colour="soft", anchor="middle")
    canvas.text(0, HEIGHT - 8, "operations (multiplications and additions)", 7.5)


def _name(canvas: Canvas, panel: Panel, names: list[tuple[float, str, str]]) -> None:
    """Write the lines' names beside their right ends, none over another."""
    gap, below = 9.0, -math.inf
    for height, name, colour in sorted(names):
        y = max(panel.bottom + height * panel.height - 2.5, below + gap)
        canvas.text(panel.right + 6, y, name, 7, colour=colour)
        below = y
