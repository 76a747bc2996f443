"""The exact model: what stands where leaving something out saves nothing."""

from __future__ import annotations

from dataclasses import replace

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.model import SimplifiedModel


def no_dearer(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """Give the exact model in place of one that saves nothing; what was searched remains said."""
    if model.saves:
        return model
    everything = exactly(exact, model.level, model.accuracy.allowed, model.accuracy.budget)
    stated = everything.accuracy
    accuracy = replace(model.accuracy, errors=stated.errors, motions=stated.motions, norms=stated.norms)
    return replace(everything, accuracy=accuracy, provenance=model.provenance)


def exactly(exact: ExactDynamics, level: Level, allowed: FloatArray, budget: str) -> SimplifiedModel:
    """Keep everything, in the fewest operations known."""
    form = exact.form
    model = SimplifiedModel(
        level=level,
        form=form,
        terms=level.terms(form),
        program=form.program,
        operations_full=form.operations,
        accuracy=Accuracy(
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
    return replace(model, accuracy=exact.held(model.accuracy, model.torque(*exact.states.arrays)))
