"""Models of chosen terms, made without a search, and budgets from numbers."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program
from gd_analyze.simplification.accuracy import Accuracy, ErrorTable
from gd_analyze.simplification.budget import Allowance
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.model import exactly, measured, with_gamma
from gd_analyze.simplification.model_file import digest_of_model
from gd_analyze.simplification.search import SearchOptions, selected_terms
from gd_analyze.types import Budget, ExactDynamics, ExactForm, RobotArm, SimplifiedModel, States

# Identification is exact to a few hundred eps of the largest element (its noise is measured in
# tests/harmonics); a torque sums some thousand terms of that size. Models that lack a term, or hold it with
# a wrong factor, are off by its share, which in these arms is 1e-6 and more.
ROUND_OFF = 1e-10


def model_of(form: ExactForm, level: Level, terms: Terms) -> SimplifiedModel:
    """A model of these terms that promises nothing."""
    n = form.arm.n_joints
    nothing = ErrorTable(np.ones(n), np.zeros(n), np.zeros(n))
    return SimplifiedModel(
        level=level,
        form=form,
        terms=terms,
        accuracy=Accuracy(np.ones(n), "1 N m", nothing, {"box": "drawn", "states": 5, "seed": 0}),
    )


def running(program: Program, form: ExactForm) -> SimplifiedModel:
    """A model that runs any program as its torque, and promises nothing."""
    model = model_of(form, ELEMENT, {})
    vars(model)["program"] = program
    return model


def exact_model(arm: RobotArm, drives: bool = False, level: Level = ENERGY) -> SimplifiedModel:
    """A model of all terms."""
    form = ExactForm(arm, drives)
    return model_of(form, level, level.terms(form))


def model_of_parts(arm: RobotArm, labels: Collection[str], drives: bool = False) -> SimplifiedModel:
    """A model that keeps the parts of these labels."""
    form = ExactForm(arm, drives)
    kept = {part: weight for part, weight in ELEMENT.terms(form).items() if part.label in labels}
    assert len(kept) == len(set(labels))
    return model_of(form, ELEMENT, kept)


def searched(exact: ExactDynamics, budget: Budget | str | None, options: SearchOptions) -> SimplifiedModel:
    """The model that a search ends with at given states, though it may save nothing."""
    exact = exact.under(budget)
    allowed = exact.allowed(budget)
    everything = exactly(exact, options.level, allowed, str(Budget.of(budget)))
    terms = selected_terms(exact, allowed, options).terms
    return with_gamma(exact, measured(exact, replace(everything, terms=terms)))


def by_elements(
    arm: RobotArm, given: States | Trajectory | xr.Dataset, drives: bool = False
) -> SimplifiedModel:
    """The dominant part of every element."""
    return model_by_verdicts(ExactDynamics.of(arm, given, drives))


def allowing(model: SimplifiedModel, allowed: FloatArray) -> SimplifiedModel:
    """The same model with another budget, N m, shape (n,)."""
    return replace(model, accuracy=replace(model.accuracy, allowed=allowed))


def signed(document: dict[str, Any]) -> dict[str, Any]:
    return document | {"digest": digest_of_model(document)}


def assert_same(model: SimplifiedModel, again: SimplifiedModel, states: States) -> None:
    """Everything a file must keep, to the last bit."""
    np.testing.assert_array_equal(again.torque(*states.arrays), model.torque(*states.arrays))
    np.testing.assert_array_equal(again.inertia(states.q), model.inertia(states.q))
    np.testing.assert_array_equal(again.gravity_loading(states.q), model.gravity_loading(states.q))
    np.testing.assert_array_equal(
        again.coriolis_centrifugal(states.q, states.qd), model.coriolis_centrifugal(states.q, states.qd)
    )
    for name in ("level", "terms", "drives", "operations", "provenance"):
        assert getattr(again, name) == getattr(model, name), name
    for name in ("budget", "fitted_on", "steps"):
        assert getattr(again.accuracy, name) == getattr(model.accuracy, name), name
    np.testing.assert_array_equal(again.accuracy.allowed, model.accuracy.allowed)
    for name in ("peak_torque", "largest", "rms"):
        np.testing.assert_array_equal(
            getattr(again.accuracy.errors, name), getattr(model.accuracy.errors, name)
        )


def of_shares(*shares: float) -> Budget:
    """Shares of peak torque, one for all joints or one each."""
    return Budget(tuple((Allowance(share),) for share in shares))


def of_torque(amount: float) -> Budget:
    """One torque for all joints, N m."""
    return Budget.of_torques([amount])
