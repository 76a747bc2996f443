"""The fifth step of the main job: all results as tables, see schema.csv."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import certify
from gd_analyze.dynamics.decomposition import MOST_KEPT
from gd_analyze.dynamics.dominance_over_time import dominance_over_time
from gd_analyze.dynamics.robustness import robustness
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.states import states_in_box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results import motion_tables, run_tables
from gd_analyze.results.findings import Findings
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.model_torque import payload_effect
from gd_analyze.studies.budget_stops import stops_table
from gd_analyze.studies.steps.decompose import RunDynamics, rank_step
from gd_analyze.studies.steps.read import RunInputs
from gd_analyze.studies.steps.simplify import RunModels

if TYPE_CHECKING:
    import xarray as xr

# States drawn to test a model beyond its own.
_TESTED_STATES = 1000
# Arms drawn from the stated uncertainties: probabilities near 95 % are known to within 0.5 %.
_DRAWN_ARMS = 2000


def collect_step(inputs: RunInputs, dynamics: RunDynamics, models: RunModels) -> Findings:
    """Put everything found into tables; of a long motion at the set points shown."""
    trajectory, dataset = dynamics.points.shown(models.worst)
    is_element = inputs.settings.level is ELEMENT
    model, elements = (
        replace(each, form=each.form.of_arm(dynamics.arm)) for each in (models.model, models.elements)
    )
    return Findings(
        arm=inputs.arm,
        trajectory=trajectory,
        tables=_tables(inputs, dynamics, models, trajectory, dataset),
        model=model,
        element_model=model if is_element else elements,
        ranked_terms={ranked.term: ranked.weight for ranked in models.ranking.terms},
        warnings=(),
        provenance=inputs.source,
    )


def _tables(
    inputs: RunInputs, dynamics: RunDynamics, models: RunModels, trajectory: Trajectory, dataset: xr.Dataset
) -> dict[str, xr.Dataset]:
    arm, settings, exact = inputs.arm, inputs.settings, models.exact
    held, model = models.held, models.model
    dominance = rank_step(inputs, dynamics, models.budget)
    tube = inputs.tube
    if inputs.has_tube and held.certificate is None:
        tube = replace(tube, note=_why_unproven(models))
    # From a long pool, set points are taken evenly; peaks are over all.
    over_time = dataset.isel(time=evenly(trajectory.n_set_points, MOST_KEPT))
    tables = {
        "trajectory": motion_tables.trajectory_table(arm, trajectory),
        "decomposition": dataset,
        "cross_check": run_tables.cross_check_table(dynamics.residuals, arm),
        "dominance": dominance,
        "dominance_over_time": dominance_over_time(over_time, dominance),
        "simplified_model": run_tables.model_table(model, dataset),
        "parts": run_tables.parts_table(models.elements, exact, model.operations_full, dominance),
        "by_verdicts": run_tables.verdicts_table(model, exact, settings.dominance),
        "terms": run_tables.terms_table(models.ranking, arm, not dynamics.too_many_terms),
        "budgets": run_tables.budgets_table(models.path, models.own_place, models.ranking),
        "beyond": _beyond(models),
        "tube": run_tables.tube_table(model, tube, held, Margin.of(settings.margin)),
    }
    if models.stops:
        tables["stops"] = stops_table(models.stops, models.places, arm)
    if trajectory.recording is not None and trajectory.recording.measured:
        tables["recording"] = motion_tables.recording_table(
            arm, inputs.trajectory, trajectory, dataset, dominance
        )
    if dynamics.measured_torque is not None:
        compared_at = dynamics.measured_torque.time.values
        shown = np.searchsorted(compared_at, trajectory.time)
        tables["measured_torque"] = dynamics.measured_torque.isel(time=shown)
    if dynamics.diagnosis is not None:
        tables["diagnosis"] = dynamics.diagnosis
    if trajectory.motions:
        allowed = [alone.allowed(models.budget) for alone in exact.by_motion.values()]
        ranked = motion_tables.rank_by_motion(arm, dataset, trajectory, allowed)
        tables["motions"] = motion_tables.motions_table(
            arm, trajectory, dominance, ranked, model.accuracy, held.certificate
        )
    every_set_point = dynamics.points.every_set_point(model)
    if every_set_point is not None:
        tables["every_set_point"] = every_set_point
    if arm.spread is not None or any(link.uncertainty is not None for link in arm.links):
        tables["robustness"] = robustness(arm, trajectory, threshold=settings.dominance, samples=_DRAWN_ARMS)
    return tables


def _beyond(models: RunModels) -> xr.Dataset:
    """Test the run's model at states it was not fitted on."""
    exact, model = models.exact, models.model
    arm, states = exact.arm, exact.states
    certificate = errors = None
    if models.efforts is not None:
        box = Box.around(*states.arrays)
        certificate = certify(model, box, effort=models.efforts.box, harmonics=exact.form.harmonics)
    if arm.has_all_limits:
        drawn = exact.at(states_in_box(arm, _TESTED_STATES))
        errors = drawn.errors_of(model.torque(*drawn.states.arrays))
    payload, drawn_states = payload_effect(model, states), _TESTED_STATES if errors else 0
    uncertainty = models.ranking.uncertainty
    return run_tables.beyond_table(model, certificate, errors, payload, uncertainty, drawn_states)


def _why_unproven(models: RunModels) -> str:
    why = "the model is the exact torque, with no error but round-off to bound"
    if not models.model.is_exact:
        name = models.model.arm.name
        why = f"the model of {name} is too long to be written out; `gd-analyze evaluate` tests it at states"
    return f"Not certified: {why}."
