"""A sweep: verdicts, peak torques and operations over one varied number, maps over two, and draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray, evenly
from gd_analyze.figures.elements import subscripted
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    Axis,
    Cells,
    Curve,
    Figure,
    FigureWords,
    Item,
    LegendKey,
    Panel,
    in_columns,
    tick_label,
    ticks,
    value_axis,
)
from gd_analyze.text import pretty

if TYPE_CHECKING:
    import xarray as xr

# Most rows of elements.
_MOST_ROWS = 30
# Most maps.
_MOST_MAPS = 12
# Most draws that are marked.
_MOST_MARKED_DRAWS = 500
# Least range of a map's shades, as a share of its largest value: less than this would look like much.
_LEAST_SPAN = 0.1
_COLOURS = {
    **{verdict: verdict for verdict in ("translation", "rotation", "both", "drive")},
    "beyond budget": "warn",
}
_LEGEND = tuple(LegendKey(verdict, colour, "area") for verdict, colour in _COLOURS.items())
# Colour and dashes of the contributions to a joint's torque.
_LOOKS: dict[str, tuple[str, tuple[float, ...]]] = {
    "inertia translation": ("translation", ()),
    "inertia rotation": ("rotation", ()),
    "velocity translation": ("translation", (3.2, 1.6)),
    "velocity rotation": ("rotation", (3.2, 1.6)),
    "gravity": ("series-3", ()),
    "drives": ("combined", ()),
}


def changing(sweep: xr.Dataset) -> list[str]:
    """Elements whose verdict changes."""
    verdicts = sweep.verdict.stack(point=[d for d in sweep.verdict.dims if d != "element"])
    is_changing = (verdicts != verdicts.isel(point=0)).any("point").values
    return [str(label) for label in sweep.element.values[is_changing]]


def verdict_figure(sweep: xr.Dataset) -> Figure:
    """Verdicts over one number, a row per element that is not always negligible, with changes marked."""
    (name,) = sweep.verdict.dims[:-1]
    verdicts = sweep.verdict.transpose("element", name)
    is_coloured = np.isin(verdicts.values, list(_COLOURS)).any(axis=1)
    is_gravity = np.char.startswith(sweep.element.values, "c")
    verdicts = verdicts.isel(element=np.flatnonzero(is_coloured & ~is_gravity)[:_MOST_ROWS])
    labels, values = verdicts.element.values.tolist(), sweep[name].values
    marks: list[Item] = []
    for element, at in zip(sweep.change_element.values, sweep.change_at.values[:, 0], strict=True):
        if element in labels:
            row = labels.index(element)
            marks.append(Curve(np.array([at, at]), np.array([row, row + 0.9]), "ink", 1.4))
    y = Axis(len(labels), 0.0, tuple(k + 0.45 for k in range(len(labels))), names=tuple(map(_named, labels)))
    items = (
        _cells(values, verdicts.values, [f"{label} at {name} = {{0}}" for label in labels], values),
        *marks,
    )
    panel = Panel("verdicts", "", _axis(sweep, name), y, items, margins=(72.0, 13.0, 12.0, 6.0))
    return Figure(f"Verdicts over {name}", ((panel,),), FIGURE_WIDTH, 9.5 * len(labels) + 22.0, _LEGEND)


def peak_torque_figure(sweep: xr.Dataset) -> Figure:
    """Peak torque of every joint and its contributions over the first number; operations; draws as points."""
    name, panels, drawn = str(sweep.parameter.values[0]), [], "sample" in sweep.dims
    selection = evenly(sweep.sizes["sample"], _MOST_MARKED_DRAWS) if drawn else slice(None)
    x, axis = sweep[name].values[selection], _axis(sweep, name)
    for i, unit in enumerate(sweep.effort_unit.values.tolist()):
        torque = sweep.peak_torque[..., i].values[selection]
        parts = sweep.contribution[:, i].values[selection].T
        items = [Curve(x, torque, "accent", 0.0, marker="circle", size=1.6)]
        if not drawn:
            looks = zip(_LOOKS.items(), parts, strict=True)
            items = [
                Curve(x, part, colour, 1.0, dashes, key)
                for (key, (colour, dashes)), part in looks
                if part.any()
            ]
            items.append(Curve(x, torque, "ink", 1.3, label="torque"))
        panels.append(
            Panel(f"peak{i + 1}", f"joint {i + 1}", axis, value_axis(unit, torque, parts), tuple(items))
        )
    if sweep.operations.notnull().any():
        counts = sweep.operations.values[selection]
        curve = Curve(x, counts, "accent", 1.2 * (not drawn), marker="circle", size=2.6)
        panels.append(Panel("operations", "operations", axis, value_axis("", counts, zero=False), (curve,)))
    keys = [
        LegendKey("torque", "ink"),
        *(LegendKey(k, colour, dashes=dashes) for k, (colour, dashes) in _LOOKS.items()),
    ]
    return in_columns(
        f"Peak torque over {name}", panels, min(3, len(panels)), 110.0, () if drawn else tuple(keys)
    )


def maps_figure(sweep: xr.Dataset) -> Figure:
    """Maps over two numbers: verdicts that change, with lines of change; operations; peak torques."""
    across, upward = map(str, sweep.parameter.values)
    x, grid = sweep[across].values, sweep[upward].values
    places = np.arange(len(grid)) + 0.5
    at, axis = ticks(grid[0], grid[-1], 4), _axis(sweep, across)
    names = [tick_label(value) for value in at]
    # Above the panel the unit would seem to be that of the map.
    names[-1:] = [f"{names[-1]} {pretty(str(sweep.unit.values[1]))}".rstrip()]
    y = Axis(0.0, float(len(grid)), tuple(np.interp(at, grid, places).tolist()), names=tuple(names))
    panels = []
    for label in changing(sweep)[:_MOST_MAPS]:
        verdicts = sweep.verdict.sel(element=label).transpose(upward, across).values
        at = sweep.change_at.values[sweep.change_element.values == label]
        marks = Curve(at[:, 0], np.interp(at[:, 1], grid, places), "ink", 0.0, marker="circle", size=1.8)
        words = [f"{label}: {across} = {{0}}, {upward} = {value:g}" for value in grid]
        panels.append(Panel(label, _named(label), axis, y, (_cells(x, verdicts, words, x, gap=0.0), marks)))
    numbers = {"operations": (sweep.operations, "")} if sweep.operations.notnull().any() else {}
    for i, effort in enumerate(sweep.effort_unit.values.tolist()):
        numbers[f"peak torque {i + 1}"] = (sweep.peak_torque[..., i], effort)
    for title, (array, effort) in numbers.items():
        values = array.transpose(upward, across).values
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        span = max(high - low, _LEAST_SPAN * max(abs(low), abs(high))) or 1.0
        shade = 0.1 + 0.9 * np.round((np.nan_to_num(values, nan=low) - low) / span, 1)
        words = [f"{title} {{1}} {effort}: {across} = {{0}}, {upward} = {value:g}" for value in grid]
        cell_numbers = np.stack([np.broadcast_to(x, values.shape), np.vectorize(_short)(values)], axis=-1)
        colours = np.where(np.isnan(values), "", "accent")
        cells = Cells(_edges(x), colours, shade, tuple(words), cell_numbers, gap=0.0)
        bar = _bar(axis, y, low, span)
        panels.append(Panel(title, title, axis, y, (cells, *bar), effort, margins=(24.0, 12.0, 34.0, 13.0)))
    label = f"Maps over {across} (across) and {upward} (upward)"
    return in_columns(label, panels, 3, 120.0, _LEGEND)


def _bar(x: Axis, y: Axis, low: float, span: float) -> tuple[Item, ...]:
    """Bar of a map's shades right of it, with the values at its ends."""
    rows, wide = max(int(y.high), 2), x.high - x.low
    values = np.linspace(low, low + span, rows)
    edges = x.high + wide * np.array([0.04, 0.08])
    shade = (0.1 + 0.9 * np.round((values - low) / span, 1))[:, None]
    words, cell_numbers = ("{0}",) * rows, np.vectorize(_short)(values)[:, None, None]
    cells = Cells(edges, np.full((rows, 1), "accent"), shade, words, cell_numbers, gap=0.0)
    ends = ((0.0, 0.0, low), (y.high, -6.0, low + span))
    named = (FigureWords(float(edges[1]), at, tick_label(_short(v)), right=2.0, up=up) for at, up, v in ends)
    return (cells, *named)


def _axis(sweep: xr.Dataset, name: str) -> Axis:
    values, unit = sweep[name].values, str(sweep.unit.sel(parameter=name).values)
    low, high = float(values.min()), float(values.max())
    return Axis(low, high, tuple(ticks(low, high, 4)), pretty(unit))


def _cells(
    x: FloatArray, verdicts: np.ndarray, words: Sequence[str], cell_values: FloatArray, gap: float = 0.1
) -> Cells:
    colours = np.vectorize(lambda verdict: _COLOURS.get(verdict, ""))(verdicts)
    numbers = np.broadcast_to(np.vectorize(_short)(cell_values)[:, None], (*verdicts.shape, 1))
    return Cells(_edges(x), colours, np.full(verdicts.shape, 0.85), tuple(words), numbers, gap)


def _edges(x: FloatArray) -> FloatArray:
    return np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])


def _short(value: float) -> float:
    return float(f"{value:.4g}")


def _named(label: str) -> str:
    return label if " " in label else subscripted(label)
