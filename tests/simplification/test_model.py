"""Models: quantities and shapes, D, h and c as their own programs, and mechanical systems."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from few_tries import few_tries
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import ModelError
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.element import model_by_verdicts, parts_of
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.model_torque import model_torque
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.tables import decompose_states, states_in_box, states_of
from gd_analyze.types import LEVELS, Budget, Drive, ExactDynamics, SimplifiedModel, States
from made_models import ROUND_OFF, exact_model, model_of_parts, searched
from strategies import arms_with_states, examples, random_states


@pytest.fixture(scope="module", params=LEVELS)
def model(request, two_link, swing) -> SimplifiedModel:
    exact, how = ExactDynamics.of(two_link, swing), SearchOptions(LEVELS[request.param])
    return model_by_verdicts(exact) if request.param == "element" else searched(exact, "90%", how)


@examples(12)
@given(arms_with_states(max_joints=4), st.integers(0, 2**32 - 1))
def test_a_model_is_the_sum_of_what_it_keeps(case, seed):
    (arm, states), rng = case, np.random.default_rng(seed)
    parts, effects = parts_of(arm.n_joints), ("translation", "rotation")
    kept = {part for part in parts if rng.random() < 0.5}
    model = model_of_parts(arm, [part.label for part in kept])
    found = decompose_states(arm, states)
    for part in {*parts} - kept:
        (i, j), e = (part.element.i, part.element.j), effects.index(part.effect)
        if part.element.quantity == "gravity_loading":
            found["gravity_loading"][:, i] = 0.0
        elif j is None:
            found["coriolis_centrifugal"][:, e, i] = 0.0
        else:
            found["inertia"][:, e, [i, j], [j, i]] = 0.0
    inertia, h = (found[name].sum(axis=1) for name in ("inertia", "coriolis_centrifugal"))
    c = found["gravity_loading"]
    torque = np.einsum("tij,tj->ti", inertia, states.qdd) + h + c
    bounds = round_off_bounds(arm, *states.arrays)  # two correct programs
    assert np.abs(model.inertia(states.q) - inertia).max() <= bounds["inertia"]
    assert np.abs(model.coriolis_centrifugal(states.q, states.qd) - h).max() <= bounds["coriolis_centrifugal"]
    assert np.abs(model.gravity_loading(states.q) - c).max() <= bounds["gravity_loading"]
    assert np.abs(model.torque(*states.arrays) - torque).max() <= bounds["torque"]


def test_leading_axes(model):
    states = random_states(2, 6, 9)
    flat = model.torque(*states.arrays)
    nested = model.torque(*(x.reshape(2, 3, 2) for x in states.arrays))
    np.testing.assert_array_equal(nested.reshape(6, 2), flat)
    single = model.torque(states.q[2], states.qd[2], states.qdd[2])
    assert single.shape == (2,)
    # cos and sin of one number and of several may take different paths: an ulp, as between two programs.
    assert np.abs(single - flat[2]).max() <= round_off_bounds(model.arm, *states.arrays)["torque"]
    assert model.inertia(states.q[2]).shape == (2, 2)
    assert model.inertia(states.q.reshape(2, 3, 2)).shape == (2, 3, 2, 2)
    assert model.gravity_loading(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("shape", [(), (4, 5)])
def test_states_of_another_arm_are_refused(model, shape):
    with pytest.raises(ModelError) as caught:
        model.gravity_loading(np.zeros(shape))
    assert caught.value.details["expected"] == "shape (..., 2)"
    assert caught.value.details["found"] == str(shape)


def test_error_table_by_hand():
    table = ErrorTable.of(np.array([[1.0, 0.0], [-4.0, 0.0]]), np.array([[1.0, 2.0], [-1.0, 0.0]]))
    assert table.peak_torque.tolist() == [4.0, 0.0]
    assert table.largest.tolist() == [3.0, 2.0]
    assert table.rms.tolist() == [np.sqrt(4.5), np.sqrt(2.0)]
    assert table.largest_share.tolist() == [0.75, np.inf]
    exact = np.array([[1000.0, 0.0]])
    assert not ErrorTable.of(exact, exact + 1e-10).largest.any()  # round-off
    assert ErrorTable.of(exact, exact + 1e-8).largest.all()


def test_it_errs_by_what_it_promises_where_it_was_made(model, swing):
    found = model_torque(model, swing)
    np.testing.assert_array_equal(found.errors.largest, model.accuracy.errors.largest)
    assert found.within(model.promised(model.accuracy)).all()
    assert not found.within(0 * model.accuracy.allowed).all()
    assert model.accuracy.fitted_on == states_of(swing).described


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


@pytest.mark.parametrize("level", LEVELS.values(), ids=str)
@examples(3)
@given(case=arms_with_states(max_joints=3), drives=st.booleans())
def test_so_it_is_of_any_arm(case, level, drives):
    arm, states = case
    arm = dataclasses.replace(arm, drives=tuple(Drive(0.1 * (i + 1)) for i in range(arm.n_joints)))
    model = exact_model(arm, drives, level)
    numeric = decompose_states(arm, states, christoffel=False, drives=drives)
    inertia = numeric["inertia"].sum(axis=1) + (np.diag(arm.drive_inertia) if drives else 0.0)
    h, c, torque = numeric["coriolis_centrifugal"].sum(axis=1), numeric["gravity_loading"], numeric["torque"]
    found = (model.torque(*states.arrays), *quantities(model, states))
    for one, wanted in zip(found, (torque, inertia, h, c), strict=True):
        assert one.shape == wanted.shape
        assert np.abs(one - wanted).max() <= ROUND_OFF * max(np.abs(torque).max(), np.abs(wanted).max())
    assert_adds_up(model, states)


# Level element may miss its budget.
BUDGETS = [(level, budget) for level in LEVELS for budget in ("1%", "20%", "60%") if level != "element"]


@pytest.mark.parametrize(("level", "budget"), [("element", None), *BUDGETS])
@examples(3)
@given(case=arms_with_states(max_joints=3, massive=True, count=10))
@few_tries()
def test_a_simplified_model_adds_up_as_well(case, level, budget):
    arm, states = case
    how = SearchOptions(LEVELS[level], thorough=False)
    exact = ExactDynamics.of(arm, states)
    model = model_by_verdicts(exact) if level == "element" else simplify_exact(exact, budget, how)
    assert_adds_up(model, states)
    assert_adds_up(model, random_states(arm.n_joints, 10, 7))


def slopes(f, arm, q: np.ndarray) -> np.ndarray:
    """Exact df/dq_k of shape (N, n, ...), without small differences.

    D and potential are of second degree in every joint variable. For a trigonometric polynomial of degree 2
    Riesz's formula gives the slope from four values, f'(q) = 1/8 sum_k (-1)^(k+1) f(q + t_k) / sin^2(t_k /
    2), t_k = (2k-1) pi/4; for a sliding joint's parabola half the difference over -1 and 1 does.
    """
    out = []
    for k in range(arm.n_joints):
        step = np.eye(arm.n_joints)[k]
        if arm.is_revolute[k]:
            turns = (2 * np.arange(1, 5) - 1) * np.pi / 4
            weights = np.array([1, -1, 1, -1]) / np.sin(turns / 2) ** 2 / 8
            out.append(sum(w * f(q + t * step) for w, t in zip(weights, turns, strict=True)))
        else:
            out.append((f(q + step) - f(q - step)) / 2)
    return np.stack(out, axis=1)


def assert_mechanical(model: SimplifiedModel, q: np.ndarray, qd: np.ndarray) -> None:
    """D symmetric, h = C qd with the Christoffel symbols of its own D, c the slope of its own potential."""
    inertia = model.inertia(q)
    d = slopes(model.inertia, model.arm, q)
    speed = np.abs(qd).max()
    # Riesz's weights sum to 2, and n^2 slopes of D make a row of h.
    scale = np.abs(inertia).max() * model.arm.n_joints**2
    assert np.abs(inertia - inertia.transpose(0, 2, 1)).max() <= ROUND_OFF * scale
    coriolis = 0.5 * (
        np.einsum("tkij,tk->tij", d, qd) + np.einsum("tjik,tk->tij", d, qd) - np.einsum("tijk,tk->tij", d, qd)
    )
    h = model.coriolis_centrifugal(q, qd)
    assert np.abs(h - np.einsum("tij,tj->ti", coriolis, qd)).max() <= ROUND_OFF * scale * speed**2
    # The same said without C: what h does to the energy is what D's change does.
    power = np.einsum("ti,tkij,tk,tj->t", qd, d, qd, qd) - 2 * np.einsum("ti,ti->t", qd, h)
    assert np.abs(power).max() <= ROUND_OFF * scale * speed**3
    load = slopes(lambda q: potential(model, q), model.arm, q)
    size = sum(abs(coefficient) for term, coefficient in model.terms.items() if term.is_potential)
    assert np.abs(model.gravity_loading(q) - load).max() <= ROUND_OFF * size


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


def test_the_energy_level_is_a_mechanical_system(puma_energy, puma):
    assert 0 < puma_energy.operations.total < puma_energy.operations_full.total
    states = states_in_box(puma, 50, 1)
    assert_mechanical(puma_energy, states.q, states.qd)


@pytest.mark.parametrize("budget", ["1%", "10%", "40%"])
@examples(3)
@given(case=arms_with_states(max_joints=3, massive=True))
@few_tries()
def test_so_it_is_of_any_arm_mechanical_systems(case, budget):
    arm, states = case
    how = SearchOptions(ENERGY, thorough=False)
    model = simplify_exact(ExactDynamics.of(arm, states), Budget.parse(budget), how)
    assert_mechanical(model, states.q, states.qd)
