"""The answer of a diagnosis, in a word and in sentences, and what the remaining torques follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.causes import MOST_RESIDUAL_SHARE, is_same, is_unexplained
from gd_analyze.diagnosis.faults import VELOCITIES, Fault
from gd_analyze.diagnosis.hypothesis import MOST_REMAINDER, Candidate, Problem
from gd_analyze.diagnosis.of_one_log import DIFFERENCES, FrictionOfLogs
from gd_analyze.diagnosis.of_positions import TimeUnit, doubtful_positions
from gd_analyze.diagnosis.remedies import IN_DEGREES
from gd_analyze.errors import argument, in_options
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import amount, enumerated, named_joints, percent

if TYPE_CHECKING:
    from gd_analyze.diagnosis.diagnose import Diagnosis

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

# Share of faulty readings of which a verdict takes note; lost messages and spikes of a sound log are fewer.
_FAULTY_SHARE = 0.02

_FAR_OFF = (
    "The file's links must be off by more than a file's usually are: check that it is the file of this arm."
)
# How the source of an arm begins whose numbers were fitted to logs.
IDENTIFIED = "Identified by gd-analyze"
TELLS_NOTHING = "The log does not tell whether the file describes this robot"
_FRICTION_ALONE = (
    "friction alone explains the torques as well, "
    "as there is too little motion, or they do not hold the arm's weight and inertia."
)
_FOLLOWED = ("position", "velocity", "acceleration", "time")
_VARIES = {quantity: f"varies with {quantity}" for quantity in _FOLLOWED} | {"time": "drifts with time"}
Word = Literal["agrees", "agrees in part", "does not agree", "tells nothing"]


def word_of(diagnosis: Diagnosis) -> Word:
    """The verdict on logs and file, where the logs tell anything beside friction.

    They do not agree if a joint's column is of no use, the links must be off by more than a file's usually
    are, most of a joint's torque remains, logs have causes of their own, or there is a cause of more than a
    file's usual error. They agree in part if there is a smaller cause, friction of some logs differs, many
    readings are faulty, the links are off by much, a constant is much of a joint's torque, or more remains
    than a file's usual error leaves.
    """
    fit = diagnosis.after
    is_column_useless = any(fault.is_of_column for fault in diagnosis.faults)
    is_most_left = float(np.nanmax(fit.residuals, initial=0.0)) > MOST_REMAINDER
    if is_column_useless and diagnosis.problem.moving:
        return "does not agree"
    if not diagnosis.tells:
        return "tells nothing"
    if diagnosis.is_far_off or is_most_left or diagnosis.apart:
        return "does not agree"
    if diagnosis.causes:
        is_friction = all(cause.name == FrictionOfLogs.name for cause in diagnosis.causes)
        is_clear = _is_misfit(diagnosis) and not is_friction
        return "does not agree" if is_clear else "agrees in part"
    is_faulty = any(fault.share > _FAULTY_SHARE for fault in diagnosis.faults)
    is_in_part = is_faulty or is_unexplained(fit) or fit.off > MUCH_TORQUE_SHARE or bool(diagnosis.offsets)
    # Drives that a file states are part of what it says.
    is_in_part |= (
        bool(diagnosis.arm.drives)
        and float(np.nanmax(diagnosis.as_filed.share, initial=0.0)) > MOST_REMAINDER
    )
    return "agrees in part" if is_in_part else "agrees"


def answer(diagnosis: Diagnosis) -> str:
    """Whether the file describes the robot of the logs, what is wrong where it does not, and what to do."""
    n, causes, fit = diagnosis.arm.n_joints, diagnosis.causes, diagnosis.after
    texts = [opening(diagnosis)]
    doubtful = doubtful_positions(diagnosis.corrected)
    if doubtful and is_unexplained(fit):
        joints = named_joints([i + 1 for i in doubtful], n)
        unit = f"say their unit first, such as {IN_DEGREES}"
        texts.append(f"The positions at {joints} are beyond what such joints reach: {unit}.")
    texts += [_of_causes(diagnosis)] if causes else []
    texts += [_of_offsets(diagnosis)] if causes and diagnosis.offsets else []
    texts += [f"Log {log} differs: {_begun(cause.what)} ({cause.remedy})." for log, cause in diagnosis.apart]
    texts += ["Diagnose the logs one by one."] if diagnosis.apart else []
    texts += [_of_rival(diagnosis, rival) for rival in diagnosis.rivals]
    faults = mentioned(diagnosis.faults)
    # A wrong unit of time explains velocities, too.
    is_explained = any(cause.name == TimeUnit.name for cause in causes)
    of_velocities = [fault for fault in faults if fault.name == VELOCITIES and not is_explained]
    of_torques = [fault for fault in faults if fault.name != VELOCITIES]
    texts += [_remedy_of(of_torques)] if of_torques else []
    texts += [faults_in_words(of_velocities, n)] if of_velocities else []
    poor = _poor(diagnosis)
    if causes and poor:
        joints = named_joints([i + 1 for i in poor], n)
        texts.append(f"Something else is wrong, too: at {joints} {_left_of_poor(diagnosis, poor)}.")
    if not diagnosis.problem.moving:
        texts.append("No joint is left to compare.")
    return " ".join([*texts, _FAR_OFF] if diagnosis.is_far_off and _FAR_OFF not in texts else texts)


def opening(diagnosis: Diagnosis) -> str:
    """The verdict as a sentence or two: what the file describes, what is left, and faulty readings."""
    texts = [_verdict(diagnosis)]
    if diagnosis.offsets and diagnosis.tells and not diagnosis.causes:
        texts.append(_of_offsets(diagnosis))
    faults = [fault for fault in mentioned(diagnosis.faults) if fault.name != VELOCITIES]
    if faults:
        texts.append(_what_is_faulty(faults, diagnosis.arm.n_joints))
    return " ".join(texts)


def _verdict(diagnosis: Diagnosis) -> str:
    """What of the robot the file describes, and how much of the torque is left."""
    word, fit, n = word_of(diagnosis), diagnosis.after, diagnosis.arm.n_joints
    if word == "tells nothing":
        return f"{TELLS_NOTHING}: {_FRICTION_ALONE}" if diagnosis.problem.moving else f"{TELLS_NOTHING}."
    compared = np.flatnonzero(np.isfinite(fit.residuals)).tolist()
    if diagnosis.causes:
        what, *further = [_begun(cause.what) for cause in diagnosis.causes]
        things = f": {what}." if not further else f" for two reasons: {what}, and {further[0]}."
        if any(cause.name in DIFFERENCES for cause in diagnosis.causes):
            return f"The logs do not agree with each other{things}"
        if diagnosis.made_worse:
            things = things.replace(": ", ": its links are off, or ", 1)
        return f"The file {'does not fit' if _is_misfit(diagnosis) else 'nearly fits'} this log{things}"
    if diagnosis.apart:
        return "The logs do not agree with each other."
    poor = _poor(diagnosis)
    if not poor:
        return _FAR_OFF if diagnosis.is_far_off else _of_fit(diagnosis, compared)
    good = [i for i in compared if i not in poor]
    subject = f"{_of_good(diagnosis, good)} but not" if good else "does not fit"
    joints = "any joint" if len(poor) == n else named_joints([i + 1 for i in poor], n)
    text = f"The file {subject} {joints} (even with its links fitted, {_left_of_poor(diagnosis, poor)})."
    unmoved = diagnosis.unmoved
    if unmoved:
        never = f"The position of {named_joints(unmoved, n)} never changes in the log"
        remedy = in_options(argument("map", f"q:{unmoved[0]}=COLUMN"))
        return f"{text} {never}: if it moved, name another column with {remedy}."
    return f"{text} No sign, unit, payload or column mends it."


def contradicted_joints(diagnosis: Diagnosis) -> tuple[int, ...]:
    """Joints, from 1, of which file and log do not agree: more is left than a file's usual error leaves.

    Where they do not agree and no joint stands out, these are all that are compared.
    """
    useless = {fault.joint + 1 for fault in diagnosis.faults if fault.is_of_column}
    if word_of(diagnosis) == "tells nothing":
        return ()
    if useless:
        return tuple(sorted(useless))
    residuals, moving = diagnosis.before.residuals, diagnosis.problem.moving
    joints = tuple(i + 1 for i in moving if residuals[i] > MOST_RESIDUAL_SHARE)
    if joints or word_of(diagnosis) != "does not agree":
        return joints
    return tuple(i + 1 for i in moving)


def _is_misfit(diagnosis: Diagnosis) -> bool:
    """Whether file and log differ by more than a file's usual error, or the causes explain most of it."""
    shares = (diagnosis.as_filed.share, diagnosis.as_mended.share)
    as_filed, mended = (float(np.nansum(x**2)) for x in shares)
    return is_unexplained(diagnosis.before) or mended < MOST_REMAINDER**2 * as_filed


