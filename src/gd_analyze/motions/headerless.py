"""What to type for a text table without a header line: names of the columns that its numbers show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.table import LogTable, no_progress
from gd_analyze.motions.velocities import contradictions

# Positions, and what may be their derivatives.
_ROLES = ("q", "qd", "qdd")


def naming(table: LogTable, joints: int) -> str:
    """Options that name the columns: time, positions, and derivatives where the numbers are derivatives."""
    width = len(table.names)
    # As many columns as joints, or a multiple, leave no column for time.
    has_time = width % joints > 0 or joints == 1
    count = (width - has_time) // joints
    begins = range(has_time, has_time + count * joints, joints)
    numeric = [k for k in begins if all(_is_numeric(table, k + joint) for joint in range(joints))]
    roles = _derivatives(table, has_time, numeric, joints)
    names = ["time"] if has_time else []
    for begin, role in zip(begins, [*roles, *[""] * count], strict=False):
        numbered_names = f"{role}1..{role}{joints}" if joints > 1 else f"{role}1"
        names += [numbered_names] if role and begin in numeric else ["-"] * joints
    names += ["-"] * (width - has_time - count * joints)
    options = f"--columns {','.join(names)}" + ("" if has_time else " --rate HZ")
    if "qdd" not in roles:
        options += " --measured"
    step = f"if these are the columns, name them: {options}"
    if count > len(roles):
        torques = f"torque1..torque{joints}" if joints > 1 else "torque1"
        step += f"; {torques} in place of - names torques, or currents beside --torque-constant"
    return step


def _is_numeric(table: LogTable, column: int) -> bool:
    return all(isinstance(cell, float) for cell in table.head(column))


def _derivatives(table: LogTable, has_time: bool, begins: Sequence[int], joints: int) -> list[str]:
    """Roles of the first blocks of columns: each is the derivative of the one before."""
    begins = begins[: len(_ROLES)]
    columns = [*range(has_time), *(k + joint for k in begins for joint in range(joints))]
    if not begins or not all(_is_numeric(table, k) for k in columns[:has_time]):
        return ["q"]
    numbers = table.read(columns, (), no_progress).numbers
    numbers = numbers[np.isfinite(numbers).all(axis=1)]
    blocks = np.split(numbers[:, has_time:], len(begins), axis=1)
    roles = ["q"]
    for role, previous, values in zip(_ROLES[1:], blocks, blocks[1:], strict=False):
        time = numbers[:, 0] if has_time else _instants(blocks[0], blocks[1])
        if contradictions(time, previous, values, None):
            break
        roles.append(role)
    return roles


def _instants(q: FloatArray, qd: FloatArray) -> FloatArray:
    """Instants of even steps with which velocities cover the distance that positions do."""
    distance, speed = (float(np.abs(x).sum()) for x in (np.diff(q, axis=0), qd[1:]))
    return np.arange(float(len(q))) * (distance / speed if speed > 0.0 else 1.0)
