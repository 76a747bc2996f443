"""Every joint over time: motion, readings, torque by contribution, its error, and measured torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    HATCHING,
    Area,
    Curve,
    Figure,
    Item,
    LegendKey,
    Panel,
    broken,
    in_columns,
    over_time,
    short_joint_label,
    time_axis,
    value_axis,
)
from gd_analyze.figures.run import Run
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.parts import Joint
from gd_analyze.schema import SCHEMA_UNITS
from gd_analyze.text import amount, pretty

if TYPE_CHECKING:
    import xarray as xr


class Contribution(NamedTuple):
    """How a contribution to torque is drawn: its colour is that of its effect, paler for h."""

    label: str
    colour: str
    letter: str
    hatching: str = ""

    def key(self, label: str) -> LegendKey:
        """Entry of a legend."""
        return LegendKey(label, self.colour, "area", hatching=self.hatching)


CONTRIBUTIONS = {
    "translation": Contribution("inertia by translation", "translation", "T"),
    "rotation": Contribution("inertia by rotation", "rotation", "R", HATCHING["rotation"]),
    "h_translation": Contribution("h by translation", "area-translation", "h"),
    "h_rotation": Contribution("h by rotation", "area-rotation", "h", HATCHING["rotation"]),
    "gravity": Contribution("gravity", "area-gravity", "c", HATCHING["gravity"]),
    "drives": Contribution("drives", "area-drives", "J", HATCHING["drives"]),
}
# A limit beyond this multiple of the torque would leave no room for the contributions.
_LIMIT_IN_VIEW = 1.6
# Height of the stacked torque, pt.
_STACK_HEIGHT = 172.0
# Length of the enlarged part, in periods of the cut-off.
_ENLARGED_PERIODS = 6.0
# Least number of readings in the enlarged part.
_FEWEST_READINGS = 40


def motion_figure(run: Run) -> Figure:
    """Position, velocity and acceleration of every joint; a row per joint."""
    motion, axis, rows = run.trajectory, time_axis(run.trajectory.time), []
    for i, joint in enumerate(run.arm.joints):
        name = short_joint_label(run.arm.joints, i, 90.0)
        panels = []
        for quantity, letter in (("q", "q"), ("qd", "q̇"), ("qdd", "q̈")):
            values = in_degrees(getattr(motion, quantity)[:, i], joint)
            y = value_axis(motion_unit(joint, quantity), values, most=3, zero=quantity != "q")
            curve = over_time(motion.time, values, motion.gaps, label=letter)
            panels.append(Panel(f"{quantity}{i + 1}", f"{name}: {letter}", axis, y, (curve,)))
        rows.append(tuple(panels))
    return Figure("Motion of every joint", tuple(rows), FIGURE_WIDTH / 3, min(240.0 / run.arm.n_joints, 86.0))


def recording_figure(run: Run) -> Figure:
    """Readings and smoothed motion, and their difference near the joint's largest acceleration."""
    motion, axis, rows = run.trajectory, time_axis(run.trajectory.time), []
    for i, joint in enumerate(run.arm.joints):
        near, unit = most_accelerated(motion, i), motion_unit(joint, "q")
        read = in_degrees(run.tables["recording"].q_read.values[:, i], joint)
        smooth = in_degrees(motion.q[:, i], joint)
        curves = (
            over_time(motion.time, read, motion.gaps, "combined", 2.6, label="readings"),
            over_time(motion.time, smooth, motion.gaps, "accent", 0.9, label="smoothed"),
        )
        name, y = short_joint_label(run.arm.joints, i, 190.0), value_axis(unit, read, most=3, zero=False)
        reading_panel = Panel(f"reading{i + 1}", name, axis, y, curves)
        time, difference = motion.time[near], (read - smooth)[near]
        residue = (Curve(time, difference, "combined", 0.7, label="readings − smoothed"),)
        name, y = f"{i + 1} readings − smoothed", value_axis(unit, difference, most=3)
        rows.append((reading_panel, Panel(f"residue{i + 1}", name, time_axis(time), y, residue)))
    legend = (LegendKey("readings", "combined"), LegendKey("smoothed", "accent"))
    height = min(270.0 / run.arm.n_joints, 84.0)
    return Figure("Readings and smoothed motion", tuple(rows), FIGURE_WIDTH / 2, height, legend)


