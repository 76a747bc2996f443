"""Models made of harmonic terms: exact programs, honest counts, and sound mechanics at the energy level."""

from __future__ import annotations

import numpy as np
import pytest
from harmonic_models import ROUND_OFF, exact_model
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.lagrangian import literals
from gd_analyze.models import HarmonicModel
from gd_analyze.operations import Expression
from gd_analyze.robots import load_arm
from gd_analyze.simplification import simplify
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.states import States, states_in_box
from strategies import arms_with_states, examples, random_states


@pytest.fixture(scope="module")
def puma_energy(puma) -> HarmonicModel:
    """At 1 % with drives: what the energy level is for."""
    return simplify(puma, states_in_box(puma), level="energy", drives=True)


def assert_exact(arm, states, drives: bool = False) -> None:
    model = exact_model(arm, drives)
    q, qd, qdd = states.q, states.qd, states.qdd
    numeric = decompose_states(arm, q, qd, qdd, coupling=False, drives=drives)
    inertia = numeric["inertia"].sum(axis=1) + (np.diag(arm.drive_inertia) if drives else 0.0)
    pairs = [
        (model.torque(q, qd, qdd), numeric["torque"]),
        (model.coriolis_centrifugal(q, qd), numeric["coriolis_centrifugal"].sum(axis=1)),
        (model.gravity_loading(q), numeric["gravity_loading"]),
        (model.inertia(q), inertia),
    ]
    scale = np.abs(numeric["torque"]).max()
    for found, wanted in pairs:
        assert found.shape == wanted.shape
        assert np.abs(found - wanted).max() <= ROUND_OFF * max(scale, np.abs(wanted).max())


@pytest.mark.parametrize(
    ("name", "drives"), [("puma560", False), ("puma560", True), ("stanford", False), ("two_link", False)]
)
def test_the_programs_of_all_terms_are_exact(name, drives):
    arm = load_arm(name)
    assert_exact(arm, random_states(arm.n_joints, 20, 3), drives)


@examples(12)
@given(arms_with_states(max_joints=4))
def test_of_any_arm(case):
    assert_exact(*case)


def test_two_rods_take_few_operations(two_link):
    assert exact_model(two_link).operations.total <= 22


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


def test_the_count_is_that_of_the_program(puma_energy):
    for model in (puma_energy, exact_model(load_arm("stanford"))):
        counted = recount(model.programs["torque"].outputs)
        assert vars(model.operations) == counted
        assert model.operations.total == counted["multiplications"] + counted["additions"]


def test_states_of_any_leading_shape(two_link):
    model = exact_model(two_link)
    states = random_states(2, 6, 0)
    flat = model.torque(states.q, states.qd, states.qdd)
    again = model.torque(*(x.reshape(2, 3, 2) for x in (states.q, states.qd, states.qdd)))
    np.testing.assert_array_equal(again.reshape(6, 2), flat)
    np.testing.assert_array_equal(model.torque(states.q[0], states.qd[0], states.qdd[0]), flat[0])


def test_states_of_another_arm_are_refused(two_link):
    with pytest.raises(ModelError, match="does not fit the model"):
        exact_model(two_link).gravity_loading(np.zeros((5, 3)))


def slopes(model: HarmonicModel, q: np.ndarray) -> np.ndarray:
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


def assert_mechanical(model: HarmonicModel, q: np.ndarray, qd: np.ndarray) -> None:
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
def test_so_it_is_of_any_arm(case, budget, refit):
    arm, states = case
    model = simplified(arm, states, budget, refit)
    assert_mechanical(model, states.q, states.qd)


def simplified(arm, states, budget: str, refit: bool) -> HarmonicModel:
    given_states = States(
        states.q, states.qd, states.qdd, {"box": "drawn", "states": len(states.q), "seed": 0}
    )
    return simplify(arm, given_states, Budget.parse(budget), level="energy", refit=refit)


def test_the_term_level_is_not(puma):
    """What the check above is able to see."""
    model = simplify(puma, states_in_box(puma, 500), Budget.parse("5%"), drives=True)
    states = states_in_box(puma, 50, 1)
    with pytest.raises(AssertionError):
        assert_mechanical(model, states.q, states.qd)


def test_inertia_is_positive_definite_wherever_looked_for(puma_energy, puma):
    """Shown by search over 20 000 states of the box, not proven for all."""
    inertia = puma_energy.inertia(states_in_box(puma, 20_000, 5).q)
    least = np.linalg.eigvalsh(0.5 * (inertia + inertia.transpose(0, 2, 1)))[:, 0]
    assert least.min() > 0.0


def potential(model: HarmonicModel, q: np.ndarray) -> np.ndarray:
    functions = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
    total = np.zeros(len(q))
    for term in model.energy:
        if term.is_potential:
            value = np.full(len(q), term.coefficient)
            for kind, multiples in literals(term.product):
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
