"""Derivatives of programs: against a step into the complex plane, closed forms and Euler's theorem."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_programs import INPUTS, evaluated, program_of, trees, trees_of

from gd_analyze.operations.program import Program, derivative
from gd_analyze.operations.trace import Trace
from strategies import examples

NAMES = tuple(f"x{i + 1}" for i in range(INPUTS))
COUNT = 20

# Eight leaves of at most 2: no value is beyond 2^8 and no slope beyond 2^11. Values are then off by some
# 2^8 eps, which a sine behind them turns into 2^19 eps of a slope at most; eight of them may add up.
small_trees = trees_of(2.0, 8)
CLOSE = 2.0**19 * np.finfo(float).eps * 8

directions = st.dictionaries(
    st.sampled_from(NAMES), st.sampled_from([1.0, -2.0, 0.0, 0.7]) | st.sampled_from(NAMES)
)
fixed = st.dictionaries(st.sampled_from(NAMES), st.sampled_from([0.0, 1.0, -1.5, 0.3]))


def drawn(seed: int, most: float = 1.5) -> dict[str, np.ndarray]:
    return dict(zip(NAMES, np.random.default_rng(seed).uniform(-most, most, (INPUTS, COUNT)), strict=True))


def along_a_step(tree, inputs, along) -> np.ndarray:
    """Slope of a tree: of an analytic function the imaginary part of f(x + i h d) is h times it, h tiny."""
    step = 1e-30
    moved = []
    for name in NAMES:
        direction = along.get(name, 0.0)
        moved.append(
            inputs[name] + 1j * step * (inputs[direction] if isinstance(direction, str) else direction)
        )
    return np.broadcast_to(np.imag(evaluated(tree, moved)) / step, COUNT)


@examples(120)
@given(small_trees, directions, st.integers(0, 2**32 - 1))
def test_it_is_the_slope_along_the_direction(tree, along, seed):
    inputs = drawn(seed)
    found = derivative(program_of(tree), along).run(inputs)[0]
    assert np.abs(found - along_a_step(tree, inputs, along)).max() <= CLOSE


@examples(60)
@given(small_trees, directions, fixed, st.integers(0, 2**32 - 1))
def test_some_inputs_may_have_their_numbers(tree, along, values, seed):
    inputs = drawn(seed) | {name: np.full(COUNT, value) for name, value in values.items()}
    program = derivative(program_of(tree), along, values)
    named = {step.arguments[0] for step in program.steps if step.operation == "input"}
    # A direction may still be that of an input whose value is known.
    assert not named & (values.keys() - set(along.values()))
    assert np.abs(program.run(inputs)[0] - along_a_step(tree, inputs, along)).max() <= CLOSE


@examples(80)
@given(trees, fixed, st.integers(0, 2**32 - 1))
def test_with_values_computes_the_same(tree, values, seed):
    """To the last bit: what is folded is computed as it would have been."""
    inputs = drawn(seed, 3.0)
    program = program_of(tree).with_values(values)
    expected = evaluated(tree, [values.get(name, inputs[name]) for name in NAMES])
    np.testing.assert_array_equal(program.run(inputs)[0], np.broadcast_to(expected, COUNT))
    assert not {step.arguments[0] for step in program.steps if step.operation == "input"} & values.keys()
    assert program.count.total <= program_of(tree).count.total


@pytest.fixture
def trace() -> Trace:
    return Trace()


def slopes(trace: Trace, expression, *names: str) -> list[object]:
    return [derivative(Program.of(trace, [expression]), {name: 1.0}).outputs[0] for name in names]


def test_closed_forms(trace):
    x, y, _ = trace.inputs("x", 3)[:, 0]
    inputs = drawn(1)
    a, b = inputs["x1"], inputs["x2"]

    def function(kind: str, argument):
        return trace.apply(kind, argument)

    cases = [
        (x * x * x, 3 * a**2, 0 * a),
        (x * y - y, b, a - 1.0),
        (function("sin", 2.0 * x + y), 2 * np.cos(2 * a + b), np.cos(2 * a + b)),
        (function("cos", x * y), -np.sin(a * b) * b, -np.sin(a * b) * a),
        (-function("cos", x) * function("sin", y), np.sin(a) * np.sin(b), -np.cos(a) * np.cos(b)),
    ]
    for expression, by_x, by_y in cases:
        for name, wanted in (("x1", by_x), ("x2", by_y)):
            found = derivative(Program.of(trace, [expression]), {name: 1.0}).run(inputs)[0]
            # Some ten roundings of numbers of order 1.
            np.testing.assert_allclose(found, wanted, rtol=0, atol=50 * np.finfo(float).eps)


def test_nothing_superfluous_remains(trace):
    x, y, z = trace.inputs("x", 3)[:, 0]
    assert slopes(trace, 3.0 * x + y * z, "x1") == [3.0]
    assert slopes(trace, y * z, "x1") == [0.0]
    assert slopes(trace, 4.0, "x1") == [0.0]
    assert [repr(slope) for slope in slopes(trace, x * y, "x1", "x2")] == ["input('x2',)", "input('x1',)"]
    product = derivative(Program.of(trace, [x * x * y + z]), {"x2": 1.0})
    assert (product.count.total, len(product.steps)) == (1, 2)
    at_rest = derivative(Program.of(trace, [x * y + y * y * z]), {"x2": 1.0}, {"x2": 0.0})
    assert repr(at_rest.outputs[0]) == "input('x1',)"
    assert not Program.of(trace, [x * y + z]).with_values({"x1": 0.0, "x3": 2.0}).steps


whole_numbers = st.integers(-3, 3).map(float)


@examples(25)
@given(
    st.integers(1, 4).flatmap(
        lambda degree: st.tuples(
            st.just(degree),
            st.dictionaries(
                st.lists(st.integers(0, INPUTS - 1), min_size=degree, max_size=degree).map(
                    lambda chosen: tuple(sorted(chosen))
                ),
                whole_numbers,
                min_size=1,
                max_size=5,
            ),
        )
    ),
    st.lists(whole_numbers, min_size=INPUTS, max_size=INPUTS),
)
def test_along_themselves_a_form_grows_by_its_degree(form, at):
    """Euler: sum of x_i df/dx_i is k f for a form of degree k; in whole numbers, so exact."""
    degree, coefficients = form
    trace = Trace()
    x = trace.inputs("x", INPUTS)[:, 0]
    total = 0.0
    for monomial, coefficient in coefficients.items():
        product = coefficient
        for k in monomial:
            product = trace.multiply(product, x[k])
        total = trace.add(total, product)
    program = Program.of(trace, [total])
    inputs = {name: np.array([value]) for name, value in zip(NAMES, at, strict=True)}
    grown = derivative(program, {name: name for name in NAMES})
    np.testing.assert_array_equal(grown.run(inputs), degree * program.run(inputs))
