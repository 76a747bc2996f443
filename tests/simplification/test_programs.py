"""The fewest operations known: of the exact torque and of some terms, the same in every run."""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from computed_terms import assert_computes
from gd_analyze import load_arm, simplify
from gd_analyze.cache import VARIABLE, keep, kept, without_cache
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.files import shipped
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Factor, TorqueTerm, Velocity
from gd_analyze.operations.functions import (
    bias_program,
    gravity_loading_program,
    inertia_program,
    motion_program,
)
from gd_analyze.operations.program import Program, plain_program, program_inputs
from gd_analyze.simplification.exact import has_more_terms
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.kept_program import kept_programs
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.torque_program import COUNTING, FINAL, ROUGH, torque_program
from gd_analyze.studies.formulations import count_cost
from gd_analyze.tables import decompose_states
from gd_analyze.types import LEVELS, ExactDynamics, ExactForm, RobotArm, States
from long_cases import long, long_but
from parallel_axes import arm_of, scara
from strategies import arms, arms_with_states, examples, random_states

BUILT_IN = ("puma560", "stanford", "two_link")


@examples(5)
@given(arms_with_states(max_joints=5))
def test_it_is_the_torque(case):
    """Within what a program of as many roundings per joint may differ; rewriting adds some."""
    form, states = ExactForm(case[0]), case[1]
    exact = decompose_states(form.arm, states, christoffel=False)["torque"]
    bound = round_off_bounds(form.arm, *states.arrays)["torque"]
    assert np.abs(form.program.run(program_inputs(states)).T - exact).max() <= 8 * bound


@examples(4)
@given(arms(max_joints=4))
def test_written_out_it_is_the_terms(arm):
    """At every state, not at some: coefficient by coefficient."""
    form = ExactForm(arm)
    assert_computes(form.program, form, TERM, TERM.terms(form))


@pytest.mark.parametrize("name", BUILT_IN)
def test_no_formulation_takes_fewer(name):
    arm = load_arm(name)
    folded = [count_cost(method, arm).folded.total for method in METHODS.values()]
    assert ExactForm(arm).operations.total <= min(folded)
    if name == "puma560":  # published: 413, with drives 425
        assert ExactForm(arm).operations.total <= 280
        assert ExactForm(arm, drives=True).operations.total <= 285


SHIPPED = shipped("programs", ".json")


@pytest.mark.parametrize(
    "path", long_but([SHIPPED["puma560-drives"]], SHIPPED.values()), ids=lambda path: path.stem
)
def test_a_shipped_program_is_used_where_it_is_right(path, place):
    """It takes fewer operations than a second finds; another arm of that name gets its own."""
    name, _, drives = path.stem.partition("-")
    arm = load_arm(name)
    program = exact(arm, bool(drives))
    assert [*plain_program(program)] == json.loads(path.read_text())["torque"]
    assert not place.exists()
    heavier = dataclasses.replace(arm.links[-1], mass=1.01 * arm.links[-1].mass)
    other = dataclasses.replace(arm, links=(*arm.links[:-1], heavier))
    searched = exact(other, bool(drives))
    assert plain_program(searched) != plain_program(program)
    assert program.count.total < searched.count.total


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


@pytest.mark.slow
def test_a_scara_takes_few_operations():
    """Its angles add up across the slide: 58 and 59 terms with the roll a run of its own."""
    form = ExactForm(scara())
    assert form.operations.total <= 53
    # The fast profile of Lloyd et al. 2021: the full circle, velocities of 1 and accelerations of 10.
    rng = np.random.default_rng(0)
    q, qd, qdd = (rng.uniform(-x, x, (1000, 4)) for x in (np.pi, 1.0, 10.0))
    model = simplify(scara(), States(q, qd, qdd), "1%")
    assert (model.functions.operations.total, model.operations.total) <= (39, 45)


def test_a_general_arm_of_eight_joints_is_never_written_out():
    form = ExactForm(arm_of(["askew"] * 8, np.random.default_rng(1)))
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


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda steps, outputs: None,
        lambda steps, outputs: {"steps": steps, "outputs": outputs},
        lambda steps, outputs: [steps, None],
        lambda steps, outputs: [steps, [*outputs, 0.0]],
        lambda steps, outputs: [steps, {"a": 1}],
        lambda steps, outputs: [7, outputs],
        lambda steps, outputs: [[*steps, 7], outputs],
        lambda steps, outputs: [[*steps, []], outputs],
        lambda steps, outputs: [[[["input"], "q1"], *steps], outputs],
        lambda steps, outputs: [steps, [True, *outputs[1:]]],
        lambda steps, outputs: [steps, [[], *outputs[1:]]],
        lambda steps, outputs: [steps, outputs, {"solved": True}],
    ],
)
def test_an_entry_of_other_types_is_written_anew(two_link, place, spoilt):
    first = exact(two_link)
    (entry,) = place.iterdir()
    name = entry.name.removesuffix(".gd.json")
    keep(name, [spoilt(*kept(name)[0])])
    assert plain_program(exact(two_link)) == plain_program(first)
    assert kept(name) == json.loads(json.dumps([plain_program(first)]))


