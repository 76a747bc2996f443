"""Torques of terms, by the joints they act on: together they are the torque, and some are their share."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.effects import Effects
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.tables import decompose_states
from gd_analyze.types import ExactForm, States
from made_models import ROUND_OFF
from parallel_axes import arms_with_runs, of_every_turn
from strategies import arms, examples, random_states


def effects_of(arm, level, states: States, drives: bool = False) -> Effects:
    form = ExactForm(arm, drives)
    return level.term_torques(form, level.terms(form)).at(states).effects()


def scale_of(effects: Effects, exact: FloatArray) -> float:
    """Largest sum of magnitudes at a joint, of which round-off is a share."""
    return max(float(np.abs(effects.dense()).sum(axis=0).max(initial=0.0)), float(np.abs(exact).max()))


@pytest.mark.parametrize("level", [TERM, ENERGY])
@of_every_turn(seed=1)
@examples(16)
@given(arm=st.one_of(arms(max_joints=4), arms_with_runs(max_joints=5)), seed=st.integers(0, 2**32 - 1))
def test_all_terms_together_are_the_torque(arm, seed, level):
    states = random_states(arm.n_joints, 7, seed)
    effects = effects_of(arm, level, states)
    exact = decompose_states(arm, states, christoffel=False)["torque"].T
    total = effects.total(np.ones(effects.count, dtype=bool))
    # Of the magnitudes, as terms of a drawn arm may cancel.
    slack = ROUND_OFF * scale_of(effects, exact)
    assert np.abs(total - exact).max() <= slack
    assert np.abs(effects.dense().sum(axis=0) - exact).max() <= slack


def test_drives_are_terms_of_the_inertia(puma, pick_and_place):
    states = States(pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    exact = decompose_states(puma, states, christoffel=False, drives=True)["torque"].T
    for level in (TERM, ENERGY):
        effects = effects_of(puma, level, states, drives=True)
        total = effects.total(np.ones(effects.count, dtype=bool))
        assert np.abs(total - exact).max() <= ROUND_OFF * scale_of(effects, exact)


@pytest.mark.parametrize("level", [TERM, ENERGY])
@of_every_turn(seed=1)
@examples(8)
@given(
    arm=st.one_of(arms(max_joints=3, massive=True), arms_with_runs(max_joints=4)),
    seed=st.integers(0, 2**32 - 1),
)
def test_parts_of_them_are_what_the_whole_says(arm, seed, level):
    rng, states, form = np.random.default_rng(seed), random_states(arm.n_joints, 5, seed), ExactForm(arm)
    of_terms = level.term_torques(form, level.terms(form))
    torques = of_terms.at(states)
    every, dense = torques.effects(), torques.effects().dense()
    chosen = rng.random(torques.count) < 0.5
    # Sums of the same numbers in another order.
    slack = 1e-13 * np.abs(dense).sum(axis=0).max(initial=1.0)
    assert np.abs(every.total(chosen) - dense[chosen].sum(axis=0)).max() <= slack
    some = rng.permutation(np.flatnonzero(chosen))
    assert np.abs(torques.effects(some).dense() - dense[some]).max(initial=0.0) <= slack
    blocks = [(block, part.dense()) for block, part in torques.in_blocks(40)]
    assert [k for block, _ in blocks for k in range(block.start, block.stop)] == [*range(torques.count)]
    assert np.abs(np.concatenate([part for _, part in blocks]) - dense).max() <= slack
    allowed = rng.uniform(0.1, 10.0, arm.n_joints)
    np.testing.assert_array_equal(every.over(allowed).dense(), dense / allowed[:, None])
    largest = every.largest(np.abs(every.torque).max(axis=1))
    np.testing.assert_array_equal(largest, np.abs(dense).max(axis=(1, 2)))
    more = rng.normal(size=(len(some), len(states)))
    joined = every.joined_by(some, more).dense()
    np.testing.assert_array_equal(joined[:, :-1], dense)
    np.testing.assert_array_equal(joined[some, -1], more)
    assert not joined[~chosen, -1].any()
    weights = rng.uniform(0.5, 2.0, (len(states), arm.n_joints))
    weighty = dataclasses.replace(states, weights=weights)
    weighted = of_terms.at(weighty).effects().dense()
    np.testing.assert_allclose(weighted, dense * weights.T, rtol=1e-15)
    assert np.abs(of_terms.at(weighty).together(some) - weighted[some].sum(axis=0)).max() <= 2.0 * slack
