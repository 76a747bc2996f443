"""A drawing placed by hand in points from the lower left corner, drawn by matplotlib.

A report has some fifty panels. As Axes of their own they would take longer than everything else; so all of
them are shapes in one, whose data coordinates are points.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.colours import ON_PAPER

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase
    from matplotlib.figure import Figure
    from matplotlib.font_manager import FontProperties

Anchor = Literal["start", "middle", "end"]
Kind = Literal["line", "segments", "area", "marks"]

_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "diamond": "D", "star": "*"}
_ANCHORS: dict[Anchor, Literal["left", "center", "right"]] = {
    "start": "left",
    "middle": "center",
    "end": "right",
}
# Text stays text, so that Typst and the page set it in the report's own font: matplotlib names both families,
# has only the first, and Typst, which sees no font of the machine, has only the second.
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "gd-analyze",
    "font.family": "serif",
    "font.serif": ["DejaVu Serif", "Libertinus Serif"],
}


@dataclass(frozen=True, eq=False)
class Shape:
    """What is drawn: where, pt, shape (N, 2), and how; the higher its order, the later."""

    kind: Kind
    points: FloatArray
    colour: str
    look: dict[str, Any]
    order: float
    label: str = ""


@dataclass(frozen=True)
class Text:
    """What is written, and where, in pt."""

    x: float
    y: float
    text: str
    size: float
    colour: str
    anchor: Anchor
    look: dict[str, Any]


class Frame(NamedTuple):
    """Where a panel is, pt: left, bottom, width and height; and the range of the numbers in it."""

    box: tuple[float, float, float, float]
    x: tuple[float, float]
    y: tuple[float, float]


@dataclass(frozen=True)
class Canvas:
    """An empty drawing of some width and height, pt."""

    width: float
    height: float
    shapes: list[Shape] = field(default_factory=list)
    texts: list[Text] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)

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
        look = {"linewidth": width, "linestyle": (0, tuple(dashes)) if dashes else "-"}
        self.shapes.append(Shape("line", points, colour, look, order, label))

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
        if ends:
            look = {"linewidth": width, "capstyle": "round" if rounded else "butt"}
            self.shapes.append(Shape("segments", np.reshape(ends, (-1, 2)), colour, look, order))

    def area(
        self, points: FloatArray, colour: str, *, opacity: float = 1.0, order: float = 0.5, label: str = ""
    ) -> None:
        """Fill what points go around, pt, shape (N, 2)."""
        look = {"linewidth": 0.0, "alpha": opacity if opacity < 1.0 else None}
        self.shapes.append(Shape("area", points, colour, look, order, label))

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
        look = {
            "marker": _MARKERS[shape],
            "markersize": size,
            "markerfacecolor": _hex(fill or colour),
            "markeredgewidth": edge,
        }
        self.shapes.append(Shape("marks", points, colour, look, order, label))

    def text(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 7.0,
        *,
        colour: str = "ink",
        anchor: Anchor = "start",
        **look: str,
    ) -> None:
        """Write on a baseline; `look` is matplotlib's, such as weight="bold"."""
        self.texts.append(Text(x, y, text, size, colour, anchor, look))

    def axes(self, figure: Figure | None = None) -> Axes:
        """Give it as matplotlib Axes in pt; they fill a figure, by default their own."""
        from matplotlib.figure import Figure
        from matplotlib.transforms import TransformedPatchPath

        if figure is None:
            figure = Figure(figsize=(self.width / 72, self.height / 72), dpi=72)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, self.width), ylim=(0.0, self.height))
        axes.set_axis_off()
        # Nothing is clipped; but whatever has no path to be clipped by is given one of its own.
        edge = TransformedPatchPath(axes.patch)
        for artist in self._artists():
            artist.set_clip_path(edge)
            axes.add_artist(artist)
        return axes

    def _artists(self) -> list[Artist]:
        """All that matplotlib draws, in the order in which it draws."""
        ordered = sorted(self.shapes, key=lambda shape: shape.order)
        artists = [*map(_artist, ordered), *map(_written, self.texts)]
        return sorted(artists, key=lambda artist: artist.get_zorder())

    def svg(self) -> str:
        """Write it down."""
        import matplotlib
        from matplotlib.backends.backend_svg import RendererSVG

        out = io.StringIO()
        # Artists draw themselves: a figure of theirs, with Axes, would take as long to import as all else of
        # matplotlib. The user's own settings (LaTeX text, tight boxes) must not reach the report.
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(_STYLE)
            svg_of: Any = RendererSVG  # which tells no types
            renderer = svg_of(self.width, self.height, out, metadata={"Date": None})
            for artist in self._artists():
                _draw(artist, renderer)
            renderer.finalize()
        return out.getvalue()


def _hex(colour: str) -> str:
    return colour if colour.startswith("#") else ON_PAPER[colour]


def _artist(shape: Shape) -> Artist:
    """What matplotlib draws of a shape."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import PathPatch, Polygon
    from matplotlib.path import Path

    rest: dict[str, Any] = {"zorder": shape.order, "label": shape.label, "clip_on": False}
    colour, (x, y) = _hex(shape.colour), shape.points.T
    if shape.kind == "area":
        return Polygon(shape.points, facecolor=colour, **shape.look, **rest)
    if shape.kind == "segments":
        path = Path(shape.points, [Path.MOVETO, Path.LINETO] * (len(shape.points) // 2))
        return PathPatch(path, edgecolor=colour, fill=False, **shape.look, **rest)
    if shape.kind == "marks":
        return Line2D(x, y, color=colour, linestyle="none", **shape.look, **rest)
    return Line2D(x, y, color=colour, solid_joinstyle="round", **shape.look, **rest)


def _written(text: Text) -> Artist:
    from matplotlib.text import Text as Written

    return Written(
        text.x,
        text.y,
        text.text,
        color=_hex(text.colour),
        horizontalalignment=_ANCHORS[text.anchor],
        fontproperties=_font(text.size, **text.look),
        parse_math=False,
        clip_on=False,
    )


def _draw(artist: Artist, renderer: RendererBase) -> None:
    """Let an artist draw itself; of a text without its extent, which a line on a baseline does not need."""
    from matplotlib.text import Text as Written

    if not isinstance(artist, Written):
        artist.draw(renderer)
        return
    (x, y), (_, height) = artist.get_position(), renderer.get_canvas_width_height()
    look = renderer.new_gc()
    look.set_foreground(artist.get_color())
    font = artist.get_fontproperties()
    renderer.draw_text(look, x, height - y, artist.get_text(), font, 0.0, mtext=artist)


@cache
def _font(size: float, **look: Any) -> FontProperties:
    from matplotlib.font_manager import FontProperties

    return FontProperties(size=size, **look)
