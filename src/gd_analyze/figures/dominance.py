"""Overview of the verdict on each element at every set point; elements as figures and numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.dynamics.dominance_over_time import verdicts
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.errors import UsageError
from gd_analyze.figures.elements import (
    LETTERS,
    MOST_MARKED_SET_POINTS,
    Look,
    inertia_figure,
    subscripted,
    vector_figure,
)
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    HATCHING,
    ON_PAPER,
    Axis,
    Cells,
    Figure,
    FigureWords,
    LegendKey,
    Panel,
    time_axis,
)
from gd_analyze.figures.run import Run
from gd_analyze.text import amount, pretty

# Most rows of elements.
_MOST_ROWS = 30
# Most columns that can be distinguished.
_MOST_COLUMNS = 120
# Shades by the element's torque, as a share of the peak torque of its joint.
_SHADES = ((0.1, 1.0), (0.03, 0.7), (0.01, 0.45), (0.0, 0.22))
_MARGINS = (26.0, 13.0, 114.0, 16.0)
# Height of a row, pt.
_ROW_HEIGHT = 9.5
# Height of all rows on a first page, pt.
_FIRST_PAGE_HEIGHT = 165.0
_LEGEND = (
    *(
        LegendKey(name, name, "area", hatching=HATCHING.get(name, ""))
        for name in ("translation", "rotation", "both", "drive")
    ),
    LegendKey("fuller colour: torque above 1, 3, 10 % of the joint's peak", "soft", "area"),
)


def dominance_figure(run: Run) -> Figure:
    """Elements of D and h against time, largest torque first: verdicts in colours, shaded by torque."""
    ranking = run.dominance
    is_shown = (ranking.quantity.values != "gravity_loading") & (ranking.verdict.values != "zero")
    ranking = ranking.isel(element=np.flatnonzero(is_shown)[:_MOST_ROWS])
    labels = ranking.element.values.tolist()
    over_time = run.tables["dominance_over_time"].sel(element=labels)
    over_time = over_time.isel(time=evenly(over_time.sizes["time"], _MOST_COLUMNS))
    time, parts = over_time.time.values, over_time.dominance.values.swapaxes(0, 1)
    words = verdicts(over_time).values.T
    # The torque of what the colour names: the links' parts, or the element with its drive.
    torque = (over_time.torque + over_time.drive_torque * (words.T == "drive")).values.T
    peaks = np.abs(run.exact_torque).max(axis=0)[ranking.torque_joint.values - 1, None]
    share = np.abs(torque) / np.where(peaks > 0.0, peaks, np.inf)
    edges = np.concatenate([time[:1], (time[1:] + time[:-1]) / 2, time[-1:]])
    row_heads = zip(labels, ranking.torque_joint.values, ranking.torque_unit.values, strict=True)
    rounded = [[float(f"{value:.3g}") for value in row] for row in torque.tolist()]
    numbers = np.concatenate([np.rint(100 * parts), np.array(rounded)[..., None]], axis=-1)
    colours = np.where(words == "negligible", "", words)
    shades = np.select([share >= least for least, _ in _SHADES], [shade for _, shade in _SHADES])
    # The motion is unknown across a gap: an empty column.
    for behind in np.unique(np.searchsorted(time, run.trajectory.time[list(run.trajectory.gaps)]))[::-1]:
        edges = np.concatenate([edges[:behind], time[behind - 1 : behind + 1], edges[behind + 1 :]])
        colours, shades = (np.insert(x, behind, y, axis=1) for x, y in ((colours, ""), (shades, 0.0)))
        numbers = np.insert(numbers, behind, 0.0, axis=1)
    cells = Cells(
        edges,
        colours,
        shades,
        tuple(
            f"{label}: translation {{0}} % of peak, rotation {{1}} %; {{2}} {pretty(str(unit))} at joint {k}"
            for label, k, unit in row_heads
        ),
        numbers,
        hatching=HATCHING,
    )
    rows = len(labels)
    y = Axis(float(rows), 0.0, tuple(k + 0.45 for k in range(rows)), names=tuple(map(subscripted, labels)))
    x = time_axis(time)
    panel = Panel("dominance", "", x, y, (cells, *_beside(run, labels, x.high)), margins=_MARGINS)
    height = min(rows * _ROW_HEIGHT, _FIRST_PAGE_HEIGHT) + _MARGINS[1] + _MARGINS[3]
    return Figure("Verdict on each element over time", ((panel,),), FIGURE_WIDTH, height, _LEGEND)


def _beside(run: Run, labels: list[str], end: float) -> list[FigureWords]:
    """Verdict over the motion, and the largest torques of links and drive, by element."""
    ranking = run.dominance.sel(element=labels)
    units = ranking.torque_unit.values.tolist()
    columns = {"verdict": [(LETTERS[verdict], verdict) for verdict in ranking.verdict.values.tolist()]}
    for head, name in (("of links", "torque_peak"), ("of drive", "drive_torque_peak")):
        peaks = zip(ranking[name].values.tolist(), units, strict=True)
        columns[head] = [(pretty(amount(peak, unit)) if peak else "", "") for peak, unit in peaks]
    out = []
    for right, (head, cells) in zip((6.0, 34.0, 75.0), columns.items(), strict=True):
        out.append(FigureWords(end, 0.0, head, right=right, up=3.0))
        for row, (text, verdict) in enumerate(cells):
            colour = f"{verdict}-text" if f"{verdict}-text" in ON_PAPER else "ink"
            out.append(FigureWords(end, row + 0.75, text, colour, right=right))
    return out


def element_figures(
    run: Run, elements: Sequence[str], x: str, effects: Sequence[str], marks: bool | None
) -> dict[str, Figure]:
    """Figures by name: of each quantity among the labels, or of all, with dominance over time."""
    marked = run.trajectory.n_set_points <= MOST_MARKED_SET_POINTS if marks is None else marks
    out = {}
    for letter, name in (("D", "inertia"), ("h", "coriolis_centrifugal"), ("c", "gravity_loading")):
        labels = tuple(label for label in elements if label.startswith(letter))
        if labels or not elements:
            look = Look(labels, x.replace("-", " "), tuple(effects), marked)
            out[name] = inertia_figure(run, look) if letter == "D" else vector_figure(run, name, look)
    if not elements:
        out["dominance"] = dominance_figure(run)
    elif not out:
        labels_text = ", ".join(elements)
        raise UsageError(
            "there is no such element", where="element", expected="D12, h3, c2", found=labels_text
        )
    return out


def element_numbers(run: Run, labels: Sequence[str]) -> str:
    """CSV of elements at every set point: parts, shares, torque, verdict; all elements without labels."""
    over_time, ranking = run.tables["dominance_over_time"], run.dominance
    if labels:
        over_time, ranking = over_time.sel(element=list(labels)), ranking.sel(element=list(labels))
    shares = {"_of_peak": over_time.dominance, "_of_value": over_time.share}
    columns = {"unit": ranking.unit.reset_coords(drop=True)}
    for suffix, parts in ({"": over_time.dominance * ranking.peak} | shares).items():
        columns |= {f"{effect}{suffix}": parts.sel(effect=effect, drop=True) for effect in EFFECTS}
    for source in over_time.source.values.tolist():
        columns[f"{source}_consequence"] = over_time.part_consequence.sel(source=source, drop=True)
    table = over_time[["torque", "drive_torque", "consequence"]].assign(columns)
    table = table.assign(verdict=verdicts(over_time))
    return str(table.to_dataframe(dim_order=["element", "time"]).to_csv(lineterminator="\n"))
