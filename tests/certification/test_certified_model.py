"""Models whose budget is proven: no state of the region breaks it, drawn or found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from attacks import drawn_motion, drawn_states, errors_at, largest_excess, round_off_in
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from budgets import of_shares
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import NUMBER, Change
from gd_analyze.simplification.simplify import simplify
from pruned_recursions import errors_at as errors_of_program
from pruned_recursions import general_arm, searched
from strategies import arms, arms_with_states, examples


@examples(6)
@given(
    arms_with_states(max_joints=2, count=15, massive=True),
    st.floats(0.02, 0.3),
    st.sampled_from([TERM, ENERGY]),
    st.integers(0, 2**32 - 1),
)
def test_no_state_of_the_box_breaks_the_budget(case, share, level, seed):
    arm, drawn = case
    states = States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 15, "seed": 0})
    box = Box.around(*states.arrays)
    exact = ExactDynamics.of(arm, states)
    model, certificate = simplify_certified(exact, of_shares(share), box, level=level)
    allowed = exact.allowed(of_shares(share))
    assert (certificate.certified <= allowed).all()
    attacked = drawn_states(box, 400, np.random.default_rng(seed))
    slack = 1e-10 * exact.peak_torque.max()
    assert (errors_at(model, *attacked).max(axis=0) <= certificate.certified + slack).all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    np.testing.assert_array_equal(model.accuracy.allowed, allowed)


@examples(4)
@given(arms(max_joints=2, massive=True), st.floats(0.02, 0.3), st.integers(0, 2**32 - 1))
def test_no_state_of_the_tube_breaks_the_budget(arm, share, seed):
    rng = np.random.default_rng(seed)
    motion = drawn_motion(arm, rng)
    exact = ExactDynamics.of(arm, States(motion.q, motion.qd, motion.qdd))
    if not exact.peak_torque.all():
        return
    tube, budget = Tube.along(arm, motion), Budget.parse(f"{100 * share}%")
    model, certificate = simplify_certified(exact, budget, tube)
    assert (certificate.certified <= exact.allowed(budget)).all()
    assert largest_excess(model, tube, certificate.along, rng) <= round_off_in(model, tube)


@pytest.mark.parametrize("level", [TERM, pytest.param(ENERGY, marks=pytest.mark.slow), ELEMENT])
def test_along_a_trajectory(puma, pick_and_place, level):
    exact, budget = ExactDynamics.of(puma, pick_and_place, drives=True), Budget.parse("2%")
    tube = Tube.along(puma, pick_and_place)
    model, certificate = simplify_certified(exact, budget, tube, level=level)
    allowed = exact.allowed(budget)
    assert certificate.region is tube
    assert (certificate.certified <= allowed).all()
    bounds = np.broadcast_to(allowed, certificate.along.shape)
    assert largest_excess(model, tube, bounds, np.random.default_rng(2)) <= round_off_in(model, tube)
    assert model.accuracy.budget == "2%, certified"


def test_between_the_extremes_of_a_trajectory(puma, pick_and_place):
    """A budget kept at the set points only is broken between their extremes; a certified one is not."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=True)
    box = Box.around(*exact.states.arrays)
    sampled = simplify(puma, pick_and_place, Budget.parse("2%"), level="energy", drives=True)
    assert (gd.certify(sampled, box).certified > sampled.accuracy.allowed).any()
    rounds: list[int] = []
    model, certificate = simplify_certified(
        exact, Budget.parse("2%"), box, level=ENERGY, progress=rounds.append
    )
    assert certificate.within(model.accuracy.allowed).all()
    assert len(rounds) > 1
    assert model.operations.total >= sampled.operations.total
    assert model.accuracy.fitted_on["set_points"] == 31


def test_a_budget_below_what_a_bound_can_resolve_is_refused(two_link, swing):
    exact = ExactDynamics.of(two_link, swing)
    with pytest.raises(UsageError, match="not even the exact model"):
        simplify_certified(exact, of_shares(0.0), Box.around(*exact.states.arrays))


def test_the_program_that_is_returned_is_the_one_certified(two_link):
    exact, box = ExactDynamics.of(two_link, states_in_box(two_link, 300)), Box.of(two_link)
    model, certificate = simplify_certified(exact, Budget.parse("40%"), box)
    assert certify(model, box).certified.tolist() == certificate.certified.tolist()
    assert certificate.within(model.accuracy.allowed).all()


def test_levels_and_steps_are_those_of_the_certified_model(two_link, swing, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.simplify._FEW_JOINTS", 0)
    monkeypatch.setattr("gd_analyze.simplification.simplify._FEW", 0.0)
    exact = ExactDynamics.of(two_link, swing)
    model, _ = simplify_certified(exact, "60%", Box.around(*exact.states.arrays), effort=0.01)
    counts = {one.level: one.operations for one in model.accuracy.levels}
    assert counts.pop(model.level.name) == model.operations.total
    assert list(counts.values()) == [None]
    assert model.accuracy.steps[-1].operations == model.operations.total


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


@pytest.mark.slow
def test_models_that_are_programs_alone_take_few_rounds(monkeypatch):
    rng = np.random.default_rng(3)
    arm = general_arm(4, rng, slides=False)
    box = Box(np.full(4, -2.0), np.full(4, 2.0), np.ones(4), np.full(4, 5.0))
    q, signs = rng.uniform(box.lower, box.upper, (200, 4)), rng.choice([-1.0, 1.0], (2, 200, 4))
    described = {"box": "drawn", "states": 200, "seed": 3}
    states = States(q, signs[0] * box.velocity, signs[1] * box.acceleration, described)
    exact = ExactDynamics.of(arm, states)
    monkeypatch.setattr("gd_analyze.certification.certified_model.simplify_exact", pruned_within)
    rounds: list[Any] = []
    model, certificate = simplify_certified(
        exact, Budget.parse("8%"), box, level=TERM, progress=rounds.append
    )
    # Of sixteen at most.
    assert 1 < len(rounds) <= 8
    assert model.saves
    assert certificate.within(model.accuracy.allowed).all()
    for joint in range(4):
        state = searched(model, box, joint, rng)[:, None]
        assert errors_of_program(model, *state)[0, joint] <= model.accuracy.allowed[joint]
