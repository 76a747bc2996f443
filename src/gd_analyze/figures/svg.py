"""Figures as SVG: whole for PDF, and panel by panel for a page, whose style and script use the marks.

A unit of the drawing is a twentieth of a point, so that all coordinates are whole numbers.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from functools import lru_cache
from html import escape

import numpy as np

from gd_analyze.arrays import FloatArray, runs
from gd_analyze.figures.figure import (
    CELL_HEIGHT,
    ON_PAPER,
    Area,
    Cells,
    Curve,
    Figure,
    FigureWords,
    LegendKey,
    Panel,
    hatching,
)

UNITS_PER_POINT = 20
# Points this near to a line, pt, may be left out.
_THINNED_WITHIN = 0.04
# Most points of a curve: some three per pt of a wide panel.
_MOST_POINTS = 600
_LEGEND_HEIGHT = 14.0
_NUMBERS_OF_CELLS = re.compile("<g data-cells='[^']*'/>")

Placed = Callable[[FloatArray, FloatArray], FloatArray]
# A colour as a page's style names it.
_colour: Callable[[str], str] = "var(--{})".format


def figure_svg(figure: Figure) -> str:
    """Draw a whole figure for paper."""
    width = figure.columns * figure.width
    legend, head = _legend(figure.legend, width)
    height, parts = len(figure.rows) * figure.height + head, [legend]
    for r, c, panel in figure.places:
        x, y = c * figure.width, r * figure.height + head
        parts.append(f'<g transform="translate({_int(x)} {_int(y)})">{_drawn_panels(figure)[panel]}</g>')
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}pt" height="{height:g}pt" '
        f'viewBox="0 0 {_int(width)} {_int(height)}" font-family="Libertinus Serif" '
        f'fill="none" stroke-linejoin="round">{"".join(parts)}</svg>'
    )
    for name, colour in ON_PAPER.items():
        svg = svg.replace(_colour(name), colour)
    return _NUMBERS_OF_CELLS.sub("", svg)  # which a page's script reads


def panel_svg(panel: Panel, figure: Figure) -> str:
    """Draw one panel for a page; its script reads values from the curves and the axes' ends."""
    frame, axes = _frame(panel, figure.width, figure.height), ""
    if not panel.is_bare and not panel.x.is_logarithmic:
        low, high = panel.y.low / panel.y.factor, panel.y.high / panel.y.factor
        axes = (
            f' data-frame="{" ".join(str(_int(v)) for v in frame)}"'
            f' data-x="{panel.x.low:g} {panel.x.high:g} {panel.x.unit}"'
            f' data-y="{low:.6g} {high:.6g} {escape(panel.y.unit)}"'
        )
    label = escape(f"{figure.label}: {panel.title}" if panel.title else figure.label)
    return (
        f'<svg class="panel" viewBox="0 0 {_int(figure.width)} {_int(figure.height)}" role="img" '
        f'aria-label="{label}" data-key="{escape(panel.key)}"{axes}>'
        f"{_drawn_panels(figure)[panel]}</svg>"
    )


@lru_cache(maxsize=32)
def _drawn_panels(figure: Figure) -> dict[Panel, str]:
    """Draw the panels of a figure once, for page and paper."""
    return {panel: "".join(_drawn(panel, figure.width, figure.height)) for panel in figure.panels}


def _drawn(panel: Panel, width: float, height: float) -> Iterator[str]:
    """Grid, items, axes and title of a panel; y points downward here."""
    left, top, wide, high = frame = _frame(panel, width, height)

    def placed(x: FloatArray, y: FloatArray) -> FloatArray:
        across, upward = left + wide * panel.x.place(x), top + high * (1.0 - panel.y.place(y))
        return np.stack([across, upward], axis=-1)

    if not panel.is_bare:
        yield from _axes(panel, frame)
    for item in panel.items:
        if isinstance(item, FigureWords):
            x, y = placed(np.array(item.x), np.array(item.y)).tolist()
            look = ' font-weight="bold"' if item.bold else ""
            look += ' font-style="italic"' if item.italic else ""
            if item.space is not None:
                look += f' data-space3="{" ".join(f"{value:.4g}" for value in item.space)}"'
                look += f' data-shift="{_int(item.right)} {_int(-item.up)}"'
            at = x + item.right, y - item.up
            yield _text(*at, item.text, item.size, _colour(item.colour), item.anchor, look)
        elif isinstance(item, Area):
            yield _area(item, placed)
        elif isinstance(item, Cells):
            yield from _cells(item, placed)
        else:
            yield from _curve(item, placed)
    if panel.title:
        unit = f'<tspan font-weight="normal" fill="{_colour("soft")}">, {escape(panel.y.unit)}</tspan>'
        x = left - 14 if left > 14 else left
        yield (
            f'<text x="{_int(x)}" y="{_int(top - 4)}" font-size="{_int(panel.text + 1)}" '
            f'font-weight="bold" style="fill:{_colour("ink")}">{escape(panel.title)}'
            f"{unit if panel.y.unit and not panel.is_bare else ''}</text>"
        )
    if panel.corner:
        colour = _colour(panel.corner_colour)
        yield _text(left + wide, top - 4, panel.corner, panel.text, colour, "end")


