"""The arm and its motion drawn: poses along the trajectory in an oblique and two plain views.

All views are orthographic projections onto two unit vectors, so lengths along an axis can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.report.colours import GREY, ON_PAPER, PALE
from gd_analyze.report.motion import Motion, motion
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
from gd_analyze.report.thinning import thinned
from gd_analyze.results import Findings
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 262.0
POSES = 9
_PATH = ON_PAPER["rotation"]


@dataclass(frozen=True)
class View:
    """A projection: drawn to the right and upward are the coordinates along two unit vectors."""

    title: str
    right: FloatArray
    up: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Coordinates on paper of points (..., 3), m, shape (..., 2)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def arm_figure(findings: Findings) -> Figure:
    """Poses of the arm along the trajectory, and the path of its hand."""
    arm = findings.arm
    moved = motion(arm, findings.trajectory.q)
    figure = new_figure(WIDTH, HEIGHT)
    frame = upright_frame(arm)
    oblique = _oblique(frame)
    plain = _plain_views(frame, moved.points)
    _draw_view(figure, oblique, moved, (0.0, 0.0, 250.0, HEIGHT), frame)
    height = HEIGHT / len(plain)
    for k, view in enumerate(plain):
        _draw_view(figure, view, moved, (262.0, HEIGHT - (k + 1) * height, WIDTH - 262.0, height), None)
    return figure


def upright_frame(arm: RobotArm) -> FloatArray:
    """Unit vectors to draw by, rows: two horizontal ones and up, against gravity (z without gravity)."""
    strength = float(np.linalg.norm(arm.gravity))
    up = -np.asarray(arm.gravity) / strength if strength > 0 else np.array([0.0, 0.0, 1.0])
    first = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up]) + 0.0


def _oblique(frame: FloatArray) -> View:
    """Look down on the arm from the front, 25 degrees above the horizon."""
    turn, tilt = np.radians(-52.0), np.radians(24.0)
    right = np.cos(turn + np.pi / 2) * frame[0] + np.sin(turn + np.pi / 2) * frame[1]
    toward = np.cos(turn) * frame[0] + np.sin(turn) * frame[1]
    return View("oblique view", right, np.cos(tilt) * frame[2] - np.sin(tilt) * toward)


def _plain_views(frame: FloatArray, points: FloatArray) -> tuple[View, ...]:
    """Views along the frame's axes, largest motion first: two, or one of an arm that stays in a plane."""
    names = {(0, 1): "from above", (0, 2): "from the front", (1, 2): "from the side"}
    across = np.ptp(points.reshape(-1, 3) @ frame.T, axis=0)
    flat = 1e-6 * float(across.max())
    pairs = [pair for pair in combinations(range(3), 2) if min(across[list(pair)]) > flat] or [(0, 2)]
    pairs.sort(key=lambda pair: -across[pair[0]] * across[pair[1]])
    return tuple(View(names[pair], frame[pair[0]], frame[pair[1]]) for pair in pairs[:2])


def _draw_view(
    figure: Figure,
    view: View,
    moved: Motion,
    box: tuple[float, float, float, float],
    frame: FloatArray | None,
) -> None:
    """Draw one view into a box (left, bottom, width, height); with `frame`, on a floor instead of ticks."""
    left, bottom, width, height = box
    poses = _poses(len(moved.points))
    hand = moved.hand
    floor = _floor(moved.points, frame) if frame is not None else None
    shown = [view.project(moved.points).reshape(-1, 2), view.project(hand)]
    shown += [view.project(floor.reshape(-1, 3))] if floor is not None else []
    margin = (4.0, 4.0, 4.0, 14.0) if frame is not None else (30.0, 20.0, 8.0, 14.0)
    room = (
        left + margin[0],
        bottom + margin[1],
        width - margin[0] - margin[2],
        height - margin[1] - margin[3],
    )
    panel = equal_panel(np.concatenate(shown), room)
    title_at = left + margin[0]
    add_text(figure, title_at, bottom + height - 9, view.title, 7.5)
    if frame is None:
        x_ticks, y_ticks = ticks(panel.x, 5), ticks(panel.y, 4)
        add_frame(figure, panel, x_ticks=x_ticks, y_ticks=y_ticks)
        axes = f"{_axis_name(view.right)} to the right, {_axis_name(view.up)} up, m"
        add_text(figure, left + width - margin[2], bottom + height - 9, axes, 6.5, ha="right", color=GREY)
    elif floor is not None:
        for line in floor:
            add_line(figure, panel, *view.project(line).T, color=PALE, linewidth=0.5)
        low = float((moved.points @ frame[2]).min())
        shadow = hand + np.outer(low - hand @ frame[2], frame[2])
        _draw_path(figure, panel, view.project(shadow), color=GREY, linewidth=0.6, dashes=(1.5, 1.5))
    for rank, k in enumerate(poses):
        share = (rank + 1) / len(poses)
        _draw_pose(figure, panel, view.project(moved.points[k]), share)
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


def _poses(count: int) -> list[int]:
    """Evenly spaced set points to draw the arm at, first and last among them."""
    return sorted({round(k) for k in np.linspace(0, count - 1, min(POSES, count))})


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
