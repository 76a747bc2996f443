"""The structure of the dynamics: every element of D, h and c in its place, and what makes each torque.

Row i of the matrix reads as the equation of joint i: tau_i = sum_j D_ij qdd_j + h_i + c_i.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray, evenly
from gd_analyze.dynamics.decomposition import MOST_KEPT
from gd_analyze.dynamics.dominance import elements
from gd_analyze.figures.elements import subscripted
from gd_analyze.figures.figure import (
    Area,
    Axis,
    Curve,
    Figure,
    FigureWords,
    Item,
    LegendKey,
    Panel,
    short_joint_label,
)
from gd_analyze.figures.joints import CONTRIBUTIONS, torque_by_cause
from gd_analyze.figures.run import Run
from gd_analyze.text import percent

# Width of the matrix, pt.
MATRIX_WIDTH = 318.0
# Width of the bars beside it, pt.
BARS_WIDTH = 166.0
# Largest side of a cell, pt.
_LARGEST_CELL = 54.0


@dataclass(frozen=True)
class Cell:
    """Torque of an element as a share of its joint's peak torque, and the parts that make it."""

    label: str
    share: float  # from 0; above 1 where elements cancel
    joint: int  # where the share is largest, from 1
    crosses: bool  # whether that is not the joint of its row, but that of its column
    parts: Mapping[str, float]  # shares of the RMS of all parts, which sum to 1; by names of `CONTRIBUTIONS`
    verdict: str  # "zero", "negligible", "translation", "rotation", "both", "gravity" or "drive"


def cells(run: Run) -> dict[str, Cell]:
    """Every element of D, h and c by its label; on the diagonal the drive's largest torque is added."""
    ranking, out = run.dominance, {}
    rows = {element.label: element.i for element in elements(run.arm.n_joints)}
    columns = {str(name): values.values for name, values in ranking.data_vars.items()}
    for k, label in enumerate(ranking.element.values.tolist()):
        sizes = dict(zip(("translation", "rotation"), columns["part_rms"][k].tolist(), strict=True))
        if columns["quantity"][k] == "gravity_loading":
            sizes = {"gravity": sizes["translation"]}
        # Both are inertias, whose torques are these times the acceleration.
        sizes["drives"] = float(columns["drive"][k])
        total = sum(sizes.values())
        parts = {name: size / total for name, size in sizes.items() if size}
        share = float(columns["torque_share"][k] + columns["drive_torque_share"][k])
        joint = int(columns["torque_joint"][k])
        out[label] = Cell(label, share, joint, joint - 1 != rows[label], parts, str(columns["verdict"][k]))
    return out


def crosses(run: Run) -> bool:
    """Whether any share of the matrix is that of its column's joint."""
    return any(cell.crosses and _is_measured(cell) for cell in cells(run).values())


def _is_measured(cell: Cell) -> bool:
    return cell.verdict not in ("negligible", "zero")


def matrix_figure(run: Run) -> Figure:
    """D (upper triangle), h and c: a panel per element, whose area is its share of the peak torque."""
    n, by_label = run.arm.n_joints, cells(run)
    side = min(MATRIX_WIDTH / (n + 2), _LARGEST_CELL)
    rows: list[list[Panel | None]] = [[None] * (n + 2) for _ in range(n)]
    for element in elements(n):
        place = {"coriolis_centrifugal": n, "gravity_loading": n + 1}.get(element.quantity)
        column = element.j if place is None else place
        assert column is not None  # an element of D has a column
        panel = _cell(by_label[element.label], side)
        if place is not None:  # a line between D, h and c
            line = Curve(np.zeros(2), np.array([0.0, side]), "ink", 0.9)
            panel = replace(panel, items=(*panel.items, line))
        rows[element.i][column] = panel
    drives = ("drives",) if "drive_torque" in run.decomposition else ()
    legend = tuple(_key(name) for name in ("translation", "rotation", "gravity", *drives))
    if any(cell.verdict == "negligible" for cell in by_label.values()):
        legend += (LegendKey("negligible", "grid", "area"),)
    label = "Elements of D, h and c by their share of the joint's peak torque"
    return Figure(label, tuple(map(tuple, rows)), side, side, legend)


def _key(name: str) -> LegendKey:
    part = CONTRIBUTIONS[name]
    return part.key(part.label if part.letter == "h" else name)


