"""The arm along its motion: poses and the path of the end effector, in an oblique view and along the axes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray, evenly, set_points_last
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    Axis,
    Curve,
    Figure,
    FigureWords,
    Item,
    Panel,
    broken,
    tick_label,
    ticks,
)
from gd_analyze.figures.run import Run
from gd_analyze.robots.arm import RobotArm

_DRAWN_POSES = 7
# Most points of the end effector's path.
_MOST_PATH_POINTS = 600
# Most poses that a page plays.
MOST_FRAMES = 240
# Width and height of the oblique view, and of a view along an axis, pt.
_OBLIQUE_SIZE = (212.0, 172.0)
_AXIS_VIEW_SIZE = (FIGURE_WIDTH / 2, 130.0)
# Torques this far below the largest are round-off of sums that cancel.
_ROUND_OFF = 1e-14


class View(NamedTuple):
    """An orthographic projection: unit vectors to the right and upward."""

    title: str
    right: FloatArray
    up: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Coordinates in the view of points (..., 3), m, shape (..., 2)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def arm_figure(run: Run) -> Figure:
    """Poses of the arm along the trajectory above a grid with labelled step, and the end effector's path."""
    frame = upright_frame(run.arm)
    moved, path = (points @ frame.T for points in _moved(run))
    all_points = np.concatenate([moved.reshape(-1, 3), path])
    flat = flat_normal(all_points)
    view = _turned(*view_angles(flat))
    low, step, grid = _grid(all_points, flat)
    x, y = _equal_axes(
        view.project(np.concatenate([all_points, *grid])), _OBLIQUE_SIZE[0] - 16, _OBLIQUE_SIZE[1] - 28
    )
    items: list[Item] = [_spatial(view, line, "line", 0.5) for line in grid]
    gaps = run.gaps_among(evenly(run.trajectory.n_set_points, _MOST_PATH_POINTS))
    if flat is None:
        shadow = path * (1, 1, 0) + (0, 0, low[2])
        items.append(_spatial(view, broken(shadow.T, gaps).T, "soft", 0.6, dashes=(1.5, 2.5)))
        foot = moved[0, 0] * (1, 1, 0) + (0, 0, low[2])
        items.append(_spatial(view, np.stack([moved[0, 0], foot]), "combined", 4.0, opacity=0.45))
    items += _poses(view, moved)
    items.append(_spatial(view, broken(path.T, gaps).T, "series-4", 1.4))
    ends = view.project(path[[0, -1]])
    is_closed = np.ptp(ends, axis=0).max() < 0.03 * (x.high - x.low)
    is_upward = bool(ends[0, 1] < ends[1, 1])
    names = [(0, "start"), (-1, "end")]
    if is_closed:
        names = [(0, "start and end" if len(path) > 1 else "end effector")]
    for k, name in names:
        at = path[k]
        items.append(_spatial(view, at[None].repeat(2, axis=0), "series-4", 5.0))
        if k == 0:
            items.append(_spatial(view, at[None].repeat(2, axis=0), "paper", 3.0))
        up = -11.0 if (k == 0) == is_upward and not is_closed else 5.0
        items.append(_words(view, at, name, up, bold=True))
    items += [*_axis_names(view, frame, moved[0, 0], 0.8 * step)]
    items.append(FigureWords(x.low, y.low, f"grid {tick_label(step)} m", size=6.5, up=-9.0))
    panel = Panel("arm", "", x, y, tuple(items), is_bare=True, margins=(8.0, 16.0, 8.0, 12.0))
    title = "The arm along the trajectory: poses, and the path of its end effector"
    return Figure(title, ((panel,),), *_OBLIQUE_SIZE)


