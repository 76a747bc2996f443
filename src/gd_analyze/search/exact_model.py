"""The exact model: what stands where leaving something out saves nothing."""

from __future__ import annotations

from dataclasses import replace

from gd_analyze.levels import ExactDynamics, Level, Promise, SimplifiedModel
from gd_analyze.vectors import FloatArray


def no_dearer(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """Give the exact model in place of one that saves nothing; what was searched remains said."""
    if model.saves:
        return model
    everything = exactly(exact, model.level, model.promise.allowed, model.promise.budget)
    stated = everything.promise
    promise = replace(model.promise, errors=stated.errors, motions=stated.motions, norms=stated.norms)
    return replace(everything, promise=promise, provenance=model.provenance)


def exactly(exact: ExactDynamics, level: Level, allowed: FloatArray, budget: str) -> SimplifiedModel:
    """Keep everything, in the fewest operations known."""
    form = exact.form
    model = SimplifiedModel(
        level=level,
        form=form,
        terms=level.terms(form),
        program=form.program,
        operations_full=form.operations,
        promise=Promise(
            allowed,
            budget,
            exact.errors_of(exact.torque),
            exact.states.described,
            uncertainty=exact.uncertainty,
        ),
    )
    return measured(exact, model)


def measured(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State the errors that a model's own program makes."""
    return replace(model, promise=exact.held(model.promise, model.torque(*exact.states.arrays)))
