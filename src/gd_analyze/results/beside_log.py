"""The first screen of a log with torques: what it says of the file, joint by joint, and of the model."""

from __future__ import annotations

import numpy as np

from gd_analyze.diagnosis.as_filed import AsFiled
from gd_analyze.diagnosis.causes import MOST_RESIDUAL_SHARE
from gd_analyze.result import Mark, Table, joint_values
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import tube_bound
from gd_analyze.schema import declared_table
from gd_analyze.text import amount, named_joints, percent, thousands

# Words for a joint that the file describes, describes once its links are fitted, or does not describe, and
# for one of which the log says nothing.
FITS, NEEDS_FITTING, CONTRADICTED, NOT_COMPARED = "fits", "needs fitting", "contradicted", "not compared"
# A joint that fits by itself, of a file that the log contradicts as a whole; and one of a log that friction
# alone explains as well.
IN_DOUBT, NOT_TOLD = "in doubt", "not told"
# One that fits but for a constant torque.
OFFSET = "offset"
_NOTE = (
    "Residual: measured torque less that of the file as it is, fitted friction and an offset, at samples of "
    "the log where the joint moves."
)
_ON_TERMINAL = [
    "joint", "peak_measured", "residual", "residual_below_95", "share_left", "bound", "allowed", "said",
]  # fmt: skip


def has_log(findings: Findings) -> bool:
    """Whether torques were measured along the motion."""
    return "measured_torque" in findings.tables


def joint_verdicts(findings: Findings) -> list[str]:
    """What the log says of the file at every joint."""
    table, log = findings.tables.get("diagnosis"), findings.model.accuracy.log
    if table is None or log is None:
        return [NOT_COMPARED] * findings.arm.n_joints
    words, shares = [], zip(table.remains_as_filed.values, table.remains_before.values, strict=True)
    tells = findings.tables["measured_torque"].attrs["verdict"] != "tells nothing"
    for joint, (as_filed, fitted) in enumerate(shares, start=1):
        if np.isnan(as_filed):
            words.append(NOT_COMPARED)
        elif not tells:
            words.append(NOT_TOLD)
        elif joint in log.contradicted:
            words.append(CONTRADICTED if fitted > MOST_RESIDUAL_SHARE else IN_DOUBT)
        elif table.is_offset.values[joint - 1]:
            words.append(OFFSET)
        else:
            words.append(FITS if as_filed <= MOST_RESIDUAL_SHARE else NEEDS_FITTING)
    return words


def as_filed_in(findings: Findings) -> AsFiled:
    """What the file as it is leaves of each joint's torque, by which it is judged."""
    table = findings.tables.get("diagnosis")
    if table is None:
        return AsFiled(*np.full((3, findings.arm.n_joints), np.nan))
    names = ("residual_as_filed", "below_95_as_filed", "remains_as_filed")
    return AsFiled(*(table[name].values for name in names))


def joints_beside_log(findings: Findings) -> Table:
    """By joint: measured peak, what friction leaves, error of the model, and the verdict."""
    table, arm, model = findings.tables["measured_torque"], findings.arm, findings.model
    bound = tube_bound(findings)
    error, proof = (
        (model.accuracy.errors.largest, "error") if bound is None else (bound, f"error, {findings.proof}")
    )
    is_simplified = not model.is_exact
    names = ("bias", "rms_difference", "peak_measured", "explained", "rms_beside_friction")
    values = joint_values(arm.joints) | {name: table[name].values for name in names}
    as_filed = as_filed_in(findings)
    values |= {"residual": as_filed.rms, "residual_below_95": as_filed.below_95, "share_left": as_filed.share}
    values["said"] = joint_verdicts(findings)
    seen = {
        "bound": error if is_simplified else None,
        "allowed": model.accuracy.allowed if is_simplified else None,
    }
    return declared_table(
        "measured_torque",
        "joints",
        f"Torque by joint, {thousands(table.attrs['compared'])} readings compared",
        values,
        _ON_TERMINAL,
        note=_NOTE,
        seen=seen,
        words={"bound": proof},
        drawn={"said": [Mark(word.replace(" ", "-"), word) for word in values["said"]]},
    )


def as_good_within_log(findings: Findings) -> str:
    """How good a model within a log's budget is, with a space behind it; "" for any other."""
    model, log = findings.model, findings.model.accuracy.log
    if model.accuracy.asked.wholes != {"log"} or model.is_exact or log is None or log.growth is None:
        return ""
    terms, of_terms = model.size
    text = f"Within what this log can tell, {terms} terms are as good as all {thousands(of_terms)}: "
    if not (log.growth > 0.0).any():
        return f"{text}on held-out readings the residual is no larger than the exact model's. "
    joint = int(np.nanargmax(log.growth))
    growth = percent(float(log.growth[joint]))
    return f"{text}on held-out readings the residual is at most {growth} larger (joint {joint + 1}). "


def left_in_words(findings: Findings) -> str:
    """What is left at the joints that a figure shows: "0.45 N m RMS, 56 % of the measured torque"."""
    as_filed = as_filed_in(findings)
    texts = [
        f"{named_joints([i + 1], findings.arm.n_joints)}: "
        f"{amount(float(as_filed.rms[i]), findings.arm.joints[i].effort_unit)} RMS, "
        f"{percent(float(as_filed.share[i]))} of the measured torque"
        for i in shown_joints(findings)
    ]
    return "; ".join(texts)


def shown_joints(findings: Findings) -> list[int]:
    """The two joints, from 0, that matter most: those that the file does not fit, then the most left."""
    shares = np.nan_to_num(as_filed_in(findings).share, nan=-1.0)
    verdicts = joint_verdicts(findings)
    order = sorted(range(len(shares)), key=lambda i: (verdicts[i] in (FITS, NOT_COMPARED), -shares[i]))
    return sorted(i for i in order[:2] if shares[i] >= 0.0)
