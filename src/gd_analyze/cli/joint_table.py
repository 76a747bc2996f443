"""What several verbs tell of an arm and its joints, as tables and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.cli.terminal import table, width
from gd_analyze.results.model_facts import drives_text as drives_told
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.text import fitting, joint_name, number, percent, short_name

if TYPE_CHECKING:
    from gd_analyze.arrays import FloatArray
    from gd_analyze.operations.program import OperationCount
    from gd_analyze.robots.arm import RobotArm
    from gd_analyze.simplification.accuracy import Accuracy, ErrorTable
    from gd_analyze.simplification.measures import NormShare

# Characters that a joint's number and name take at least, however narrow the terminal.
_LEAST_NAME = 12
# What is so much less than the largest number of its row is round-off there.
_ROUND_OFF = 1e-9

# Heading, and torques, N m (N), shape (n,), or cells of text.
Column = tuple[str, "FloatArray | Sequence[str]"]


def joint_table(title: str, arm: RobotArm, columns: Sequence[Column]) -> None:
    """Print columns of torques or forces, each row in a unit that fits it.

    Parameters
    ----------
    title
        What is shown; "{units}" in it stands for the unit, which stands beside each row where they differ.
    arm
        Whose joints they are.
    columns
        Heading and one torque or cell per joint; cells of words stand on the left, all others on the right.
    """
    torques = [values for _, values in columns if not _are_cells(values)]
    scales = [
        fitting((float(values[i]) for values in torques), joint.effort_unit)
        for i, joint in enumerate(arm.joints)
    ]
    factors, units = [factor for factor, _ in scales], [unit for _, unit in scales]
    largest = np.fmax.reduce([np.zeros(arm.n_joints), *(np.abs(values) for values in torques)])
    shown: list[tuple[str, Sequence[str]]] = []
    for heading, values in columns:
        cells = values if _are_cells(values) else _torques(np.asarray(values, dtype=float), largest, factors)
        shown.append((heading, [*map(str, cells)]))
    one = len(set(units)) == 1
    if not one:
        shown.append(("unit", units))
    shown.insert(0, ("joint", _names(arm, shown)))
    table(
        title.format(units=units[0] if one else "in the unit of each row"),
        [heading for heading, _ in shown],
        list(zip(*(cells for _, cells in shown), strict=True)),
        "".join(
            "l" if heading in ("joint", "unit") or cells[0].isalpha() else "r" for heading, cells in shown
        ),
    )


def _names(arm: RobotArm, beside: Sequence[tuple[str, Sequence[str]]]) -> list[str]:
    """Numbers and names of joints, as long as there is room beside the other columns."""
    taken = sum(2 + max(map(len, (heading, *cells))) for heading, cells in beside)
    room = max(width() - taken, _LEAST_NAME)
    names = (joint_name(i, joint.name) for i, joint in enumerate(arm.joints, start=1))
    return [short_name(name, room) for name in names]


def _torques(values: FloatArray, largest: FloatArray, factors: Sequence[float]) -> list[str]:
    """Cells of torques in the rows' units; what is round-off beside the others of its row as such.

    What is nan nobody knows.
    """
    is_nothing = (values != 0.0) & (np.abs(values) <= _ROUND_OFF * largest)
    cells = ["≈ 0" if no else text for no, text in zip(is_nothing, numbers(values / factors), strict=True)]
    return ["–" if unknown else cell for unknown, cell in zip(np.isnan(values), cells, strict=True)]


def _are_cells(values: FloatArray | Sequence[str]) -> bool:
    return isinstance(values[0], str)


def arm_in_words(arm: RobotArm, drives: bool | None = None) -> str:
    """The arm's title, or its name where it has none; where told, whether its drives act."""
    told = "" if drives is None else drives_told(arm, drives)
    return f"{arm.title or arm.name}{told and f', {told}'}"


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


def promise_table(accuracy: Accuracy, arm: RobotArm, about: str = "") -> None:
    """Print the errors a model states beside the allowed ones; shares are of what the budget is one of."""
    errors = accuracy.errors
    joint_table(
        f"Torque error{about}, {{units}}, and its share of the {accuracy.asked.shares_of}",
        arm,
        [
            ("peak torque", errors.peak_torque),
            *([("allowed", accuracy.allowed)] if accuracy.asked.norm is None else []),
            ("largest", errors.largest),
            ("share", percents(accuracy.shares)),
            ("RMS", errors.rms),
            ("share", percents(accuracy.shares_of(errors.rms))),
        ],
    )


def promise_values(accuracy: Accuracy) -> dict[str, FloatArray | None]:
    """What a model states of its errors, by the names of the schema."""
    errors, allowed = accuracy.errors, accuracy.allowed if accuracy.asked.norm is None else None
    return {
        "peak_torque": errors.peak_torque,
        "allowed_error": allowed,
        "largest_error": errors.largest,
        "largest_share": errors.largest_share,
        "largest_of_allowed": None if allowed is None else share_of(errors.largest, allowed),
        "rms_error": errors.rms,
        "rms_share": errors.rms_share,
        "uncertainty": accuracy.uncertainty,
    }


def error_values(errors: ErrorTable, allowed: FloatArray | None) -> dict[str, FloatArray | None]:
    """Errors at given states, beside what a model's promise allows the joints, if it does."""
    return {
        "peak_torque": errors.peak_torque,
        "allowed_error": allowed,
        "largest_error": errors.largest,
        "rms_error": errors.rms,
        "within_allowed": None if allowed is None else np.asarray(errors.largest <= allowed),
        "largest_of_allowed": None if allowed is None else share_of(errors.largest, allowed),
        "largest_share_of_peak_here": errors.largest_share,
    }


def norm_rows(norms: Iterable[NormShare]) -> list[dict[str, float]]:
    """Shares of the norm as JSON has them: by the share of the states that keep each."""
    return [{"states": norm.states, "share": norm.share} for norm in norms]


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