def _axes(panel: Panel, frame: tuple[float, float, float, float]) -> Iterator[str]:
    left, top, wide, high = frame
    x_at = (left + wide * panel.x.place(np.array(panel.x.ticks))).tolist()
    y_at = (top + high * (1 - panel.y.place(np.array(panel.y.ticks)))).tolist()
    bottom, right, size = top + high, left + wide, panel.text
    grid = [f"M{_int(left)} {_int(y)}h{_int(wide)}" for y in y_at if not panel.y.names]
    grid += [f"M{_int(x)} {_int(top)}v{_int(high)}" for x in x_at if panel.x.grid]
    if grid:
        yield f'<path class="grid" style="stroke:{_colour("line")}" stroke-width="10" d="{"".join(grid)}"/>'
    base = [f"M{_int(left)} {_int(bottom)}h{_int(wide)}", *(f"M{_int(x)} {_int(bottom)}v40" for x in x_at)]
    if panel.y.low < 0 < panel.y.high:
        zero = top + high * (1 - float(panel.y.place(np.array(0.0))))
        base.append(f"M{_int(left)} {_int(zero)}h{_int(wide)}")
    for x in (left + wide * panel.x.place(np.array(panel.x.dashes))).tolist():
        base.append(f"M{_int(x)} {_int(bottom)}v24")
    yield f'<path style="stroke:{_colour("soft")}" stroke-width="11" d="{"".join(base)}"/>'
    soft = _colour("soft")
    below = math.inf  # last label, from the bottom
    for y, label in zip(y_at, panel.y.labels, strict=True):
        if panel.y.names or y + size <= below:
            below = y
            yield _text(left - 2.5, y + 0.32 * size, label, size, soft, "end")
    named, end = panel.x.labels, right + panel.margins[2]
    free = math.inf  # left end of the label to the right
    for k, (x, label) in reversed([*enumerate(zip(x_at, named, strict=True))]):
        is_last = k == len(named) - 1
        text = f"{label} {panel.x.unit}" if is_last and panel.x.unit else label
        wide = 0.5 * size * len(text)
        fits = x + wide / 2 <= end
        anchor, at = ("middle", x) if fits else ("end", end)
        if is_last or x + wide / 2 + 0.5 * size <= free:
            free = at - (wide / 2 if fits else wide)
            yield _text(at, bottom + size + 2.5, text, size, soft, anchor)


def _curve(item: Curve, placed: Placed) -> Iterator[str]:
    points, colour = placed(item.x, item.y), _colour(item.colour)
    look = f' class="{item.role}"' if item.role else ""
    look += ' display="none"' if item.hidden else ""
    look += f' opacity="{item.opacity:.2g}"' if item.opacity < 1.0 else ""
    marked = look + (f' data-label="{escape(item.label)}"' if item.label else "")
    if item.space is not None:
        marked += f' data-space="{" ".join(f"{value:.4g}" for value in np.ravel(item.space))}"'
    if item.width and len(points) > 1:
        dashes = " ".join(str(_int(length * item.width)) for length in item.dashes)
        marked += f' stroke-dasharray="{dashes}"' if dashes else ' stroke-linecap="round"'
        path = "".join(_path(run) for run in _runs(points))
        yield (f'<path{marked} style="stroke:{colour}" stroke-width="{_int(item.width)}" d="{path}"/>')
    dots = item.marker or ("circle" if len(points) == 1 else None)
    if dots == "circle" and len(points) > 1 and not item.hollow and not item.tips:
        # Round ends of lines without length: one path for all.
        path = "".join(f"M{_int(x)} {_int(y)}h0" for x, y in points.tolist() if math.isfinite(y))
        attributes = look if item.width and len(points) > 1 else marked
        round_ends = f'stroke-width="{_int(item.size)}" stroke-linecap="round"'
        yield f'<path{attributes} style="stroke:{colour}" {round_ends} d="{path}"/>'
    elif dots:
        fill = _colour("paper") if item.hollow else colour
        edge = max(item.size / 4, 0.7)
        for k, (x, y) in enumerate(points.tolist()):
            if math.isfinite(y):
                tip = f"<title>{escape(item.tips[k])}</title>" if item.tips else ""
                yield (
                    f"<path{'' if item.width and len(points) > 1 else marked} "
                    f'style="fill:{fill};stroke:{colour}" '
                    f'stroke-width="{_int(edge)}" d="{_mark(dots, x, y, item.size)}">{tip}</path>'
                )


