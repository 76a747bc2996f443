"""Operations over the number of joints, both axes logarithmic, as SVG for page and paper alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args
from xml.sax.saxutils import escape

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.figures.colours import ON_PAPER
from gd_analyze.studies.costs import Counted, Growth

_LEFT, _RIGHT, _TOP, _BOTTOM = 58.0, 98.0, 8.0, 32.0
_LABEL_PITCH = 12.0

# Colour, dash and marker tell the curves apart, so that grey print does as well.
_MARKERS = {
    "lagrange_euler": "square",
    "recursive_lagrangian": "triangle",
    "newton_euler_base": "open",
    "newton_euler_link": "circle",
    "newton_euler_regrouped": "down",
    "generalized_dalembert": "diamond",
    "composite_moments": "cross",
}
_SERIES = {name: f"series-{k}" for k, name in enumerate(_MARKERS, start=1)}


@dataclass(frozen=True)
class Palette:
    """How the names of `gd_analyze.figures.colours` are written in CSS; font as a CSS family; size in px."""

    colour: Callable[[str], str]
    font: str
    width: float
    height: float


SCREEN = Palette("var(--{})".format, "inherit", 510.0, 340.0)
PAPER = Palette(ON_PAPER.__getitem__, "Libertinus Serif", 380.0, 300.0)


def growth_chart(growth: Growth, which: Literal["executed", "folded"], palette: Palette) -> str:
    """Draw the total operations of every method; the founding text's polynomials are dashed.

    Parameters
    ----------
    growth
        Operations on the generic chain.
    which
        As executed, or folded.
    palette
        `SCREEN` or `PAPER`.
    """

    def totals(name: str, counted: Counted) -> list[int]:
        return [count.total for count in growth.counts(name, counted)]

    every = [
        total for name in growth.costs for counted in get_args(Counted) for total in totals(name, counted)
    ]
    # Both charts of a report share their scale.
    axes = _Axes(growth.sizes, min(every), max(every), palette.width - _RIGHT, palette.height - _BOTTOM)
    parts = [_frame(axes, palette)]
    ends = []
    for name in growth.costs:
        colour = palette.colour(_SERIES[name])
        if stated := totals(name, "text"):
            parts.append(_line(axes, stated, colour, dashed=True))
        ours = totals(name, which)
        parts.append(_line(axes, ours, colour))
        parts += [_marker(axes, n, total, name, palette) for n, total in zip(growth.sizes, ours, strict=True)]
        ends.append((axes.y(ours[-1]), name))
    parts += _labels(axes, ends, palette)
    style = f"font-family:{palette.font};font-size:10.5px"
    counted = "as executed" if which == "executed" else "after folding"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {palette.width:g} {palette.height:g}" '
        f'role="img" aria-label="Operations {counted} over the number of joints" style="{style}">'
        f"{''.join(parts)}</svg>"
    )


@dataclass(frozen=True)
class _Axes:
    sizes: tuple[int, ...]
    low: float
    high: float
    right: float
    bottom: float

    def x(self, n: float) -> float:
        span = math.log(self.sizes[-1] / self.sizes[0])
        return _LEFT + math.log(n / self.sizes[0]) / span * (self.right - _LEFT)

    def y(self, total: float) -> float:
        low, high = math.log(self.low / 1.3), math.log(self.high * 1.3)
        return self.bottom - (math.log(total) - low) / (high - low) * (self.bottom - _TOP)


def _frame(axes: _Axes, palette: Palette) -> str:
    soft, line = palette.colour("soft"), palette.colour("line")
    right, bottom = axes.right, axes.bottom
    parts = []
    for power in range(1, 8):
        grouped = f"{10**power:,}".replace(",", "\u202f")
        if axes.low / 1.3 <= 10**power <= axes.high * 1.3:
            y = axes.y(10**power)
            parts.append(
                f'<path d="M{_LEFT:g} {y:.1f}H{right:g}" style="stroke:{line};stroke-width:.7"/>'
                f'<text x="{_LEFT - 6:g}" y="{y + 3.5:.1f}" text-anchor="end" style="fill:{soft}">'
                f"{grouped}</text>"
            )
    for n in axes.sizes:
        x = axes.x(n)
        parts.append(f'<path d="M{x:.1f} {bottom:g}v3" style="stroke:{soft};stroke-width:.7"/>')
        if n <= 6 or n % 2 == 0:
            parts.append(
                f'<text x="{x:.1f}" y="{bottom + 14:g}" text-anchor="middle" style="fill:{soft}">{n}</text>'
            )
    middle = (_LEFT + right) / 2
    parts.append(
        f'<path d="M{_LEFT:g} {bottom:g}H{right:g}" style="stroke:{soft};stroke-width:.8"/>'
        f'<text x="{middle:g}" y="{palette.height - 3:g}" text-anchor="middle" style="fill:{soft}">'
        "joints n</text>"
    )
    return "".join(parts)


def _line(axes: _Axes, totals: list[int], colour: str, dashed: bool = False) -> str:
    points = " ".join(f"{axes.x(n):.1f},{axes.y(t):.1f}" for n, t in zip(axes.sizes, totals, strict=True))
    dash = ";stroke-dasharray:5 3.5;stroke-width:1.1" if dashed else ";stroke-width:1.7"
    return f'<polyline points="{points}" style="fill:none;stroke:{colour}{dash}"/>'


def _marker(axes: _Axes, n: int, total: int, name: str, palette: Palette) -> str:
    x, y, colour = axes.x(n), axes.y(total), palette.colour(_SERIES[name])
    shape = {
        "square": f"M{x - 2.6:.1f} {y - 2.6:.1f}h5.2v5.2h-5.2z",
        "triangle": f"M{x - 3.1:.1f} {y + 2.5:.1f}h6.2l-3.1 -5.6z",
        "down": f"M{x - 3.1:.1f} {y - 2.5:.1f}h6.2l-3.1 5.6z",
        "diamond": f"M{x:.1f} {y - 3.5:.1f}l3.5 3.5l-3.5 3.5l-3.5 -3.5z",
        "cross": f"M{x - 2.8:.1f} {y - 2.8:.1f}l5.6 5.6m0 -5.6l-5.6 5.6",
    }.get(_MARKERS[name], f"M{x - 2.7:.1f} {y:.1f}a2.7 2.7 0 1 0 5.4 0a2.7 2.7 0 1 0 -5.4 0z")
    fill = palette.colour("paper") if _MARKERS[name] == "open" else colour
    told = escape(f"{METHODS[name].short}, n = {n}: {total} operations")
    return (
        f'<path d="{shape}" style="fill:{fill};stroke:{colour};stroke-width:1.3"><title>{told}</title></path>'
    )


def _labels(axes: _Axes, ends: list[tuple[float, str]], palette: Palette) -> list[str]:
    """Name the curves at their ends, moved apart where they would overlap."""
    ordered = sorted(ends, key=lambda end: end[0])
    places: list[float] = []
    for y, _ in ordered:
        places.append(max(y, places[-1] + _LABEL_PITCH) if places else y)
    overshoot = max(0.0, places[-1] - axes.bottom)
    return [
        f'<text x="{axes.right + 8:g}" y="{place - overshoot + 3.5:.1f}" '
        f'style="fill:{palette.colour(_SERIES[name])};font-weight:600">{escape(METHODS[name].short)}</text>'
        for place, (_, name) in zip(places, ordered, strict=True)
    ]
