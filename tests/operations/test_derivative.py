"""Derivatives of programs, against a step into the complex plane; inputs set to numbers."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.operations.program import Program, program_slopes
from gd_analyze.operations.trace import Trace
from random_programs import INPUTS, evaluated, program_of, trees, trees_of
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
seeds = st.integers(0, 2**32 - 1)


def drawn(seed: int, most: float) -> dict[str, np.ndarray]:
    return dict(zip(NAMES, np.random.default_rng(seed).uniform(-most, most, (INPUTS, COUNT)), strict=True))


def derivative(program: Program, along, values=None) -> Program:
    trace = Trace()
    return Program.of(trace, program_slopes(program, along, program.folded(trace, values or {}), trace))


def inputs_of(program: Program) -> set[str]:
    return {step.arguments[0] for step in program.steps if step.operation == "input"}


@examples(120)
@given(small_trees, directions, fixed, seeds)
def test_it_is_the_slope_along_the_direction(tree, along, values, seed):
    """The imaginary part of f(x + i h d) is h times the slope of an analytic function, h tiny."""
    inputs = drawn(seed, 1.5) | {name: np.full(COUNT, value) for name, value in values.items()}
    program, step = derivative(program_of(tree), along, values), 1e-30
    moved = []
    for name in NAMES:
        direction = along.get(name, 0.0)
        moved.append(
            inputs[name] + 1j * step * (inputs[direction] if isinstance(direction, str) else direction)
        )
    expected = np.broadcast_to(np.imag(evaluated(tree, moved)) / step, COUNT)
    assert np.abs(program.run(inputs)[0] - expected).max() <= CLOSE
    # A direction may still be that of an input whose value is known.
    assert not inputs_of(program) & (values.keys() - set(along.values()))


@examples(80)
@given(trees, fixed, seeds)
def test_with_values_computes_the_same(tree, values, seed):
    """To the last bit: what is folded is computed as it would have been."""
    inputs = drawn(seed, 3.0)
    program = program_of(tree).with_values(values)
    expected = evaluated(tree, [values.get(name, inputs[name]) for name in NAMES])
    np.testing.assert_array_equal(program.run(inputs)[0], np.broadcast_to(expected, COUNT))
    assert not inputs_of(program) & values.keys()
    assert program.count.total <= program_of(tree).count.total


def test_nothing_superfluous_remains():
    trace = Trace()
    x, y, z = trace.inputs("x", 3)[:, 0]

    def slope(expression, *more):
        return derivative(Program.of(trace, [expression]), {"x1": 1.0}, *more)

    assert [slope(f).outputs[0] for f in (3.0 * x + y * z, y * z, 4.0)] == [3.0, 0.0, 0.0]
    assert repr(slope(x * y).outputs[0]) == "input('x2',)"
    product = slope(x * y * y + z)
    assert (product.count.total, len(product.steps)) == (1, 2)
    assert repr(slope(x * y + x * x * z, {"x1": 0.0}).outputs[0]) == "input('x2',)"
    assert not Program.of(trace, [x * y + z]).with_values({"x1": 0.0, "x3": 2.0}).steps
