"""What is said of a measured motion: that it is no plan, what noise is left, and what that does."""

from __future__ import annotations

import numpy as np

from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import Row
from gd_analyze.text import amount, figures, named_joints, percent

# Labels of elements that a sentence lists.
_MOST_LISTED = 8


def is_recorded(findings: Findings) -> bool:
    """Whether the motion was measured."""
    return "recording" in findings.tables


def recording_told(findings: Findings) -> list[str]:
    """Say in sentences what the reader of a measured motion's results has to know; none of a plan."""
    if not is_recorded(findings):
        return []
    return [_what_it_is(findings), _of_budget(findings), *_of_ranking(findings)]


def _what_it_is(findings: Findings) -> str:
    if findings.trajectory.motions:
        cutoffs = findings.tables["recording"].cutoff.values
        lowest = f"{figures(float(cutoffs.min()))} Hz"
        return (
            "These are recordings, not plans: accelerations are of readings, smoothed without delay, cut-off "
            f"{lowest} or higher."
        )
    smoothed = findings.tables["recording"].attrs["treatment"].split("\n")[-1].partition(";")[0]
    return f"This is a recording, not a plan: {smoothed}."


def noise_rows(findings: Findings) -> list[Row]:
    """Cut-off and noise of every joint, and what the noise makes of torque beside the budget."""
    names = ["cutoff", "noise_q", "noise_qdd", "torque_noise"]
    rows = rows_of(findings.tables["recording"][names], "joint")
    allowed = findings.model.accuracy.allowed.tolist()
    return [
        row
        | {
            "joint_name": joint.name,
            "unit": joint.unit,
            "effort_unit": joint.effort_unit,
            "allowed": budget,
            "of_allowed": row["torque_noise"] / budget,
        }
        for row, joint, budget in zip(rows, findings.arm.joints, allowed, strict=True)
    ]


def _of_budget(findings: Findings) -> str:
    """Noise of torque beside what the budget allows."""
    rows = noise_rows(findings)
    worst = max(rows, key=lambda row: row["of_allowed"])
    noise = f"{amount(worst['torque_noise'], worst['effort_unit'])} of torque at joint {worst['joint']}"
    share = f"{percent(worst['of_allowed'])} of what the budget allows (standard deviation)"
    beyond = [row["joint"] for row in rows if row["of_allowed"] > 1.0]
    if not beyond:
        return f"The noise left in the accelerations makes at most {noise}, {share}."
    return (
        f"The noise left in the accelerations makes {noise}, {share}, and more than it allows at "
        f"{named_joints(beyond, len(rows))}: models for such a budget follow the noise, too; a lower cut-off "
        "leaves less."
    )


def _of_ranking(findings: Findings) -> list[str]:
    """Elements whose place or verdict the noise decides."""
    table = findings.tables["recording"]
    labels = table.element.values
    within, undecided = labels[table.within_noise.values].tolist(), labels[table.verdict_open.values].tolist()
    told = []
    if within:
        count = np.count_nonzero(table.element_noise.values)
        told.append(
            f"Of {count} elements of D, {len(within)} make no more torque than twice that of the noise: how "
            "they rank is not told by this recording."
        )
    if undecided:
        told.append(f"The noise decides whether {_listed(undecided)} is negligible.")
    return told


def _listed(labels: list[str]) -> str:
    if len(labels) > _MOST_LISTED:
        return f"each of {', '.join(labels[:_MOST_LISTED])} and {len(labels) - _MOST_LISTED} more"
    return labels[0] if len(labels) == 1 else f"each of {', '.join(labels)}"
