"""The text's own terms: which are there, what each one is, and what they add up to."""

from __future__ import annotations

import numpy as np
from hypothesis import given

from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from strategies import arms_with_states, examples


def itemised(arm, q, qd):
    return dalembert.coriolis_centrifugal_by_link(arm, solve_kinematics(arm, q), qd)


def test_terms_of_an_arm_of_revolute_joints(puma):
    effects = {term.name: term.effect for term in dalembert.terms_of(puma)}
    assert list(effects) == ["T1", "T2", "T3", "T4", "R1", "R2"]
    assert set(list(effects.values())[:4]) == {"translation"}
    assert set(list(effects.values())[4:]) == {"rotation"}


@examples(30)
@given(arms_with_states())
def test_a_link_acts_on_no_joint_beyond_it(case):
    arm, states = case
    q, qd, _ = states.last
    terms = itemised(arm, q, qd)
    for s in range(arm.n_joints):
        assert not terms[:, s, s + 1 :].any()
    assert len(terms) == (6 if all(arm.is_revolute) else 7)


@examples(30)
@given(arms_with_states(revolute=True))
def test_purely_coriolis_terms_vanish_when_one_joint_moves(case):
    """T2, T4 and R1 need two different rates; T1, T3, R2 are centrifugal too."""
    arm, states = case
    q, qd, _ = states.last
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["coriolis_centrifugal"]
    for j in range(arm.n_joints):
        terms = itemised(arm, q, qd * (np.arange(arm.n_joints) == j)[:, None])
        for t in (1, 3, 4):
            # b is sums of z x z, zero to the last bit for a cross product with itself.
            assert np.abs(terms[t]).max() <= bound


@examples(30)
@given(arms_with_states(max_joints=3))
def test_terms_of_the_first_link_are_its_own(case):
    """Nothing lies below link 1: T1 and T2 of it are zero, and it alone cannot make Coriolis forces."""
    arm, states = case
    q, qd, _ = states.last
    terms = itemised(arm, q, qd)
    assert not terms[:2, 0].any()
    assert not terms[3, 0].any()
    assert not terms[4, 0].any()
