"""The exact torque in the fewest operations known: that it is exact, and that nothing given costs more."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from budgets import of_shares
from gd_analyze.certification.box import Box
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Joint
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.model_checks import require_terms_computed
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.term import TERM
from gd_analyze.studies.comparison_costs import count_cost
from parallel_axes import scara
from strategies import arms, arms_with_states, examples, random_states

BUILT_IN = ("puma560", "stanford", "two_link")


def inputs(states: States) -> dict[str, np.ndarray]:
    named = zip(("q", "qd", "qdd"), states.last, strict=True)
    return {f"{name}{j + 1}": row for name, rows in named for j, row in enumerate(rows)}


def assert_exact(form: ExactForm, states: States) -> None:
    """Within what a program of as many roundings per joint may differ; rewriting adds some."""
    exact = decompose_states(form.arm, states, christoffel=False, drives=form.drives)["torque"]
    bound = round_off_bounds(form.arm, *states.arrays)["torque"]
    drives = 0.0 if form.drive_inertia is None else np.abs(form.drive_inertia * states.qdd).max()
    found = form.program.run(inputs(states)).T
    assert np.abs(found - exact).max() <= 8 * (bound + 1e-15 * drives)


@examples(10)
@given(arms_with_states(max_joints=5))
def test_it_is_the_torque(case):
    arm, states = case
    assert_exact(ExactForm(arm), states)


@pytest.mark.parametrize("name", BUILT_IN)
def test_it_is_the_torque_of_the_arms_supplied(name):
    arm = load_arm(name)
    for drives in sorted({False, bool(arm.drives)}):
        assert_exact(ExactForm(arm, drives), states_in_box(arm, 50))


@examples(6)
@given(arms(max_joints=4))
def test_written_out_it_is_the_terms(arm):
    """At every state, not at some: coefficient by coefficient."""
    form = ExactForm(arm)
    states = States(*np.zeros((3, 1, arm.n_joints)))
    require_terms_computed(exactly(ExactDynamics(form, states), TERM, np.ones(arm.n_joints), "1 N m"))


@pytest.mark.parametrize("name", BUILT_IN)
def test_no_formulation_takes_fewer(name):
    arm = load_arm(name)
    folded = [count_cost(method, arm).folded.total for method in METHODS.values()]
    assert ExactForm(arm).operations.total <= min(folded)


def test_the_puma_takes_fewer_than_any_program_published():
    """Link-frame Newton-Euler with its zeros folded and equal parts shared takes 413, with drives 425."""
    puma = load_arm("puma560")
    assert count_cost(METHODS["newton_euler_regrouped"], puma).folded.total <= 350
    assert ExactForm(puma).operations.total <= 310
    assert ExactForm(puma, drives=True).operations.total <= 320


def test_what_a_link_keeps_of_its_parameters(puma):
    """Seven of a joint that turns, four of one that slides."""
    for arm in (puma, load_arm("stanford")):
        for link in regrouped(arm).links:
            if link.prismatic is None:
                assert link.mass == link.first[2] == link.second[2, 2] == 0.0
            else:
                assert not link.second.any()
    assert [link.is_round for link in regrouped(puma).links] == [False] * 5 + [True]
    assert [link.is_parallel for link in regrouped(puma).links] == [False, False, True, False, False, False]
    laden = with_payload(puma, 1.0, np.array([0.01, 0.0, 0.1]))
    assert not regrouped(laden).links[-1].is_round


def test_what_slides_along_the_only_axis_is_a_mass(two_link):
    """Turned and lifted: where its matter stands is not told from the first link's."""
    turns, lifts = two_link.joints[0], Joint("2", "prismatic")
    arm = dataclasses.replace(two_link, joints=(turns, lifts), dh_table=())
    slides = regrouped(arm).links[1]
    assert not slides.first.any()
    assert slides.mass == arm.mass[1]
    across = dataclasses.replace(lifts, axis=np.array([1.0, 0.0, 0.0]))
    slides = regrouped(dataclasses.replace(arm, joints=(turns, across))).links[1]
    assert slides.first[2] == 0.0
    assert_exact(ExactForm(arm), random_states(2, 20, 0))


def test_axes_that_are_antiparallel_turn_the_other_way(two_link, rng):
    """The second joint upside down: the same arm with the sign of its angle changed."""
    first, second = two_link.joints
    turned = dataclasses.replace(
        two_link,
        joints=(first, dataclasses.replace(second, axis=np.array([0.0, 0.0, -1.0]))),
        dh_table=(),
    )
    assert [link.sign for link in regrouped(turned).links] == [1, -1]
    assert [link.is_parallel for link in regrouped(turned).links] == [False, True]
    q, qd, qdd = rng.normal(size=(3, 20, 2))
    flip = np.array([1.0, -1.0])
    torque = METHODS["newton_euler_regrouped"].torque
    one = torque(two_link, *(x.T for x in (q, qd, qdd)))
    other = torque(turned, *((flip * x).T for x in (q, qd, qdd)))
    np.testing.assert_allclose(flip[:, None] * other, one, rtol=0, atol=1e-13 * np.abs(one).max())


@examples(10)
@given(
    arms_with_states(max_joints=3, count=20, massive=True),
    st.sampled_from([*LEVELS.values()]),
    st.floats(0.001, 0.5),
)
def test_no_model_costs_more_than_exact(case, level, share):
    arm, states = case
    exact = ExactDynamics(ExactForm(arm), states)
    model = simplify_exact(exact, of_shares(share), SearchOptions(level, thorough=level is ELEMENT))
    assert model.operations.total <= model.operations_full.total == exact.form.operations.total
    if not model.saves:
        assert model.operations == model.operations_full
        assert set(model.terms) == set(level.terms(model.form))
        assert not model.accuracy.errors.largest.any()


def test_neither_does_a_certified_one(two_link, swing):
    exact = ExactDynamics.of(two_link, swing)
    model, certificate = simplify_certified(exact, Budget.parse("0.001%"), Box.of(two_link))
    assert not model.saves
    assert certificate.within(model.accuracy.allowed).all()


def test_asked_for_more_operations_than_exact_takes_it_gives_exact(puma, pick_and_place):
    model = gd.simplify(puma, pick_and_place, operations=5000)
    assert not model.saves
    assert model.operations.total < 320
    assert not model.accuracy.errors.largest.any()


def test_a_wheel_needs_one_product():
    arm = RobotArm(
        "wheel",
        (Joint("1"),),
        (dataclasses.replace(load_arm("two_link").links[0], com=np.zeros(3), inertia_com=np.eye(3)),),
        gravity=np.zeros(3),
    )
    assert ExactForm(arm).operations.total == 1


def test_a_scara_takes_few_operations():
    """Its angles add up across the slide: 58 and 59 terms with the roll a run of its own."""
    form = ExactForm(scara())
    assert form.operations.total <= 53
    # The fast profile of Lloyd et al. 2021: the full circle, rates of 1 and accelerations of 10.
    rng = np.random.default_rng(0)
    q, qd, qdd = (rng.uniform(-x, x, (1000, 4)) for x in (np.pi, 1.0, 10.0))
    model = simplify(scara(), States(q, qd, qdd), "1%")
    assert model.operations.total <= 41
