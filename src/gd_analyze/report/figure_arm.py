"""The arm and its motion drawn: poses along the trajectory in an oblique and two plain views."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.report.colours import GREY, ON_PAPER, PALE
from gd_analyze.report.motion import skeleton
from gd_analyze.report.panel import (
    MOST_POINTS,
    WIDTH,
    Panel,
    add_frame,
    add_line,
    add_text,
    new_figure,
    ticks,
)
from gd_analyze.report.thinning import evenly, thinned
from gd_analyze.report.views import View, oblique_view, plain_views, upright_frame
from gd_analyze.results import Findings
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 262.0
POSES = 9
# Places of the arm to look at, of a long trajectory: ten for each that the path of the hand shows.
MOST_PLACES = 5000
_PATH = ON_PAPER["rotation"]


def arm_figure(findings: Findings) -> Figure:
    """Poses of the arm along the trajectory, and the path of its hand."""
    arm = findings.arm
    q = findings.trajectory.q
    moved = skeleton(arm, q[evenly(len(q), MOST_PLACES)])
    figure = new_figure(WIDTH, HEIGHT)
    frame = upright_frame(arm)
    plain = plain_views(frame, moved)
    _draw_view(figure, oblique_view(frame), moved, (0.0, 0.0, 250.0, HEIGHT), frame)
    height = HEIGHT / len(plain)
    for k, view in enumerate(plain):
        _draw_view(figure, view, moved, (262.0, HEIGHT - (k + 1) * height, WIDTH - 262.0, height), None)
    return figure


def _draw_view(
    figure: Figure,
    view: View,
    moved: FloatArray,
    box: tuple[float, float, float, float],
    frame: FloatArray | None,
) -> None:
    """Draw one view into a box (left, bottom, width, height); with `frame`, on a floor instead of ticks."""
    left, bottom, width, height = box
    poses, hand = evenly(len(moved), POSES), moved[:, -1]
    floor = np.zeros((0, 2, 3)) if frame is None else _floor(moved, frame)
    shown = np.concatenate([view.project(moved).reshape(-1, 2), view.project(floor).reshape(-1, 2)])
    margin = (4.0, 4.0, 4.0, 14.0) if frame is not None else (30.0, 20.0, 8.0, 14.0)
    room = (
        left + margin[0],
        bottom + margin[1],
        width - margin[0] - margin[2],
        height - margin[1] - margin[3],
    )
    panel = equal_panel(shown, room)
    add_text(figure, left + margin[0], bottom + height - 9, view.title, 7.5)
    if frame is None:
        x_ticks, y_ticks = ticks(panel.x, 5), ticks(panel.y, 4)
        add_frame(figure, panel, x_ticks=x_ticks, y_ticks=y_ticks)
        axes = f"{_axis_name(view.right)} to the right, {_axis_name(view.up)} up, m"
        add_text(figure, left + width - margin[2], bottom + height - 9, axes, 6.5, ha="right", color=GREY)
    else:
        for line in floor:
            add_line(figure, panel, *view.project(line).T, color=PALE, linewidth=0.5)
        low = float((moved @ frame[2]).min())
        shadow = hand + np.outer(low - hand @ frame[2], frame[2])
        _draw_path(figure, panel, view.project(shadow), color=GREY, linewidth=0.6, dashes=(1.5, 1.5))
    for rank, k in enumerate(poses):
        _draw_pose(figure, panel, view.project(moved[k]), (rank + 1) / len(poses))
    _draw_path(
        figure,
        panel,
        view.project(hand),
        color=_PATH,
        linewidth=1.4,
        zorder=5,
        label=f"hand {view.title}",
    )
    ends = view.project(hand[[0, -1]])
    for end, fill in zip(ends, ("white", _PATH), strict=True):
        add_line(
            figure,
            panel,
            end[:1],
            end[1:],
            marker="o",
            markersize=4.5,
            markerfacecolor=fill,
            markeredgecolor=_PATH,
            markeredgewidth=1.0,
            zorder=6,
        )


def equal_panel(points: FloatArray, room: tuple[float, float, float, float]) -> Panel:
    """Panel that fills a room (left, bottom, width, height) with points (N, 2), one scale both ways."""
    left, bottom, width, height = room
    low, high = points.min(axis=0), points.max(axis=0)
    middle, extent = (low + high) / 2, np.maximum(high - low, 1e-9)
    scale = 0.94 * min(width / extent[0], height / extent[1])
    half = np.array([width, height]) / (2 * scale)
    x, y = ((float(middle[c] - half[c]), float(middle[c] + half[c])) for c in range(2))
    return Panel(left, bottom, width, height, x, y)


def _draw_pose(figure: Figure, panel: Panel, points: FloatArray, share: float) -> None:
    """Draw the arm's skeleton, the later the darker, thinner toward the hand."""
    shade = 0.86 - 0.72 * share
    colour = (shade, shade, shade)
    n = (len(points) - 1) // 2
    last = share == 1.0
    full = 4.0 if last else 2.2
    for i in range(len(points) - 1):
        ends = points[i : i + 2]
        if np.ptp(ends, axis=0).max() == 0.0:
            continue
        width = full * (1 - 0.6 * (i / 2) / max(n, 1))
        add_line(
            figure, panel, *ends.T, color=colour, linewidth=width, solid_capstyle="round", zorder=2 + share
        )
    joints = points[1::2]
    add_line(
        figure,
        panel,
        *joints.T,
        linestyle="none",
        marker="o",
        markersize=3.6 if last else 1.8,
        markerfacecolor="white",
        markeredgecolor=colour,
        markeredgewidth=0.9 if last else 0.6,
        zorder=2.1 + share,
    )


def _draw_path(figure: Figure, panel: Panel, path: FloatArray, **style: object) -> None:
    chosen = thinned(path.T, MOST_POINTS)
    add_line(figure, panel, *path[chosen].T, **style)


def _floor(points: FloatArray, frame: FloatArray) -> FloatArray:
    """Lines of a horizontal grid just under everything drawn, shape (lines, 2, 3)."""
    along = points.reshape(-1, 3) @ frame.T
    low, high = along.min(axis=0), along.max(axis=0)
    step = 10.0 ** np.floor(np.log10(max(float((high - low)[:2].max()), 1e-6)))
    step = step / 5 if (high - low)[:2].max() < 3 * step else step / 2
    first, last = np.floor(low / step) * step, np.ceil(high / step) * step
    last = np.maximum(last, first + step)
    lines = []
    for axis, other in ((0, 1), (1, 0)):
        for value in np.arange(first[axis], last[axis] + step / 2, step):
            ends = np.zeros((2, 3))
            ends[:, axis] = value
            ends[:, other] = first[other], last[other]
            ends[:, 2] = low[2]
            lines.append(ends @ frame)
    return np.array(lines)


def _axis_name(vector: FloatArray) -> str:
    """Name of a base-frame axis, with its sign; in words for any other direction."""
    k = int(np.abs(vector).argmax())
    if abs(abs(vector[k]) - 1) > 1e-9:
        return "tilted"
    return ("−" if vector[k] < 0 else "") + "xyz"[k]
