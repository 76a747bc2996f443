"""Torque of every joint over time: by contribution, simplified and exact, and measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import TERMS
from gd_analyze.figures.figure import (
    WIDTH,
    Area,
    Curve,
    Figure,
    Item,
    Key,
    Panel,
    broken,
    in_columns,
    shortened,
    time_axis,
    value_axis,
)
from gd_analyze.text import amount, pretty

if TYPE_CHECKING:
    import xarray as xr

    from gd_analyze.results.findings import Findings

# What torque is made of, in the order it is stacked.
CONTRIBUTIONS = {
    "gravity": "gravity",
    "translation": "inertia by translation",
    "rotation": "inertia by rotation",
    "velocity": "Coriolis and centrifugal",
    "drives": "drives",
}
# A limit farther from zero than this many times the torque would leave no room to see what it is made of.
NEAR = 1.6
# Height that a first page leaves for the stacked torque, pt.
_ROOM = 262.0


def contributions_figure(findings: Findings) -> Figure:
    """Torque over time, its positive parts stacked above zero and its negative ones below it."""
    parts, joints = Contributions.of(findings), findings.arm.joints
    columns = {1: 1, 2: 2, 4: 2}.get(len(joints), 3 if len(joints) <= 6 else 4)
    height = max(min(_ROOM / -(-len(joints) // columns), 140.0), 60.0)
    keys = [Key(CONTRIBUTIONS[name], f"area-{name}", "area") for name in parts.parts]
    keys.append(Key("torque, their sum", "ink"))
    panels = [_stacked(findings, parts, i, WIDTH / columns) for i in range(len(joints))]
    if any(isinstance(item, Curve) and item.colour == "warn" for panel in panels for item in panel.items):
        keys.append(Key("torque limit", "warn", dashes=(4.0, 2.0)))
    return in_columns("Torque by contribution", panels, columns, height, tuple(keys))


def _stacked(findings: Findings, parts: Contributions, i: int, width: float) -> Panel:
    joint, limit, noise = findings.arm.joints[i], float(parts.limit[i]), findings.round_off
    piles = [parts.pile(i, upward=upward) for upward in (True, False)]
    edges = [outer for pile in piles for _, outer in pile.values()]
    size = max((float(np.abs(edge).max()) for edge in edges), default=0.0)
    is_near = noise < size and limit <= NEAR * size
    low = min([0.0, *(float(edge.min()) for edge in edges)])
    high = max([0.0, *(float(edge.max()) for edge in edges)])
    limits = [sign * limit for sign in (1.0, -1.0) if is_near and (sign > 0 or low < 0)]
    y = value_axis(joint.effort_unit, np.array([low, high, *limits]), floor=noise)
    x = time_axis(parts.time)
    gaps = np.unique(np.searchsorted(parts.points, parts.gaps))
    # A single set point is as wide as the panel.
    time = broken(parts.time, gaps) if len(parts.time) > 1 else np.array([x.low, x.high])
    items: list[Item] = []
    if size > noise:
        for pile in piles:
            for name, pair in pile.items():
                near, far = (np.broadcast_to(broken(edge, gaps), time.shape) for edge in pair)
                items.append(Area(time, near, far, f"area-{name}", CONTRIBUTIONS[name]))
    total = np.broadcast_to(broken(parts.total[:, i], gaps), time.shape)
    items.append(Curve(time, total, "ink", 1.2, label="torque"))
    ends = np.array([x.low, x.high])
    items += [Curve(ends, np.full(2, value), "warn", 0.9, (4.0, 2.0)) for value in limits]
    limited = f"limit {pretty(amount(limit, joint.effort_unit))}" if np.isfinite(limit) else ""
    name = shortened(joint.name, width - 3.0 * len(limited) - 60.0)
    title = str(i + 1) if joint.name == str(i + 1) else f"{i + 1} {name}"
    return Panel(f"pile{i + 1}", title, x, y, tuple(items), limited)


def error_figure(findings: Findings) -> Figure:
    """Exact and simplified torque of every joint, and the error beside the allowed one."""
    arm, table, motion = findings.arm, findings.tables["simplified_model"], findings.trajectory
    noise, seconds, x = findings.round_off, broken(motion.time, motion.gaps), time_axis(motion.time, 5)
    rows = []
    for i, joint in enumerate(arm.joints):
        exact, simplified = findings.exact_torque[:, i], findings.simplified_torque[:, i]
        error, allowed = table.torque_error.values[:, i], float(table.allowed_error[i])
        when, proven = _proven(findings, i)
        left: tuple[Item, ...] = (
            Curve(seconds, broken(exact, motion.gaps), "combined", 2.6, label="exact"),
            Curve(seconds, broken(simplified, motion.gaps), "accent", 0.9, label="simplified"),
        )
        right: list[Item] = []
        ends = np.array([x.low, x.high])
        if allowed > noise:
            right.append(Area(ends, np.full(2, -allowed), np.full(2, allowed), "accent-wash"))
        right.append(Curve(seconds, broken(error, motion.gaps), "accent", 1.2, label="error"))
        if len(when):
            right += [
                Curve(when, sign * proven, "inertia", 0.8, label="proven"[: 6 * (sign > 0)])
                for sign in (1, -1)
            ]
        spans = (
            value_axis(joint.effort_unit, exact, simplified, floor=noise),
            value_axis(joint.effort_unit, error, proven, -proven, np.array([-allowed, allowed]), floor=noise),
        )
        name = f"{i + 1} {shortened(joint.name, 120.0)}"
        told = f"allowed ±{pretty(amount(allowed, joint.effort_unit))}"
        rows.append(
            (
                Panel(f"torque{i + 1}", name, x, spans[0], left),
                Panel(f"error{i + 1}", f"{i + 1} error", x, spans[1], tuple(right), told),
            )
        )
    legend = (
        Key("exact", "combined"),
        Key("simplified; error", "accent"),
        Key("allowed", "accent-wash", "area"),
        *([Key("proven near the motion", "inertia")] if len(_proven(findings, 0)[0]) else []),
    )
    height = min(560.0 / arm.n_joints, 110.0)
    return Figure("Torque and error of every joint", tuple(rows), WIDTH / 2, height, legend)


def _proven(findings: Findings, i: int) -> tuple[FloatArray, FloatArray]:
    """Steps of the proven error near each piece of the motion, which break where nothing is proven."""
    tube = findings.tables["tube"]
    along = tube.tube_along.values[:, i]
    if not np.isfinite(along).all():
        return np.empty(0), np.zeros(1)
    when = np.stack([tube.segment_from.values, tube.segment_to.values], axis=1).ravel()
    between = 2 * np.flatnonzero(when[2::2] > when[1:-1:2]) + 2
    return broken(when, between), broken(np.repeat(along, 2), between)


def measured_figure(findings: Findings) -> Figure:
    """Measured and exact torque of every joint that was measured, and their difference."""
    arm, motion, joints = findings.arm, findings.trajectory, measured_joints(findings)
    x = time_axis(motion.time, 5)
    rows, is_fitted = [], False
    for i in joints:
        curves, unit = torque_curves(findings, i), arm.joints[i].effort_unit
        gaps = np.unique(np.searchsorted(curves.points, motion.gaps))
        seconds = broken(motion.time[curves.points], gaps)
        left = [
            Curve(seconds, broken(curves.read, gaps), "line", 0.6, label="as read"),
            Curve(seconds, broken(curves.measured, gaps), "combined", 2.2, label="measured"),
            Curve(seconds, broken(curves.exact, gaps), "accent", 1.0, label="exact"),
        ]
        right = [Curve(seconds, broken(curves.difference, gaps), "combined", 1.2, label="measured − exact")]
        if curves.friction is not None:
            is_fitted = True
            left.append(
                Curve(
                    seconds,
                    broken(curves.exact + curves.friction, gaps),
                    "rotation",
                    0.8,
                    label="exact and friction",
                )
            )
            right.append(
                Curve(seconds, broken(curves.friction, gaps), "rotation", 0.9, label="friction and offset")
            )
        y = [value_axis(unit, *(item.y for item in side)) for side in (left, right)]
        name = f"{i + 1} {shortened(arm.joints[i].name, 120.0)}"
        rows.append(
            (
                Panel(f"measured{i + 1}", name, x, y[0], tuple(left)),
                Panel(f"difference{i + 1}", f"{i + 1} measured − exact", x, y[1], tuple(right)),
            )
        )
    legend = [Key("as read", "line"), Key("measured", "combined"), Key("exact", "accent")]
    if is_fitted:
        legend.append(Key("with friction; friction and offset", "rotation"))
    height = min(360.0 / max(len(joints), 1), 92.0)
    return Figure("Measured and exact torque", tuple(rows), WIDTH / 2, height, tuple(legend))


@dataclass(frozen=True, eq=False)
class Contributions:
    """What the torque of every joint consists of, at the set points that are drawn."""

    time: FloatArray  # of these set points, s, shape (N,)
    points: NDArray[np.intp]  # their numbers, from 0, shape (N,)
    gaps: tuple[int, ...]  # set points, by their numbers, before which nothing is known of the motion
    # Torque by the names of `CONTRIBUTIONS` and in their order, N m (N where the joint slides), shape (N, n)
    # each; "drives" only where they are part of the torque
    parts: Mapping[str, FloatArray]
    total: FloatArray  # the exact torque, their sum, of the same shape
    # Largest torque that each joint's drive can give, shape (n,); nan where the arm states none
    limit: FloatArray

    @classmethod
    def of(cls, findings: Findings) -> Contributions:
        """Take them at the set points at which the elements are drawn; all of a short trajectory."""
        points, elements = findings.drawn
        decomposition = findings.decomposition
        names = [name for name in ("qdd", "torque", "drive_torque") if name in decomposition]
        parts = torque_by_cause(elements.assign(decomposition[names].isel(time=points)))
        limits = [drive.torque_limit for drive in findings.arm.drives] or [None] * findings.arm.n_joints
        return cls(
            time=findings.trajectory.time[points],
            points=points,
            gaps=findings.trajectory.gaps,
            parts=parts,
            total=findings.exact_torque[points],
            limit=np.array([np.nan if limit is None else limit for limit in limits]),
        )

    def pile(self, joint: int, *, upward: bool) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Stack the positive parts of a joint's torque from zero upward, or the negative ones downward.

        By the part's name the edges of its area, the one nearer to zero first, shape (N,) each. The ends of
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

    "translation" and "rotation" are what accelerating the links takes, by effect; "velocity" is Coriolis and
    centrifugal of both effects.
    """
    translation, rotation = np.einsum("teij,tj->eti", dataset.inertia.values, dataset.qdd.values)
    parts = {
        "gravity": dataset.gravity_loading.values,
        "translation": translation,
        "rotation": rotation,
        "velocity": dataset.coriolis_centrifugal.values.sum(axis=1),
    }
    if "drive_torque" in dataset:
        parts["drives"] = dataset.drive_torque.values
    return parts


