"""A proven budget of models that are programs alone: few rounds, each of which takes long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from gd_analyze.certification.box import Box
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.motions.states import States
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import NUMBER, Change
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.term import TERM
from pruned_recursions import errors_at, general_arm, searched


def pruned_within(
    exact: ExactDynamics, budget: Budget, how: SearchOptions, *, provenance: Mapping[str, str] | None
) -> SimplifiedModel:
    """Leave out one product after the other that the budget allows for at the states known."""
    form, allowed = exact.form, exact.allowed(budget)
    changes: dict[Change, float] = {}

    def model_of(changes: Mapping[Change, float]) -> SimplifiedModel:
        program = form.recursion.changed(changes)
        errors = exact.errors_of(program.run(inputs).T)
        accuracy = Accuracy(allowed, str(budget), errors, exact.states.described)
        return SimplifiedModel(
            level=how.level,
            form=form,
            terms={},
            program=program,
            operations_full=form.recursion.program.count,
            accuracy=accuracy,
            provenance=dict(provenance or {}),
        )

    inputs = inputs_of(exact.states)
    best = model_of(changes)
    for place, step in enumerate(form.recursion.steps):
        if step.operation == "multiply":
            tried = model_of(changes | {Change(place, NUMBER): 0.0})
            if (tried.accuracy.errors.largest <= allowed).all():
                best, changes = tried, changes | {Change(place, NUMBER): 0.0}
    return best


def test_a_budget_is_proven_in_few_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    arm = general_arm(4, rng, slides=False)
    box = Box(np.full(4, -2.0), np.full(4, 2.0), np.ones(4), np.full(4, 5.0))
    q, signs = rng.uniform(box.lower, box.upper, (200, 4)), rng.choice([-1.0, 1.0], (2, 200, 4))
    states = States(
        q, signs[0] * box.velocity, signs[1] * box.acceleration, {"box": "drawn", "states": 200, "seed": 3}
    )
    exact = ExactDynamics.of(arm, states)
    monkeypatch.setattr("gd_analyze.certification.certified_model.simplify_exact", pruned_within)
    rounds: list[Any] = []
    model, certificate = simplify_certified(
        exact, Budget.parse("8%"), box, level=TERM, progress=rounds.append
    )
    # Of the sixteen at most.
    assert 1 < len(rounds) <= 8
    assert model.saves
    assert not model.terms
    assert certificate.within(model.accuracy.allowed).all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    for joint in range(4):
        state = searched(model, box, joint, rng)[:, None]
        assert errors_at(model, *state)[0, joint] <= model.accuracy.allowed[joint]
