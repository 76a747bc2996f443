"""Every printed term of a model exists in the arm's exact equations, whichever velocities it was found in."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ModelError
from gd_analyze.report.budget import BudgetPath
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.budget_path import budget_path
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import digest_of_model
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.types import ExactDynamics, ExactForm
from long_cases import long
from made_models import searched
from parallel_axes import arms_with_runs
from printed_equations import terms_of_equations, terms_of_model, torque_of
from strategies import examples, random_states


def assert_possible(model: SimplifiedModel) -> None:
    printed, exact = terms_of_model(model.equations.formulas), terms_of_equations(model.arm)
    assert [term for term in printed if term not in exact] == []


def assert_prints_itself(model: SimplifiedModel, seed: int = 0) -> None:
    states = random_states(model.arm.n_joints, 10, seed)
    drives = model.arm.drive_inertia if model.drives else np.zeros(model.arm.n_joints)
    torque, largest = torque_of(terms_of_model(model.equations.formulas), drives, states)
    # A hundred summands, each rounded at its own size; coefficients equal to 1e-9 are shared in programs.
    assert np.abs(torque - model.torque(*states.arrays)).max() <= 1e-8 * largest


CASES = [
    ("two_link", "two-link-swing", "60%"),
    ("two_link", None, "20%"),
    long("scara", None, "10%"),
    long("puma560", "pick-and-place", "5%"),
    long("puma560", "pick-and-place", "1%"),
    long("puma560", "large-slew", "1%"),
    long("puma560", "wrist-move", "1% or 10% friction"),
    long("puma560", None, "1%"),
    long("stanford", None, "10%"),
]


@pytest.mark.parametrize(("name", "motion", "budget"), CASES)
def test_printed_terms_exist_and_are_the_model(name, motion, budget):
    model = gd.simplify(name, motion, budget)
    assert model.saves
    assert_possible(model)
    assert_prints_itself(model)


@pytest.mark.parametrize("name", ["two_link", "scara", "puma560", long("stanford")])
@pytest.mark.parametrize("level", ["term", "energy"])
def test_at_every_level_that_has_terms(name, level):
    arm = gd.load_arm(name)
    model = gd.simplify(arm, gd.tables.states_in_box(arm, 30), "20%", level=level)
    assert_possible(model)
    assert_prints_itself(model)


@examples(24)
@given(
    arms_with_runs(max_joints=3),
    st.sampled_from(["1%", "10%", "40%"]),
    st.booleans(),
    st.sampled_from([TERM, ENERGY]),
    st.integers(0, 2**32 - 1),
)
def test_of_any_arm_in_either_velocities(arm, budget, joint, level, seed):
    exact = ExactDynamics.of(arm, random_states(arm.n_joints, 20, seed))
    if joint and level is TERM:
        exact = exact.with_form(exact.form.in_joint_velocities)
    model = searched(exact, budget, SearchOptions(level, effort=0.1))
    assert_possible(model)
    assert_prints_itself(model, seed)


@examples(24)
@given(arms_with_runs(max_joints=4))
def test_equations_have_the_terms_that_models_choose_from(arm):
    form = ExactForm(arm)
    exact, listed = terms_of_equations(arm), form.printed(form.torques)
    for same in (form, form.in_joint_velocities):
        model = SimplifiedModel(level=TERM, form=same, terms=TERM.terms(same), accuracy=None)
        printed = terms_of_model(model.equations.formulas)
        assert printed.keys() == exact.keys()
        # Coefficients that round-off tells apart are made one; small ones are known to some ten digits.
        size = max(map(abs, exact.values()), default=0.0)
        assert all(abs(printed[term] - exact[term]) <= 1e-10 * size for term in exact)
    assert len(listed) >= len(exact)


def test_in_absolute_velocities_single_terms_would_be_impossible():
    """What candidates prevent: terms of h' that cancel in joint velocities, one without the other."""
    form = ExactForm(gd.load_arm("scara"))
    exact = form.printed(form.torques)
    alone = [
        term for term in form.upper_torques if form.printed(TERM.source(form, term)).keys() - exact.keys()
    ]
    assert len(alone) == 10
    states = random_states(4, 10, 0)
    candidates = candidates_of(ExactDynamics.of(form.arm, states), TERM, np.ones(4))
    assert len(candidates) == len(candidates.terms) - 5
    rng = np.random.default_rng(0)
    for _ in range(20):
        chosen = candidates.chosen(rng.random(len(candidates)) < 0.5)
        assert form.printed(TERM.torques(form, chosen)).keys() <= exact.keys()


def test_a_model_takes_no_more_than_one_in_absolute_velocities(puma, pick_and_place):
    model = gd.simplify(puma, pick_and_place, "5%", at_set_points=True)
    exact = ExactDynamics.of(puma, gd.types.States(pick_and_place.q, pick_and_place.qd, pick_and_place.qdd))
    absolute = simplify_exact(exact, "5%", SearchOptions(same_velocities=True))
    assert absolute.form.velocities.before
    assert not model.form.velocities.before, "joint velocities are better here"
    assert model.functions.operations.total < absolute.functions.operations.total


@pytest.fixture(scope="module")
def swing_model(two_link, swing) -> SimplifiedModel:
    """In joint velocities."""
    model = gd.simplify(two_link, swing, "60%")
    assert not model.form.velocities.before
    return model


def test_the_velocities_stand_in_the_file(swing_model, tmp_path: Path):
    path = tmp_path / "model.json"
    gd.save_model(swing_model, path)
    read, states = gd.load_model(path), random_states(2, 20, 0)
    np.testing.assert_array_equal(read.torque(*states.arrays), swing_model.torque(*states.arrays))
    assert str(read.equations) == str(swing_model.equations)
    assert read.functions.operations == swing_model.functions.operations
    document = json.loads(path.read_text())
    assert document["velocities"] == "joint"
    document["velocities"] = "absolute"
    path.write_text(json.dumps(document | {"digest": digest_of_model(document)}))
    with pytest.raises(ModelError, match="has no such term"):
        gd.load_model(path)


def test_models_of_other_budgets_are_possible_too(swing_model, swing):
    exact = ExactDynamics.of(swing_model.arm, gd.types.States(swing.q, swing.qd, swing.qdd))
    models = budget_path(exact, Budget.parse("60%"), swing_model)
    assert len({len(model.terms) for model in models}) > 1
    for model in models:
        assert_possible(model)
    absolute = simplify_exact(exact, "5%", SearchOptions(same_velocities=True))
    for model in budget_path(exact, Budget.parse("5%"), absolute):
        assert_possible(model)


@pytest.mark.slow
def test_a_page_prints_possible_terms_for_every_budget(puma_findings):
    exact, path = terms_of_equations(puma_findings.arm), BudgetPath.of(puma_findings)
    for k in range(len(path.rows)):
        assert terms_of_model(path.formulas(puma_findings, k)).keys() <= exact.keys()
