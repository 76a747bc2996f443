"""What is said of several motions: how each keeps its budget, and which verdicts change between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.elements import LETTERS
from gd_analyze.motions.trajectory import in_words
from gd_analyze.results.findings import Findings
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.text import amount, named_joints, number, percent

Row = dict[str, Any]

# A motion that allows a joint so many times less than others is named: it may be what costs the operations.
_STRICT = 20.0
# Elements that a sentence names.
_NAMED = 6
# Verdicts that say that an element does not matter.
_NOTHING = {"negligible", "neither"}


def has_motions(findings: Findings) -> bool:
    """Whether there are several motions to tell apart."""
    return "motions" in findings.tables


def along_told(findings: Findings) -> str:
    """Say along what: the motion, or how many of them."""
    motions = findings.trajectory.motions
    if not motions:
        return findings.trajectory.name
    names = [motion.name for motion in motions]
    told = in_words(names)
    return told if told.endswith(")") else f"{told} ({findings.trajectory.name})"


def motion_rows(findings: Findings) -> list[Row]:
    """One row per motion: set points, duration, torques and errors of the joints, and the worst of these.

    `used` is the largest error of every joint over what the budget allows it along the motion, `worst` the
    largest of them and `joint` its joint, from 1.
    """
    table = findings.tables["motions"]
    used = _used(findings)
    return [
        {
            "motion": str(table.motion.values[k]),
            "origin": str(table.motion_origin.values[k]),
            "set_points": int(table.set_points.values[k]),
            "duration": float(table.duration.values[k]),
            **{
                name: table[name].values[k].tolist()
                for name in ("peak_torque", "allowed_error", "largest_error", "rms_error")
            },
            "used": used[k].tolist(),
            "worst": float(used[k].max()),
            "joint": int(used[k].argmax()) + 1,
        }
        for k in range(table.sizes["motion"])
    ]


def verdict_rows(findings: Findings) -> list[Row]:
    """One row per element, ranked over all motions: verdict and torque share along each, and if they change.

    That an element is zero along one motion and negligible along another is no change.
    """
    table = findings.tables["motions"]
    rows = []
    for k, element in enumerate(table.element.values.tolist()):
        verdicts = table.verdict.values[k].tolist()
        gravity = table.quantity.values[k] == "gravity_loading"
        told = [v if v in _NOTHING or not gravity else "gravity" for v in verdicts]
        rows.append(
            {
                "element": element,
                "verdicts": told,
                "marks": [mark_of(verdict) for verdict in told],
                "torque_shares": table.torque_share.values[k].tolist(),
                "changes": len({"" if verdict in _NOTHING else verdict for verdict in told}) > 1,
            }
        )
    return rows


def mark_of(verdict: str) -> str:
    """A verdict where there is no room for words."""
    return "–" if verdict == "negligible" else LETTERS[verdict]


def changing(findings: Findings) -> list[Row]:
    """Those rows of `verdict_rows` whose verdict is another along another motion."""
    return [row for row in verdict_rows(findings) if row["changes"]]


def budget_sentence(findings: Findings) -> str:
    """Say that the budget holds on each motion, and where the model comes closest to it."""
    rows = motion_rows(findings)
    worst = max(rows, key=lambda row: row["worst"])
    count = len(rows)
    kept = f"The budget is measured along each of the {count} motions by itself, and holds on each"
    if not worst["worst"]:
        return f"{kept}."
    return (
        f"{kept}: the largest error, of what is allowed there, is {percent(worst['worst'])}, at joint "
        f"{worst['joint']} along {worst['motion']}."
    )


def short_sentence(findings: Findings) -> str:
    """Say both shortly: how the budget holds, and how many verdicts change."""
    rows = motion_rows(findings)
    worst, count = max(rows, key=lambda row: row["worst"]), len(changing(findings))
    used = (
        f" (at most {percent(worst['worst'])} of it used, by joint {worst['joint']} along {worst['motion']})"
    )
    verdicts = f"{count} of {len(verdict_rows(findings))} verdicts change" if count else "no verdict changes"
    return (
        f"The budget holds on each of the {len(rows)} motions by itself{used if worst['worst'] else ''}; "
        f"{verdicts} between them."
    )


def strict_sentence(findings: Findings) -> str:
    """Name the joint of which one motion allows far less than another, and what settles it; "" if none."""
    table, arm = findings.tables["motions"], findings.arm
    allowed = table.allowed_error.values
    ratio = allowed.max(axis=0) / allowed.min(axis=0)
    strict = np.flatnonzero(ratio >= _STRICT)
    if not strict.size or not findings.model.accuracy.asked.wholes & {"peak", "uncertainty"}:
        return ""
    joint = int(ratio.argmax())
    least, most = int(allowed[:, joint].argmin()), int(allowed[:, joint].argmax())
    names, peak = table.motion.values, float(table.peak_torque.values[least, joint])
    rest = [int(k) + 1 for k in strict if k != joint]
    others = f" (and far less at {named_joints(rest, arm.n_joints)})" if rest else ""
    return (
        f"Along {names[least]} joint {joint + 1} needs no more than "
        f"{amount(peak, arm.joints[joint].effort_unit)} and is allowed {number(float(ratio[joint]))} times "
        f"less than along {names[most]}{others}, which may cost operations{_settled(findings)}."
    )


def changing_sentence(findings: Findings) -> str:
    """Say on how many elements the verdict depends on the motion."""
    rows, every = changing(findings), len(verdict_rows(findings))
    if not rows:
        return f"No verdict on any of the {every} elements changes between the motions."
    names = [row["element"] for row in rows]
    told = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    verb = "changes" if len(rows) == 1 else "change"
    return f"Verdicts on {len(rows)} of {every} elements {verb} between the motions: {told}."


def _settled(findings: Findings) -> str:
    """How to allow more there; "" where the notice on friction and uncertainty says so."""
    if findings.model.notice:
        return ""
    asked = findings.model.accuracy.asked
    if len(asked.entries) == 1 and _has_friction(findings):
        return f'; --budget "{asked} or 10% friction" sets a floor'
    return "; an amount in N m in --budget, or a share of friction, sets a floor"


def _has_friction(findings: Findings) -> bool:
    nothing = np.zeros(findings.arm.n_joints)
    return bool(np.isfinite(ReferenceTorques(findings.arm, nothing).all("friction")).all())


def _used(findings: Findings) -> FloatArray:
    table = findings.tables["motions"]
    return share_of(table.largest_error.values, table.allowed_error.values)
