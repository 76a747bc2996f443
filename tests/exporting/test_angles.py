"""Sines and cosines of sums from those of their summands: the same values, fewer of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.exporting.angles import with_sums
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from random_programs import INPUTS, program_of, trees

FREE = 1e-13  # some dozen roundings of numbers up to 1
angles = st.lists(st.lists(st.integers(-3, 3), min_size=INPUTS, max_size=INPUTS), min_size=1, max_size=8)


def states(seed: int) -> dict[str, np.ndarray]:
    draws = np.random.default_rng(seed).uniform(-3.0, 3.0, (INPUTS, 20))
    return {f"x{k + 1}": row for k, row in enumerate(draws)}


@given(angles, st.integers(0, 2**32 - 1))
def test_sums_of_angles_have_the_same_sines(multiples, seed):
    trace = Trace()
    inputs = trace.inputs("x", INPUTS)[:, 0]
    sums = [sum((m * x for m, x in zip(row, inputs, strict=True)), 0.0) for row in multiples]
    sums = [x for x in sums if not isinstance(x, float)]
    program = Program.of(trace, [f for x in sums for f in (trace.apply("sin", x), trace.apply("cos", x))])
    found, given_states = with_sums(program), states(seed)
    # Each sine of a sum has the round-off of two products of others; lengths of sums are at most 9.
    assert np.abs(found.run(given_states) - program.run(given_states)).max(initial=0.0) <= 9 * FREE
    assert found.count.sines_cosines <= program.count.sines_cosines


@given(trees, trees)
def test_any_program_is_the_same(first, second):
    """Sines of sines, of products and of constants included; larger values have larger round-off."""
    program = program_of(first, second)
    if not program.steps:
        return
    with np.errstate(all="ignore"):
        expected, found = (one.run(states(1)) for one in (program, with_sums(program)))
    same = (found == expected) | ~np.isfinite(expected)
    sensitive = np.abs(expected).max(initial=1.0, where=np.isfinite(expected))
    if sensitive < 10.0:
        assert (same | (np.abs(found - expected) <= 1e-6)).all()


@pytest.mark.parametrize(("angles_left", "signs"), [(2, (1, 1)), (2, (1, -1)), (1, (1, 0))])
def test_two_angles_are_enough(angles_left, signs):
    """For a sum, a difference, and a double, in whatever order they are taken."""
    trace = Trace()
    x, y, _ = trace.inputs("x", INPUTS)[:, 0]
    other = {1: y, -1: -y, 0: x}[signs[1]]
    taken = [x + other, x, y][: angles_left + 1]
    program = Program.of(trace, [function for angle in taken for function in (angle.sin(), angle.cos())])
    found = with_sums(program)
    assert found.count.sines_cosines == 2 * angles_left
    assert np.abs(found.run(states(2)) - program.run(states(2))).max() <= FREE
    cosines = with_sums(Program.of(trace, [x.cos(), y.cos(), (x + y).cos()]))
    angles = {step.arguments[0] for step in cosines.steps if step.operation in ("sin", "cos")}
    assert len(angles) == 2  # of which sine and cosine come together
