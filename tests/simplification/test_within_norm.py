"""Models under a budget of the torque's norm: what they promise is what their program does."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.measures import kept_states
from gd_analyze.simplification.model_file import document_of
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from gd_analyze.simplification.trade_off import trade_off
from made_models import signed
from parallel_axes import scara
from strategies import examples, random_states, two_link_of

BUDGET = "2% norm at 95% of states"


@pytest.fixture(scope="module")
def exact() -> ExactDynamics:
    limits = {"lower": -np.pi, "upper": np.pi, "velocity_limit": 1.0, "acceleration_limit": 10.0}
    arm = scara()
    arm = replace(arm, joints=tuple(replace(joint, **limits) for joint in arm.joints))
    return ExactDynamics.of(arm, states_in_box(arm, 300))


@pytest.fixture(scope="module")
def model(exact) -> gd.SimplifiedModel:
    return simplify_exact(exact, BUDGET, SearchOptions(TERM))


def shares_by_hand(model: gd.SimplifiedModel, exact: ExactDynamics) -> np.ndarray:
    """Share of the norm at every state, of joints of one unit each."""
    error = model.torque(*exact.states.arrays) - exact.torque
    turning = np.array(exact.arm.is_revolute)
    groups = [of for of in (turning, ~turning) if of.any()]
    size = [
        np.linalg.norm(error[:, of], axis=1) / np.linalg.norm(exact.torque[:, of], axis=1) for of in groups
    ]
    return np.max(size, axis=0)


def assert_kept(model: gd.SimplifiedModel, exact: ExactDynamics, share: float, states: float) -> None:
    by_hand, count = np.sort(shares_by_hand(model, exact)), len(exact.states)
    kept = kept_states(states, count)
    found = {norm.states: norm.share for norm in model.accuracy.norms}
    # What is below round-off of the largest torque counts as no error, and may be a share of a small one.
    for part, told in found.items():
        assert told == pytest.approx(by_hand[kept_states(part, count) - 1], rel=1e-9, abs=1e-9)
    assert found[states] <= share
    assert (by_hand > share * (1 + 1e-9)).sum() <= count - kept
    assert model.accuracy.asked_norm is not None
    assert model.accuracy.asked_norm.share == found[states]


def test_the_promise_is_what_the_program_does(exact, model):
    assert model.operations.total < exact.form.operations.total
    assert model.operations == model.program.count
    assert_kept(model, exact, 0.02, 0.95)
    # The states it gives up are used: no budget for all states would leave as few operations.
    strict = simplify_exact(exact, "2% norm", SearchOptions(TERM))
    assert_kept(strict, exact, 0.02, 1.0)
    assert model.operations.total < strict.operations.total
    assert shares_by_hand(model, exact).max() > 0.02


@pytest.mark.parametrize("level", [ELEMENT, ENERGY, RECURSIVE])
def test_every_level_keeps_it(exact, level):
    found = simplify_exact(exact, BUDGET, SearchOptions(level, effort=0.1))
    assert found.level is level
    assert_kept(found, exact, 0.02, 0.95)


def test_a_refit_keeps_it_too(exact):
    found = simplify_exact(exact, BUDGET, SearchOptions(TERM, refit=True, effort=0.1))
    assert_kept(found, exact, 0.02, 0.95)


@examples(8)
@given(
    st.floats(0.3, 2.0),
    st.sampled_from([0.0, 9.81]),
    st.sampled_from([0.5, 0.9, 0.95, 1.0]),
    st.floats(1e-3, 0.2),
    st.integers(0, 2**32 - 1),
)
def test_no_more_states_break_it_than_may(length, g, states, share, seed):
    arm = two_link_of(length, 1.0, 0.4, g)
    exact = ExactDynamics.of(arm, random_states(2, 60, seed))
    found = simplify_exact(exact, f"{share:%} norm at {states:%} of states", SearchOptions(TERM))
    asked = found.accuracy.asked.norm
    assert asked is not None
    assert_kept(found, exact, asked.share, states)


def test_many_states_are_thinned_and_all_of_them_count(exact):
    many = exact.at(states_in_box(exact.arm, 6000, seed=2))
    assert_kept(
        simplify_exact(many, BUDGET, SearchOptions(TERM, thorough=False, write=False)), many, 0.02, 0.95
    )


def test_where_no_torque_is_needed_nothing_is_kept(exact):
    floating = replace(exact.arm, gravity=np.zeros(3))
    rest = states_in_box(floating, 20)
    still = ExactDynamics.of(floating, gd.States(rest.q, 0.0 * rest.qd, 0.0 * rest.qdd))
    found = simplify_exact(still, BUDGET, SearchOptions(TERM))
    assert found.operations.total == 0
    assert {norm.share for norm in found.accuracy.norms} == {0.0}


def test_a_file_tells_it_again(exact, model, tmp_path):
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    assert again.accuracy.norms == model.accuracy.norms
    assert again.accuracy.budget == BUDGET
    assert again.accuracy.measured
    evaluation = gd.evaluate(again, exact.states)
    assert evaluation.norms == model.accuracy.norms


@pytest.mark.parametrize(
    ("share", "says"),
    [(0.0201, "at most 0.02, the budget"), (0.001, "as measured at 300 states"), (None, "at most")],
)
def test_a_file_that_tells_otherwise_is_refused(model, tmp_path, share, says):
    document = document_of(model).model_dump()
    for norm in document["norms"]:
        if norm["states"] == 0.95:
            norm["share"] = share
    (tmp_path / "model.json").write_text(json.dumps(signed(document)))
    with pytest.raises(ModelError, match="what the model file states of its errors cannot be") as caught:
        gd.load_model(tmp_path / "model.json")
    assert "norms at 0.95 of the states" in caught.value.details["where"]
    assert says in caught.value.details["expected"]


def test_a_file_of_before_is_measured(model, tmp_path, exact):
    usual = simplify_exact(exact, "2%", SearchOptions(TERM))
    document = document_of(usual).model_dump()
    del document["norms"]
    (tmp_path / "model.json").write_text(json.dumps(signed(document)))
    assert gd.load_model(tmp_path / "model.json").accuracy.norms == usual.accuracy.norms


def test_what_cannot_be_had_is_refused_by_name(exact, two_link, swing):
    refusals = {
        "a certified model": lambda: simplify_certified(exact, BUDGET, gd.Box.of(exact.arm)),
        "a model of so many operations": lambda: simplify_exact(
            exact, BUDGET, SearchOptions(TERM, operations=20)
        ),
        "a trade-off": lambda: trade_off(exact, BUDGET),
        "the main job's results": lambda: gd.Settings(budget=BUDGET),
        "a model for several motions": lambda: gd.simplify(
            two_link, [swing, replace(swing, name="again")], BUDGET
        ),
    }
    for what, ask in refusals.items():
        with pytest.raises(UsageError, match="cannot be had with a budget of the norm") as caught:
            ask()
        assert caught.value.what.startswith(what)
        assert caught.value.details["found"] == f'"{BUDGET}", which is of all joints together'
        assert "next" in caught.value.details


def test_where_the_exact_model_is_given_its_own_shares_are_told(two_link, swing, tmp_path):
    """Of what was found, which saved nothing, nothing is left: the file states what its program does."""
    model = gd.simplify(two_link, swing, "5%", level="element")
    assert model.operations == model.operations_full
    assert [norm.share for norm in model.accuracy.norms] == [0.0, 0.0]
    gd.save_model(model, tmp_path / "model.json")
    assert gd.load_model(tmp_path / "model.json").accuracy.norms == model.accuracy.norms
