"""Everything that is proven of one model over a box or along a motion, and its result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification import certificate as bounds
from gd_analyze.certification import positive_definite
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify, largest_torque
from gd_analyze.certification.positive_definite import Definiteness, certify_positive_definite
from gd_analyze.certification.tube import Margin, Tube
from gd_analyze.harmonics.transform import harmonics_of
from gd_analyze.motions.states import in_words
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import Column, Fact, Result, Table, joint_columns
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import rounded_up, share_up

_STATE = ("q", "qd", "qdd")
_LIMITS = ("lower", "upper", "velocity", "acceleration")


@dataclass(frozen=True, eq=False)
class Proof:
    """Bounds on the errors of a model."""

    model: SimplifiedModel
    effort: int  # effort of the certificate
    certificate: Certificate  # bounds over the arm's limits, or along the motion
    # With a motion: bounds over all combinations of values between its extremes, without margins
    extremes: Certificate | None
    definiteness: Definiteness | None  # smallest eigenvalue of D; None if the model's D need not be symmetric
    largest: FloatArray  # largest exact torque found in the region, N m (N), shape (n,)
    elsewhere: bool  # whether the motion is another one than the model was fitted on

    def result(self) -> Result:
        """The bounds per joint, whether they prove the budget, and whether D is positive definite."""
        model, certificate, accuracy = self.model, self.certificate, self.model.accuracy
        arm, box = model.arm, (self.extremes or certificate).box
        peak = accuracy.errors.peak_torque
        shares = share_of(certificate.certified, peak) if accuracy.measured else None
        worst = int(np.nanargmax(certificate.certified if shares is None else shares))
        if shares is None or not np.isfinite(shares[worst]):
            bound = f"{rounded_up(float(certificate.certified[worst])):.3g} {arm.joints[worst].effort_unit}"
        else:
            bound = f"{100 * share_up(float(shares[worst])):.3g} % of peak torque"
        region = "the motion's margins" if certificate.along is not None else "the arm's limits"
        notices = [certificate.note]
        if not accuracy.measured:
            states = in_words(accuracy.fitted_on) if accuracy.fitted_on else "unnamed states"
            notices.append(f"Allowed and sampled errors are stated by the file, not measured, for {states}.")
        if accuracy.asked.norm is not None:
            notices.append("A budget of the norm holds for a share of states and cannot be proven for all.")
        return Result(
            title=f"{arm.title or arm.name}: proven torque error of the model of level {model.level}",
            subtitle=f"within {certificate.where}",
            headline=f"Torque error at most {bound} (joint {worst + 1}) within {region}",
            facts=(
                Fact("arm", "", arm.name),
                Fact("level", "", model.level.name),
                Fact("budget", "Budget", accuracy.budget),
                Fact(
                    "allowed_and_largest_error",
                    "",
                    "measured" if accuracy.measured else "stated by the file",
                ),
                Fact("from", "", certificate.region.where),
                Fact("box", "", {name: getattr(box, name) for name in _LIMITS}),
                Fact("tube", "", self._tube()),
                Fact("positive_definite", "", self._definite()),
                Fact("effort", "", self.effort),
                *self._verdicts(),
            ),
            parts=(self._joints(),),
            notices=tuple(filter(None, notices)),
        )

    def _verdicts(self) -> list[Fact]:
        facts, accuracy, definite = [], self.model.accuracy, self.definiteness
        if accuracy.asked.norm is None:
            within = self.certificate.within(accuracy.allowed)
            proven = f"{within.sum()} of {len(within)}"
            facts.append(Fact("", "Joints proven within the budget", proven))
        if definite is not None:
            unit = "kg m^2" if all(self.model.arm.is_revolute) else ""
            place = "at q = " + ", ".join(f"{q:.4g}" for q in definite.position)
            facts += [
                Fact("", "Inertia matrix D", _definiteness(definite)),
                Fact("", "Smallest eigenvalue of D, proven", -rounded_up(-definite.proven, 4), unit),
                Fact("", "Smallest eigenvalue of D, found", definite.smallest_found, unit, note=place),
            ]
        return facts

    def _joints(self) -> Table:
        arm, certificate, accuracy = self.model.arm, self.certificate, self.model.accuracy
        units = [joint.effort_unit for joint in arm.joints]
        none = [None] * arm.n_joints
        is_norm = accuracy.asked.norm is not None
        allowed = none if is_norm else accuracy.allowed
        states = zip(*certificate.worst_states, strict=True)
        extremes = self.extremes
        columns = [
            Column(
                "largest_error", "stated" if self.elsewhere else "sampled", accuracy.errors.largest, units
            ),
            Column("worst_found", "" if extremes else "found", certificate.worst_found, units),
            Column("certified", "proven", certificate.certified, units, "bound"),
            Column("allowed_error", "" if is_norm else "allowed", allowed, units),
            Column(
                "certified_of_allowed",
                "" if is_norm else "of allowed",
                none if is_norm else share_of(certificate.certified, accuracy.allowed),
                shown="bound_percent",
            ),
            Column("within_allowed", "", none if is_norm else certificate.within(accuracy.allowed)),
            Column(
                "worst_state", "", [dict(zip(("q", "qd", "qdd"), state, strict=True)) for state in states]
            ),
            Column("largest_torque_found", "", self.largest),
            Column("certified_share_of_largest_found", "", share_of(certificate.certified, self.largest)),
            Column(
                "certified_share_of_peak_made_for",
                "",
                share_of(certificate.certified, accuracy.errors.peak_torque),
            ),
            Column("ratio", "", certificate.ratio),
        ]
        note = "Sampled: at the states the model was fitted on. Proven: no state exceeds it."
        if extremes is not None:
            column = Column("certified_between_extremes", "extremes", extremes.certified, units, "bound")
            columns.insert(3, column)
            note += " Extremes: proven for all combinations of values between the motion's extremes."
        else:
            note += " Found: largest error of a search over the box."
        return Table("joints", "Torque error", (*joint_columns(arm.joints), *columns), note)

    def _tube(self) -> Mapping[str, Any] | None:
        tube, along = self.certificate.region, self.certificate.along
        if not isinstance(tube, Tube) or along is None:
            return None
        pieces = zip(tube.begin.tolist(), tube.end.tolist(), along.tolist(), strict=True)
        return {
            "margins": dict(zip(_STATE, tube.margins, strict=True)),
            "coarse": tube.coarse,
            "note": tube.note,
            "pieces": [dict(zip(("begin", "end", "certified"), piece, strict=True)) for piece in pieces],
        }

    def _definite(self) -> Mapping[str, Any] | None:
        definite = self.definiteness
        if definite is None:
            return None
        return {
            "proven": definite.is_proven,
            "singular": definite.is_singular,
            "smallest_eigenvalue_at_least": definite.proven,
            "smallest_eigenvalue_found": definite.smallest_found,
            "position": definite.position,
        }


def _definiteness(definite: Definiteness) -> str:
    if definite.is_proven:
        return "positive definite everywhere in the box"
    if definite.is_singular:
        return "singular: some motion has no inertia, and the model cannot be simulated"
    if definite.smallest_found < 0.0:
        return "not positive definite"
    return "not proven positive definite; a larger --effort may prove it"


def prove(
    model: SimplifiedModel,
    motion: Trajectory | None = None,
    *,
    margin: Margin | str | None = None,
    effort: int = bounds.EFFORT,
    progress: Callable[[int], None] | None = None,
) -> Proof:
    """Bound a model's errors over the arm's limits, or along a motion and between its extremes.

    Parameters
    ----------
    model
        A model of any level; for one of level energy the smallest eigenvalue of D is bounded as well.
    motion, margin
        A motion, and how far states may be from it.
    effort, progress
        As for `certify`, which is called twice with a motion.
    """
    harmonics = harmonics_of(model.arm)
    region = Box.of(model.arm) if motion is None else Tube.along(model.arm, motion, margin)
    certificate = certify(model, region, effort=effort, harmonics=harmonics, progress=progress)
    extremes = definiteness = None
    if motion is not None:
        between = Box.around(motion.q, motion.qd, motion.qdd)
        extremes = certify(model, between, effort=effort, harmonics=harmonics, progress=progress)
    if model.level.is_mechanical:
        positions = max(1, effort * positive_definite.EFFORT // bounds.EFFORT)
        definiteness = certify_positive_definite(model, certificate.box, effort=positions)
    return Proof(
        model,
        effort,
        certificate,
        extremes,
        definiteness,
        largest_torque(model, region, harmonics=harmonics),
        motion is not None and motion.name != model.accuracy.fitted_on.get("trajectory"),
    )