def _of_good(diagnosis: Diagnosis, good: Sequence[int]) -> str:
    """Which joints, from 0, the file fits, as it is and once its links are fitted: "fits joints 2 to 4"."""
    n, as_filed = diagnosis.arm.n_joints, diagnosis.as_filed.share
    right = [i for i in good if as_filed[i] <= MOST_RESIDUAL_SHARE]
    mended = [i for i in good if i not in right]
    texts = []
    if right:
        left = percent(float(as_filed[right].max()))
        texts.append(f"{named_joints([i + 1 for i in right], n)} ({left} of the torque or less is left)")
    if mended:
        joints = named_joints([i + 1 for i in mended], n)
        texts.append(f"once its links are fitted, {joints} ({_left(diagnosis, mended)})")
    return f"fits {' and, '.join(texts)}"


def is_identified(arm: RobotArm) -> bool:
    """Whether `gd-analyze identify` wrote an arm's file."""
    return any(text.startswith(IDENTIFIED) for text in arm.sources)


def has_useless_columns(diagnosis: Diagnosis) -> bool:
    """Whether a column is of no use: of torques, or of positions that never change beside a misfit."""
    if any(fault.is_of_column for fault in diagnosis.faults):
        return True
    return bool(diagnosis.unmoved) and not diagnosis.causes and bool(_poor(diagnosis))


