"""The arm and its motion drawn: poses along the trajectory in an oblique view and in plain ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.report.canvas import Canvas
from gd_analyze.report.motion import skeleton
from gd_analyze.report.panel import MOST_POINTS, WIDTH, Panel, add_frame, ticks
from gd_analyze.report.thinning import breaks, broken, evenly, thinned
from gd_analyze.report.views import View, oblique_view, plain_views, upright_frame
from gd_analyze.results.findings import Findings

POSES = 9
# Places of the arm to look at, of a long trajectory: ten for each that the path of the hand shows.
MOST_PLACES = 5000
_OBLIQUE, _PLAIN = (212.0, 172.0), (WIDTH, 190.0)


def arm_figure(findings: Findings) -> Canvas:
    """Poses of the arm along the trajectory above a floor, and the path of its hand."""
    frame, moved = upright_frame(findings.arm), _moved(findings)
    view, floor = oblique_view(frame), _floor(moved, frame)
    canvas = Canvas(*_OBLIQUE)
    every = np.concatenate([view.project(moved).reshape(-1, 2), view.project(floor).reshape(-1, 2)])
    panel = equal_panel(every, (2.0, 2.0, canvas.width - 4, canvas.height - 4))
    lines = [panel.place(*view.project(line).T).ravel() for line in floor]
    canvas.segments([(a, b, c, d) for a, b, c, d in lines], "line", 0.5)
    hand = moved[:, -1]
    low = float((moved @ frame[2]).min())
    shadow = hand + np.outer(low - hand @ frame[2], frame[2])
    cuts = _cuts(findings)
    _draw_path(canvas, panel, view.project(shadow), "soft", 0.6, dashes=(1.5, 1.5), cuts=cuts)
    _draw_motion(canvas, panel, view, moved, cuts)
    return canvas


def views_figure(findings: Findings) -> Canvas:
    """The same seen along the axes: two views side by side, or one of an arm that stays in a plane."""
    moved = _moved(findings)
    plain = plain_views(upright_frame(findings.arm), moved)
    width, height = _PLAIN
    pitch = width / 2
    canvas = Canvas(pitch * len(plain), height)
    for k, view in enumerate(plain):
        room = (k * pitch + 26.0, 18.0, pitch - 34.0, height - 34.0)
        panel = equal_panel(view.project(moved).reshape(-1, 2), room)
        canvas.text(room[0], height - 9, view.title, 7.5)
        add_frame(canvas, panel, x_ticks=ticks(panel.x, 5), y_ticks=ticks(panel.y, 4))
        axes = f"{_axis_name(view.right)} to the right, {_axis_name(view.up)} up, m"
        canvas.text(panel.right, height - 9, axes, 6.5, colour="soft", anchor="end")
        _draw_motion(canvas, panel, view, moved, _cuts(findings))
    return canvas


def _moved(findings: Findings) -> FloatArray:
    """Where the arm is along the trajectory, m, shape (places, points, 3)."""
    return skeleton(findings.arm, findings.trajectory.q[_places(findings)])


def _places(findings: Findings) -> NDArray[np.intp]:
    """Set points at which the arm is looked at."""
    return evenly(findings.trajectory.n_set_points, MOST_PLACES)


def _cuts(findings: Findings) -> NDArray[np.intp]:
    """Places among them before which the path of the hand breaks."""
    return breaks(_places(findings), findings.trajectory.gaps)


def _draw_motion(canvas: Canvas, panel: Panel, view: View, moved: FloatArray, cuts: NDArray[np.intp]) -> None:
    """Draw some postures, and the path of the hand from an open to a filled circle."""
    poses, hand = evenly(len(moved), POSES), view.project(moved[:, -1])
    for rank, k in enumerate(poses):
        _draw_pose(canvas, panel, view.project(moved[k]), (rank + 1) / len(poses))
    _draw_path(canvas, panel, hand, "rotation", 1.4, cuts=cuts, order=5, label=f"hand {view.title}")
    for end, fill in ((hand[:1], "paper"), (hand[-1:], "rotation")):
        canvas.mark(panel.place(*end.T), "rotation", 4.5, fill=fill, edge=1.0, order=6)


def equal_panel(points: FloatArray, room: tuple[float, float, float, float]) -> Panel:
    """Panel that fills a room (left, bottom, width, height) with points (N, 2), one scale both ways."""
    left, bottom, width, height = room
    low, high = points.min(axis=0), points.max(axis=0)
    middle, extent = (low + high) / 2, np.maximum(high - low, 1e-9)
    scale = 0.94 * min(width / extent[0], height / extent[1])
    half = np.array([width, height]) / (2 * scale)
    x, y = ((float(middle[c] - half[c]), float(middle[c] + half[c])) for c in range(2))
    return Panel(left, bottom, width, height, x, y)


def _draw_pose(canvas: Canvas, panel: Panel, points: FloatArray, share: float) -> None:
    """Draw the arm's skeleton, the later the darker, thinner toward the hand."""
    shade = f"{round(255 * (0.86 - 0.72 * share)):02x}"
    colour, last = f"#{3 * shade}", share == 1.0
    placed = panel.place(*points.T)
    links = len(placed) - 1
    for i in range(links):
        if not np.ptp(points[i : i + 2], axis=0).any():
            continue
        width = (4.0 if last else 2.2) * (1 - 0.6 * (i // 2) / max(links // 2, 1))
        (x, y), (to_x, to_y) = placed[i : i + 2].tolist()
        canvas.segments([(x, y, to_x, to_y)], colour, width, rounded=True, order=2 + share)
    size, edge = (3.6, 0.9) if last else (1.8, 0.6)
    canvas.mark(placed[1::2], colour, size, fill="paper", edge=edge, order=2.1 + share)


def _draw_path(
    canvas: Canvas,
    panel: Panel,
    path: FloatArray,
    colour: str,
    width: float,
    *,
    cuts: NDArray[np.intp],
    dashes: tuple[float, ...] = (),
    order: float = 2.0,
    label: str = "",
) -> None:
    chosen = thinned(path.T, MOST_POINTS)
    points = broken(panel.place(*path[chosen].T), breaks(chosen, cuts))
    canvas.line(points, colour, width, dashes=dashes, order=order, label=label)


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