def _cell(cell: Cell, side: float) -> Panel:
    """Label, share, and a square of the share's area, full from 100 %, cut by parts from the left."""
    size = min(0.18 * side, 8.0)
    edge, head = 1.0, 1.35 * size + 1.0
    room = side - head - 3.0 * edge
    is_grey = not _is_measured(cell)
    ground = "grid" if cell.verdict == "negligible" else "paper"
    frame = (
        np.array([edge, side - edge, side - edge, edge, edge]),
        np.array([edge, edge, side - edge, side - edge, edge]),
    )
    items: list[Item] = [_box(edge, side - edge, edge, side - edge, ground), Curve(*frame, "line", 0.5)]
    if not is_grey:
        reach = room * math.sqrt(min(cell.share, 1.0))
        left, low = (side - reach) / 2, 2.0 * edge + (room - reach) / 2
        for name in filter(cell.parts.__contains__, CONTRIBUTIONS):
            right = left + reach * cell.parts[name]
            items.append(_part(name, left, right, low, low + reach))
            left = right
    colour = "soft" if is_grey else "ink"
    top = side - edge - 1.05 * size
    items.append(FigureWords(edge + 1.5, top, subscripted(cell.label), colour, size=size, bold=not is_grey))
    if cell.verdict == "zero":
        items.append(FigureWords(side / 2, side / 2 - 0.7 * size, "0", colour, "middle", size))
    elif side > 26.0 and not is_grey:
        arrow, small = ("↓", 0.72 * size) if cell.crosses else ("", 0.8 * size)
        share = f"{arrow}{_share(cell.share)}"
        items.append(FigureWords(side - edge - 1.5, top, share, colour, "end", small))
    axis = Axis(0.0, side)
    return Panel(cell.label, "", axis, axis, tuple(items), is_bare=True, margins=(0.0, 0.0, 0.0, 0.0))


def _share(share: float) -> str:
    """A share in as few characters as a cell has room for."""
    if not math.isfinite(share):
        return "∞"
    return percent(share if share >= 0.095 else float(f"{share:.1g}"))


def _box(left: float, right: float, low: float, high: float, colour: str) -> Area:
    return Area(np.array([left, right]), np.full(2, low), np.full(2, high), colour)


def _part(name: str, left: float, right: float, low: float, high: float) -> Area:
    """A rectangle with its hatching."""
    part = CONTRIBUTIONS[name]
    return replace(_box(left, right, low, high, part.colour), hatching=part.hatching)


def shares_of_torque(run: Run) -> dict[str, FloatArray]:
    """RMS of each cause of every joint's torque over the sum of these RMS, shape (n,), by `CONTRIBUTIONS`.

    Zero at a joint without torque. Of a long motion, evenly spaced set points count.
    """
    selection = run.decomposition.isel(time=evenly(run.trajectory.n_set_points, MOST_KEPT))
    causes = torque_by_cause(selection)
    rms = {name: np.sqrt((part**2).mean(axis=0)) for name, part in causes.items()}
    total = np.sum([*rms.values()], axis=0)
    floor = float(run.decomposition.attrs["torque_round_off"])
    return {
        name: np.divide(rms[name], total, out=np.zeros_like(total), where=total > floor)
        for name in CONTRIBUTIONS
        if name in rms
    }


def shares_figure(run: Run) -> Figure:
    """A bar per joint: what makes its torque; rows as high as those of the matrix."""
    n, shares = run.arm.n_joints, shares_of_torque(run)
    side = min(MATRIX_WIDTH / (n + 2), _LARGEST_CELL)
    rows = tuple((_bar(run, i, {name: float(v[i]) for name, v in shares.items()}, side),) for i in range(n))
    legend = tuple(_key(name) for name in shares)
    return Figure("What makes each joint's torque, share of the sum of RMS", rows, BARS_WIDTH, side, legend)


def _bar(run: Run, joint: int, shares: Mapping[str, float], side: float) -> Panel:
    size = min(0.19 * side, 8.0)
    low, high = 2.0, side - 1.75 * size
    left, items = 0.0, list[Item]()
    for name, share in shares.items():
        part, right = CONTRIBUTIONS[name], left + BARS_WIDTH * share
        if right - left > 0.2:
            items.append(_part(name, left, right, low, high))
        label = f"{part.letter} {percent(share)}"
        for words in (label, label.split()[0]):
            # Text on its area, on a piece of paper where lines would run through it.
            wide = 0.6 * size * len(words) + 3.0
            if wide < right - left:
                middle, mid = (left + right) / 2, (low + high) / 2
                if part.hatching:
                    half = 0.62 * size
                    ends = middle - wide / 2, middle + wide / 2, mid - half, mid + half
                    items.append(_box(*ends, part.colour))
                colour = "paper" if name in ("translation", "rotation") else "ink"
                items.append(FigureWords(middle, mid - 0.34 * size, words, colour, "middle", size, bold=True))
                break
        left = right
    if not left:
        items.append(FigureWords(0.0, low + 2.0, "no torque beyond round-off", "soft", size=size))
    title = short_joint_label(run.arm.joints, joint, BARS_WIDTH, size)
    items.append(FigureWords(0.0, side - 1.25 * size, title, "ink", size=size, bold=True))
    axes = Axis(0.0, BARS_WIDTH), Axis(0.0, side)
    return Panel(f"bar{joint + 1}", "", *axes, tuple(items), is_bare=True, margins=(0.0, 0.0, 0.0, 0.0))
