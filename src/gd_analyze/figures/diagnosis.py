"""Measured and fitted torque of a diagnosis, and what remains where one looks for a cause."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    Curve,
    Figure,
    LegendKey,
    Panel,
    short_joint_label,
    value_axis,
)
from gd_analyze.robots.arm import RobotArm

if TYPE_CHECKING:
    import xarray as xr

# Quantities that what remains may follow, with their units for revolute and prismatic joints.
_ACROSS = {
    "position": ("sample_q", "rad", "m"),
    "velocity": ("sample_qd", "rad/s", "m/s"),
    "acceleration": ("sample_qdd", "rad/s^2", "m/s^2"),
    "time": ("sample_time", "s", "s"),
}
# Dots of one colour in a panel.
_MOST_DOTS_PER_COLOUR = 200
_LEFT = {"as logged": ("combined", "sample_measured", "sample_fitted")}
_MENDED = {"with the causes": ("accent", "sample_mended", "sample_fitted_mended")}


def compared_joints(tabulated: xr.Dataset) -> list[int]:
    """Joints, from 0, that a diagnosis compares."""
    return np.flatnonzero(np.isfinite(tabulated.remains_before.values)).tolist()


def _looks(tabulated: xr.Dataset) -> dict[str, tuple[str, str, str]]:
    return _LEFT | (_MENDED if tabulated.sizes["cause"] else {})


def diagnosed_torque_figure(tabulated: xr.Dataset, arm: RobotArm) -> Figure:
    """Measured torque and its fit over time, a row per joint: as logged, and with the causes."""
    time = tabulated.sample_time.values
    order = np.argsort(time, kind="stable")
    x, rows, joints = value_axis("s", time, zero=False), [], compared_joints(tabulated)
    looks = _looks(tabulated)
    for i in joints:
        panels = []
        for look, (_, measured_name, fitted_name) in looks.items():
            measured, fitted = (tabulated[name].values[order, i] for name in (measured_name, fitted_name))
            y = value_axis(arm.joints[i].effort_unit, measured, fitted, most=3)
            items = (
                Curve(time[order], measured, "combined", 2.0, label="measured"),
                Curve(time[order], fitted, "accent", 0.9, label="fitted"),
            )
            name = short_joint_label(arm.joints, i, 110.0)
            title = f"{name}, {look}" if len(looks) > 1 else name
            panels.append(Panel(f"torque{i + 1}_{look.replace(' ', '_')}", title, x, y, items))
        rows.append(tuple(panels))
    if len(looks) == 1:  # two joints side by side
        flat = [panel for row in rows for panel in row]
        rows = [tuple(flat[k : k + 2]) for k in range(0, len(flat), 2)]
    height = max(min(280.0 / max(len(rows), 1), 92.0), 46.0)
    legend = (LegendKey("measured", "combined"), LegendKey("fitted", "accent"))
    return Figure("Torque measured and fitted", tuple(rows), FIGURE_WIDTH / 2, height, legend)


def where_figure(tabulated: xr.Dataset, arm: RobotArm, joints: Sequence[int]) -> Figure:
    """Residuals of some joints, from 0, against position, velocity, acceleration and time, a row each."""
    looks, rows = _looks(tabulated), []
    chosen = evenly(tabulated.sizes["sample"], _MOST_DOTS_PER_COLOUR)
    for i in joints:
        residuals = {
            look: (tabulated[measured].values - tabulated[fitted].values)[chosen, i]
            for look, (_, measured, fitted) in looks.items()
        }
        y = value_axis(arm.joints[i].effort_unit, *residuals.values(), most=3)
        panels = []
        for quantity, (name, *units) in _ACROSS.items():
            values = tabulated[name].values[chosen]
            across = values if quantity == "time" else values[:, i]
            panels.append(
                Panel(
                    f"{quantity}{i + 1}",
                    f"{i + 1}: by {quantity}",
                    value_axis(units[not arm.is_revolute[i]], across, most=2, zero=False),
                    y,
                    tuple(
                        Curve(across, residuals[look], colour, 0.0, label=look, marker="circle", size=1.6)
                        for look, (colour, *_) in looks.items()
                    ),
                )
            )
        rows.append(tuple(panels))
    keys = tuple(LegendKey(look, colour, marker="circle") for look, (colour, *_) in looks.items())
    legend = keys if len(looks) > 1 else ()
    height = max(min(360.0 / max(len(rows), 1), 76.0), 60.0)
    return Figure(
        "What remains, where one looks for its cause", tuple(rows), FIGURE_WIDTH / 4, height, legend
    )