def _area(item: Area, placed: Placed) -> str:
    near, far = _runs(placed(item.x, item.near)), _runs(placed(item.x, item.far))
    path = "".join(f"{_path(forth)}L{_path(back[::-1])[1:]}z" for forth, back in zip(far, near, strict=True))
    marked = f' data-label="{escape(item.label)}"' if item.label else ""
    lines = "".join(_hatched(*pair, item.hatching) for pair in zip(near, far, strict=True))
    return f'<path{marked} style="fill:{_colour(item.colour)}" d="{path}"/>{_lines(lines)}'


def _hatched(near: FloatArray, far: FloatArray, slopes: str) -> str:
    """Path of the hatching between two curves of placed points."""
    ends = hatching(near[:, 0], -near[:, 1], -far[:, 1], slopes) * (1.0, -1.0) if slopes else ()
    corners = np.rint(UNITS_PER_POINT * np.asarray(ends)).astype(int).tolist()
    return "".join(f"M{x} {y}L{u} {v}" for (x, y), (u, v) in corners)


def _lines(path: str) -> str:
    return f'<path style="stroke:{_colour("paper")}" stroke-width="11" d="{path}"/>' if path else ""


def _cells(item: Cells, placed: Placed) -> Iterator[str]:
    """Draw equal cells in one path, with neighbours merged."""
    looks = np.char.add(item.colours, np.char.mod(" %.2g", item.opacity))
    for look in np.unique(looks[item.colours != ""]):
        colour, opacity = look.split()
        path, lines = [], []
        for row, has_look in enumerate(looks == look):
            for pair in runs(has_look):
                corners = placed(item.x[pair], row + np.array([0.0, CELL_HEIGHT]))
                (left, top), (right, bottom) = np.rint(UNITS_PER_POINT * corners).astype(int).tolist()
                path.append(f"M{left} {top}H{right}V{bottom}H{left}z")
                upper, lower = (corners * (1, 0) + (0, y) for y in corners[:, 1])
                lines.append(_hatched(upper, lower, item.hatching.get(colour, "")))
        yield f'<path style="fill:{_colour(colour)}" opacity="{opacity}" d="{"".join(path)}"/>'
        yield _lines("".join(lines))
    data = {"x": item.x.tolist(), "words": item.words, "numbers": item.numbers.tolist()}
    cells = escape(json.dumps(data, ensure_ascii=False, separators=(",", ":")), quote=False)
    yield "<g data-cells='" + cells.replace("'", "&#39;") + "'/>"


def _runs(points: FloatArray) -> list[FloatArray]:
    """Pieces of a line between points that are nan."""
    is_finite = np.isfinite(points).all(axis=1)
    if is_finite.all():
        return [points]
    cuts = np.flatnonzero(np.diff(is_finite.astype(int))) + 1
    return [run for run in np.split(points, cuts) if np.isfinite(run[0]).all()]


def _path(points: FloatArray) -> str:
    """Line through points, pt, without invisible ones."""
    corners = np.rint(UNITS_PER_POINT * without_straights(_extremes(points))).astype(int)
    first, steps = corners[0].tolist(), np.diff(corners, axis=0).ravel().tolist()
    return (
        f"M{first[0]} {first[1]}l{' '.join(map(str, steps))}".replace(" -", "-")
        if steps
        else (f"M{first[0]} {first[1]}h0")
    )