def is_for_identification(diagnosis: Diagnosis) -> bool:
    """Whether links fitted to the log, which they were not before, may explain what no cause does."""
    if is_identified(diagnosis.arm) or has_useless_columns(diagnosis):
        return False
    if diagnosis.causes:
        return bool(diagnosis.made_worse)
    is_off = diagnosis.is_far_off or diagnosis.after.off >= _RIGHT_TORQUE_SHARE
    is_poor = diagnosis.is_far_off or bool(_poor(diagnosis))
    return bool(diagnosis.needing_a_fit) or (is_poor and is_off)


def _of_fit(diagnosis: Diagnosis, compared: Sequence[int]) -> str:
    """That file, friction and drives fit, with masses off by some share."""
    fit, n = diagnosis.after, diagnosis.arm.n_joints
    fitted = ["friction"]
    if fit.joint_numbers[compared, 0].any():
        fitted.append("drive inertia")
    if fit.off >= _RIGHT_TORQUE_SHARE:
        fitted.append(f"masses (off by some {percent(fit.off)})")
    is_of_all = not any(fault.is_of_column for fault in diagnosis.faults)
    subject = "describes this robot" if is_of_all else f"fits {named_joints([i + 1 for i in compared], n)}"
    if is_of_all and word_of(diagnosis) == "agrees in part":
        subject += " in part"
    text = f"The file {subject}: with {enumerated(fitted)} fitted, {_left(diagnosis, compared)}."
    if diagnosis.needing_a_fit:
        joints = named_joints(diagnosis.needing_a_fit, n)
        text += f" As it is, up to {percent(float(np.nanmax(diagnosis.as_filed.share)))} is left at {joints}."
    not_compared = [i + 1 for i in range(n) if i not in compared]
    if not_compared:
        never = ", whose position never changes," if {*not_compared} <= {*diagnosis.unmoved} else ""
        text += f" Of {named_joints(not_compared, n)}{never} the log says nothing."
    best = diagnosis.ranking[0] if diagnosis.ranking else None
    if fit.off > MUCH_TORQUE_SHARE and best is not None and best.fall > _POSSIBLE_FALL:
        text += f" That is far off, so look whether {_begun(best.what)} ({best.remedy})."
    return text