def most_accelerated(motion: Trajectory, joint: int) -> NDArray[np.intp]:
    """Set points, from 0, of some periods of the cut-off around a joint's largest acceleration."""
    recording = motion.recording
    assert recording is not None  # called for smoothed readings only
    assert recording.cutoff is not None
    fastest = int(np.abs(motion.qdd[:, joint]).argmax())
    stretch = next(part for part in motion.stretches if part.start <= fastest < part.stop)
    half, middle = _ENLARGED_PERIODS / 2 / float(recording.cutoff[joint]), float(motion.time[fastest])
    first, last = np.searchsorted(motion.time, (middle - half, middle + half))
    first, last = min(first, fastest - _FEWEST_READINGS // 2), max(last, fastest + _FEWEST_READINGS // 2)
    return np.arange(max(first, stretch.start), min(last, stretch.stop))


def in_degrees(values: FloatArray, joint: Joint) -> FloatArray:
    """Angles in degrees; lengths unchanged."""
    return np.degrees(values) if joint.kind == "revolute" else values


def motion_unit(joint: Joint, name: str) -> str:
    """Unit in which "q", "qd" or "qdd" of a joint is shown."""
    prismatic, revolute = SCHEMA_UNITS[{"q": "position", "qd": "velocity", "qdd": "acceleration"}[name]]
    return revolute.replace("rad", "deg") if joint.kind == "revolute" else prismatic


def contributions_figure(run: Run) -> Figure:
    """Torque over time, its positive parts stacked above zero and its negative ones below it."""
    parts, n = Contributions.of(run), run.arm.n_joints
    columns = {1: 1, 2: 2, 4: 2}.get(n, 3 if n <= 6 else 4)
    height = max(min(_STACK_HEIGHT / -(-n // columns), 140.0), 60.0)
    panels = [_stacked(run, parts, i, FIGURE_WIDTH / columns) for i in range(n)]
    keys = [CONTRIBUTIONS[name].key(CONTRIBUTIONS[name].label) for name in parts.parts]
    keys.append(LegendKey("torque, their sum", "ink"))
    if any(isinstance(item, Curve) and item.colour == "warn" for panel in panels for item in panel.items):
        keys.append(LegendKey("torque limit", "warn", dashes=(4.0, 2.0)))
    return in_columns("Torque by contribution", panels, columns, height, tuple(keys))


def _stacked(run: Run, parts: Contributions, i: int, width: float) -> Panel:
    joint, limit, noise = run.arm.joints[i], float(parts.limit[i]), run.round_off
    piles = [parts.pile(i, upward=upward) for upward in (True, False)]
    edges = np.array(
        [0.0, *(end for pile in piles for _, edge in pile.values() for end in (min(edge), max(edge)))]
    )
    size = np.abs(edges).max()
    is_near = noise < size and limit <= _LIMIT_IN_VIEW * size
    limits = [sign * limit for sign in (1.0, -1.0) if is_near and (sign > 0 or edges.min() < 0)]
    x, y = time_axis(parts.time), value_axis(joint.effort_unit, edges, np.array(limits), floor=noise)
    gaps = run.gaps_among(parts.points)
    # A single set point is as wide as the panel.
    time = broken(parts.time, gaps) if len(parts.time) > 1 else np.array([x.low, x.high])
    items: list[Item] = []
    for pile in piles if size > noise else ():
        for name, pair in pile.items():
            near, far = (np.broadcast_to(broken(edge, gaps), time.shape) for edge in pair)
            part = CONTRIBUTIONS[name]
            items.append(Area(time, near, far, part.colour, part.label, part.hatching))
    total = np.broadcast_to(broken(parts.total[:, i], gaps), time.shape)
    items.append(Curve(time, total, "ink", 1.2, label="torque"))
    ends = np.array([x.low, x.high])
    items += [Curve(ends, np.full(2, value), "warn", 0.9, (4.0, 2.0)) for value in limits]
    limited = f"limit {pretty(amount(limit, joint.effort_unit))}" if np.isfinite(limit) else ""
    title = short_joint_label(run.arm.joints, i, width - 34.0 - 3.0 * len(limited) - 4.0 * len(y.unit))
    return Panel(f"pile{i + 1}", title, x, y, tuple(items), limited)


@dataclass(frozen=True, eq=False)
class Contributions:
    """Contributions to the torque of every joint, at the drawn set points."""

    points: NDArray[np.intp]  # the set points, from 0, shape (N,)
    time: FloatArray  # (N,), s
    parts: Mapping[str, FloatArray]  # of `torque_by_cause`, (N, n) each
    total: FloatArray  # the exact torque, their sum, (N, n)
    limit: FloatArray  # largest torque of each joint's drive, (n,); nan if not stated

    @classmethod
    def of(cls, run: Run) -> Contributions:
        """Contributions at the drawn set points; all of a short trajectory."""
        points, elements = run.drawn
        names = [name for name in ("qdd", "torque", "drive_torque") if name in run.decomposition]
        parts = torque_by_cause(elements.assign(run.decomposition[names].isel(time=points)))
        limits = [drive.torque_limit for drive in run.arm.drives] or [None] * run.arm.n_joints
        limit = np.array([np.nan if limit is None else limit for limit in limits])
        return cls(points, run.trajectory.time[points], parts, run.exact_torque[points], limit)

    def pile(self, joint: int, *, upward: bool) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Stack a joint's positive parts from zero upward, or its negative ones downward.

        Returns edges of each part's area by name, the one nearer to zero first, shape (N,) each. The ends of
        both piles sum to the torque, at the set points and on the straight lines between.
        """
        clipped = np.maximum if upward else np.minimum
        edges, inner = {}, np.zeros(len(self.time))
        for name, part in self.parts.items():
            outer = inner + clipped(part[:, joint], 0.0)
            if np.any(outer != inner):
                edges[name] = inner, outer
            inner = outer
        return edges


def torque_by_cause(dataset: xr.Dataset) -> dict[str, FloatArray]:
    """Split the torque of every joint by `CONTRIBUTIONS`, N m (N), shape (N, n) each, which sum to it.

    In stacking order. "translation" and "rotation" accelerate the links; "drives" exists only if they are
    part of the torque.
    """
    translation, rotation = np.einsum("teij,tj->eti", dataset.inertia.values, dataset.qdd.values)
    h_translation, h_rotation = dataset.coriolis_centrifugal.values.swapaxes(0, 1)
    parts = {
        "gravity": dataset.gravity_loading.values,
        "translation": translation,
        "rotation": rotation,
        "h_translation": h_translation,
        "h_rotation": h_rotation,
    }
    return parts | ({"drives": dataset.drive_torque.values} if "drive_torque" in dataset else {})


def error_figure(run: Run) -> Figure:
    """Exact and simplified torque of every joint, and the error with the allowed one."""
    table, tube, motion = run.tables["simplified_model"], run.tables["tube"], run.trajectory
    noise, x = run.round_off, time_axis(motion.time, 5)
    ends = np.array([x.low, x.high])
    is_proven = bool(np.isfinite(tube.tube_along.values).all())
    # Steps of the proven error near each piece of the motion, interrupted where nothing is proven.
    edges = np.stack([tube.segment_from.values, tube.segment_to.values], axis=1).ravel()
    breaks = 2 * np.flatnonzero(edges[2::2] > edges[1:-1:2]) + 2
    rows = []
    for i, joint in enumerate(run.arm.joints):
        exact, simplified = run.exact_torque[:, i], run.simplified_torque[:, i]
        error, allowed = table.torque_error.values[:, i], float(table.allowed_error[i])
        proven = broken(np.repeat(tube.tube_along.values[:, i], 2), breaks) if is_proven else np.zeros(1)
        left: tuple[Item, ...] = (
            over_time(motion.time, exact, motion.gaps, "combined", 2.6, label="exact"),
            over_time(motion.time, simplified, motion.gaps, "accent", 0.9, label="simplified"),
        )
        right: list[Item] = []
        if allowed > noise:
            right.append(Area(ends, np.full(2, -allowed), np.full(2, allowed), "accent-wash"))
        right.append(over_time(motion.time, error, motion.gaps, "accent", 1.2, label="error"))
        if is_proven:
            steps = broken(edges, breaks)
            right.append(Curve(steps, proven, "bound", 0.8, label=run.proof))
            right.append(Curve(steps, -proven, "bound", 0.8))
        unit = joint.effort_unit
        torques = value_axis(unit, exact, simplified, floor=noise)
        errors = value_axis(unit, error, proven, -proven, np.array([-allowed, allowed]), floor=noise)
        name = short_joint_label(run.arm.joints, i, 190.0)
        allowed_text = f"allowed ±{pretty(amount(allowed, unit))}"
        rows.append(
            (
                Panel(f"torque{i + 1}", name, x, torques, left),
                Panel(f"error{i + 1}", f"{i + 1} error", x, errors, tuple(right), allowed_text),
            )
        )
    legend = (
        LegendKey("exact", "combined"),
        LegendKey("simplified; error", "accent"),
        LegendKey("allowed", "accent-wash", "area"),
        *([LegendKey(f"{run.proof} near the motion", "bound")] if is_proven else []),
    )
    height = min(252.0 / run.arm.n_joints, 110.0)
    return Figure("Torque and error of every joint", tuple(rows), FIGURE_WIDTH / 2, height, legend)


def measured_figure(run: Run) -> Figure:
    """Measured and exact torque of every joint that was measured, and their difference."""
    table, joints = run.tables["measured_torque"], measured_joints(run)
    is_fitted = "coulomb" in table
    x, rows = time_axis(run.trajectory.time, 5), []
    for i in joints:
        of_joint = table.isel(joint=i)
        points = np.flatnonzero(np.isfinite(of_joint.filtered.values) & np.isfinite(of_joint.measured.values))
        line = partial(over_time, run.trajectory.time[points], gaps=run.gaps_among(points))
        read, measured = (of_joint[name].values[points] for name in ("measured", "filtered"))
        exact = run.exact_torque[points, i]
        left = [
            line(read, colour="line", width=0.6, label="as read"),
            line(measured, colour="combined", width=2.2, label="measured"),
            line(exact, colour="accent", width=1.0, label="exact"),
        ]
        right = [line(measured - exact, colour="combined", width=1.2, label="measured − exact")]
        if is_fitted:
            coulomb, viscous, offset = (np.nan_to_num(float(of_joint[name])) for name in FRICTION_TERMS)
            velocity = run.trajectory.qd[points, i]
            friction = coulomb * np.sign(velocity) + viscous * velocity + offset
            left.append(line(exact + friction, colour="series-5", width=0.8, label="exact and friction"))
            right.append(line(friction, colour="series-5", width=0.9, label="friction and offset"))
        joint = run.arm.joints[i]
        y = [value_axis(joint.effort_unit, *(item.y for item in side)) for side in (left, right)]
        name = short_joint_label(run.arm.joints, i, 190.0)
        rows.append(
            (
                Panel(f"measured{i + 1}", name, x, y[0], tuple(left)),
                Panel(f"difference{i + 1}", f"{i + 1} measured − exact", x, y[1], tuple(right)),
            )
        )
    legend = [LegendKey("as read", "line"), LegendKey("measured", "combined"), LegendKey("exact", "accent")]
    if is_fitted and joints:
        legend.append(LegendKey("with friction; friction and offset", "series-5"))
    height = min(252.0 / max(len(joints), 1), 92.0)
    return Figure("Measured and exact torque", tuple(rows), FIGURE_WIDTH / 2, height, tuple(legend))


def followed_figure(run: Run, joints: Sequence[int]) -> Figure:
    """Measured torque of some joints, from 0, beside that of file and friction, and their difference."""
    table, time = run.tables["measured_torque"], run.trajectory.time
    x, panels = time_axis(time, 8), []
    for i in joints:
        measured, modelled = (table[name].values[:, i] for name in ("filtered", "with_friction"))
        gaps = run.gaps_among(np.arange(len(time)))
        is_compared = np.isfinite(measured + modelled)
        near, far = (broken(np.where(is_compared, values, np.nan), gaps) for values in (measured, modelled))
        joint = run.arm.joints[i]
        items = (
            Area(broken(time, gaps), near, far, "area-left", "not explained"),
            over_time(time, measured, gaps, colour="combined", width=1.3, label="measured"),
            over_time(time, modelled, gaps, colour="accent", width=1.0, label="file and friction"),
        )
        y = value_axis(joint.effort_unit, measured, modelled)
        title = short_joint_label(run.arm.joints, i, 300.0)
        panels.append(Panel(f"followed{i + 1}", title, x, y, items, text=8.0))
    legend = (
        LegendKey("measured", "combined"),
        LegendKey("torque of the file, and fitted friction and offset where the joint moves", "accent"),
        LegendKey("not explained", "area-left", "area"),
    )
    return in_columns("Measured torque beside that of file and friction", panels, 1, 104.0, legend)


def measured_joints(run: Run) -> list[int]:
    """Joints, from 0, with a measured torque; empty for a run without any."""
    if "measured_torque" not in run.tables:
        return []
    return np.flatnonzero(np.isfinite(run.tables["measured_torque"].rms_difference.values)).tolist()
