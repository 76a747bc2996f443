"""A drawing placed by hand in points from the lower left corner, written as SVG for page and paper alike.

A report has some fifty panels. Drawn with matplotlib they, and importing it, would take longer than all that
is computed; SVG written here takes a few milliseconds, and text stays text.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal
from xml.sax.saxutils import escape

import numpy as np

from gd_analyze.report.colours import ON_PAPER
from gd_analyze.vectors import FloatArray

Anchor = Literal["start", "middle", "end"]


@dataclass(frozen=True)
class Palette:
    """How the names of `gd_analyze.report.colours` are written in SVG, and the font's family."""

    colour: Callable[[str], str]
    font: str


SCREEN = Palette("var(--{})".format, "inherit")
PAPER = Palette(ON_PAPER.__getitem__, "Libertinus Serif")


@dataclass(frozen=True, eq=False)
class Shape:
    """What was drawn: where, in pt, shape (N, 2); what it is called; the higher its order, the later."""

    points: FloatArray
    path: str
    style: str
    order: float = 2.0
    label: str = ""


@dataclass(frozen=True)
class Text:
    """What was written, and where, in pt."""

    x: float
    y: float
    text: str
    size: float
    style: str
    anchor: Anchor = "start"


@dataclass(frozen=True)
class Canvas:
    """An empty drawing of some width and height, pt."""

    width: float
    height: float
    palette: Palette = PAPER
    shapes: list[Shape] = field(default_factory=list)
    texts: list[Text] = field(default_factory=list)

    def line(
        self,
        points: FloatArray,
        colour: str = "ink",
        width: float = 1.0,
        *,
        dashes: Sequence[float] = (),
        order: float = 2.0,
        label: str = "",
    ) -> None:
        """Draw through points, pt, shape (N, 2), or a dot; dashes are multiples of the width."""
        if len(points) == 1:
            self.mark(points, colour, 2.0 + width, order=order, label=label)
            return
        style = f"fill:none;stroke:{self._written(colour)};stroke-width:{width:g};stroke-linejoin:round"
        if dashes:
            style += f";stroke-dasharray:{' '.join(f'{width * dash:g}' for dash in dashes)}"
        self.shapes.append(Shape(points, self._path(points), style, order, label))

    def segments(
        self,
        ends: Sequence[tuple[float, float, float, float]],
        colour: str,
        width: float,
        *,
        rounded: bool = False,
        order: float = 1.0,
    ) -> None:
        """Draw straight lines from (x, y) to (x, y) as one shape."""
        if not ends:
            return
        points = np.reshape(ends, (-1, 2))
        path = "".join(
            f"M{x:.2f} {self.height - y:.2f}L{to_x:.2f} {self.height - to_y:.2f}"
            for x, y, to_x, to_y in np.reshape(ends, (-1, 4)).tolist()
        )
        cap = ";stroke-linecap:round" if rounded else ""
        style = f"fill:none;stroke:{self._written(colour)};stroke-width:{width:.2f}{cap}"
        self.shapes.append(Shape(points, path, style, order))

    def area(
        self, points: FloatArray, colour: str, *, opacity: float = 1.0, order: float = 0.5, label: str = ""
    ) -> None:
        """Fill what points go around, pt, shape (N, 2)."""
        faint = f";fill-opacity:{opacity:g}" if opacity < 1.0 else ""
        style = f"fill:{self._written(colour)}{faint}"
        self.shapes.append(Shape(points, self._path(points) + "z", style, order, label))

    def mark(
        self,
        points: FloatArray,
        colour: str,
        size: float = 3.0,
        *,
        shape: str = "circle",
        fill: str = "",
        edge: float = 0.0,
        order: float = 2.0,
        label: str = "",
    ) -> None:
        """Put a mark of some size at each of the points; filled with its own colour unless told otherwise."""
        path = "".join(_mark(shape, x, self.height - y, size) for x, y in points.tolist())
        style = f"fill:{self._written(fill or colour)};stroke:{self._written(colour)};stroke-width:{edge:g}"
        self.shapes.append(Shape(points, path, style, order, label))

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 7.0,
        *,
        colour: str = "ink",
        anchor: Anchor = "start",
        look: str = "",
    ) -> None:
        """Write on a baseline; `look` is further style, such as "font-weight:600"."""
        style = f"fill:{self._written(colour)}" + (f";{look}" if look else "")
        self.texts.append(Text(x, y, text, size, style, anchor))

    def svg(self, alt: str = "") -> str:
        """Write it down; `alt` says what it shows to who cannot see it."""
        named = f' role="img" aria-label="{escape(alt, {chr(34): "&quot;"})}"' if alt else ""
        shapes = (
            f'<path d="{shape.path}" style="{shape.style}"/>'
            for shape in sorted(self.shapes, key=lambda shape: shape.order)
        )
        texts = (
            f'<text x="{text.x:.2f}" y="{self.height - text.y:.2f}" font-size="{text.size:g}"'
            f"{'' if text.anchor == 'start' else f' text-anchor={chr(34)}{text.anchor}{chr(34)}'}"
            f' style="{text.style}">{escape(text.text)}</text>'
            for text in self.texts
        )
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:g} {self.height:g}" '
            f'width="{self.width:g}pt" height="{self.height:g}pt"{named} '
            f'style="font-family:{self.palette.font}">{"".join(shapes)}{"".join(texts)}</svg>'
        )

    def _written(self, colour: str) -> str:
        return colour if colour.startswith("#") else self.palette.colour(colour)

    def _path(self, points: FloatArray) -> str:
        flipped = points * (1.0, -1.0) + (0.0, self.height)
        return "M" + "L".join([f"{x:.2f} {y:.2f}" for x, y in flipped.tolist()])


# Corners of marks, in halves of their size, y downward.
_TURNS = np.arange(10) * np.pi / 5
_CORNERS = {
    "square": np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
    "diamond": 1.2 * np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
    "star": np.where(np.arange(10) % 2, 0.42, 1.0)[:, None] * np.stack([np.sin(_TURNS), -np.cos(_TURNS)], 1),
}


def _mark(shape: str, x: float, y: float, size: float) -> str:
    """Path of a mark around a point, y downward."""
    r = size / 2
    if shape == "circle":
        return f"M{x - r:.2f} {y:.2f}a{r:g} {r:g} 0 1 0 {size:g} 0a{r:g} {r:g} 0 1 0 {-size:g} 0z"
    corners = (x, y) + r * _CORNERS[shape]
    return "M" + "L".join([f"{a:.2f} {b:.2f}" for a, b in corners.tolist()]) + "z"
