"""Programs of torque terms: the terms' own values, and fewer operations for more effort."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from harmonic_models import exact_model
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.lagrangian import Rate, TorqueTerm
from gd_analyze.models.harmonic import torques_of_energy
from gd_analyze.models.torque_program import shared_torque, torque_programs
from gd_analyze.robots import load_arm
from strategies import examples, random_states

# Ratios of coefficients count as equal within 1e-12, and a term passes through a few of them; given weights
# count as equal within 1e-9, but those drawn here are equal or far apart.
ROUND_OFF = 1e-11

ARMS = ("puma560", "stanford", "two_link")
FUNCTIONS = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
WEIGHTS = (1.0, -1.0, 2.0, 0.5, 0.7, -0.7, 1.4, 1e-3)


@st.composite
def term_sets(draw):
    """An arm's basis, and some torque terms of random rates and products: many alike, as in an arm."""
    basis = AbsoluteRates.of(load_arm(draw(st.sampled_from(ARMS))))
    n = basis.n_joints
    literals = [
        (kind, tuple(m.multiples[run.joints.index(j)] if j in run.joints else 0 for j in range(n)))
        for run in basis.runs
        for m in run.modes
        if not m.is_one
        for kind in (["power"] if run.sliding else ["cos", "sin"])
        if kind != "power" or m.multiples == (1,)
    ]
    joints = st.integers(0, n - 1)
    rates = st.one_of(
        st.just(()),
        joints.map(lambda j: (Rate(2, j),)),
        st.tuples(joints, joints).map(lambda pair: tuple(Rate(1, j) for j in sorted(pair))),
    )
    monomials = st.lists(st.sampled_from(literals), max_size=3).map(lambda factors: tuple(sorted(factors)))
    terms = draw(
        st.dictionaries(
            st.builds(TorqueTerm, joints, rates, monomials), st.sampled_from(WEIGHTS), max_size=12
        )
    )
    return basis, terms


def evaluated(basis: AbsoluteRates, terms, states) -> tuple[np.ndarray, np.ndarray]:
    """Torques by the terms' definition, and the sum of the magnitudes of the terms in each."""
    back = np.linalg.inv(basis.matrix)
    moving = {1: states.qd @ back.T, 2: states.qdd @ back.T}
    parts = np.zeros((2, *states.q.shape))
    for term, weight in terms.items():
        value = np.full(len(states.q), weight)
        for rate in term.rates:
            value = value * moving[rate.order][:, rate.joint]
        for kind, multiples in term.monomial:
            value = value * FUNCTIONS[kind](states.q @ np.array(multiples, dtype=float))
        parts[0, :, term.row] += value
        parts[1, :, term.row] += np.abs(value)
    return parts[0] @ back, parts[1] @ np.abs(back)


def run(program, states) -> np.ndarray:
    named = (("q", states.q), ("qd", states.qd), ("qdd", states.qdd))
    return program.run({f"{name}{i + 1}": row for name, array in named for i, row in enumerate(array.T)}).T


def assert_ways_agree(basis: AbsoluteRates, terms) -> None:
    states = random_states(basis.n_joints, 20, 5)
    wanted, scale = evaluated(basis, terms, states)
    quick, thorough = (torque_programs(basis, terms, thorough=t) for t in (False, True))
    once = shared_torque(basis, terms)
    for program in (quick["torque"], once, thorough["torque"]):
        assert (np.abs(run(program, states) - wanted) <= ROUND_OFF * scale).all()
    for name in ("coriolis_centrifugal", "gravity_loading"):
        chosen = {term: weight for term, weight in terms.items() if term.quantity == name}
        wanted, scale = evaluated(basis, chosen, states)
        assert (np.abs(run(thorough[name], states) - wanted) <= ROUND_OFF * scale).all()
    assert thorough["torque"].count.total <= min(quick["torque"].count.total, once.count.total)


@examples(40)
@given(term_sets())
def test_every_way_has_the_value_of_the_terms(case):
    assert_ways_agree(*case)


def test_so_it_is_for_a_whole_arm():
    arm = load_arm("puma560")
    assert_ways_agree(AbsoluteRates.of(arm), exact_model(arm).torques)


def test_rows_of_parallel_joints_are_passed_on():
    """Torque on the outer of two parallel joints loads the inner one alike."""
    arm = load_arm("two_link")
    outer = TorqueTerm(1, (Rate(2, 0),), ())
    states = random_states(2, 3, 1)
    torque = run(torque_programs(AbsoluteRates.of(arm), {outer: 2.0})["torque"], states)
    np.testing.assert_array_equal(torque[:, 0], torque[:, 1])
    np.testing.assert_array_equal(torque[:, 1], 2.0 * states.qdd[:, 0])


@pytest.mark.parametrize(
    ("name", "fewest"),
    [("two_link", 22), ("puma560", 580), ("stanford", 460)],
)
def test_all_terms_of_an_arm_take_few_operations(name, fewest):
    """Extracted once, with a margin of some 5 %; nested, the PUMA takes 639 and the Stanford arm 583."""
    arm = load_arm(name)
    assert shared_torque(AbsoluteRates.of(arm), exact_model(arm).torques).count.total <= fewest


def test_no_terms_are_no_torque():
    basis = AbsoluteRates.of(load_arm("two_link"))
    program = torque_programs(basis, {})["torque"]
    assert program.count.total == 0
    np.testing.assert_array_equal(run(program, random_states(2, 3, 1)), np.zeros((3, 2)))


def test_the_order_of_the_terms_does_not_matter():
    arm = load_arm("two_link")
    basis, terms = AbsoluteRates.of(arm), torques_of_energy(arm, exact_model(arm).energy)
    backwards = dict(reversed(terms.items()))
    one, other = (repr(torque_programs(basis, t)["torque"].outputs) for t in (terms, backwards))
    assert one == other


PRINT = """
from gd_analyze.harmonics import harmonics_of
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.models.harmonic import torques_of_energy
from gd_analyze.models.torque_program import torque_programs
from gd_analyze.robots import load_arm

arm = load_arm("two_link")
terms = torques_of_energy(arm, energy_terms(harmonics_of(arm)))
print(torque_programs(AbsoluteRates.of(arm), terms)["torque"].outputs)
"""


def test_the_same_program_in_every_process():
    """Python hashes text differently in each; nothing may depend on the order of a set."""
    outputs = {
        subprocess.run(
            [sys.executable, "-c", PRINT],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert "sin" in outputs.pop()
