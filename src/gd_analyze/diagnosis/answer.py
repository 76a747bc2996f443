"""The answer of a diagnosis in a sentence or two, and what remains of the torques follows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.causes import MOST_RESIDUAL_SHARE, doubtful_positions, is_same, is_unexplained
from gd_analyze.diagnosis.diagnose import Diagnosis
from gd_analyze.diagnosis.faults import VELOCITIES, Fault
from gd_analyze.diagnosis.hypothesis import Candidate, Problem
from gd_analyze.diagnosis.of_positions import TimeUnit
from gd_analyze.diagnosis.remedies import IN_DEGREES
from gd_analyze.text import named_joints, percent

_BINS = 10  # bins of a quantity that a residual may follow
_LEAST_SAMPLES_PER_BIN = 5  # samples of each bin, on average
# Share of the residual's variance that the bins' means explain where it follows the quantity.
_FOLLOWED_VARIANCE = 0.3
# Torque by which the file's links are off, over its own, below which they are as good as right.
_RIGHT_TORQUE_SHARE = 0.05
# The same beyond which files seldom are off: masses and torque constants are off by up to that.
MUCH_TORQUE_SHARE = 1.0 / 3.0
_POSSIBLE_FALL = 15.0  # fall of the score from which a cause is worth a look then
# Share of faulty readings that the answer mentions; fewer are in the table alone.
_MENTIONED_FAULT_SHARE = 0.002

_FAR_OFF = "The links must be off by more than a file's usually are: check that the file is of this arm."
_FRICTION_ALONE = (
    "Friction alone explains the torques as well: "
    "there is too little motion to say anything, or they do not hold the arm's weight and inertia."
)
_FOLLOWED = ("position", "velocity", "acceleration", "time")


def answer(diagnosis: Diagnosis) -> str:
    """What is wrong, with the residual before and after and what to do; or that nothing needs explaining."""
    n, causes, fit = diagnosis.arm.n_joints, diagnosis.causes, diagnosis.after
    texts = []
    doubtful = doubtful_positions(diagnosis.corrected)
    if doubtful and is_unexplained(fit):
        joints = named_joints([i + 1 for i in doubtful], n)
        unit = f"say their unit first, such as {IN_DEGREES}"
        texts.append(f"The positions at {joints} are beyond what such joints reach: {unit}.")
    texts += [_of_causes(diagnosis)] if causes else []
    texts += [f"Log {log} differs: {_begun(cause.what)} ({cause.remedy})." for log, cause in diagnosis.apart]
    texts += [_of_rival(diagnosis, rival) for rival in diagnosis.rivals]
    faults = mentioned(diagnosis.faults)
    # A wrong unit of time explains velocities, too.
    is_explained = any(cause.name == TimeUnit.name for cause in causes)
    of_velocities = [fault for fault in faults if fault.name == VELOCITIES and not is_explained]
    of_torques = [fault for fault in faults if fault.name != VELOCITIES]
    texts += [faults_in_words(group, n) for group in (of_torques, of_velocities) if group]
    poor = [i for i in diagnosis.problem.moving if fit.residuals[i] > MOST_RESIDUAL_SHARE]
    several = f"several things may be wrong: {_of_poor(diagnosis, poor)}." if poor else ""
    if diagnosis.apart:
        texts.append("Diagnose the logs one by one.")
    elif causes:
        texts += [f"S{several[1:]}"] if poor else []
    elif not diagnosis.problem.moving:
        texts.append("Nothing else can be said: no joint is left to compare.")
    elif not diagnosis.tells:
        return " ".join([_FRICTION_ALONE, *texts])
    elif poor:
        texts.append(f"No cause found, {several}")
    elif diagnosis.is_far_off:
        texts.append(f"No cause found: {percent(fit.remains)} of the torque's RMS remains.")
    else:
        texts.append(_of_nothing(diagnosis, "Nothing else to explain" if faults else "Nothing to explain"))
    return " ".join([*texts, _FAR_OFF] if diagnosis.is_far_off else texts)


def _of_nothing(diagnosis: Diagnosis, beginning: str) -> str:
    """That file and friction fit, with masses off by some share."""
    remains = f"{percent(diagnosis.before.remains)} of the torque's RMS remains."
    torque_error = diagnosis.before.off
    if torque_error < _RIGHT_TORQUE_SHARE:
        return f"{beginning}: the file and friction fit, {remains}"
    text = f"{beginning} beyond masses off by some {percent(torque_error)}: {remains}"
    best = diagnosis.ranking[0] if diagnosis.ranking else None
    if torque_error > MUCH_TORQUE_SHARE and best is not None and best.fall > _POSSIBLE_FALL:
        text += f" That is much, so look whether {_begun(best.what)} ({best.remedy})."
    return text


def _of_causes(diagnosis: Diagnosis) -> str:
    causes = diagnosis.causes
    what = causes[0].what
    if len(causes) > 1:
        what = f"Two things are wrong: {_begun(what)}, and {_begun(causes[1].what)}"
    after, before = (_share_of_torque(fit.remains) for fit in (diagnosis.after, diagnosis.before))
    text = f"{what}: {after} of the torque's RMS remains instead of {before}. {diagnosis.remedy.advice}"
    unsure = [cause.unsure for cause in causes if cause.unsure]
    return text + "".join(f" The log does not tell this from another cause: {other}." for other in unsure)


def _of_rival(diagnosis: Diagnosis, rival: Candidate) -> str:
    is_one = is_same(rival, diagnosis.causes[0])
    degree = "The same in this log" if is_one else "Nearly as good"
    return f"{degree}: {_begun(rival.what)} ({rival.remedy})."


def _of_poor(diagnosis: Diagnosis, poor: Sequence[int]) -> str:
    """What remains at some joints, from 0, and what it follows."""
    missed = ", ".join(_share_of_torque(float(diagnosis.after.residuals[i])) for i in poor)
    joints = named_joints([i + 1 for i in poor], diagnosis.arm.n_joints)
    return f"{missed} of the torque's RMS remains at {joints}; it follows {_followed(diagnosis, poor)}"


def _followed(diagnosis: Diagnosis, poor: Sequence[int]) -> str:
    """Which quantities the residuals of some joints, from 0, follow: "time at joint 3"."""
    follows = what_remains_follows(diagnosis.corrected)
    joints_by_quantity: dict[str, list[int]] = {}
    for i in poor:
        joints_by_quantity.setdefault(follows[i], []).append(i + 1)
    if len(joints_by_quantity) == 1:
        return next(iter(joints_by_quantity)) or "nothing"
    return " and ".join(
        f"{quantity} at {named_joints(joints, diagnosis.arm.n_joints)}"
        for quantity, joints in joints_by_quantity.items()
        if quantity
    )


def _share_of_torque(remains: float) -> str:
    return percent(remains) if remains <= 1.0 else "more than all"


def mentioned(faults: Sequence[Fault]) -> list[Fault]:
    """Faults of more than some single readings."""
    return [fault for fault in faults if fault.share > _MENTIONED_FAULT_SHARE]


def faults_in_words(faults: Sequence[Fault], n: int) -> str:
    """The first of some faults with its remedy, and the joints of the others."""
    first = faults[0]
    joints = sorted({fault.joint + 1 for fault in faults[1:]} - {first.joint + 1})
    further = f"; {named_joints(joints, n)}, too" if joints else ""
    return f"{first.what}, {first.effect}{further}. {first.remedy[0].upper()}{first.remedy[1:]}."


def _begun(sentence: str) -> str:
    return sentence[0].lower() + sentence[1:]


def what_remains_follows(problem: Problem) -> list[str]:
    """By joint, which of its position, velocity, acceleration or time its residual follows; "" for none."""
    q, qd, qdd, _ = problem.correction.states(problem.samples)
    measured, model = problem.torques()
    out = []
    for i in range(problem.n):
        residual = measured[:, i] - model[:, i]
        is_measured = np.isfinite(residual)
        shares = [
            _share(x[is_measured], residual[is_measured])
            for x in (q[:, i], qd[:, i], qdd[:, i], problem.samples.time)
        ]
        out.append(_FOLLOWED[int(np.argmax(shares))] if max(shares) > _FOLLOWED_VARIANCE else "")
    return out


def _share(x: FloatArray, values: FloatArray) -> float:
    """Share of the variance of values that the means over bins of x explain, adjusted for their number."""
    if len(values) < _BINS * _LEAST_SAMPLES_PER_BIN or not (np.ptp(values) and np.ptp(x)):
        return 0.0
    parts = np.array_split(values[np.argsort(x, kind="stable")], _BINS)
    inside = sum(float(np.square(part - part.mean()).sum()) for part in parts)
    whole = float(np.square(values - values.mean()).sum())
    return 1.0 - inside / (len(values) - _BINS) / (whole / (len(values) - 1))
