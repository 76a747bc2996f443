"""A table with one row per joint, as several verbs print it."""

from __future__ import annotations

from collections.abc import Sequence

from typing import TYPE_CHECKING

from gd_analyze.cli.terminal import table
from gd_analyze.formatting import number, percent
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    from gd_analyze.levels import ErrorTable

Column = tuple[str, str, Sequence[str]]


def error_table(title: str, arm: RobotArm, errors: ErrorTable, allowed: FloatArray) -> None:
    """Print the torque errors of a model beside what its budget allows."""

    def column(heading: str, values: FloatArray, as_share: bool = False) -> Column:
        return heading, "right", [(percent if as_share else number)(x) for x in values.tolist()]

    joint_table(
        title,
        arm,
        [
            column("peak torque", errors.peak_torque),
            column("allowed", allowed),
            column("largest", errors.largest),
            column("share", errors.largest_share, as_share=True),
            column("RMS", errors.rms),
            column("share", errors.rms_share, as_share=True),
        ],
    )


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
