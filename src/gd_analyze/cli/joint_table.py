"""What several verbs tell of an arm and its joints, as tables and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gd_analyze.cli.terminal import table
from gd_analyze.formatting import number, percent
from gd_analyze.levels.promise import share_of
from gd_analyze.results.words import drives_told

if TYPE_CHECKING:
    from gd_analyze.levels import Promise
    from gd_analyze.operations import OperationCount
    from gd_analyze.robots import RobotArm
    from gd_analyze.vectors import FloatArray

Column = tuple[str, Sequence[str]]


def joint_table(title: str, arm: RobotArm, columns: Sequence[Column]) -> None:
    """Print columns of torques or forces, their unit in the title, and beside each row where units differ.

    Parameters
    ----------
    title
        What is shown; "{units}" in it stands for the units.
    arm
        Whose joints they are.
    columns
        Heading and one cell per joint; cells of words stand on the left, all others on the right.
    """
    units = [joint.effort_unit for joint in arm.joints]
    names = [joint_name(i, joint.name) for i, joint in enumerate(arm.joints, start=1)]
    shown: list[Column] = [("joint", names), *columns]
    if len(set(units)) > 1:
        shown.append(("unit", units))
    table(
        title.format(units=" or ".join(sorted(set(units), reverse=True))),
        [heading for heading, _ in shown],
        list(zip(*(cells for _, cells in shown), strict=True)),
        "".join("l" if heading == "joint" or cells[0].isalpha() else "r" for heading, cells in shown),
    )


def arm_in_words(arm: RobotArm, drives: bool | None = None) -> str:
    """The arm's title, or its name where it has none; where told, whether its drives act."""
    told = "" if drives is None else drives_told(arm, drives)
    return f"{arm.title or arm.name}{told and f', {told}'}"


def joint_name(number: int, name: str) -> str:
    """A joint's number, and its name where that says more."""
    return name if name == str(number) else f"{number} {name}"


def numbers(values: Iterable[float]) -> list[str]:
    """Cells of torques."""
    return [number(float(x)) for x in values]


def percents(shares: Iterable[float]) -> list[str]:
    """Cells of shares."""
    return [percent(float(x)) for x in shares]


def times(error: FloatArray, allowed: FloatArray) -> list[str]:
    """Cells of errors as multiples of the allowed ones."""
    return numbers(share_of(error, allowed))


def counts(operations: OperationCount) -> dict[str, int]:
    """Operations as JSON has them."""
    return {**asdict(operations), "total": operations.total}


def promise_table(promise: Promise, arm: RobotArm, about: str = "") -> None:
    """Print the errors a model states beside the allowed ones; shares are of what the budget is one of."""
    errors, by_peak = promise.errors, promise.asked.wholes == {"peak"}
    whole = errors.peak_torque if by_peak else promise.allowed
    joint_table(
        f"Torque error{about}, {{units}}, and its share of "
        + ("peak torque" if by_peak else "the allowed error"),
        arm,
        [
            ("peak torque", numbers(errors.peak_torque)),
            ("allowed", numbers(promise.allowed)),
            ("largest", numbers(errors.largest)),
            ("share", percents(share_of(errors.largest, whole))),
            ("RMS", numbers(errors.rms)),
            ("share", percents(share_of(errors.rms, whole))),
        ],
    )


def promise_values(promise: Promise) -> dict[str, FloatArray | None]:
    """What a model states of its errors, by the names of the schema."""
    errors = promise.errors
    return {
        "peak_torque": errors.peak_torque,
        "allowed_error": promise.allowed,
        "largest_error": errors.largest,
        "largest_share": errors.largest_share,
        "largest_of_allowed": share_of(errors.largest, promise.allowed),
        "rms_error": errors.rms,
        "rms_share": errors.rms_share,
        "uncertainty": promise.uncertainty,
    }


def joint_rows(arm: RobotArm, columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    """One JSON object per joint; None for a column of which nothing is known."""
    # Numbers of NumPy as those of Python.
    plain = {k: v.tolist() if hasattr(v, "tolist") else v for k, v in columns.items()}
    return [
        {
            "joint": i + 1,
            "joint_name": joint.name,
            "effort_unit": joint.effort_unit,
            **{name: None if values is None else values[i] for name, values in plain.items()},
        }
        for i, joint in enumerate(arm.joints)
    ]