def test_it_is_written_once_and_the_same_with_and_without(two_link, place):
    first = exact(two_link)
    assert len(list(place.iterdir())) == 1
    with without_cache():
        assert plain_program(exact(two_link)) == plain_program(first)


def test_what_is_kept_is_what_is_given(two_link, place):
    """Another program, as right but of more operations, in the place of the shortest."""
    exact(two_link)
    (path,) = place.iterdir()
    other = plain_program(ExactForm(two_link).recursion)
    keep(path.name.split(".")[0], [other])
    assert plain_program(exact(two_link)) == other


def test_a_wrong_entry_is_not_believed_and_written_anew(two_link, place):
    right = plain_program(exact(two_link))
    (path,) = place.iterdir()
    before, name = path.read_bytes(), path.name.split(".")[0]
    numbers = [(k, j) for k, step in enumerate(right[0]) for j, x in enumerate(step) if isinstance(x, float)]
    steps = [list(step) for step in right[0]]
    k, j = numbers[0]
    steps[k][j] *= 1.0 + 1e-6
    renamed = [["input", "q9"] if step == ["input", "q1"] else step for step in right[0]]
    for wrong in ([steps, right[1]], [renamed, right[1]], [right, right], before[:-1], b"[" * 10_000):
        if isinstance(wrong, bytes):
            path.write_bytes(wrong)
        else:
            keep(name, wrong)
        assert path.read_bytes() != before
        assert plain_program(exact(two_link)) == right
        assert path.read_bytes() == before


# Ratios of coefficients count as equal within 1e-12, and a term passes through a few of them; given weights
# count as equal within 1e-9, but those drawn here are equal or far apart.
ROUND_OFF = 1e-11

FUNCTIONS = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
WEIGHTS = (1.0, -1.0, 2.0, 0.5, 0.7, -0.7, 1.4, 1e-3)


@st.composite
def term_sets(draw):
    """An arm's absolute velocities, and some torque terms of random velocities and products: many alike."""
    arm = load_arm(draw(st.sampled_from(BUILT_IN)))
    velocities = AbsoluteVelocities.of(arm)
    n = velocities.n_joints
    factors = []
    for run in velocities.runs:
        turns = arm.is_revolute[run[0]]
        for within in itertools.product(range(-2, 3) if turns else (1,), repeat=len(run)):
            # Of an angle and its negative one is enough.
            if next((m for m in within if m), 0) > 0:
                multiples = tuple(within[run.index(j)] if j in run else 0 for j in range(n))
                factors += [Factor(kind, multiples) for kind in (("cos", "sin") if turns else ("power",))]
    joints = st.integers(0, n - 1)
    moving = st.one_of(
        st.just(()),
        joints.map(lambda j: (Velocity(2, j),)),
        st.tuples(joints, joints).map(lambda pair: tuple(Velocity(1, j) for j in sorted(pair))),
    )
    monomials = st.lists(st.sampled_from(factors), max_size=3).map(lambda chosen: tuple(sorted(chosen)))
    terms = draw(
        st.dictionaries(
            st.builds(TorqueTerm, joints, moving, monomials), st.sampled_from(WEIGHTS), max_size=12
        )
    )
    return velocities, terms


def evaluated(velocities: AbsoluteVelocities, terms, states) -> tuple[np.ndarray, np.ndarray]:
    """Torques by the terms' definition, and the sum of the magnitudes of the terms in each."""
    back = np.linalg.inv(velocities.matrix)
    moving = {1: states.qd @ back.T, 2: states.qdd @ back.T}
    parts = np.zeros((2, *states.q.shape))
    for term, weight in terms.items():
        value = np.full(len(states.q), weight)
        for velocity in term.velocities:
            value = value * moving[velocity.order][:, velocity.joint]
        for kind, multiples in term.monomial:
            value = value * FUNCTIONS[kind](states.q @ np.array(multiples, dtype=float))
        parts[0, :, term.row] += value
        parts[1, :, term.row] += np.abs(value)
    return parts[0] @ back, parts[1] @ np.abs(back)


@examples(20)
@given(term_sets())
def test_every_way_has_the_value_of_the_terms(case):
    velocities, terms = case
    states = random_states(velocities.n_joints, 20, 5)
    wanted, scale = evaluated(velocities, terms, states)
    programs = {effort: torque_program(velocities, terms, effort) for effort in (ROUGH, COUNTING, FINAL)}
    for program in programs.values():
        assert (np.abs(program.run(program_inputs(states)).T - wanted) <= ROUND_OFF * scale).all()
    # More effort holds what less effort finds against something else.
    assert programs[FINAL].count.total <= min(programs[effort].count.total for effort in (ROUGH, COUNTING))


