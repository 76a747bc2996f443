"""What a study of control means: whether the simplified model is good enough, what dropping h costs."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.studies.controllers import Controller
from gd_analyze.studies.settings import CONTINUOUS
from gd_analyze.studies.study import ControlStudy, TrackedLoop
from gd_analyze.text import named_joints, number, percent, rounded_up

EXACT, SIMPLIFIED, FIXED_GAINS, WITHOUT_H = (
    Controller("computed_torque", "exact"),
    Controller("computed_torque", "simplified"),
    Controller("fixed_gains", "simplified"),
    Controller("computed_torque", "without_h"),
)
# Below this share of another controller's error a difference is not worth a sentence.
_ALIKE = 1.1
# Certified errors below this, rad (m), are below what integrating leaves.
_NOTHING = 1e-8
# Expected errors beyond this, rad (m), are of a D that is nearly singular.
_FARTHEST = 1.0


class Worst(NamedTuple):
    """The error that is the largest share of its joint's tolerance, and that joint, from 1."""

    told: str
    joint: int


def error_scale(study: ControlStudy, joint: int) -> tuple[float, str]:
    """Factor and unit in which a joint's tracking error, from 0, is told."""
    return 1e3, "mrad" if study.arm.is_revolute[joint] else "mm"


def worst_of(study: ControlStudy, errors: FloatArray, *, bound: bool = False) -> Worst:
    """Tell the worst of the joints' errors, rad (m), shape (n,)."""
    joint = int((errors / study.tolerance).argmax())
    scale, unit = error_scale(study, joint)
    value = scale * float(errors[joint])
    return Worst(f"{number(rounded_up(value) if bound else value)} {unit}", joint + 1)


def rate_told(rate: float) -> str:
    """Say how often a controller is asked."""
    return "in continuous time" if rate == CONTINUOUS else f"at {rate:g} Hz"


def sentences(study: ControlStudy) -> list[str]:
    """Say what was found; the first sentence answers the question."""
    return [
        text
        for text in (
            _answer(study),
            _feedback(study),
            _fixed(study),
            _without_h(study),
            _bound(study),
            _saturation(study),
            _beyond(study),
        )
        if text
    ]


def _usual(study: ControlStudy, controller: Controller) -> TrackedLoop:
    return study.loop(controller, study.usual_rate, study.usual_speed)


def _within(study: ControlStudy, controller: Controller, speed: float) -> bool:
    return study.loop(controller, study.usual_rate, speed).within(study.tolerance)


def _off(study: ControlStudy, loop: TrackedLoop) -> str:
    """Say by how much a loop is off, as in "it is off by 0.2 mrad at most (joint 2)"."""
    if loop.lost_at is not None:
        return f"lost: more than a turn from the motion after {number(loop.lost_at)} s"
    worst = worst_of(study, loop.peak_error)
    return f"off by {worst.told} at most (joint {worst.joint})"


def good_enough(study: ControlStudy) -> Literal["computed torque", "fixed gains", ""]:
    """Law by which the simplified model keeps every joint within the tolerance; "" where there is none."""
    if study.feedback.is_enough and _usual(study, SIMPLIFIED).within(study.tolerance):
        return "computed torque"
    return "fixed gains" if _usual(study, FIXED_GAINS).within(study.tolerance) else ""


def judged(study: ControlStudy) -> Controller:
    """Give the law by which the simplified model is judged: one that is good enough, or the better."""
    law = good_enough(study)
    if law:
        return SIMPLIFIED if law == "computed torque" else FIXED_GAINS
    laws = (SIMPLIFIED, FIXED_GAINS)
    return min(laws, key=lambda one: float((_usual(study, one).peak_error / study.tolerance).max()))


def _answer(study: ControlStudy) -> str:
    exact, law = _usual(study, EXACT), good_enough(study)
    simplified = _usual(study, judged(study))
    within = study.settings.tolerance.in_words(study.arm)
    speed = "" if study.usual_speed == 1.0 else f" run at {study.usual_speed:g} times its speed"
    where = f"{rate_told(study.usual_rate)}, along {study.motion.name}{speed},"
    compared = f"it is {_off(study, simplified)}, with the exact model {_off(study, exact)}"
    if not exact.within(study.tolerance):
        return (
            f"Not even the exact model keeps every joint within {within} of the motion: {where} it is "
            f"{_off(study, exact)}, with the simplified model {_off(study, simplified)}."
        )
    if law:
        how = ", with fixed gains beside its torque" if law == "fixed gains" else ""
        return (
            f"The simplified model is good enough to control this arm{how}: {where} every joint stays within "
            f"{within}; {compared}."
        )
    how = ", nor with fixed gains" * (judged(study) == FIXED_GAINS)
    return f"The simplified model is not good enough to stay within {within}{how}: {where} {compared}."


