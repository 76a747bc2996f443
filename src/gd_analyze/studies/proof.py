"""Proven bounds of one model over a box or along a motion, as a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification import certificate as bounds
from gd_analyze.certification import positive_definite
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify, largest_torque
from gd_analyze.certification.held import stated_region
from gd_analyze.certification.positive_definite import Definiteness, certify_positive_definite
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.harmonics.transform import harmonics_of
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.states import in_words
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.result import (
    AnyFact,
    Fact,
    Result,
    Shown,
    Table,
    Value,
    joint_values,
    value_text,
)
from gd_analyze.schema import declared_table
from gd_analyze.simplification.accuracy import STATED, share_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import LARGEST, rounded_up, share_up

_STATE = ("q", "qd", "qdd")
# What people see of the errors by joint.
_ERRORS = [
    "joint", "largest_error", "worst_found", "certified", "certified_between_extremes", "allowed_error",
    "certified_of_allowed",
]  # fmt: skip


def proof(
    model: SimplifiedModel,
    motion: Trajectory | None = None,
    *,
    margin: Margin | str | None = None,
    effort: int = bounds.POSITIONS_PER_JOINT,
    progress: Progress = NO_PROGRESS,
) -> Result:
    """Bound a model's errors over the arm's limits, or along a motion and between its extremes.

    For a model with a symmetric D its smallest eigenvalue is bounded as well.
    """
    progress.stage("certifying")
    harmonics = harmonics_of(model.arm)
    region = Box.of(model.arm) if motion is None else Tube.along(model.arm, motion, margin)
    certificate = certify(model, region, effort=effort, harmonics=harmonics, progress=progress)
    extremes = definiteness = None
    if motion is not None:
        between = Box.around(motion.q, motion.qd, motion.qdd)
        extremes = certify(model, between, effort=effort, harmonics=harmonics, progress=progress)
    if model.has_terms:
        positions = max(1, effort * positive_definite.INERTIA_POSITIONS // bounds.POSITIONS_PER_JOINT)
        definiteness = certify_positive_definite(model, region, effort=positions)
    largest = largest_torque(model, region, harmonics=harmonics)
    accuracy = model.accuracy
    elsewhere = motion is not None and motion.name != accuracy.fitted_on.get("trajectory")
    arm, certified = model.arm, certificate.certified
    shares = share_of(certified, accuracy.errors.peak_torque) if accuracy.measured else certified
    worst = int(np.nanargmax(shares))
    if accuracy.measured and np.isfinite(shares[worst]):
        bound = f"{100 * share_up(float(shares[worst])):.3g} % of peak torque"
    else:
        bound = f"{rounded_up(float(certified[worst])):.3g} {arm.joints[worst].effort_unit}"
    notices = [certificate.note]
    if not accuracy.measured:
        states = in_words(accuracy.fitted_on) if accuracy.fitted_on else "unnamed states"
        notices.append(f"Allowed and sampled errors are {STATED} for {states}, not measured.")
    within = "the arm's limits" if motion is None else "the motion's margins"
    return Result(
        title=f"{arm.title or arm.name}: proven torque error of the model of level {model.level}",
        subtitle=f"within {certificate.where}",
        headline=f"Torque error at most {bound} (joint {worst + 1}) within {within}",
        facts=(
            Value("arm", arm.name),
            Value("level", model.level.name),
            Fact("budget", "Budget", accuracy.budget, text=accuracy.asked.words),
            Value("allowed_and_largest_error", "measured" if accuracy.measured else STATED),
            Value("from", region.where),
            Value("box", _limits(certificate) if motion is None else None),
            Value("extremes", None if extremes is None else _limits(extremes)),
            Value("tube", _tube(certificate)),
            *_definite(model, certificate, definiteness),
            Value("effort", effort),
        ),
        parts=(_joints(model, certificate, extremes, largest, "stated" if elsewhere else "sampled"),),
        notices=tuple(filter(None, notices)),
    )


def _limits(certificate: Certificate) -> dict[str, FloatArray]:
    """Limits of a box in which a bound is proven."""
    return {name: getattr(certificate.box, name) for name in ("lower", "upper", "velocity", "acceleration")}


def proven_again(
    model: SimplifiedModel, along: Trajectory | None = None, *, progress: Progress = NO_PROGRESS
) -> tuple[Result, bool]:
    """Prove a model's certificate again, along the motion it names; also return whether every bound holds.

    Raises a UsageError if it states none, or the motion is missing or a different one.
    """
    stated, joints = model.accuracy.certificate, model.arm.joints
    if stated is None:
        next_step = "make one with `gd-analyze simplify --certified`, or bound its errors without it"
        raise UsageError("the model states no certificate", where="check", next_step=next_step)
    region = stated_region(model, [along] if along else [])
    is_other = isinstance(region, Tube) and along is not None and along.fingerprint != region.fingerprint
    if region is None or is_other:
        raise UsageError(
            "the certificate is for another motion",
            where="along",
            expected=f"the certificate's motion: {stated.where}",
            found="none" if along is None else along.name,
            next_step="name its file with `along`, or those of several motions in their order",
        )
    limit = np.minimum(stated.certified, LARGEST)
    certificate = certify(model, region, effort=stated.effort, limit=limit, progress=progress)
    # The same sums, up to the rounding of another machine.
    holds = certificate.certified <= stated.certified * (1.0 + 1e-9)
    verdict = "holds" if holds.all() else f"does not hold at joint {1 + int(np.argmin(holds))}"
    values = joint_values(joints) | {
        "stated": stated.certified,
        "certified": certificate.certified,
        "worst_found": certificate.worst_found,
        "holds": holds,
    }
    names = ["joint", "stated", "certified", "worst_found", "holds"]
    facts = (
        Value("arm", model.arm.name),
        Value("holds", bool(holds.all())),
        Value("effort", stated.effort),
    )
    title = f"{model.arm.title or model.arm.name}: the model's certificate, proven again"
    subtitle = f"within {stated.where}"
    parts = (declared_table("proof", "joints", "Torque error", values, names),)
    result = Result(
        title=title, subtitle=subtitle, headline=f"The certificate {verdict}", facts=facts, parts=parts
    )
    return result, bool(holds.all())


def _joints(
    model: SimplifiedModel,
    certificate: Certificate,
    extremes: Certificate | None,
    largest: FloatArray,
    sampled: str,
) -> Table:
    """Errors sampled, found and proven by joint; the largest torques found are in N m (N), shape (n,)."""
    accuracy, certified = model.accuracy, certificate.certified
    states = [dict(zip(_STATE, state, strict=True)) for state in zip(*certificate.worst_states, strict=True)]
    values = joint_values(model.arm.joints) | {
        "largest_error": accuracy.errors.largest,
        "worst_found": certificate.worst_found,
        "certified": certified,
        "allowed_error": accuracy.allowed,
        "certified_of_allowed": share_of(certified, accuracy.allowed),
        "within_allowed": certificate.within(accuracy.allowed),
        "worst_state": states,
        "largest_torque_found": largest,
        "certified_share_of_largest_found": share_of(certified, largest),
        "certified_share_of_peak_made_for": share_of(certified, accuracy.errors.peak_torque),
        "ratio": certificate.ratio,
    }
    seen: dict[str, Any] = {"certified_between_extremes": None}
    note = "Found: largest error of a search over the box."
    if extremes is not None:
        values["certified_between_extremes"] = extremes.certified
        seen = {"worst_found": None}
        note = "Extremes: proven for all combinations of values between the motion's extremes."
    return declared_table(
        "proof",
        "joints",
        "Torque error",
        values,
        _ERRORS,
        note=f"Sampled: at the states the model was fitted on. Proven: no state exceeds it. {note}",
        seen=seen,
        words={"largest_error": sampled},
    )


def _tube(certificate: Certificate) -> Mapping[str, Any] | None:
    tube, along = certificate.region, certificate.along
    if not isinstance(tube, Tube) or along is None:
        return None
    pieces = zip(tube.begin.tolist(), tube.end.tolist(), along.tolist(), strict=True)
    return {
        "margins": dict(zip(_STATE, tube.margins, strict=True)),
        "coarse": tube.coarse,
        "note": tube.note,
        "pieces": [dict(zip(("begin", "end", "certified"), piece, strict=True)) for piece in pieces],
    }


def _definite(
    model: SimplifiedModel, certificate: Certificate, definite: Definiteness | None
) -> list[AnyFact]:
    """The verdicts: joints within the budget, and D."""
    within = certificate.within(model.accuracy.allowed)
    facts: list[AnyFact] = [
        Value("positive_definite", None),
        Shown("Joints proven within the budget", f"{within.sum()} of {len(within)}"),
    ]
    if definite is None:
        return facts
    values = {
        "proven": definite.is_proven,
        "singular": definite.is_singular,
        "smallest_eigenvalue_at_least": definite.proven,
        "smallest_eigenvalue_found": definite.smallest_found,
        "position": definite.position,
    }
    facts[0] = Value("positive_definite", values)
    if definite.is_proven:
        verdict = "positive definite at all these positions"
    elif definite.is_singular:
        verdict = "singular: some motion has no inertia, so the model cannot be simulated"
    elif definite.smallest_found < 0.0:
        verdict = "not positive definite"
    else:
        verdict = "not proven positive definite; a larger --effort may prove it"
    unit = "kg m^2" if all(model.arm.is_revolute) else ""
    place = "at q = " + ", ".join(f"{q:.4g}" for q in definite.position)
    return [
        *facts,
        Shown("Mass matrix D", verdict),
        Shown("Smallest eigenvalue of D, proven", value_text(-rounded_up(-definite.proven, 4), unit)),
        Shown("Smallest eigenvalue of D, found", value_text(definite.smallest_found, unit), place),
    ]