def views_figure(run: Run) -> Figure:
    """The arm along the axes of its base frame: two views, or one for a planar arm."""
    moved, path = _moved(run)
    all_points = np.concatenate([moved.reshape(-1, 3), path])
    panels, margins = [], (26.0, 12.0, 8.0, 14.0)
    gaps = run.gaps_among(evenly(run.trajectory.n_set_points, _MOST_PATH_POINTS))
    for view in _plain_views(upright_frame(run.arm), all_points):
        wide, high = (
            _AXIS_VIEW_SIZE[0] - margins[0] - margins[2],
            _AXIS_VIEW_SIZE[1] - margins[1] - margins[3],
        )
        x, y = _equal_axes(view.project(all_points), wide, high)
        path_points = view.project(broken(path.T, gaps).T)
        items = [
            *_poses(view, moved),
            Curve(path_points[:, 0], path_points[:, 1], "series-4", 1.4, label=f"end effector {view.title}"),
        ]
        for k, hollow in ((0, True), (-1, False)):
            end = view.project(path[k])
            items.append(Curve(end[:1], end[1:], "series-4", 0.0, marker="circle", size=4.5, hollow=hollow))
        corner = f"{_axis_name(view.right)} to the right, {_axis_name(view.up)} up, m"
        panels.append(Panel(view.title, view.title, x, y, tuple(items), corner, margins=margins))
    return Figure("The arm along the axes of its base frame", (tuple(panels),), *_AXIS_VIEW_SIZE)


def playable(run: Run) -> dict[str, Any]:
    """Poses that a page plays, and the projection of points in space onto the drawing of `arm_figure`."""
    arm, motion = run.arm, run.trajectory
    figure, frame = arm_figure(run), upright_frame(arm)
    (panel,) = figure.panels
    moved, path = (points @ frame.T for points in _moved(run))
    frames = evenly(motion.n_set_points, MOST_FRAMES)
    torque = run.exact_torque
    torque = np.where(np.abs(torque) > _ROUND_OFF * np.abs(torque).max(), torque, 0.0)[frames]
    azimuth, elevation = view_angles(flat_normal(np.concatenate([moved.reshape(-1, 3), path])))
    wide = figure.width - panel.margins[0] - panel.margins[2]
    return {
        "point": (frames + 1).tolist(),
        "time": [float(f"{t:.6g}") for t in motion.time[frames]],
        "poses": np.round(skeleton(arm, motion.q[frames]) @ frame.T, 4).tolist(),
        "q": [[float(f"{v:.5g}") for v in row] for row in motion.q[frames]],
        "torque": [[float(f"{v:.4g}") for v in row] for row in torque],
        "joints": [[joint.kind == "revolute", joint.effort_unit] for joint in arm.joints],
        "azimuth": azimuth,
        "elevation": elevation,
        "origin": [panel.x.low, panel.y.high],
        "corner": [panel.margins[0], panel.margins[3]],
        "scale": wide / (panel.x.high - panel.x.low),
    }


def skeleton(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Origins of the base, of every joint and of its link's frame, m, shape (N, 2 n + 1, 3)."""
    kinematics = solve_kinematics(arm, set_points_last(q))
    points = np.zeros((len(q), 2 * arm.n_joints + 1, 3))
    for i in range(arm.n_joints):
        points[:, 2 * i + 1] = kinematics.joint_origins[i].T
        points[:, 2 * i + 2] = kinematics.link_origins[i].T
    return points


def upright_frame(arm: RobotArm) -> FloatArray:
    """Unit vectors of the drawing, rows: two horizontal ones and up, against gravity (z without gravity)."""
    strength = float(np.linalg.norm(arm.gravity_vector))
    up = -np.asarray(arm.gravity_vector) / strength if strength > 0 else np.array([0.0, 0.0, 1.0])
    first = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up]) + 0.0


def flat_normal(points: FloatArray) -> int | None:
    """Axis of `upright_frame` along which the arm never moves; None if there is none."""
    across = np.ptp(points.reshape(-1, 3), axis=0)
    return int(across.argmin()) if across.min() <= 1e-6 * across.max() else None


def view_angles(flat: int | None) -> tuple[float, float]:
    """Azimuth and elevation of the view, degrees: head-on for a flat arm, otherwise from above and aside."""
    return {None: (-52.0, 24.0), 0: (0.0, 0.0), 1: (-90.0, 0.0), 2: (-90.0, 90.0)}[flat]


def _turned(azimuth: float, elevation: float) -> View:
    a, e = np.radians([azimuth, elevation])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return View("oblique view", right, np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]))


def _plain_views(frame: FloatArray, points: FloatArray) -> tuple[View, ...]:
    """Views along the frame's axes, largest motion first: two, or one for a planar arm."""
    names = {(0, 1): "from above", (0, 2): "from the front", (1, 2): "from the side"}
    across = np.ptp(points @ frame.T, axis=0)
    flat = 1e-6 * float(across.max())
    pairs = [pair for pair in combinations(range(3), 2) if min(across[list(pair)]) > flat] or [(0, 2)]
    pairs.sort(key=lambda pair: -across[pair[0]] * across[pair[1]])
    return tuple(View(names[pair], frame[pair[0]], frame[pair[1]]) for pair in pairs[:2])


