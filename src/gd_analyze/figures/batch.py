"""A batch: peak torque of every joint, and operations, over the varied number or the row."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.figure import Axis, Curve, Figure, LegendKey, Panel, in_columns, ticks, value_axis
from gd_analyze.robots.arm_numbers import ArmNumber
from gd_analyze.text import pretty

if TYPE_CHECKING:
    import pandas as pd

_EFFORT_UNITS = {"R": "N m", "P": "N"}
_OPERATIONS = {"exact_operations": "combined", "model_operations": "accent"}


def batch_figure(table: pd.DataFrame, across: str) -> Figure:
    """Draw the finished rows of a batch's table over one of its columns: the name of a number, or "row"."""
    done = table[(table.state == "done") & table[across].notna()]
    if not len(done):
        empty = Panel("none", "no row is done", Axis(0.0, 1.0), Axis(0.0, 1.0), (), is_bare=True)
        return in_columns("No row is done", [empty], 1, 60.0)
    done = done.sort_values(across)
    x, number = _values(done, across), ArmNumber.named(across)
    axis, width = _axis(x, number), 0.0 if number is None else 1.1
    panels = []
    for name, unit in effort_units(done).items():
        torque = _values(done, name)
        curve = Curve(x, torque, "ink", width, marker="circle", size=2.6)
        panels.append(Panel(name, name.replace("_", " "), axis, value_axis(unit, torque), (curve,)))
    curves = tuple(
        Curve(x, _values(done, name), colour, width, marker="circle", size=2.6)
        for name, colour in _OPERATIONS.items()
    )
    y = value_axis("", *(curve.y for curve in curves))
    panels.append(Panel("operations", "operations", axis, y, curves))
    legend = LegendKey("operations of the exact torque", "combined"), LegendKey("of the model", "accent")
    return in_columns(f"Peak torque and operations over {across}", panels, min(3, len(panels)), 110.0, legend)


def effort_units(done: pd.DataFrame) -> dict[str, str]:
    """Unit of every column of peak torques; "N or N m" where the joints of the arms are of both kinds."""
    joints = range(int(done.joints.max()) if len(done) else 0)
    kinds = [{word[i] for word in done.joint_kinds if i < len(word)} for i in joints]
    return {
        f"peak_torque_{i + 1}": " or ".join(sorted(_EFFORT_UNITS[kind] for kind in kinds[i])) for i in joints
    }


def _values(table: pd.DataFrame, name: str) -> FloatArray:
    return np.asarray(table[name], dtype=float)


def _axis(x: FloatArray, number: ArmNumber | None) -> Axis:
    """Axis of the numbers, or of rows, which are whole."""
    room = 0.04 * float(x.max() - x.min()) or 0.5
    low, high = float(x.min()) - room, float(x.max()) + room
    at = tuple(value for value in ticks(low, high, 4) if number is not None or value == round(value))
    return Axis(low, high, at, "" if number is None else pretty(number.unit))