@dataclass(frozen=True, eq=False)
class TorqueCurves:
    """Curves of one joint, N m (N where it slides), shape (M,)."""

    points: NDArray[np.intp]  # the set points, from 0: those with a reading
    # The torque as read, and through the filter
    read: FloatArray
    measured: FloatArray
    exact: FloatArray  # the exact model's
    friction: FloatArray | None  # friction and offset as fitted; None where none was asked for

    @property
    def difference(self) -> FloatArray:
        """Measured minus exact."""
        return self.measured - self.exact


def torque_curves(findings: Findings, joint: int) -> TorqueCurves:
    """Take the curves of a joint, from 0, that was measured, of a run with measured torques."""
    table = findings.tables["measured_torque"].isel(joint=joint)
    read, measured = table.measured.values, table.filtered.values
    points = np.flatnonzero(np.isfinite(measured) & np.isfinite(read))
    friction = None
    if "coulomb" in table:
        coulomb, viscous, offset = (np.nan_to_num(float(table[name])) for name in TERMS)
        rate = findings.trajectory.qd[points, joint]
        friction = coulomb * np.sign(rate) + viscous * rate + offset
    exact = findings.exact_torque[points, joint]
    return TorqueCurves(points, read[points], measured[points], exact, friction)


def measured_joints(findings: Findings) -> list[int]:
    """Joints, from 0, with a measured torque; none of a run without any."""
    if "measured_torque" not in findings.tables:
        return []
    verdicts = findings.tables["measured_torque"].verdict.values.tolist()
    return [i for i, verdict in enumerate(verdicts) if verdict != "not measured"]
