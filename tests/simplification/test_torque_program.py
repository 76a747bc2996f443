"""Programs of torque terms: the terms' own values, and fewer operations for more effort."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Factor, TorqueTerm, Velocity
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.cache import VARIABLE, without_cache
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH, Effort
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.program_cache import kept_programs
from gd_analyze.simplification.torque_program import torque_program, torque_programs
from strategies import examples, random_states

# Ratios of coefficients count as equal within 1e-12, and a term passes through a few of them; given weights
# count as equal within 1e-9, but those drawn here are equal or far apart.
ROUND_OFF = 1e-11

ARMS = ("puma560", "stanford", "two_link")
FUNCTIONS = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
EFFORTS = (ROUGH, COUNTING, THOROUGH)
WEIGHTS = (1.0, -1.0, 2.0, 0.5, 0.7, -0.7, 1.4, 1e-3)


@st.composite
def term_sets(draw):
    """An arm's absolute velocities, and some torque terms of random velocities and products: many alike."""
    arm = load_arm(draw(st.sampled_from(ARMS)))
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


def run(program, states) -> np.ndarray:
    named = (("q", states.q), ("qd", states.qd), ("qdd", states.qdd))
    return program.run({f"{name}{i + 1}": row for name, array in named for i, row in enumerate(array.T)}).T


def assert_ways_agree(velocities: AbsoluteVelocities, terms) -> None:
    states = random_states(velocities.n_joints, 20, 5)
    wanted, scale = evaluated(velocities, terms, states)
    programs = {effort: torque_program(velocities, terms, effort) for effort in EFFORTS}
    for program in programs.values():
        assert (np.abs(run(program, states) - wanted) <= ROUND_OFF * scale).all()
    # More effort holds what less effort finds against something else.
    assert programs[THOROUGH].count.total <= min(programs[effort].count.total for effort in (ROUGH, COUNTING))


@examples(20)
@given(term_sets())
def test_every_way_has_the_value_of_the_terms(case):
    assert_ways_agree(*case)


@pytest.mark.parametrize(("name", "fewest"), [("two_link", 22), ("puma560", 580), ("stanford", 460)])
def test_all_terms_of_an_arm_take_few_operations(name, fewest):
    """Extracted once, with a margin of some 5 %; nested, the PUMA takes 639 and the Stanford arm 583."""
    form = ExactForm(load_arm(name))
    assert torque_program(form.velocities, form.torques, Effort(600)).count.total <= fewest


def test_the_order_of_the_terms_does_not_matter():
    form = ExactForm(load_arm("two_link"))
    backwards = dict(reversed(form.torques.items()))
    for effort in EFFORTS:
        written = []
        for terms in (form.torques, backwards):
            kept_programs.cache_clear()
            with without_cache():
                written.append(repr(torque_program(form.velocities, terms, effort).outputs))
        assert written[0] == written[1]


@examples(10)
@given(term_sets(), st.data())
def test_written_step_by_step_they_have_the_value_of_the_terms(case, data):
    velocities, terms = case
    order = data.draw(st.permutations(sorted(terms)))
    ends = sorted(data.draw(st.lists(st.integers(0, len(order)), min_size=1, max_size=4, unique=True)))
    steps = [{term: terms[term] for term in order[:end]} for end in ends]
    states = random_states(velocities.n_joints, 20, 5)
    programs = torque_programs(velocities, steps, 10_000)
    assert len(programs) == len(steps)
    for program, some in zip(programs, steps, strict=True):
        wanted, scale = evaluated(velocities, some, states)
        assert (np.abs(run(program, states) - wanted) <= ROUND_OFF * scale).all()


@pytest.mark.slow
def test_steps_end_before_the_first_that_takes_too_many_operations():
    form = ExactForm(load_arm("puma560"))
    listed = [*form.torques.items()]
    steps = [dict(listed[:count]) for count in (20, 25, 30, 35)]
    counts = [program.count.total for program in torque_programs(form.velocities, steps, 10_000)]
    assert counts == sorted(counts)
    # As thorough as each written by itself, but for what goes on from the one before: 10 % at most.
    alone = [torque_program(form.velocities, terms, THOROUGH).count.total for terms in steps]
    assert sum(counts) <= 1.1 * sum(alone)
    for most in (counts[0] - 1, counts[1], counts[-1]):
        fewer = [program.count.total for program in torque_programs(form.velocities, steps, most)]
        assert fewer == [count for count in counts if count <= most]


PRINT = """
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.torque_program import torque_program, torque_programs
from gd_analyze.robots.catalogue import load_arm

form = ExactForm(load_arm("two_link"))
print(torque_program(form.velocities, form.torques, THOROUGH).outputs)
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
