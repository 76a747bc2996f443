"""Torque of every joint over time, stacked by what makes it: one drawing for page and paper."""

from __future__ import annotations

import numpy as np

from gd_analyze.report.canvas import Canvas
from gd_analyze.report.panel import MOST_POINTS, WIDTH, Panel, Scale, add_frame, ticks, whole_range
from gd_analyze.report.thinning import breaks, broken, thinned
from gd_analyze.results import summary
from gd_analyze.results.contributions import Contributions
from gd_analyze.results.findings import Findings
from gd_analyze.robots.parts import Joint
from gd_analyze.text import amount, pretty

_HEAD, _FOOT, _LEFT, _GAP = 12.0, 20.0, 22.0, 12.0
# A limit farther from zero than this many times the torque would leave no room to see what it is made of.
_NEAR = 1.6
# Height that a first page leaves; and of a line of words above, a frame around them, letters of a line.
_ROOM, _LINE, _FRAME, _LETTERS = 272.0, 13.0, 24.0, 105


def contributions_figure(findings: Findings) -> Canvas:
    """Stack positive parts above zero and negative ones below it; the line, their sum, is the torque."""
    parts, joints = Contributions.of(findings), findings.arm.joints
    columns = _columns(len(joints))
    rows = -(-len(joints) // columns)
    pitch = WIDTH / columns
    height = max(min((_ROOM - _said_above(findings)) / rows, 140.0), 56.0)
    canvas = Canvas(WIDTH, rows * height + _FOOT)
    for i, joint in enumerate(joints):
        left = (i % columns) * pitch + _LEFT
        bottom = _FOOT + (rows - 1 - i // columns) * height
        box = (left, bottom, pitch - _LEFT - _GAP, height - _HEAD - 8)
        below = i + columns >= len(joints)
        _joint_panel(canvas, parts, i, joint, box, findings.round_off, seconds=below)
    return canvas


def _said_above(findings: Findings) -> float:
    """Height that a notice and warnings take of the first page, beyond the two lines that have room."""
    warnings = [-(-len(said) // _LETTERS) for said in findings.warnings]
    notice = -(-len(str(summary.opening(findings)["notice"])) // _LETTERS)
    said = _LINE * (sum(warnings) + bool(warnings) + notice) + _FRAME * bool(warnings)
    return max(0.0, said - 2 * _LINE)


def _columns(n_joints: int) -> int:
    """Panels side by side: so few that they are wide, and so many that all of them fit on a page."""
    return {1: 1, 2: 2, 4: 2}.get(n_joints, 3 if n_joints <= 6 else 4)


def _joint_panel(
    canvas: Canvas,
    parts: Contributions,
    i: int,
    joint: Joint,
    box: tuple[float, float, float, float],
    noise: float,
    *,
    seconds: bool,
) -> None:
    """Draw one joint's torque, named and with its limit."""
    total, limit = parts.total[:, i], float(parts.limit[i])
    piles = [parts.pile(i, upward=upward) for upward in (True, False)]
    edges = [outer for pile in piles for _, outer in pile.values()]
    size = max((float(np.abs(edge).max()) for edge in edges), default=0.0)
    idle = size <= noise
    low, high = (min([0.0, *(e.min() for e in edges)]), max([0.0, *(e.max() for e in edges)]))
    near = not idle and limit <= _NEAR * size
    if near:
        low, high = (-limit if low < 0 else low), max(high, limit)
    room = 0.05 * (high - low)
    span = (-1.0, 1.0) if idle else (float(low - room), float(high + room))
    panel = Panel(*box, whole_range(parts.time), span)
    scale = Scale.of(span, joint.effort_unit)
    add_frame(
        canvas,
        panel,
        x_ticks=ticks(panel.x, 4),
        y_ticks=[0.0] if idle else ticks(span, 4),
        labels="xy" if seconds else "y",
        scale=scale,
    )
    if seconds:
        canvas.text(panel.right, panel.bottom - 16, "time, s", 6, colour="soft", anchor="end")
    if not idle:
        _draw_piles(canvas, parts, panel, piles, i)
    chosen = thinned(total[None], MOST_POINTS)
    line = broken(panel.place(parts.time[chosen], total[chosen]), breaks(parts.points[chosen], parts.gaps))
    canvas.line(line, "ink", 1.2, order=3, label=f"total {i + 1}")
    if near:
        for sign in (1.0, -1.0):
            if span[0] <= sign * limit <= span[1]:
                ends = panel.place(np.array(panel.x), np.full(2, sign * limit))
                canvas.line(ends, "warn", 0.9, dashes=(4, 2), order=3, label=f"limit {i + 1}")
    _name(canvas, panel, i, joint, scale.unit, limit)


def _draw_piles(
    canvas: Canvas,
    parts: Contributions,
    panel: Panel,
    piles: list[dict[str, tuple[np.ndarray, np.ndarray]]],
    i: int,
) -> None:
    """Fill the area of every part; all of them at the same set points, so that none overlaps another."""
    every = np.stack([edge for pile in piles for pair in pile.values() for edge in pair])
    chosen = thinned(every, MOST_POINTS)
    # A single set point is as wide as the panel.
    time = parts.time[chosen] if len(chosen) > 1 else np.array(panel.x)
    cuts = breaks(parts.points[chosen], parts.gaps)
    for pile in piles:
        for name, edges in pile.items():
            inner, outer = (np.split(np.broadcast_to(edge[chosen], time.shape), cuts) for edge in edges)
            for when, near, far in zip(np.split(time, cuts), inner, outer, strict=True):
                around = np.concatenate([panel.place(when, far), panel.place(when, near)[::-1]])
                canvas.area(around, f"area-{name}", order=1.5, label=f"{name} {i + 1}")


def _name(canvas: Canvas, panel: Panel, i: int, joint: Joint, unit: str, limit: float) -> None:
    """Write number, name and unit above a panel, and the limit at its right where there is one."""
    limited = f"limit {pretty(amount(limit, joint.effort_unit))}" if np.isfinite(limit) else ""
    room = panel.width - 3.0 * len(limited) - 3.6 * len(unit) - 22
    fitting = max(int(room / 3.7), 3)
    name = joint.name if len(joint.name) <= fitting else joint.name[: fitting - 1] + "…"
    named = f"{i + 1}" if joint.name == str(i + 1) else f"{i + 1} {name}"
    y = panel.top + 4
    canvas.text(panel.left - 14, y, f"{named}, {unit}", 7.5, weight="bold")
    if limited:
        canvas.text(panel.right, y, limited, 6, colour="soft", anchor="end")
