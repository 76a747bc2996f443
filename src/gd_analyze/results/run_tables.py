"""Results of a run as labelled tables, one per group of the schema."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray
from gd_analyze.certification.certificate import Certificate
from gd_analyze.certification.held import Held
from gd_analyze.certification.tube import Tube
from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.pinocchio_check import Residual
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import term_formula
from gd_analyze.motions.margin import Margin
from gd_analyze.operations.program import OperationCount
from gd_analyze.results.model_facts import joint_error_values
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import GROUPS, table
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.element import (
    ELEMENT,
    VERDICT_SOURCES,
    model_by_verdicts,
    operations_by_quantity,
    parts_of,
)
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.level import Terms
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_torque import PayloadEffect, losses
from gd_analyze.simplification.term_ranking import RankedTerm, TermRanking
from gd_analyze.simplification.torque_program import ROUGH

if TYPE_CHECKING:
    import xarray as xr

# Types of the numbers that are stated of a term.
_TYPES = {"int": int, "float": float}


def cross_check_table(residuals: Sequence[Residual], arm: RobotArm) -> xr.Dataset:
    """Tabulate the differences from Pinocchio."""
    return table(
        "cross_check",
        {
            "largest_difference": [residual.largest for residual in residuals],
            "round_off_bound": [residual.bound for residual in residuals],
        },
        arm.is_revolute,
        {
            "comparison": [f"{residual.quantity}, {residual.unit}" for residual in residuals],
            "quantity": ("comparison", [residual.quantity for residual in residuals]),
            "unit": ("comparison", [residual.unit for residual in residuals]),
        },
    )


def model_table(model: SimplifiedModel, dataset: xr.Dataset) -> xr.Dataset:
    """Tabulate budget and errors, and the model's torque at the set points of a decomposition."""
    torque = model.torque(*(dataset[kind].values for kind in ("q", "qd", "qdd")))
    accuracy, error = model.accuracy, torque - dataset.torque.values
    return table(
        "simplified_model",
        {**joint_error_values(model), "torque": torque, "torque_error": error},
        model.arm.is_revolute,
        {"time": dataset.time, **joint_names(model.arm)},
        {
            "level": model.level.name,
            "drives": int(model.drives),
            "budget": accuracy.budget,
            "errors_are": "sampled at the set points",
            "search": accuracy.search,
            **_counts(model.operations, model.operations_full),
        },
    )


def parts_table(
    model: SimplifiedModel, exact: ExactDynamics, full: OperationCount, dominance: xr.Dataset
) -> xr.Dataset:
    """Tabulate the parts that [FGL87]'s own method keeps, and the torque of the others.

    `full` are the operations of the exact torque, as the run's own model states them.
    A part is zero where the ranking of elements says so, and its torque where it is round-off.
    """
    parts, lost = parts_of(model.arm.n_joints), {loss.part: loss for loss in losses(model, exact)}
    labels, is_kept = [part.label for part in parts], np.array([part in model.terms for part in parts])
    of_elements = dominance.sel(element=[part.element.label for part in parts])
    effects = [dominance.effect.values.tolist().index(part.effect) for part in parts]
    peak = of_elements.part_peak.values[np.arange(len(parts)), effects]
    torque, share, joints = (
        np.array([getattr(lost[label], name) if label in lost else unknown for label in labels])
        for name, unknown in (("torque_peak", np.nan), ("torque_share", np.nan), ("torque_joint", 0))
    )
    nothing = ~is_kept & ((peak == 0.0) | (share <= ROUND_OFF_SHARE))
    return table(
        "parts",
        {
            "kept_by_element": is_kept,
            "peak": peak,
            "torque_peak": np.where(nothing, 0.0, torque),
            "torque_joint": joints,
            "torque_share": np.where(nothing, 0.0, share),
        },
        model.arm.is_revolute,
        {
            "part": labels,
            "unit": ("part", of_elements.unit.values),
            "torque_unit": ("part", _efforts(model.arm, joints)),
        },
        {"budget": model.accuracy.budget, **_counts(model.operations, full)},
    )


