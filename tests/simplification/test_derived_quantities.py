"""D, h and c of a model are derivatives of its torque's program: the exact ones where it keeps everything."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from few_tries import few_tries
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.trace import Expression
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Drive
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from made_models import ROUND_OFF, exact_model
from strategies import arms_with_states, examples, random_states

every_level = pytest.mark.parametrize("level", LEVELS.values(), ids=str)
CASES = [("puma560", False), ("puma560", True), ("stanford", False), ("two_link", False)]


def assert_adds_up(model: SimplifiedModel, states: States) -> None:
    """Torque is D qdd + h + c: derivatives and torque sum the same products, in another order."""
    inertia, h, c = quantities(model, states)
    products = np.einsum("tij,tj->tij", inertia, states.qdd)
    size = np.abs(products).sum(axis=2) + np.abs(h) + np.abs(c)
    error = np.abs(model.torque(*states.arrays) - (products.sum(axis=2) + h + c))
    # Within a row terms may cancel that are larger than D qdd, h and c: six digits are left for it.
    assert error.max() <= ROUND_OFF * max(size.max(), 1e-300)


def quantities(model: SimplifiedModel, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return (
        model.inertia(states.q),
        model.coriolis_centrifugal(states.q, states.qd),
        model.gravity_loading(states.q),
    )


def assert_exact(model: SimplifiedModel, states: States) -> None:
    arm = model.arm
    numeric = decompose_states(arm, states, christoffel=False, drives=model.drives)
    inertia = numeric["inertia"].sum(axis=1) + (np.diag(arm.drive_inertia) if model.drives else 0.0)
    expected = (inertia, numeric["coriolis_centrifugal"].sum(axis=1), numeric["gravity_loading"])
    scale = np.abs(numeric["torque"]).max()
    pairs = [
        (model.torque(*states.arrays), numeric["torque"]),
        *zip(quantities(model, states), expected, strict=True),
    ]
    for found, wanted in pairs:
        assert found.shape == wanted.shape
        assert np.abs(found - wanted).max() <= ROUND_OFF * max(scale, np.abs(wanted).max())
    if model.level in (ELEMENT, ENERGY):
        found = model.inertia(states.q)
        np.testing.assert_allclose(
            found, found.swapaxes(1, 2), rtol=0, atol=ROUND_OFF * np.abs(found).max(initial=0.0)
        )
    assert_adds_up(model, states)


@every_level
@pytest.mark.parametrize(("name", "drives"), CASES)
def test_a_model_of_all_terms_is_exact(level, name, drives):
    arm = load_arm(name)
    assert_exact(exact_model(arm, drives, level), random_states(arm.n_joints, 20, 3))


@every_level
@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_without_a_budget_nothing_that_acts_is_lost(level, name):
    """Over many states what makes no torque beyond round-off anywhere makes none elsewhere."""
    arm = load_arm(name)
    exact = ExactDynamics.of(arm, states_in_box(arm, 100))
    model = simplify_exact(exact, Budget.parse("0%"), SearchOptions(level, thorough=False))
    assert not model.accuracy.errors.largest.any()
    assert_exact(model, states_in_box(arm, 20, 1))


@examples(12)
@given(arms_with_states(max_joints=4), st.sampled_from(list(LEVELS.values())), st.booleans())
def test_so_it_is_of_any_arm(case, level, drives):
    arm, states = case
    arm = dataclasses.replace(arm, drives=tuple(Drive(0.1 * (i + 1)) for i in range(arm.n_joints)))
    assert_exact(exact_model(arm, drives, level), states)


@examples(10)
@given(
    arms_with_states(max_joints=3, massive=True, count=10),
    st.sampled_from(list(LEVELS.values())),
    st.sampled_from(["1%", "20%", "60%"]),
)
@few_tries()
def test_a_simplified_model_adds_up_as_well(case, level, budget):
    arm, states = case
    how = SearchOptions(level, refit=level.has_torque_terms, thorough=False)
    model = simplify_exact(ExactDynamics.of(arm, states), Budget.parse(budget), how)
    assert_adds_up(model, states)
    assert_adds_up(model, random_states(arm.n_joints, 10, 7))
    if level.is_mechanical:
        inertia = model.inertia(states.q)
        size = np.abs(inertia).max(initial=0.0)
        assert np.abs(inertia - inertia.swapaxes(1, 2)).max(initial=0.0) <= ROUND_OFF * size


def test_inertia_of_the_simplified_puma_is_symmetric(puma_energy, puma):
    inertia = puma_energy.inertia(states_in_box(puma, 100, 1).q)
    assert np.abs(inertia - inertia.swapaxes(1, 2)).max() <= ROUND_OFF * np.abs(inertia).max()


@every_level
def test_each_of_them_needs_no_more_than_it_depends_on(two_link, level):
    model = exact_model(two_link, level=level)
    asked = {
        "inertia": (model.inertia_program, {"q"}),
        "h": (model.coriolis_centrifugal_program, {"q", "qd"}),
        "c": (model.gravity_loading_program, {"q"}),
    }
    for *programs, kinds in asked.values():
        for program in programs:
            named = {step.arguments[0].rstrip("12") for step in program.steps if step.operation == "input"}
            assert named <= kinds
            assert program.count.total < model.operations.total


def recount(outputs) -> dict[str, int]:
    """Every expression the outputs reach, once, without the program's own list of steps."""
    found: dict[int, str] = {}
    waiting = [x for x in outputs if isinstance(x, Expression)]
    while waiting:
        node = waiting.pop()
        if node.order not in found:
            found[node.order] = node.operation
            waiting += [x for x in node.arguments if isinstance(x, Expression)]
    kinds = list(found.values())
    return {
        "multiplications": kinds.count("multiply"),
        "additions": kinds.count("add") + kinds.count("subtract"),
        "sines_cosines": kinds.count("cos") + kinds.count("sin"),
    }


@every_level
def test_the_count_is_that_of_the_program(puma_energy, level):
    for model in (puma_energy, exact_model(load_arm("stanford"), level=level)):
        counted = recount(model.program.outputs)
        assert vars(model.operations) == counted
        assert model.operations.total == counted["multiplications"] + counted["additions"]


def test_two_rods_take_few_operations(two_link):
    assert exact_model(two_link).operations.total <= 22
