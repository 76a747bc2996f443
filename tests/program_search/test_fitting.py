"""Numbers of programs: derivatives of errors, a step of least squares, and a refit."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drawn_nodes import (
    EPS,
    FIRST,
    LAYOUT,
    Drawn,
    Evaluated,
    Step,
    drawn,
    evaluated,
    nodes_of,
    scratch_of,
    states,
)
from gd_analyze.arrays import FloatArray
from gd_analyze.program_search.layout import SCALED, SUM, Nodes, copied
from strategies import examples
from uncompiled import canonical, guarded, kernels

seeds = st.integers(0, 2**32 - 1)
STATES, FEW = 24, 10
# Most factors of a summand, of which each may be a multiple of the same number, and some more from folding.
FACTORS = 12


class Fitted(NamedTuple):
    """A canonical program, its memory, states with outputs of a program like it, and its values there."""

    nodes: Nodes
    memory: Any
    active: Any
    exact: Evaluated


def fitted(program: Any, seed: int) -> Fitted:
    found = canonical(nodes_of(program), LAYOUT.about)
    assert found is not None
    nodes, rng, inputs = found[0], np.random.default_rng(seed), states(seed, STATES)
    exact = evaluated(nodes, LAYOUT.values(inputs))
    shape = exact.outputs.shape
    scale = rng.uniform(0.1, 10.0, (len(shape), 1)) * rng.uniform(0.5, 2.0, shape)
    targets = exact.outputs + rng.normal(scale=0.1, size=shape)
    memory, active = scratch_of(nodes, inputs, targets, scale, FEW)
    return Fitted(nodes, memory, active, exact)


def largest_error(case: Fitted, nodes: Nodes) -> float:
    kernels.evaluate_nodes(nodes, case.active.values, FIRST, 0, STATES)
    sample = case.active
    return kernels.errors(nodes, sample.values, sample.targets, sample.scale, 0, STATES, sample.errors)


def with_slopes(case: Fitted) -> Any:
    """Derivatives at the few states, which are the first."""
    largest_error(case, case.nodes)
    kernels.slopes_at(case.nodes, case.active.values, case.active.scale, FIRST, case.memory.chord)
    return case.memory.chord


def dense_slopes(fit: Any) -> FloatArray:
    """Derivatives by all numbers, shape (outputs, states, numbers)."""
    dense = np.zeros((*fit.slopes.shape[:2], int(fit.total[0])))
    for row, size in enumerate(fit.sizes):
        members = fit.members[row, :size]
        assert len(set(members.tolist())) == size
        dense[row][:, members] = fit.slopes[row, :, :size]
    return dense


@examples(60)
@given(drawn(), seeds)
def test_errors_are_weighted_differences(program, seed):
    case = fitted(program, seed)
    largest = largest_error(case, case.nodes)
    expected = (case.exact.outputs - case.active.targets) * case.active.scale
    np.testing.assert_array_equal(case.active.errors, expected)
    assert largest == np.abs(expected).max()


@examples(60)
@given(drawn(zeros=False), seeds)
def test_slopes_are_derivatives_by_relative_changes(program, seed):
    """A step along the imaginary axis gives them without differences."""
    case = fitted(program, seed)
    fit = with_slopes(case)
    nodes, step = case.nodes, 1e-30
    numbers = [place for place in range(FIRST, int(nodes.length[0])) if nodes.kind[place] == SCALED]
    assert [fit.numbers[place] for place in numbers] == [*range(len(numbers))]
    assert int(fit.total[0]) == len(numbers)
    slopes, scale = dense_slopes(fit), case.active.scale[:, :FEW]
    leaf_values = case.active.values[:FIRST, :FEW]
    # A derivative has the summands of the output, each as often as the number is a factor of it.
    allowed = 4 * FACTORS * case.exact.output_rounding[:, :FEW] * scale
    for index, place in enumerate(numbers):
        factors = np.ones(int(nodes.length[0]), dtype=complex)
        factors[place] += 1j * step
        changed = evaluated(nodes, leaf_values, factors=factors).outputs
        assert (np.abs(slopes[:, :, index] - changed.imag / step * scale) <= allowed).all()


@examples(30)
@given(drawn(most=10, zeros=False, numbers=st.sampled_from([0.5, 2.0, -1.5])), seeds)
def test_slopes_are_differences_of_errors(program, seed):
    case = fitted(program, seed)
    slopes, nodes, width = dense_slopes(with_slopes(case)), case.nodes, EPS ** (1 / 3)
    numbers = [place for place in range(FIRST, int(nodes.length[0])) if nodes.kind[place] == SCALED]
    sizes = case.exact.output_rounding / EPS * case.active.scale
    for index, place in enumerate(numbers):
        sides = []
        for sign in (1.0, -1.0):
            moved = guarded(copied(nodes))
            moved.number[place] *= 1.0 + sign * width
            largest_error(case, moved)
            sides.append(case.active.errors[:, :FEW].copy())
        difference = (sides[0] - sides[1]) / (2.0 * width)
        # Off by a sixth of the third derivative times the square of the step, and by rounding over the step;
        # errors are also rounded as outputs and targets are.
        allowed = (FACTORS**3 / 6.0 * width**2 + 2.0 * EPS / width) * (sizes[:, :FEW] + np.abs(sides[0]))
        assert (np.abs(slopes[:, :, index] - difference) <= allowed).all()


@examples(60)
@given(drawn(zeros=False), seeds)
def test_consequences_are_squared_derivatives_by_values(program, seed):
    case = fitted(program, seed)
    fit = with_slopes(case)
    step, scale = 1e-30, case.active.scale[:, :FEW]
    leaf_values = case.active.values[:FIRST, :FEW]
    sizes = case.exact.output_rounding[:, :FEW] / EPS
    for place in range(FIRST, int(case.nodes.length[0])):
        changed = evaluated(case.nodes, leaf_values, nudged=(place, 1j * step)).outputs
        expected = ((changed.imag / step * scale) ** 2).sum(axis=0)
        # An adjoint sums what multiplies the node in some summands of the output.
        own = np.abs(case.exact.values[place, :FEW])
        parts = ((sizes / np.maximum(own, 1e-3) + 1.0) * scale) ** 2
        assert (np.abs(fit.consequence[place] - expected) <= 1e3 * EPS * parts.sum(axis=0)).all()


@examples(60)
@given(drawn(zeros=False), seeds)
def test_a_step_solves_damped_weighted_least_squares(program, seed):
    case = fitted(program, seed)
    fit, rng = with_slopes(case), np.random.default_rng(seed)
    slopes, total = dense_slopes(fit), int(fit.total[0])
    if total == 0 or not slopes.any():
        return
    # Some states do not count.
    weights = guarded(rng.uniform(0.1, 1.0, (2, FEW)) * (rng.random((2, FEW)) < 0.9))
    errors = case.active.errors[:, :FEW]
    kernels.factor(fit, weights, case.memory.dense)
    kernels.step(fit, errors, weights)
    found = np.asarray(fit.gradient[:total])
    rows = slopes.reshape(-1, total) * np.sqrt(np.asarray(weights)).reshape(-1, 1)
    right = -(np.asarray(errors) * np.sqrt(np.asarray(weights))).ravel()
    damping = kernels.DAMPING * (rows**2).sum(axis=0).max()
    stacked = np.vstack([rows, np.sqrt(damping) * np.eye(total)])
    expected = np.linalg.lstsq(stacked, np.concatenate([right, np.zeros(total)]), rcond=None)[0]
    # Normal equations lose eps times the condition number, at most 1 / DAMPING, of the solution, and what
    # rounding of their right side, a sum over states and outputs, becomes by the inverse.
    condition = np.linalg.cond(stacked) ** 2
    assert condition <= total * (1.0 + 1.0 / kernels.DAMPING)
    roundings = 2 * FEW + total**1.5
    summed = np.linalg.norm(np.abs(rows).T @ np.abs(right)) / np.linalg.norm(stacked, 2) ** 2
    allowed = 4 * roundings * EPS * condition * (np.linalg.norm(expected) + summed)
    assert np.linalg.norm(found - expected) <= allowed


@examples(40)
@given(drawn(zeros=False), seeds, st.integers(0, 6), st.sampled_from([0.0, 0.5, 1.0]))
def test_a_refit_never_adds_error(program, seed, rounds, aim):
    case = fitted(program, seed)
    rng, nodes = np.random.default_rng(seed), guarded(copied(case.nodes))
    nodes.number[:] *= rng.uniform(0.7, 1.3, nodes.number.size)
    before = largest_error(case, nodes)
    signs = np.sign(nodes.number)
    refitted = guarded(copied(nodes))
    reached = kernels.refit(refitted, case.active, case.memory, FIRST, rounds, aim * before)
    found = largest_error(case, refitted)
    assert found <= before
    assert reached == found
    # It changes numbers alone, and none to another sign.
    np.testing.assert_array_equal(np.sign(refitted.number), signs)
    for name in ("kind", "left", "right", "outputs", "length"):
        np.testing.assert_array_equal(getattr(refitted, name), getattr(nodes, name))
    if rounds == 0 or aim == 1.0:
        np.testing.assert_array_equal(refitted.number, nodes.number)


@examples(6)
@given(seeds)
def test_a_refit_finds_numbers_that_were_changed(seed):
    """Of a sum of multiples of five leaves, by all its states."""
    leaves = [place for place in range(1, FIRST) if LAYOUT.about.degree[place] == 0]
    rng = np.random.default_rng(seed)
    steps = [Step(SCALED, (leaf, False), (0, False), rng.uniform(0.5, 2.0)) for leaf in leaves]
    places = range(FIRST, FIRST + len(leaves))
    last = FIRST
    for place in places[1:]:
        steps.append(Step(SUM, (last, False), (place, False), 0.0))
        last = FIRST + len(steps) - 1
    case = fitted(Drawn(tuple(steps), ((last, False), None)), seed)
    case.active.targets[:] = case.exact.outputs
    nodes = guarded(copied(case.nodes))
    nodes.number[:] *= rng.uniform(0.7, 1.3, nodes.number.size)
    before = largest_error(case, nodes)
    after = kernels.refit(nodes, case.active, case.memory, FIRST, 10, 0.0)
    # A round leaves the share of a change that the damping, 1e-7 of the largest, has in the least eigenvalue
    # of the normal equations; after three rounds rounding is left, some eps of numbers three times the error.
    assert after <= 100 * EPS * before