def verdicts_table(model: SimplifiedModel, exact: ExactDynamics, threshold: float) -> xr.Dataset:
    """Tabulate torque errors and operations of models by verdicts, our own and [FGL87]'s.

    Those of the exact dynamics are as the run's own model states them.
    """
    form = exact.form
    names = VERDICT_SOURCES if text_verdicts(exact.arm.name) else VERDICT_SOURCES[:1]
    models = {name: model_by_verdicts(exact, name, threshold, model.accuracy.asked) for name in names}
    functions = model.functions_full
    all_terms = ELEMENT.terms(form)
    counts = {
        "exact": [*(program.count for program in functions), functions.operations, model.operations_full],
        "exact, by element": _by_element(form, all_terms, ELEMENT.write(form, all_terms, ROUGH).count),
        **{name: _by_element(form, by_name.terms, by_name.operations) for name, by_name in models.items()},
    }
    error_tables = [by_name.accuracy.errors for by_name in models.values()]
    values = {
        "operations": np.array([[count.total for count in row] for row in counts.values()]),
        "sines_cosines": np.array([[count.sines_cosines for count in row] for row in counts.values()]),
        "largest_error": np.array([error_table.largest for error_table in error_tables]),
        "largest_share": np.array([error_table.largest_share for error_table in error_tables]),
    }
    coords = {
        "program": [*counts],
        "quantity": ["D", "h", "c", "D, h and c", "torque"],
        "verdicts": [*models],
    }
    return table("by_verdicts", values, exact.arm.is_revolute, coords)


def _by_element(form: ExactForm, terms: Terms, torque: OperationCount) -> list[OperationCount]:
    return [*operations_by_quantity(form, terms).values(), torque]


def term_values(ranking: TermRanking) -> dict[str, np.ndarray]:
    """Ranked terms by the names of the table "terms"; types are explicit, as there may be no terms."""
    terms, plain = ranking.terms, Plain()
    formulas = [term_formula(term.term, term.weight) for term in terms]
    numbers: dict[str, np.ndarray] = {
        field.name: np.array([getattr(term, field.name) for term in terms], dtype=_TYPES[field.type])
        for field in fields(RankedTerm)
        if field.name in GROUPS["terms"] and field.type in _TYPES
    }
    below = [-1 if term.below_uncertainty is None else int(term.below_uncertainty) for term in terms]
    return {
        "label": np.array([plain.symbol(formula.left) for formula in formulas], dtype=str),
        "quantity": np.array([term.term.quantity for term in terms], dtype=str),
        "text": np.array([plain.right(formula) for formula in formulas], dtype=str),
        **numbers,
        "below_uncertainty": np.array(below, dtype=int),
    }


def terms_table(ranking: TermRanking, arm: RobotArm, written_out: bool) -> xr.Dataset:
    """Tabulate the ranking of single terms."""
    terms = ranking.terms
    units = np.array([term.term.weight_unit(arm.is_revolute) for term in terms], dtype=str)
    return table(
        "terms",
        term_values(ranking),
        arm.is_revolute,
        {
            "rank": np.arange(1, len(terms) + 1),
            "weight_unit": ("rank", units),
            "alone_unit": ("rank", _efforts(arm, [term.alone_joint for term in terms])),
        },
        {
            "written_out": int(written_out),
            "total": ranking.total,
            "not_worth_keeping": -1 if ranking.not_worth_keeping is None else ranking.not_worth_keeping,
        },
    )


def budgets_table(path: Sequence[SimplifiedModel], position: int, ranking: TermRanking) -> xr.Dataset:
    """Tabulate parts kept, errors and operations of models for several budgets; the run's is at `position`.

    For a model of torque or energy terms, `kept` says which ranked torque terms remain: a term remains as
    long as anything that contributes to it. For a model of parts, `kept_parts` says which parts remain.
    """
    arm, counts = path[0].form.arm, [model.operations for model in path]
    counts_apart = [model.functions.operations for model in path]
    values: dict[str, Any] = {
        "budget": [model.accuracy.budget for model in path],
        "operations": [count.total for count in counts],
        "multiplications": [count.multiplications for count in counts],
        "additions": [count.additions for count in counts],
        "sines_cosines": [count.sines_cosines for count in counts],
        "operations_apart": [count.total for count in counts_apart],
        "sines_cosines_apart": [count.sines_cosines for count in counts_apart],
        "largest_error": [model.accuracy.errors.largest for model in path],
        "allowed_error": [model.accuracy.allowed for model in path],
    }
    coords: dict[str, Any] = {"position": np.arange(len(path))}
    if path[0].has_terms:
        is_kept = [[ranked.term in model.torques for ranked in ranking.terms] for model in path]
        values["kept"] = np.array(is_kept, dtype=bool).reshape(len(path), len(ranking.terms))
        coords["rank"] = np.arange(1, len(ranking.terms) + 1)
    else:
        parts = parts_of(arm.n_joints)
        values["kept_parts"] = [[part in model.terms for part in parts] for model in path]
        coords["part"] = [part.label for part in parts]
    return table("budgets", values, arm.is_revolute, coords, {"asked": position})


