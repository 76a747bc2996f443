"""Models at the energy level are mechanical systems; those at the term level are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from few_tries import few_tries
from gd_analyze.motions.states import states_in_box
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from made_models import ROUND_OFF
from strategies import arms_with_states, examples


def slopes(model: SimplifiedModel, q: np.ndarray) -> np.ndarray:
    """Exact dD/dq_k of shape (N, n, n, n), k first, without small differences.

    D is of second degree in every joint variable. For a trigonometric polynomial of degree 2, Riesz's formula
    gives the slope from four values, f'(q) = 1/8 sum_k (-1)^(k+1) f(q + t_k) / sin^2(t_k / 2), t_k = (2k-1)
    pi/4; for a sliding joint's parabola half the difference over -1 and 1 does.
    """
    out = []
    for k in range(model.arm.n_joints):
        step = np.eye(model.arm.n_joints)[k]
        if model.arm.is_revolute[k]:
            turns = (2 * np.arange(1, 5) - 1) * np.pi / 4
            weights = np.array([1, -1, 1, -1]) / np.sin(turns / 2) ** 2 / 8
            out.append(sum(w * model.inertia(q + t * step) for w, t in zip(weights, turns, strict=True)))
        else:
            out.append((model.inertia(q + step) - model.inertia(q - step)) / 2)
    return np.stack(out, axis=1)


def assert_mechanical(model: SimplifiedModel, q: np.ndarray, qd: np.ndarray) -> None:
    """D symmetric, h = C qd with the Christoffel symbols of the model's own D, dD/dt - 2C skew."""
    inertia = model.inertia(q)
    d = slopes(model, q)
    speed = np.abs(qd).max()
    # Riesz's weights sum to 2, and n^2 slopes of D make a row of h.
    scale = np.abs(inertia).max() * model.arm.n_joints**2
    assert np.abs(inertia - inertia.transpose(0, 2, 1)).max() <= ROUND_OFF * scale
    coriolis = 0.5 * (
        np.einsum("tkij,tk->tij", d, qd) + np.einsum("tjik,tk->tij", d, qd) - np.einsum("tijk,tk->tij", d, qd)
    )
    h = model.coriolis_centrifugal(q, qd)
    assert np.abs(h - np.einsum("tij,tj->ti", coriolis, qd)).max() <= ROUND_OFF * scale * speed**2
    skew = np.einsum("tkij,tk->tij", d, qd) - 2 * coriolis
    assert np.abs(skew + skew.transpose(0, 2, 1)).max() <= ROUND_OFF * scale * speed
    # The same said without C: what h does to the energy is what D's change does.
    power = np.einsum("ti,tkij,tk,tj->t", qd, d, qd, qd) - 2 * np.einsum("ti,ti->t", qd, h)
    assert np.abs(power).max() <= ROUND_OFF * scale * speed**3


def test_the_energy_level_is_a_mechanical_system(puma_energy, puma):
    assert 0 < puma_energy.operations.total < puma_energy.operations_full.total
    states = states_in_box(puma, 50, 1)
    assert_mechanical(puma_energy, states.q, states.qd)


@examples(8)
@given(arms_with_states(max_joints=3, massive=True), st.sampled_from(["1%", "10%", "40%"]), st.booleans())
@few_tries()
def test_so_it_is_of_any_arm(case, budget, refit):
    arm, states = case
    how = SearchOptions(ENERGY, refit=refit, thorough=False)
    model = simplify_exact(ExactDynamics.of(arm, states), Budget.parse(budget), how)
    assert_mechanical(model, states.q, states.qd)


def test_the_term_level_is_not(puma):
    """What the check above is able to see."""
    exact = ExactDynamics.of(puma, states_in_box(puma, 200), drives=True)
    model = simplify_exact(exact, Budget.parse("5%"), SearchOptions(TERM, thorough=False))
    states = states_in_box(puma, 50, 1)
    with pytest.raises(AssertionError):
        assert_mechanical(model, states.q, states.qd)


def test_inertia_is_positive_definite_wherever_looked_for(puma_energy, puma):
    """Shown by search over 20 000 states of the box, not proven for all."""
    inertia = puma_energy.inertia(states_in_box(puma, 20_000, 5).q)
    least = np.linalg.eigvalsh(0.5 * (inertia + inertia.transpose(0, 2, 1)))[:, 0]
    assert least.min() > 0.0


def potential(model: SimplifiedModel, q: np.ndarray) -> np.ndarray:
    functions = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
    total = np.zeros(len(q))
    for term, coefficient in model.terms.items():
        if term.is_potential:
            value = np.full(len(q), coefficient)
            for kind, multiples in term.monomial:
                value = value * functions[kind](q @ np.array(multiples, dtype=float))
            total += value
    return total


def test_a_swing_keeps_the_models_own_energy(puma_energy):
    model, n = puma_energy, puma_energy.arm.n_joints

    def rhs(_, y: np.ndarray) -> np.ndarray:
        q, qd = y[:n], y[n:]
        load = model.coriolis_centrifugal(q, qd) + model.gravity_loading(q)
        return np.concatenate([qd, np.linalg.solve(model.inertia(q), -load)])

    start = np.concatenate([[0.3, -0.8, 1.0, 0.4, -0.6, 0.2], [1.0, -0.5, 1.5, 2.0, -1.0, 0.5]])
    swing = solve_ivp(rhs, (0.0, 0.5), start, method="DOP853", rtol=1e-10, atol=1e-12)
    q, qd = swing.y[:n].T, swing.y[n:].T
    kinetic = 0.5 * np.einsum("ti,tij,tj->t", qd, model.inertia(q), qd)
    energy = kinetic + potential(model, q)
    assert np.ptp(kinetic) > 1.0  # J: it swings
    # The integrator errs by 1e-10 of a state per step, in some hundred steps, times the largest torque.
    steps, torque = len(swing.t), np.abs(model.gravity_loading(q)).max()
    assert np.abs(energy - energy[0]).max() <= 1e-10 * steps * max(torque, np.abs(energy).max())
