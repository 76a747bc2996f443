"""The comparison of two files as a result: how much their torques differ, and what makes the difference."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import coulomb_friction, viscous_coefficients
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.result import Result, Table, Value, joint_values
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import declared_table
from gd_analyze.studies.comparison import NUMBERS_ALIKE, Comparison, Step
from gd_analyze.text import amount, enumerated, joint_name, number, percent

# Share of peak torque below which a difference comes from the digits that files have.
_OF_DIGITS = 1e-4
# Parts make most of a difference where less than this share of it is left without them.
_MOST = 0.5
# Parts are not shown once less than this share of the difference is left.
_SHOWN = 0.01


def compared_result(
    comparison: Comparison, names: tuple[str, str], progress: Progress = NO_PROGRESS
) -> Result:
    """The comparison as a result; `names` are those of the two files."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of arms that are in no file
        shares = comparison.shares(comparison.largest)
        agrees = bool(shares.max() <= NUMBERS_ALIKE)
        steps = comparison.steps(progress) if comparison.is_in_order and not agrees else []
    worst = int(np.argmax(shares))
    joint = comparison.first.joints[worst]
    place = f"at joint {joint_name(worst + 1, joint.name)}"
    if agrees:
        headline = "Torques agree, up to round-off."
    elif shares[worst] < _OF_DIGITS:
        headline = "Torques agree within 0.01 % of each joint's peak."
    else:
        size = amount(comparison.largest[worst], joint.effort_unit)
        difference = f"{percent(shares[worst])} of a joint's peak, {size} {place}"
        headline = f"Torques differ by up to {difference}. {_makers(comparison, steps)}".rstrip()
    base = comparison.base if comparison.is_in_order else None
    return Result(
        title=" and ".join(_short(names, names)),
        subtitle=f"compared by torques D qdd + h + c at {comparison.states.in_words}",
        headline=headline,
        facts=(
            Value("agrees", agrees),
            Value("largest_difference", comparison.largest[worst]),
            Value("largest_share", shares[worst]),
            Value("largest_at_joint", worst + 1),
            Value("compared_at", comparison.states.in_words),
            Value("base_rotation", None if base is None else base.rotations[0]),
            Value("base_translation", None if base is None else base.translations[0]),
        ),
        parts=(
            _joints_table(comparison, shares, names),
            *([_parts_table(comparison, steps)] if steps else []),
        ),
        notices=tuple(_notices(comparison, names)),
        provenance={"first": names[0], "second": names[1]},
    )


def _makers(comparison: Comparison, steps: list[Step]) -> str:
    """Which parts make the difference, in a sentence."""
    if not steps:
        return ""
    total = comparison.shares(comparison.largest).max()
    left = [comparison.shares(step.left).max() for step in steps]
    count = next((k for k, share in enumerate(left, start=1) if share < _MOST * total), len(left))
    names = enumerated([step.part.name for step in steps[:count]])
    if left[count - 1] <= NUMBERS_ALIKE:
        return f"All of it comes from {names}."
    return f"Most of it comes from {names}; without that, {percent(left[count - 1])} would be left."


def _short(names: tuple[str, str], otherwise: tuple[str, str]) -> tuple[str, str]:
    """The files without their folders, or something else where that is the same."""
    first, second = (Path(name).name for name in names)
    return (first, second) if first != second else otherwise


def _joints_table(comparison: Comparison, shares: FloatArray, names: tuple[str, str]) -> Table:
    theirs = [comparison.second.joints[k].name for k in comparison.order]
    is_named_alike = theirs == list(comparison.first.joint_names)
    values: dict[str, Any] = joint_values(comparison.first.joints) | {
        "second_joint": theirs,
        "first_peak": comparison.peaks[0],
        "second_peak": comparison.peaks[1],
        "difference": comparison.largest,
        "share": shares,
    }
    shown = ["joint", *([] if is_named_alike else ["second_joint"])]
    shown += ["first_peak", "second_peak", "difference", "share"]
    files = _short(names, ("first", "second"))
    words = {"first_peak": files[0], "second_peak": files[1], "second_joint": files[1]}
    title = "Peak torques, and the largest difference"
    return declared_table("compared", "joints", title, values, shown, words=words)


def _parts_table(comparison: Comparison, steps: list[Step]) -> Table:
    """What the first arm takes over, step by step."""
    first = comparison.first
    alone = [comparison.shares(step.alone) for step in steps]
    worst = [int(np.argmax(shares)) for shares in alone]
    values: Mapping[str, Any] = {
        "part": [step.part.name for step in steps],
        "kind": [step.part.kind for step in steps],
        "link": [None if step.part.link is None else step.part.link + 1 for step in steps],
        "difference_in": [step.part.difference for step in steps],
        "alone": [step.alone[k] for step, k in zip(steps, worst, strict=True)],
        "alone_unit": [first.joints[k].effort_unit for k in worst],
        "alone_joint": [k + 1 for k in worst],
        "alone_share": [shares[k] for shares, k in zip(alone, worst, strict=True)],
        "left_share": [comparison.shares(step.left).max() for step in steps],
    }
    note = (
        "Parts are copied from the second file to the first one by one, the one that helps most first. "
        "Alone: effect of this part only; left: the largest difference once it and those above are copied."
    )
    names = ["part", "difference_in", "alone", "alone_joint", "alone_share", "left_share"]
    left = values["left_share"]
    enough = _SHOWN * comparison.shares(comparison.largest).max()
    top = next((k for k, share in enumerate(left, start=1) if share < enough), len(left))
    title = "What makes the difference"
    return declared_table("compared", "parts", title, values, names, note=note, top=top)


def _notices(comparison: Comparison, names: tuple[str, str]) -> Iterator[str]:
    first, second = comparison.first, comparison.second
    if not comparison.is_in_order:
        yield (
            "The joints have the same names in both files, but another order from base to tip: they are "
            "paired by name, and what makes the difference is not told."
        )
        return
    turn = np.degrees(np.arccos(np.clip((np.trace(comparison.base.rotations[0]) - 1) / 2, -1, 1)))
    if turn > 1e-6:
        yield f"The base frame of {names[1]} is turned by {number(turn)}° against that of {names[0]}."
    if any(arm.drives for arm in (first, second)):
        ours, theirs = (_friction(arm) for arm in (first, second))
        differing = np.flatnonzero(np.abs(ours - theirs).max(axis=0) > NUMBERS_ALIKE)
        if differing.size:
            joints = ", ".join(str(k + 1) for k in differing)
            noun = "joint" if differing.size == 1 else "joints"
            yield f"Friction, which is no part of these torques, differs at {noun} {joints}."


def _friction(arm: RobotArm) -> FloatArray:
    """Viscous and Coulomb friction at the joints, (3, n)."""
    if not arm.drives:
        return np.zeros((3, arm.n_joints))
    once = np.ones(arm.n_joints)
    return np.array([viscous_coefficients(arm), coulomb_friction(arm, once), coulomb_friction(arm, -once)])