def _feedback(study: ControlStudy) -> str:
    """Say what of the feedback is missing where it is multiplied by the model's D, and what helps."""
    if study.feedback.is_enough:
        return ""
    share = study.feedback.share
    left = f"{percent(share)} of the feedback is" if share > 0.0 else "no feedback is"
    return (
        "Computed torque multiplies feedback by the model's D, which lacks inertia of "
        f"{named_joints(study.feedback.joints, study.arm.n_joints)}: in some direction {left} left along the "
        f"motion. So it is {_off(study, _usual(study, SIMPLIFIED))}, and with fixed gains "
        f"{_off(study, _usual(study, FIXED_GAINS))}."
    )


def _fixed(study: ControlStudy) -> str:
    """Say where fixed gains cannot be stable."""
    rates = study.too_slow_for_fixed_gains
    if not rates:
        return ""
    return (
        f"Fixed gains are up to {number(study.fixed_excess)} times what they should be, in a direction in "
        "which the arm has little inertia; no controller that has them is stable there at "
        f"{' or '.join(f'{rate:g}' for rate in rates)} Hz."
    )


def _without_h(study: ControlStudy) -> str:
    loop, exact = _usual(study, WITHOUT_H), _usual(study, EXACT)
    told = f"Without h, as for a slow arm, it is {_off(study, loop)}"
    worst = int((loop.peak_error / study.tolerance).argmax())
    if loop.lost_at is None and exact.peak_error[worst]:
        times = float(loop.peak_error[worst] / exact.peak_error[worst])
        told += f", {number(times)} times the exact model's" if times > _ALIKE else ", as the exact model is"
    within, most = study.settings.tolerance.in_words(study.arm), max(study.settings.speeds)
    leaves, exact_leaves = (study.tracks_up_to(c, study.usual_rate) for c in (WITHOUT_H, EXACT))
    if leaves is None:
        return f"{told}, and leaves {within} at every speed tried."
    if leaves == math.inf:
        return f"{told}; it stays within {within} up to {most:g} times the planned speed."
    told = f"{told}. Dropping h hurts beyond {number(leaves)} times the planned speed, where {within} is left"
    if exact_leaves is not None and exact_leaves <= _ALIKE * leaves:
        return f"{told}; the exact model leaves it there as well."
    one = judged(study)
    name = "the simplified model" + " with fixed gains" * (one == FIXED_GAINS)
    left = [f"{speed:g}" for speed in study.settings.speeds if not _within(study, one, speed)]
    if not left:
        return f"{told}; {name} stays within it up to {most:g} times."
    return f"{told}; {name} leaves it at {' and '.join(left)} times."


def _bound(study: ControlStudy) -> str:
    found = study.certified.get(study.usual_speed)
    simulated = study.loop(judged(study), max(study.settings.rates), study.usual_speed)
    beside = f"{_off(study, simulated)} {rate_told(simulated.rate)}"
    found = found if simulated.controller == SIMPLIFIED else None
    if simulated.controller == FIXED_GAINS and simulated.rate in study.too_slow_for_fixed_gains:
        return ""  # what is expected is of a stable loop
    if found is None and not (simulated.expected < _FARTHEST).all():
        return (
            "The model's D is singular on the motion, or nearly so: nothing bounds the error of computed "
            "torque with it."
        )
    if found is None:
        worst = worst_of(study, simulated.expected)
        return (
            f"What the model leaves out along the motion accounts for {worst.told} at most (joint "
            f"{worst.joint}), to first order; simulated it is {beside}."
        )
    worst = worst_of(study, found.error, bound=True)
    if (found.error < _NOTHING).all():
        return f"Certified: the model's torque error causes a tracking error of no more than {worst.told}."
    return (
        f"Certified: the model's torque error causes a tracking error of no more than {worst.told} (joint "
        f"{worst.joint}) at these gains, where torque is neither held nor limited; simulated it is {beside}."
    )


def _saturation(study: ControlStudy) -> str:
    shares = {
        speed: max(
            float(loop.saturated.max())
            for loop in study.loops
            if loop.speed == speed and loop.lost_at is None and loop.controller in (EXACT, SIMPLIFIED)
        )
        for speed in study.settings.speeds
        if any(loop.speed == speed and loop.lost_at is None for loop in study.loops)
    }
    told = [
        f"{percent(share)} of the time at {speed:g} times the speed"
        for speed, share in shares.items()
        if share
    ]
    return f"Torque is at its limit for up to {', '.join(told)}." if told else ""


def _beyond(study: ControlStudy) -> str:
    fastest = study.fastest_within_limits
    beyond = [f"{speed:g}" for speed in study.settings.speeds if speed > fastest * (1 + 1e-9)]
    if not beyond:
        return ""
    return (
        f"The arm's limits of rate and acceleration allow {number(np.floor(1e3 * fastest) / 1e3)} times the "
        f"planned speed; {' and '.join(beyond)} {'is' if len(beyond) == 1 else 'are'} beyond them."
    )