def beyond_table(
    model: SimplifiedModel,
    certificate: Certificate | None,
    within_limits: ErrorTable | None,
    payload: PayloadEffect,
    uncertainty: Sequence[float] | None,
    states_drawn: int,
) -> xr.Dataset:
    """Tabulate the model's errors away from the set points; nan where unknown."""
    unknown = np.full(model.arm.n_joints, np.nan)
    certified = unknown if certificate is None else certificate.certified
    return table(
        "beyond",
        {
            "certified": certified,
            "certified_share": _of_peak(certified, model),
            "worst_found": unknown if certificate is None else certificate.worst_found,
            "within_limits": unknown if within_limits is None else within_limits.largest,
            "within_limits_share": unknown if within_limits is None else within_limits.largest_share,
            "torque_per_kg": payload.torque_per_kg,
            "mass_within_budget": payload.mass_within_budget,
            "uncertainty": unknown if uncertainty is None else np.array(uncertainty),
        },
        model.arm.is_revolute,
        joint_names(model.arm),
        {"states_drawn": states_drawn},
    )


def tube_table(model: SimplifiedModel, tube: Tube, held_model: Held, margin: Margin) -> xr.Dataset:
    """Tabulate proven and found errors of a model around the motion; nan where unknown."""
    unknown, certificate = np.full(tube.lower.shape[::2], np.nan), held_model.certificate
    certified = worst_found = unknown[0]
    if certificate is not None:
        # Weights of several motions may have led the search past larger errors at set points.
        certified, worst_found = (
            certificate.certified,
            np.fmax(certificate.found, model.accuracy.errors.largest),
        )
    if (
        held_model.found is not None
        and held_model.tried
        and (certificate is None or not model.accuracy.motions)
    ):
        worst_found = np.fmax(worst_found, held_model.found)
    return table(
        "tube",
        {
            "tube_certified": certified,
            "tube_certified_share": _of_peak(certified, model),
            "tube_worst_found": worst_found,
            "tube_worst_found_share": _of_peak(worst_found, model),
            **{f"tube_margin_{name}": tube.margins[k] for k, name in enumerate(("q", "qd", "qdd"))},
            "tube_along": unknown if certificate is None else certificate.along,
        },
        model.arm.is_revolute,
        {
            **joint_names(model.arm),
            "segment_from": ("segment", tube.begin, {"units": "s"}),
            "segment_to": ("segment", tube.end, {"units": "s"}),
        },
        {"margin": str(margin), "coarse": tube.coarse, "note": tube.note, "tried": held_model.tried},
    )


def joint_names(arm: RobotArm) -> dict[str, Any]:
    """The coordinate with the names of the joints."""
    return {"joint_name": ("joint", [joint.name for joint in arm.joints])}


def _of_peak(error: FloatArray, model: SimplifiedModel) -> FloatArray:
    """Share of peak torque; nan where there is no torque."""
    peak = model.accuracy.errors.peak_torque
    return np.divide(error, peak, out=np.full_like(error, np.nan), where=peak > 0.0)


def _efforts(arm: RobotArm, joints: Sequence[int] | np.ndarray) -> np.ndarray:
    """Unit of each joint's torque, joints from 1; "" for none."""
    return np.array([arm.joints[joint - 1].effort_unit if joint else "" for joint in joints], dtype=str)


def _counts(operations: OperationCount, full: OperationCount) -> dict[str, int]:
    """Operations of a model, and of the exact torque."""
    return {
        f"{kind}{suffix}": getattr(count, kind)
        for suffix, count in (("", operations), ("_full", full))
        for kind in ("multiplications", "additions", "sines_cosines")
    }