def _moved(run: Run) -> tuple[FloatArray, FloatArray]:
    """Some poses along the trajectory, and the path of the end effector, m."""
    arm, motion = run.arm, run.trajectory
    poses = skeleton(arm, motion.q[evenly(motion.n_set_points, _DRAWN_POSES)])
    return poses, skeleton(arm, motion.q[evenly(motion.n_set_points, _MOST_PATH_POINTS)])[:, -1]


def _spatial(view: View, points: FloatArray, colour: str, width: float, **more: Any) -> Curve:
    """A line through points in the upright frame, shape (N, 3), which a page can turn."""
    x, y = view.project(points).T
    return Curve(x, y, colour, width, space=points, **more)


def _words(view: View, at: FloatArray, name: str, up: float, **more: Any) -> FigureWords:
    """A name at a point in the upright frame."""
    u, v = view.project(at).tolist()
    return FigureWords(u, v, name, "ink", "middle", 7.0, up=up, space=tuple(at.tolist()), **more)


def _poses(view: View, moved: FloatArray) -> Iterator[Curve]:
    """The arm at some set points, later ones darker; the last is thick at the base and thin at the end."""
    for rank, points in enumerate(moved[:-1], start=1):
        yield _spatial(view, points, "ink", 1.6, opacity=0.1 + 0.4 * rank / len(moved))
    last = moved[-1]
    for i, limb in enumerate(pairwise(last)):
        if np.ptp(limb, axis=0).any():
            yield _spatial(view, np.array(limb), "ink", 4.0 * (1 - 0.6 * i / len(last)))
    for joint in last[1::2]:
        yield _spatial(view, joint[None].repeat(2, axis=0), "paper", 1.6)


def _equal_axes(points: FloatArray, width: float, height: float) -> tuple[Axis, Axis]:
    """Axes of equal scale that show points (N, 2) in the given size, pt."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, extent = (low + high) / 2, np.maximum(high - low, 1e-9)
    scale = 0.94 * min(width / extent[0], height / extent[1])
    half = np.array([width, height]) / (2 * scale)
    spans = [(float(middle[c] - half[c]), float(middle[c] + half[c])) for c in range(2)]
    x, y = (Axis(*span, tuple(ticks(*span, most))) for span, most in zip(spans, (5, 4), strict=True))
    return x, y


def _grid(points: FloatArray, flat: int | None) -> tuple[FloatArray, float, list[FloatArray]]:
    """Lowest coordinates, step, and lines of a grid under the arm, or in the plane of a flat one."""
    normal = 2 if flat is None else flat
    first_axis, second_axis = (k for k in range(3) if k != normal)
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    tick_values = ticks(0.0, max(extent[first_axis], extent[second_axis], 1e-3), 4)
    step = tick_values[1] - tick_values[0]
    first = np.floor(low / step + 1e-6) * step
    last = np.maximum(np.ceil(high / step - 1e-6) * step, first + step)
    lines = []
    for axis, across in ((first_axis, second_axis), (second_axis, first_axis)):
        for value in np.arange(first[axis], last[axis] + step / 2, step):
            ends = np.zeros((2, 3))
            ends[:, axis] = value
            ends[:, across] = first[across], last[across]
            ends[:, normal] = low[normal]
            lines.append(ends)
    return low, step, lines


def _axis_names(view: View, frame: FloatArray, base: FloatArray, length: float) -> Iterator[Item]:
    """Visible axes of the base frame."""
    for axis, name in zip(frame.T, "xyz", strict=True):
        tip = base + length * axis
        if np.hypot(*view.project(tip - base)) > 0.15 * length:
            yield _spatial(view, np.stack([base, tip]), "ink", 0.9)
            yield _words(view, base + 1.25 * length * axis, name, -2.5, italic=True)


def _axis_name(vector: FloatArray) -> str:
    """Name of a base-frame axis, with its sign; "tilted" for any other direction."""
    k = int(np.abs(vector).argmax())
    if abs(abs(vector[k]) - 1) > 1e-9:
        return "tilted"
    return ("−" if vector[k] < 0 else "") + "xyz"[k]
