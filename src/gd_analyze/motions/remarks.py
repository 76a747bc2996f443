"""What is to be said of the columns that were chosen, and of those that were not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gd_analyze.motions.joints import Family, arms_numbers
from gd_analyze.motions.refusals import PLURAL
from gd_analyze.motions.roles import Meaning
from gd_analyze.motions.said import listed
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm


def renaming(family: Family) -> list[str]:
    """Say which joints were matched by number although their names differ."""
    if not family.renamed:
        return []
    log, own = family.renamed[0]
    pairs = f"{log} is {own}"
    if len(family.renamed) > 1:
        pairs += " and so on to " + " is ".join(family.renamed[-1])
    return [
        f"the log's joints are not called like the arm's and were matched by number: {pairs}; "
        f"--map joint:{own}={log} and so on matches them otherwise"
    ]


def left_over(chosen: Mapping[str, Family], arm: RobotArm, table: LogTable) -> list[str]:
    """Say that a log counts more joints than the arm has: it may be of another arm."""
    family = chosen.get("q")
    if family is None or not family.extra or not family.why.startswith("by number"):
        return []
    counts = arms_numbers([joint.name for joint in arm.joints])
    if counts is not None and max(counts[1]) - min(counts[1]) >= arm.n_joints:
        return []  # an arm picked out of a longer chain counts as the log does
    return [
        f"it counts {len(family.columns) + len(family.extra)} joints, arm {arm.name} has {arm.n_joints}: "
        f"{listed([table.names[column] for column in family.extra])} left out; check that it is "
        "of this arm"
    ]


def standing_in(
    families: Sequence[Family], chosen: Mapping[str, Family], zero: frozenset[object], table: LogTable
) -> list[str]:
    """Say which columns are taken in the place of such that are 0 throughout."""
    told = []
    for role, family in chosen.items():
        dead = [of for of in families if of.role == role and of.key in zero and of.key != family.key]
        if dead:
            first = [table.names[min(of.all_columns)] for of in dead]
            told.append(
                f"{' and '.join(first)} and so on are 0 throughout; {PLURAL[role]} are taken from "
                f"{table.names[min(family.all_columns)]} and so on"
            )
    return told


def unused(
    used: set[int],
    meanings: Sequence[Meaning],
    families: Sequence[Family],
    chosen: Mapping[str, Family],
    zero: frozenset[object],
) -> dict[int, str]:
    """Why each of the other columns is left out."""
    why = {}
    for column, meaning in enumerate(meanings):
        if column not in used and meaning.role not in ("time", "sec", "nanosec", "index"):
            why[column] = "names of joints" if meaning.role == "name" else "no quantity of the joints' motion"
    for family in families:
        reason = "0 throughout" if family.key in zero else "of another family"
        if family.kind == "target" and "q" in chosen and chosen["q"].kind != "target":
            reason = "target beside measured"
        for column in family.all_columns:
            if column not in used:
                why[column] = reason
        for column in family.extra:
            if column not in used:
                why[column] = (
                    "of a joint that the arm lacks" if family.why != "by name" else why.get(column, "")
                )
    return why
