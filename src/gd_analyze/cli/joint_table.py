"""A table with one row per joint, as several verbs print it."""

from __future__ import annotations

from collections.abc import Sequence

from gd_analyze.cli.terminal import table
from gd_analyze.robots import RobotArm

Column = tuple[str, str, Sequence[str]]


def joint_table(title: str, arm: RobotArm, columns: Sequence[Column]) -> None:
    """Print columns of torques or forces, their unit in the title, and beside each row where units differ.

    Parameters
    ----------
    title
        What is shown; "{units}" in it stands for the units.
    arm
        Whose joints they are.
    columns
        Heading, side ("left" or "right") and one cell per joint.
    """
    units = [joint.effort_unit for joint in arm.joints]
    names = [
        f"{i + 1} {joint.name}" if joint.name != str(i + 1) else joint.name
        for i, joint in enumerate(arm.joints)
    ]
    shown: list[Column] = [("joint", "left", names), *columns]
    if len(set(units)) > 1:
        shown.append(("unit", "left", units))
    table(
        title.format(units=" or ".join(sorted(set(units), reverse=True))),
        [(heading, side) for heading, side, _ in shown],
        list(zip(*(cells for _, _, cells in shown), strict=True)),
    )