def _extremes(points: FloatArray) -> FloatArray:
    """Lowest and highest points of equal stretches of a long line, in order."""
    count = len(points)
    if count <= _MOST_POINTS:
        return points
    length = -(-count // (_MOST_POINTS // 4))
    stretches = -(-count // length)
    padded = np.pad(points, ((0, stretches * length - count), (0, 0)), mode="edge")
    windows, starts = padded.reshape(stretches, length, 2), np.arange(stretches) * length
    extremes = [(pick(axis=1) + starts[:, None]).ravel() for pick in (windows.argmin, windows.argmax)]
    return points[np.unique(np.minimum(np.concatenate([[0, count - 1], *extremes]), count - 1))]


def without_straights(points: FloatArray) -> FloatArray:
    """Leave out points that lie within `_THINNED_WITHIN` of the line between their neighbours, in rounds."""
    for _ in range(6):
        if len(points) < 4:
            break
        before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
        across = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        length = np.hypot(*(before + after).T)
        # Where a line turns back, its turning point is kept.
        straight = (np.abs(across) <= _THINNED_WITHIN * length) & ((before * after).sum(axis=1) >= 0.0)
        straight[1::2] = False
        if not straight.any():
            break
        points = points[np.concatenate([[True], ~straight, [True]])]
    return points


def _mark(shape: str, x: float, y: float, size: float) -> str:
    r, whole = size / 2, _int(size)
    turns = [((r, 0.42 * r)[k % 2], k * math.pi / 5) for k in range(10)]
    corners: dict[str, list[tuple[float, float]]] = {
        "square": [(-r, -r), (r, -r), (r, r), (-r, r)],
        "triangle": [(-1.15 * r, r), (1.15 * r, r), (0, -1.1 * r)],
        "diamond": [(0, -1.3 * r), (1.3 * r, 0), (0, 1.3 * r), (-1.3 * r, 0)],
        "star": [(radius * math.sin(turn), -radius * math.cos(turn)) for radius, turn in turns],
    }
    if shape == "cross":
        return f"M{_int(x - r)} {_int(y - r)}l{whole} {whole}m0-{whole}l-{whole} {whole}"
    if shape == "circle":
        arc = f"a{_int(r)} {_int(r)} 0 1 0"
        return f"M{_int(x - r)} {_int(y)}{arc} {whole} 0{arc}-{whole} 0z"
    return f"M{'L'.join(f'{_int(x + dx)} {_int(y + dy)}' for dx, dy in corners[shape])}z"


def _text(
    x: float, y: float, text: str, size: float, colour: str, anchor: str = "start", look: str = ""
) -> str:
    where = "" if anchor == "start" else f' text-anchor="{anchor}"'
    return (
        f'<text x="{_int(x)}" y="{_int(y)}" font-size="{_int(size)}"{where}{look} style="fill:{colour}">'
        f"{escape(text)}</text>"
    )


def _legend(keys: tuple[LegendKey, ...], width: float) -> tuple[str, float]:
    """Draw a legend in as many lines as the width, pt, requires; also return their height, pt."""
    parts, x, y, size = [], 0.0, 0.0, 7.5
    for key in keys:
        mark, label = 15.0 if key.kind == "area" else 18.0, 0.5 * size * len(key.label)
        if x and x + mark + label > width:
            x, y = 0.0, y + _LEGEND_HEIGHT
        parts.append(f'<g transform="translate({_int(x)} {_int(y)})">{_key(key)}</g>')
        parts.append(_text(x + mark, y + 9.6, key.label, size, _colour("ink")))
        x += mark + label + 9.0
    return "".join(parts), y + _LEGEND_HEIGHT if keys else 0.0


def key_svg(key: LegendKey) -> str:
    """Draw the look of a legend's entry for a page."""
    return f'<svg class="key" viewBox="0 60 300 180" aria-hidden="true">{_key(key)}</svg>'


def _key(key: LegendKey) -> str:
    """A piece of the area, or of the line with its marker, 15 pt wide."""
    if key.kind == "area":
        left, right, bottom, top = 0.0, 13.0, -10.5, -3.5
        ends = np.array([left, right])
        area = Area(ends, np.full(2, bottom), np.full(2, top), key.colour, hatching=key.hatching)
        items: list[Area | Curve] = [area]
    else:
        ends = np.array([0.0, 15.0])
        items = [Curve(ends, np.full(2, -7.5), key.colour, 1.4, key.dashes)]
        if key.marker:
            mark = np.array([7.5]), np.array([-7.5])
            hollow = bool(key.dashes)
            items.append(Curve(*mark, key.colour, 0.0, marker=key.marker, size=4.2, hollow=hollow))

    def placed(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.stack([x, -y], axis=-1)

    return "".join(
        _area(item, placed) if isinstance(item, Area) else "".join(_curve(item, placed)) for item in items
    )


def _int(value: float) -> int:
    return round(UNITS_PER_POINT * value)


def _frame(panel: Panel, width: float, height: float) -> tuple[float, float, float, float]:
    """Left, top, width and height of the area within the margins."""
    left, bottom, right, top = panel.margins
    return left, top, width - left - right, height - top - bottom
