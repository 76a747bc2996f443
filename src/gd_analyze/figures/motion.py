"""Every joint over time: its motion, and the readings behind a recorded one."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.figure import (
    WIDTH,
    Curve,
    Figure,
    Key,
    Panel,
    over_time,
    shortened,
    time_axis,
    value_axis,
)
from gd_analyze.figures.run import Run
from gd_analyze.robots.parts import Joint
from gd_analyze.schema import UNITS

# Length of what is drawn large, in periods of the cut-off, and readings at least.
_PERIODS, _FEWEST = 6.0, 40


def motion_figure(run: Run) -> Figure:
    """Position, velocity and acceleration of every joint; a row per joint."""
    motion, axis, rows = run.trajectory, time_axis(run.trajectory.time), []
    for i, joint in enumerate(run.arm.joints):
        name = f"{i + 1}" if joint.name == str(i + 1) else f"{i + 1} {shortened(joint.name, 55.0)}"
        panels = []
        for what, letter in (("q", "q"), ("qd", "q̇"), ("qdd", "q̈")):
            values = degrees(getattr(motion, what)[:, i], joint)
            y = value_axis(motion_unit(joint, what), values, most=3, zero=what != "q")
            curve = over_time(motion.time, values, motion.gaps, label=letter)
            panels.append(Panel(f"{what}{i + 1}", f"{name}: {letter}", axis, y, (curve,)))
        rows.append(tuple(panels))
    return Figure("Motion of every joint", tuple(rows), WIDTH / 3, min(372.0 / run.arm.n_joints, 86.0))


def recording_figure(run: Run) -> Figure:
    """Readings and smoothed motion, and their difference near the joint's largest acceleration."""
    motion, axis, rows = run.trajectory, time_axis(run.trajectory.time), []
    for i, joint in enumerate(run.arm.joints):
        near, unit = most_accelerated(run, i), motion_unit(joint, "q")
        read = degrees(run.tables["recording"].q_read.values[:, i], joint)
        smooth = degrees(motion.q[:, i], joint)
        both = (
            over_time(motion.time, read, motion.gaps, "combined", 2.6, label="readings"),
            over_time(motion.time, smooth, motion.gaps, "accent", 0.9, label="smoothed"),
        )
        name, y = f"{i + 1} {shortened(joint.name, 90.0)}", value_axis(unit, read, most=3, zero=False)
        left = Panel(f"reading{i + 1}", name, axis, y, both)
        time, difference = motion.time[near], (read - smooth)[near]
        apart = (Curve(time, difference, "combined", 0.7, label="readings − smoothed"),)
        name, y = f"{i + 1} readings − smoothed", value_axis(unit, difference, most=3)
        rows.append((left, Panel(f"residue{i + 1}", name, time_axis(time), y, apart)))
    legend = (Key("readings", "combined"), Key("smoothed", "accent"))
    height = min(410.0 / run.arm.n_joints, 84.0)
    return Figure("Readings and smoothed motion", tuple(rows), WIDTH / 2, height, legend)


def most_accelerated(run: Run, joint: int) -> np.ndarray:
    """Set points, from 0, of some periods of the cut-off around a joint's largest acceleration."""
    motion = run.trajectory
    fastest = int(np.abs(motion.qdd[:, joint]).argmax())
    stretch = next(part for part in motion.stretches if part.start <= fastest < part.stop)
    half, middle = _PERIODS / 2 / float(run.tables["recording"].cutoff[joint]), float(motion.time[fastest])
    first, last = np.searchsorted(motion.time, (middle - half, middle + half))
    first, last = min(first, fastest - _FEWEST // 2), max(last, fastest + _FEWEST // 2)
    return np.arange(max(first, stretch.start), min(last, stretch.stop))


def degrees(values: FloatArray, joint: Joint) -> FloatArray:
    """Angles in degrees; lengths as they are."""
    return np.degrees(values) if joint.kind == "revolute" else values


def motion_unit(joint: Joint, name: str) -> str:
    """Unit in which "q", "qd" or "qdd" of a joint is shown."""
    prismatic, revolute = UNITS[{"q": "position", "qd": "velocity", "qdd": "acceleration"}[name]]
    return revolute.replace("rad", "deg") if joint.kind == "revolute" else prismatic
