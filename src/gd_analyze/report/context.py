"""The numbers of a report as plain values, before anything is drawn or typeset.

HTML, PDF and the terminal show the same context, so they cannot disagree.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from gd_analyze.dominance import text_verdicts
from gd_analyze.elements import elements
from gd_analyze.round_off import ROUND_OFF_SHARE
from gd_analyze.findings import Findings
from gd_analyze.formulations.generalized_dalembert import EFFECTS
from gd_analyze.levels import Loss, SimplifiedModel, losses
from gd_analyze.levels.parts import parts_of
from gd_analyze.operations import OperationCount
from gd_analyze.formatting import inertia_unit
from gd_analyze.robots import RobotArm, fingerprint
from gd_analyze.search import curves
from gd_analyze.search.ranking import RankedTerm

# Rows of the ranking of single terms that a report shows.
TERMS_SHOWN = 40


@dataclass(frozen=True)
class JointError:
    """Torque error of one joint; torques in `unit`, shares of peak torque."""

    joint: str
    name: str
    unit: str
    peak_torque: float
    allowed: float
    largest: float
    largest_share: float
    rms: float
    rms_share: float


@dataclass(frozen=True)
class DominanceRow:
    """One element in the ranking; `text_verdict` is "" where the text says nothing."""

    rank: int
    element: str
    peak: float
    unit: str
    translation_peak: float
    rotation_peak: float
    without_translation: float
    without_rotation: float
    torque_peak: float
    torque_joint: int
    torque_share: float
    dominant: str
    verdict: str
    kept: str
    text_verdict: str


@dataclass(frozen=True)
class BeyondRow:
    """One joint away from the set points, torques in its unit; None where nothing can be said.

    Parameters
    ----------
    certified, certified_share
        No state between the extremes of the trajectory has a larger error; and that over peak torque.
    worst_found
        Largest error a search found among those states.
    within_limits, within_limits_share
        Largest error over states drawn from the arm's limits; and that over the peak torque there.
    torque_per_kg
        Largest torque along the trajectory of a kilogram in the hand.
    mass_within_budget
        Largest point mass in the hand, kg, that keeps the joint within its budget along the trajectory.
    uncertainty
        Largest standard uncertainty of the torque that follows from the parameters' stated ones.
    """

    joint: str
    name: str
    unit: str
    certified: float | None
    certified_share: float | None
    worst_found: float | None
    within_limits: float | None
    within_limits_share: float | None
    torque_per_kg: float
    mass_within_budget: float
    uncertainty: float | None


@dataclass(frozen=True)
class TradeOffRow:
    """One budget of the trade-off: operations by kind, in the order of `Context.trade_off_kinds`."""

    budget: str
    is_asked: bool
    operations: tuple[int, ...]
    error_shares: tuple[float, ...]


@dataclass(frozen=True)
class Context:
    """All numbers a report shows.

    Parameters
    ----------
    title, subtitle
        Arm and trajectory.
    headline
        The answer: what can go and what it costs, in one sentence.
    facts
        Headline figures as (value, caption).
    budget
        As the user put it.
    level, refitted, kept_terms
        Level of the model, whether kept coefficients were refitted, and how much it keeps, in words.
    search
        Operations after each step of the search, in words.
    operations, operations_full
        Multiplications, additions, sines and cosines of the model and of the full dynamics.
    joint_errors, dominance, dropped
        Tables; `dropped` by the text's own method, with the largest torque first.
    terms, terms_total, terms_not_worth_keeping
        The terms that matter most, of how many, and how many together stay below the parameters' stated
        uncertainty (None where none is stated).
    trade_off, trade_off_kinds
        Operations against error; kinds are level and whether refitted.
    beyond, drawn
        What the model does away from the set points; number of states drawn from the arm's limits.
    element_operations, element_operations_full
        The same for the model by the text's own method.
    inertia_kept, coriolis_kept, gravity_kept
        What the model by the text's own method keeps: "translation", "rotation", "both" or "neither" per
        element; D as n rows.
    text_source
        Source of the text's verdicts, "" where the text does not show this arm.
    text_agreement
        Number of the text's verdicts that ours match, and of all it gives.
    verdict_counts
        How many elements of D and h are of each verdict.
    residuals
        (quantity, largest difference from Pinocchio, round-off bound, unit).
    provenance
        (label, value), flat.
    warnings
        Sentences.
    """

    title: str
    subtitle: str
    headline: str
    facts: tuple[tuple[str, str], ...]
    budget: str
    level: str
    refitted: bool
    kept_terms: str
    search: str
    operations: tuple[int, int, int]
    operations_full: tuple[int, int, int]
    joint_errors: tuple[JointError, ...]
    dominance: tuple[DominanceRow, ...]
    dropped: tuple[Loss, ...]
    terms: tuple[RankedTerm, ...]
    terms_total: int
    terms_not_worth_keeping: int | None
    trade_off: tuple[TradeOffRow, ...]
    trade_off_kinds: tuple[tuple[str, bool], ...]
    beyond: tuple[BeyondRow, ...]
    drawn: int
    element_operations: tuple[int, int, int]
    element_operations_full: tuple[int, int, int]
    inertia_kept: tuple[tuple[str, ...], ...]
    coriolis_kept: tuple[str, ...]
    gravity_kept: tuple[str, ...]
    text_source: str
    text_agreement: tuple[int, int]
    verdict_counts: dict[str, int]
    residuals: tuple[tuple[str, float, float, str], ...]
    provenance: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]


def build_context(findings: Findings) -> Context:
    """Collect the numbers of one run."""
    model, arm = findings.model, findings.arm
    promise = model.promise.errors
    joint_errors = tuple(
        JointError(
            joint=str(i + 1),
            name=joint.name,
            unit=joint.effort_unit,
            peak_torque=float(promise.peak_torque[i]),
            allowed=float(model.promise.allowed[i]),
            largest=float(promise.largest[i]),
            largest_share=float(promise.largest_share[i]),
            rms=float(promise.rms[i]),
            rms_share=float(promise.rms_share[i]),
        )
        for i, joint in enumerate(arm.joints)
    )
    elements_kept = findings.element_model
    kept = _kept(tuple(part.label for part in elements_kept.terms), arm.n_joints)
    rows = _dominance_rows(findings, kept)
    compared = [row for row in rows if row.text_verdict]
    reference = text_verdicts(arm.name)
    worst = max(joint_errors, key=lambda row: row.largest_share)
    n_parts = len(parts_of(arm.n_joints))
    saved = 1 - model.operations.total / model.operations_full.total
    n = arm.n_joints
    dropped = losses(elements_kept, findings.decomposition)
    kept_terms = _kept_terms(model)
    return Context(
        title=arm.title or arm.name,
        subtitle=f"along {findings.trajectory.name}, {findings.trajectory.n_set_points} set points",
        headline=(
            _headline(dropped, n_parts, saved, worst)
            if not model.level.has_torque_terms
            else _harmonic_headline(model, kept_terms, worst)
        ),
        facts=(
            (
                (f"{len(dropped)} / {n_parts}", f"parts dropped, {_zeros(dropped)} of them zero here")
                if not model.level.has_torque_terms
                else (kept_terms, f"kept of the exact model's {_all_terms(findings)}")
            ),
            (f"{model.operations_full.total} → {model.operations.total}", "operations per torque evaluation"),
            (percent(worst.largest_share), f"largest error, of peak torque (joint {worst.joint})"),
            (number(max(r.largest for r in findings.residuals)), "largest difference from Pinocchio, SI"),
        ),
        budget=model.promise.budget,
        level=model.level.name,
        refitted=model.refitted,
        kept_terms=kept_terms,
        search=model.promise.search,
        operations=_count(model.operations),
        operations_full=_count(model.operations_full),
        joint_errors=joint_errors,
        dominance=rows,
        dropped=dropped,
        terms=findings.terms.terms[:TERMS_SHOWN],
        terms_total=len(findings.terms.terms) + findings.terms.unlisted,
        terms_not_worth_keeping=(
            None if findings.terms.uncertainty is None else findings.terms.not_worth_keeping
        ),
        trade_off=_trade_off(findings),
        trade_off_kinds=tuple((level.name, refit) for level, refit in curves(findings.trade_off)),
        beyond=_beyond(findings),
        drawn=findings.beyond.drawn,
        element_operations=_count(elements_kept.operations),
        element_operations_full=_count(elements_kept.operations_full),
        inertia_kept=tuple(
            tuple(kept[_label("D", min(i, j), max(i, j))] for j in range(n)) for i in range(n)
        ),
        coriolis_kept=tuple(kept[f"h{i + 1}"] for i in range(n)),
        gravity_kept=tuple(kept[f"c{i + 1}"] for i in range(n)),
        text_source=reference.source if reference else "",
        text_agreement=(sum(row.dominant == row.text_verdict for row in compared), len(compared)),
        verdict_counts=dict(Counter(row.verdict for row in rows if not row.element.startswith("c"))),
        residuals=tuple((r.quantity, r.largest, r.bound, r.unit) for r in findings.residuals),
        provenance=_provenance(findings),
        warnings=findings.warnings,
    )


def _zeros(dropped: tuple[Loss, ...]) -> int:
    return sum(loss.torque_share <= ROUND_OFF_SHARE for loss in dropped)


def _headline(dropped: tuple[Loss, ...], n_parts: int, saved: float, worst: JointError) -> str:
    """Answer "what can I drop and what does it cost me" in one sentence."""
    zero = _zeros(dropped)
    more = len(dropped) - zero
    if not more:
        return (
            f"No part that acts can go within the budget; {zero} of {n_parts} parts are zero along this "
            "trajectory and leaving them out costs nothing."
        )
    rest = f"; {zero} more are zero here anyway" if zero else ""
    return (
        f"{more} of {n_parts} parts can go{rest}. That saves {percent(saved)} of the operations, and no "
        f"joint's torque is off by more than {percent(worst.largest_share).replace('< ', '')} of its peak "
        "along this trajectory."
    )


def _harmonic_headline(model: SimplifiedModel, kept_terms: str, worst: JointError) -> str:
    """Answer the same for a model of harmonic terms."""
    full, left = model.operations_full.total, model.operations.total
    drop = f"{kept_terms[0].upper()}{kept_terms[1:]} give every torque in {left} operations instead of {full}"
    return (
        f"{drop}, and no joint's torque is off by more than "
        f"{percent(worst.largest_share).replace('< ', '')} of its peak along this trajectory."
    )


def _kept_terms(model: SimplifiedModel) -> str:
    """How much a model keeps, in words."""
    return f"{len(model.terms)} {model.level.keeps}"


def _all_terms(findings: Findings) -> int:
    """Number of terms of the exact model at the level of the simplified one."""
    return len(findings.model.level.terms(findings.model.form))


def _trade_off(findings: Findings) -> tuple[TradeOffRow, ...]:
    """Rows by budget, as multiples of the one asked for."""
    return tuple(
        TradeOffRow(
            points[0].budget,
            points[0].factor == 1.0,
            tuple(point.operations.total for point in points),
            tuple(point.error_share for point in points),
        )
        for points in zip(*curves(findings.trade_off).values(), strict=True)
    )


def _beyond(findings: Findings) -> tuple[BeyondRow, ...]:
    beyond, peak = findings.beyond, findings.model.promise.errors.peak_torque
    certificate, drawn = beyond.certificate, beyond.within_limits
    uncertainty = findings.terms.uncertainty
    return tuple(
        BeyondRow(
            joint=str(i + 1),
            name=joint.name,
            unit=joint.effort_unit,
            certified=None if certificate is None else float(certificate.certified[i]),
            certified_share=(
                None if certificate is None or not peak[i] else float(certificate.certified[i] / peak[i])
            ),
            worst_found=None if certificate is None else float(certificate.worst_found[i]),
            within_limits=None if drawn is None else float(drawn.largest[i]),
            within_limits_share=None if drawn is None else float(drawn.largest_share[i]),
            torque_per_kg=float(beyond.payload.torque_per_kg[i]),
            mass_within_budget=float(beyond.payload.mass_within_budget[i]),
            uncertainty=None if uncertainty is None else uncertainty[i],
        )
        for i, joint in enumerate(findings.arm.joints)
    )


def number(value: float) -> str:
    """Format to three significant digits, for display only."""
    if value == 0.0:
        return "0"
    return f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e5 else f"{value:.3g}"


def percent(share: float) -> str:
    """Format a share as percent with two significant digits, for display only."""
    if not np.isfinite(share):
        return "∞"
    value = 100 * share
    if value == 0.0:
        return "0 %"
    return "< 0.01 %" if abs(value) < 0.01 else f"{value:.2g} %" if abs(value) < 9.95 else f"{value:.0f} %"


def _kept(labels: tuple[str, ...], n_joints: int) -> dict[str, str]:
    """What is kept of every element."""
    chosen: dict[str, list[str]] = {element.label: [] for element in elements(n_joints)}
    for part in parts_of(n_joints):
        if part.label in labels:
            chosen[part.element.label].append(part.effect)
    names = {(): "neither", EFFECTS[:1]: EFFECTS[0], EFFECTS[1:]: EFFECTS[1], EFFECTS: "both"}
    return {label: names[tuple(effects)] for label, effects in chosen.items()}


def _unit(arm: RobotArm, i: int, j: int) -> str:
    """Unit of D_ij, or of h_i and c_i where j is -1."""
    return arm.joints[i].effort_unit if j < 0 else inertia_unit(arm, i, j)


def _label(symbol: str, i: int, j: int) -> str:
    return f"{symbol}{i + 1}{',' if max(i, j) >= 9 else ''}{j + 1}"


def _dominance_rows(findings: Findings, kept: dict[str, str]) -> tuple[DominanceRow, ...]:
    dominance = findings.dominance
    reference = text_verdicts(findings.arm.name)
    verdicts = reference.verdicts if reference else {}
    arm = findings.arm
    columns = {str(name): array.values for name, array in dominance.data_vars.items()}
    return tuple(
        DominanceRow(
            rank=k + 1,
            element=str(label),
            peak=float(columns["peak"][k]),
            unit=_unit(arm, int(columns["i"][k]) - 1, int(columns["j"][k]) - 1),
            translation_peak=float(columns["part_peak"][k, 0]),
            rotation_peak=float(columns["part_peak"][k, 1]),
            without_translation=float(columns["change_without"][k, 0]),
            without_rotation=float(columns["change_without"][k, 1]),
            torque_peak=float(columns["torque_peak"][k]),
            torque_joint=int(columns["torque_joint"][k]),
            torque_share=float(columns["torque_share"][k]),
            dominant=str(columns["dominant"][k]),
            verdict=str(columns["verdict"][k]),
            kept=kept[str(label)],
            text_verdict=verdicts.get(str(label), ""),
        )
        for k, label in enumerate(dominance.element.values)
    )


def _provenance(findings: Findings) -> tuple[tuple[str, str], ...]:
    trajectory = findings.trajectory
    return (
        ("arm", f"{findings.arm.name}, SHA-256 {fingerprint(findings.arm)[:16]}"),
        ("trajectory", f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}"),
        ("trajectory origin", trajectory.origin or "not stated"),
        ("rates", trajectory.rates_from),
        ("drives", "drive inertia included" if findings.model.drives else "not included"),
        *findings.provenance.items(),
    )


def _count(operations: OperationCount) -> tuple[int, int, int]:
    return operations.multiplications, operations.additions, operations.sines_cosines
