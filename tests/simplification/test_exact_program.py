"""The exact torque in the fewest operations known: that it is exact, and that nothing given costs more."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from budgets import of_shares
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import Program, written
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Joint
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.cache import VARIABLE, keep, without_cache
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm, has_more_terms
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.model_checks import require_terms_computed
from gd_analyze.simplification.program_cache import kept_programs
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.term import TERM
from gd_analyze.simplification.torque_program import torque_program
from gd_analyze.studies.comparison_costs import count_cost
from parallel_axes import arm_of, arms_with_runs, scara
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


@examples(5)
@given(arms_with_states(max_joints=5))
def test_it_is_the_torque(case):
    arm, states = case
    assert_exact(ExactForm(arm), states)


@pytest.mark.parametrize("name", BUILT_IN)
def test_it_is_the_torque_of_the_arms_supplied(name):
    arm = load_arm(name)
    for drives in sorted({False, bool(arm.drives)}):
        assert_exact(ExactForm(arm, drives), states_in_box(arm, 50))


@examples(4)
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
        two_link, joints=(first, dataclasses.replace(second, axis=np.array([0.0, 0.0, -1.0]))), dh_table=()
    )
    assert [link.sign for link in regrouped(turned).links] == [1, -1]
    assert [link.is_parallel for link in regrouped(turned).links] == [False, True]
    q, qd, qdd = rng.normal(size=(3, 20, 2))
    flip = np.array([1.0, -1.0])
    torque = METHODS["newton_euler_regrouped"].torque
    one = torque(two_link, *(x.T for x in (q, qd, qdd)))
    other = torque(turned, *((flip * x).T for x in (q, qd, qdd)))
    np.testing.assert_allclose(flip[:, None] * other, one, rtol=0, atol=1e-13 * np.abs(one).max())


@examples(5)
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


def test_a_scara_takes_few_operations():
    """Its angles add up across the slide: 58 and 59 terms with the roll a run of its own."""
    form = ExactForm(scara())
    assert form.operations.total <= 53
    # The fast profile of Lloyd et al. 2021: the full circle, velocities of 1 and accelerations of 10.
    rng = np.random.default_rng(0)
    q, qd, qdd = (rng.uniform(-x, x, (1000, 4)) for x in (np.pi, 1.0, 10.0))
    model = simplify(scara(), States(q, qd, qdd), "1%")
    assert model.operations.total <= 41


@examples(12)
@given(st.one_of(arms(6), arms_with_runs(6)), st.floats(0.0, 1.5))
def test_it_is_what_counting_all_of_them_says(arm, share):
    # Of random numbers, coefficients stand far above round-off, whatever joints are looked at.
    count = len(ExactForm(arm).torques)
    most = int(share * count)
    assert has_more_terms(ExactForm(arm), most) == (count > most)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_general_arm_of_eight_joints_is_never_written_out(seed):
    form = ExactForm(arm_of(["askew"] * 8, np.random.default_rng(seed)))
    assert has_more_terms(form, 2000)
    # Written out it has some million terms, which take a minute and 2 GB.
    assert "torques" not in vars(form)
    assert "harmonics" not in vars(form)


@pytest.fixture
def place(tmp_path, monkeypatch) -> Path:
    """An empty folder; nothing is remembered of earlier tests, nor afterwards."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    kept_programs.cache_clear()
    yield tmp_path / "cache"
    kept_programs.cache_clear()


def exact(arm: RobotArm, drives: bool = False) -> Program:
    """As another run would make it."""
    kept_programs.cache_clear()
    return ExactForm(arm, drives).program


def thorough(arm: RobotArm) -> Program:
    kept_programs.cache_clear()
    form = ExactForm(arm)
    some = dict(sorted(form.torques.items())[:10])
    return torque_program(form.velocities, some, THOROUGH)


@pytest.fixture(params=[exact, thorough], ids=["exact", "some terms"])
def made(request, place):
    return request.param


def test_it_is_written_once_and_the_same_with_and_without(two_link, place, made, monkeypatch):
    first = made(two_link)
    assert len(list(place.iterdir())) == 1
    with without_cache():
        assert written(made(two_link)) == written(first)
    for module, name in (("exact_form", "_shortest"), ("torque_program", "_thorough")):
        monkeypatch.setattr(f"gd_analyze.simplification.{module}.{name}", None)
    again = made(two_link)
    assert written(again) == written(first)
    assert [step.order for step in again.steps] == [step.order for step in first.steps]


def test_a_wrong_entry_is_not_believed_and_written_anew(two_link, place, made):
    right = written(made(two_link))
    (path,) = place.iterdir()
    before, name = path.read_bytes(), path.name.split(".")[0]
    numbers = [(k, j) for k, step in enumerate(right[0]) for j, x in enumerate(step) if isinstance(x, float)]
    steps = [list(step) for step in right[0]]
    k, j = numbers[0]
    steps[k][j] *= 1.0 + 1e-6
    renamed = [["input", "q9"] if step == ["input", "q1"] else step for step in right[0]]
    for wrong in (
        [[steps, right[1]]],
        [[right[0], right[1][:1]]],
        [[right[0], [*reversed(right[1])]]],
        [[renamed, right[1]]],
        [[right[0], [float("1e300")] * 2]],
        [right, right],
        [],
        [None],
        {"steps": 1},
        "text",
        7,
        None,
    ):
        keep(name, wrong)
        assert path.read_bytes() != before
        assert written(made(two_link)) == right
        assert path.read_bytes() == before


def test_what_is_no_entry_at_all_is_replaced(two_link, place, made):
    right = written(made(two_link))
    (path,) = place.iterdir()
    before = path.read_bytes()
    for content in (b"", b"\0" * 100, before[:-1], b"[" * 10_000):
        path.write_bytes(content)
        assert written(made(two_link)) == right
        assert path.read_bytes() == before


def test_other_code_finds_nothing_of_this(two_link, place, monkeypatch):
    exact(two_link)
    monkeypatch.setattr("gd_analyze.simplification.program_cache._surroundings", lambda: ["other code"])
    exact(two_link)
    assert len(list(place.iterdir())) == 2