@pytest.mark.parametrize(("name", "fewest"), [("two_link", 22), long("puma560", 580), long("stanford", 460)])
def test_all_terms_of_an_arm_take_few_operations(name, fewest):
    """Extracted once, with a margin of some 5 %; nested, the PUMA takes 639 and the Stanford arm 583."""
    form = ExactForm(load_arm(name))
    assert torque_program(form.velocities, form.torques, FINAL).count.total <= fewest


PRINT = """
from gd_analyze.types import ExactForm
from gd_analyze.simplification.torque_program import FINAL
from gd_analyze.simplification.torque_program import torque_program
from gd_analyze.robots.catalogue import load_arm

form = ExactForm(load_arm("two_link"))
print(torque_program(form.velocities, form.torques, FINAL).outputs)
"""


def test_the_same_program_in_every_process():
    """Python hashes text differently in each; nothing may depend on the order of a set."""
    outputs = {
        subprocess.run(
            [sys.executable, "-c", PRINT],
            env=os.environ | {"PYTHONHASHSEED": seed, VARIABLE: "off"},
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert "sin" in outputs.pop()


def weightless(arm: RobotArm) -> RobotArm:
    return dataclasses.replace(arm, gravity_vector=np.zeros(3))


@pytest.mark.parametrize(
    ("name", "has_gravity"),
    [
        *(("two_link", True), ("puma560", True), ("stanford", True), ("two_link", False)),
        *(
            long(*case)
            for case in (("scara", True), ("puma560", False), ("stanford", False), ("scara", False))
        ),
    ],
)
def test_no_program_is_dearer_than_one_that_follows_from_it_by_folding(name, has_gravity):
    arm = load_arm(name) if has_gravity else weightless(load_arm(name))
    n = arm.n_joints
    form, heavy = ExactForm(arm, bool(arm.drives)), ExactForm(load_arm(name), bool(arm.drives))
    bias = bias_program(form.program, n)
    for program, longer in (
        (form.functions.inertia, inertia_program(form.program, n, symmetric=True)),
        (form.functions.coriolis_centrifugal, motion_program(bias)),
        (form.functions.coriolis_centrifugal, bias),
        (form.functions.gravity_loading, gravity_loading_program(form.program, n)),
        (form.functions.gravity_loading, gravity_loading_program(bias, n)),
        (form.program, heavy.program),
        *zip(form.functions, heavy.functions, strict=True),
    ):
        assert program.count.total <= longer.count.total


@pytest.mark.parametrize("name", ["two_link", long("puma560"), long("stanford")])
def test_d_and_h_do_not_depend_on_gravity_nor_h_and_c_on_drives(name):
    arm = load_arm(name)
    for drives in sorted({False, bool(arm.drives)}):
        level = ExactForm(arm, drives).functions
        for gravity in ((0.0, 0.0, 9.8062), (9.8062, 0.0, 0.0), (3.0, 1.0, -9.0)):
            turned = ExactForm(dataclasses.replace(arm, gravity_vector=np.array(gravity)), drives).functions
            assert turned.inertia.count.total <= level.inertia.count.total
            assert turned.coriolis_centrifugal.count.total <= level.coriolis_centrifugal.count.total
        links = ExactForm(arm).functions
        assert level.coriolis_centrifugal.count.total <= links.coriolis_centrifugal.count.total
        assert level.gravity_loading.count.total <= links.gravity_loading.count.total


def test_a_program_that_is_the_exact_one_has_the_exact_functions(two_link, swing):
    """At any level."""
    exact = ExactDynamics.of(two_link, swing)
    for level in LEVELS.values():
        model = exactly(exact, level, exact.peak_torque, "100%")
        assert model.functions.operations == exact.form.functions.operations


@examples(6)
@given(arms_with_states(max_joints=4))
def test_d_h_and_c_of_their_own_programs_add_up_to_the_torque(case):
    """By terms, by folding and by degree: three ways, and the recursion that none of them runs."""
    arm, states = case
    form = ExactForm(arm)
    inputs = program_inputs(states)
    parts = [program.run(inputs).T for program in form.functions]
    inertia = parts[0].reshape(-1, arm.n_joints, arm.n_joints)
    torque = np.einsum("tij,tj->ti", inertia, states.qdd) + parts[1] + parts[2]
    recursion = form.recursion.run(inputs).T
    # Rearranging changes rounding by some tens of eps of the largest torque.
    np.testing.assert_allclose(torque, recursion, rtol=0, atol=1e-12 * np.abs(recursion).max())
    motion = motion_program(form.recursion).run(inputs).T
    without = ExactForm(weightless(arm)).recursion.run(inputs).T
    np.testing.assert_allclose(motion, without, rtol=0, atol=1e-12 * np.abs(recursion).max())