def _of_offsets(diagnosis: Diagnosis) -> str:
    """Constant torques beside the file's, and what they may come of."""
    arm = diagnosis.arm
    constants = [
        f"{amount(torque, arm.joints[joint - 1].effort_unit)} at {named_joints([joint], arm.n_joints)}"
        for joint, torque in diagnosis.offsets.items()
    ]
    verb = "is" if len(constants) == 1 else "are"
    reasons = "a load, a spring, a bias of the sensor or gravity along a slide"
    return f"A constant {enumerated(constants)} {verb} not the file's: {reasons}."


def _poor(diagnosis: Diagnosis) -> list[int]:
    """Joints, from 0, of which more remains than a file's usual error leaves."""
    return [i for i in diagnosis.problem.moving if diagnosis.after.residuals[i] > MOST_RESIDUAL_SHARE]


def _left(diagnosis: Diagnosis, joints: Sequence[int]) -> str:
    """How much of the torque of some joints, from 0, is left."""
    return f"{percent(float(diagnosis.after.residuals[joints].max()))} of the torque or less is left"


def _of_causes(diagnosis: Diagnosis) -> str:
    """What remains with the causes mended, and how they are."""
    after, before = (_share_of_torque(fit.remains) for fit in (diagnosis.after, diagnosis.before))
    left = f"With this corrected, {after} of the torque (RMS) is left instead of {before}."
    text = f"{left} {diagnosis.remedy.advice}"
    if diagnosis.made_worse:
        joints = named_joints(diagnosis.made_worse, diagnosis.arm.n_joints)
        text = f"{left} But of the file as it is, more is then left at {joints}: fit the links instead."
    unsure = [cause.unsure for cause in diagnosis.causes if cause.unsure]
    return text + "".join(f" Another cause would fit equally well: {other}." for other in unsure)


def _of_rival(diagnosis: Diagnosis, rival: Candidate) -> str:
    is_one = is_same(rival, diagnosis.causes[0])
    degree = "The same in this log" if is_one else "Nearly as good"
    return f"{degree}: {_begun(rival.what)} ({rival.remedy})."


def _left_of_poor(diagnosis: Diagnosis, poor: Sequence[int]) -> str:
    """How much of the torque of some joints, from 0, is left, and with what it varies."""
    shares = enumerated([_share_of_torque(float(diagnosis.after.residuals[i])) for i in poor])
    followed = _followed(diagnosis, poor)
    return f"{shares} is left; it {followed}" if followed else f"{shares} is left"


def _followed(diagnosis: Diagnosis, poor: Sequence[int]) -> str:
    """With what residuals of some joints, from 0, vary: "drifts with time at joint 3"; "" with nothing."""
    follows = what_remains_follows(diagnosis.corrected)
    joints_by_quantity: dict[str, list[int]] = {}
    for i in poor:
        joints_by_quantity.setdefault(follows[i], []).append(i + 1)
    is_alike = len(joints_by_quantity) == 1
    return " and ".join(
        f"{_VARIES[quantity]}{'' if is_alike else f' at {named_joints(joints, diagnosis.arm.n_joints)}'}"
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
    return f"{_what_is_faulty(faults, n)} {_remedy_of(faults)}"


def _what_is_faulty(faults: Sequence[Fault], n: int) -> str:
    """The first of some faults, and the joints of the others."""
    first = faults[0]
    joints = sorted({fault.joint + 1 for fault in faults[1:]} - {first.joint + 1})
    further = f"; {named_joints(joints, n)}, too" if joints else ""
    return f"{first.what}, {first.effect}{further}."


def _remedy_of(faults: Sequence[Fault]) -> str:
    remedy = in_options(faults[0].remedy)
    return f"{remedy[0].upper()}{remedy[1:]}."


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
