"""Which effect dominates each element at every set point: elements against time at a glance."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.elements import LETTERS, subscripted
from gd_analyze.figures.figure import ON_PAPER, WIDTH, Axis, Cells, Figure, Key, Panel, Words, time_axis
from gd_analyze.figures.run import Run
from gd_analyze.text import amount, pretty

# Elements that have a row, and columns at most: more could not be told apart.
_ROWS, _COLUMNS = 30, 120
# Shades by the element's torque, as a share of the peak torque of its joint.
_SHADES = ((0.1, 1.0), (0.03, 0.7), (0.01, 0.45), (0.0, 0.22))
_PITCH, _MARGINS = 9.5, (26.0, 13.0, 96.0, 16.0)
_LEGEND = (
    Key("translation", "translation", "area"),
    Key("rotation", "rotation", "area"),
    Key("both", "both", "area"),
    Key("darker: torque above 1, 3, 10 % of the joint's peak", "soft", "area"),
)


def dominance_figure(run: Run) -> Figure:
    """Elements of D and h against time, largest torque first: verdicts in colours, shaded by torque."""
    ranking = run.dominance
    is_shown = (ranking.quantity.values != "gravity_loading") & (ranking.peak.values > 0.0)
    ranking = ranking.isel(element=np.flatnonzero(is_shown)[:_ROWS])
    labels = ranking.element.values.tolist()
    over_time = run.tables["dominance_over_time"].sel(element=labels)
    time, columns = over_time.time.values, _columns(over_time.sizes["time"])
    needed = np.stack([over_time.needed.values[block].any(axis=0) for block in columns], axis=1)
    torque = np.stack([np.abs(over_time.torque.values[block]).max(axis=0) for block in columns], axis=1)
    parts = np.stack([_largest(over_time.dominance.values[block]) for block in columns], axis=1)
    peaks = np.abs(run.exact_torque).max(axis=0)[ranking.torque_joint.values - 1, None]
    share = torque / np.where(peaks > 0.0, peaks, np.inf)
    middles = np.array([time[block].mean() for block in columns])
    edges = np.concatenate([time[:1], (middles[1:] + middles[:-1]) / 2, time[-1:]])
    told = zip(labels, ranking.torque_joint.values, ranking.torque_unit.values, strict=True)
    cells = Cells(
        edges,
        np.array(["", "translation", "rotation", "both"])[needed @ [1, 2]],
        np.select([share >= least for least, _ in _SHADES], [shade for _, shade in _SHADES]),
        tuple(
            f"{label}: translation {{0}} % of peak, rotation {{1}} %; {{2}} {pretty(str(unit))} at joint {k}"
            for label, k, unit in told
        ),
        np.concatenate([np.rint(100 * parts), _three_digits(torque)[..., None]], axis=-1),
    )
    rows = len(labels)
    y = Axis(float(rows), 0.0, tuple(k + 0.45 for k in range(rows)), names=tuple(map(subscripted, labels)))
    x = time_axis(time)
    panel = Panel("dominance", "", x, y, (cells, *_beside(run, labels, x.high)), margins=_MARGINS)
    height = rows * _PITCH + _MARGINS[1] + _MARGINS[3]
    return Figure("Dominant effect of each element over time", ((panel,),), WIDTH, height, _LEGEND)


_EFFECTS = {"T": "translation", "R": "rotation"}


def _columns(count: int) -> list[slice]:
    """Set points that share a column."""
    ends = np.unique(np.linspace(0, count, min(count, _COLUMNS) + 1).round().astype(int))
    return [slice(begin, end) for begin, end in pairwise(ends.tolist())]


def _three_digits(values: FloatArray) -> FloatArray:
    """Numbers as a page tells them."""
    return np.array([float(f"{value:.3g}") for value in values.ravel()]).reshape(values.shape)


def _largest(parts: FloatArray) -> FloatArray:
    """Values of largest magnitude over the first axis, with their signs."""
    return np.take_along_axis(parts, np.abs(parts).argmax(axis=0)[None], axis=0)[0]


def _beside(run: Run, labels: list[str], end: float) -> list[Words]:
    """Verdict over the motion, what the founding text's method keeps, and the largest torque, by element."""
    flags = zip(run.tables["parts"].part.values, run.tables["parts"].kept.values, strict=True)
    kept = {str(part) for part, is_kept in flags if is_kept}
    out = [
        Words(end, 0.0, head, "soft", size=6.0, right=right, up=3.0)
        for head, right in (("verdict", 6.0), ("kept", 34.0), ("torque", 54.0))
    ]
    ranking = run.dominance.sel(element=labels)
    rows = zip(labels, *(ranking[k].values for k in ("dominant", "torque_peak", "torque_unit")), strict=True)
    for row, (label, verdict, peak, unit) in enumerate(rows):
        effects = [
            letter for name, letter in (("translation", "T"), ("rotation", "R")) if f"{label} {name}" in kept
        ]
        colour = f"{verdict}-text" if f"{verdict}-text" in ON_PAPER else "ink"
        for text, right, shade in (
            (LETTERS[verdict], 6.0, colour),
            ("+".join(effects) or "–", 34.0, "ink"),
            (pretty(amount(float(peak), str(unit))), 54.0, "ink"),
        ):
            out.append(Words(end, row + 0.75, text, shade, size=6.0, right=right))
    return out
