"""Every joint over time: its motion, and the readings behind a recorded one."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.figure import (
    WIDTH,
    Curve,
    Figure,
    Key,
    Panel,
    broken,
    shortened,
    time_axis,
    value_axis,
)
from gd_analyze.robots.parts import Joint
from gd_analyze.schema import UNITS

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings

# Length of what is drawn large, in periods of the cut-off, and readings at least.
_PERIODS, _FEWEST = 6.0, 40


def motion_figure(findings: Findings) -> Figure:
    """Position, velocity and acceleration of every joint; a row per joint."""
    arm, motion = findings.arm, findings.trajectory
    axis, seconds = time_axis(motion.time), broken(motion.time, motion.gaps)
    rows = []
    for i, joint in enumerate(arm.joints):
        name = f"{i + 1}" if joint.name == str(i + 1) else f"{i + 1} {shortened(joint.name, 55.0)}"
        panels = []
        for what, letter in (("q", "q"), ("qd", "q̇"), ("qdd", "q̈")):
            curve = degrees(getattr(motion, what)[:, i], joint)
            y = value_axis(motion_unit(joint, what), curve, most=3, zero=what != "q")
            items = (Curve(seconds, broken(curve, motion.gaps), label=letter),)
            panels.append(Panel(f"{what}{i + 1}", f"{name}: {letter}", axis, y, items))
        rows.append(tuple(panels))
    return Figure("Motion of every joint", tuple(rows), WIDTH / 3, min(372.0 / arm.n_joints, 86.0))


def recording_figure(findings: Findings) -> Figure:
    """Readings and smoothed motion, and their difference near the joint's largest acceleration."""
    arm, motion = findings.arm, findings.trajectory
    axis, seconds = time_axis(motion.time), broken(motion.time, motion.gaps)
    rows = []
    for i, joint in enumerate(arm.joints):
        drawn, unit = Readings.of(findings, i), motion_unit(joint, "q")
        near = motion.time[drawn.near]
        name = f"{i + 1} {shortened(joint.name, 90.0)}"
        both = (
            Curve(seconds, broken(drawn.read, motion.gaps), "combined", 2.6, label="readings"),
            Curve(seconds, broken(drawn.smooth, motion.gaps), "accent", 0.9, label="smoothed"),
        )
        left = Panel(f"reading{i + 1}", name, axis, value_axis(unit, drawn.read, most=3, zero=False), both)
        y = value_axis(unit, drawn.difference, most=3)
        apart = (Curve(near, drawn.difference, "combined", 0.7, label="readings − smoothed"),)
        rows.append(
            (left, Panel(f"residue{i + 1}", f"{i + 1} readings − smoothed", time_axis(near), y, apart))
        )
    legend = (Key("readings", "combined"), Key("smoothed", "accent"))
    height = min(410.0 / arm.n_joints, 84.0)
    return Figure("Readings and smoothed motion", tuple(rows), WIDTH / 2, height, legend)


class Readings(NamedTuple):
    """Curves of one joint, angles in degrees, lengths in m."""

    # Readings and smoothed motion at all set points, shape (N,)
    read: FloatArray
    smooth: FloatArray
    near: np.ndarray  # set points, from 0, of some periods of the cut-off around the largest acceleration

    @classmethod
    def of(cls, findings: Findings, joint: int) -> Readings:
        """Take those of a joint, from 0, of a measured motion."""
        motion, table = findings.trajectory, findings.tables["recording"]
        fastest = int(np.abs(motion.qdd[:, joint]).argmax())
        stretch = next(part for part in motion.stretches if part.start <= fastest < part.stop)
        half, middle = _PERIODS / 2 / float(table.cutoff[joint]), float(motion.time[fastest])
        first, last = np.searchsorted(motion.time, (middle - half, middle + half))
        first, last = min(first, fastest - _FEWEST // 2), max(last, fastest + _FEWEST // 2)
        near = np.arange(max(first, stretch.start), min(last, stretch.stop))
        of = findings.arm.joints[joint]
        return cls(degrees(table.q_read.values[:, joint], of), degrees(motion.q[:, joint], of), near)

    @property
    def difference(self) -> FloatArray:
        """Readings minus smoothed motion near the largest acceleration."""
        return (self.read - self.smooth)[self.near]


def degrees(values: FloatArray, joint: Joint) -> FloatArray:
    """Angles in degrees; lengths as they are."""
    return np.degrees(values) if joint.kind == "revolute" else values


def motion_unit(joint: Joint, name: str) -> str:
    """Unit in which "q", "qd" or "qdd" of a joint is shown."""
    prismatic, revolute = UNITS[{"q": "position", "qd": "velocity", "qdd": "acceleration"}[name]]
    return revolute.replace("rad", "deg") if joint.kind == "revolute" else prismatic
