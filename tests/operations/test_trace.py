"""Traced arithmetic: folded, shared, counted, and a program that computes what the code computes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import cross, dot
from gd_analyze.operations.program import Program, plain_program, read_back
from gd_analyze.operations.trace import Trace
from random_programs import evaluated, program_of, trees
from strategies import examples


@pytest.fixture
def trace() -> Trace:
    return Trace()


def counted(trace: Trace, *outputs: object) -> tuple[int, int, int]:
    count = Program.of(trace, outputs).count
    return count.multiplications, count.additions, count.sines_cosines


def test_zeros_ones_and_signs_vanish(trace):
    x, y, z = trace.inputs("x", 3)[:, 0]
    for folded in (x + 0, 0 + x, x - 0, x * 1, 1.0 * x, trace.negative(-x)):
        assert folded is x
    for zero in (x * 0, 0 * x, x - x, x * y - y * x):
        assert zero == 0.0
    for one, other in (
        (x * -1, -x),
        (0 - x, -x),
        ((-x) * (-y), x * y),
        ((-x) * y, -(x * y)),
        (x + (-y), x - y),
        ((-x) + y, y - x),
        (-(x - y), y - x),
        ((-x) - y, -(x + y)),
        (x - (-y), x + y),
        (x * -2.0, -(x * 2.0)),
        (x + y, y + x),
        (x + 2, 2.0 + x),
        ((x * y) * z, (y * x) * z),
    ):
        assert one is other
    assert x - y is not y - x


def test_constants_are_folded(trace):
    found = [trace.add(2, 3), trace.multiply(2, 3), trace.negative(2), trace.apply("cos", 0.0)]
    assert found == [5.0, 6.0, -2.0, 1.0]
    assert not trace.expressions


def test_counts_done_by_hand(trace):
    """l1 cos(q1) + l2 cos(q1 + q2), and the same with sines: 4 products, 3 sums, 4 functions."""
    q, a, b = trace.inputs("q", 2), trace.inputs("a", 3), trace.inputs("b", 3)
    elbow = q[0] + q[1]
    x = 0.5 * np.cos(q[0]) + 0.25 * np.cos(elbow)
    y = 0.5 * np.sin(q[0]) + 0.25 * np.sin(elbow)
    assert counted(trace, x[0], y[0]) == (4, 3, 4)
    assert counted(trace, x[0]) == (2, 2, 2)
    assert counted(trace, 1.0, q[0, 0]) == (0, 0, 0)
    # a x b: 6 products, 3 differences; a . b: 3 and 2; a . (a x b) as written: 9 and 5.
    assert counted(trace, *cross(a, b)[:, 0]) == (6, 3, 0)
    assert counted(trace, dot(a, b)[0]) == (3, 2, 0)
    assert counted(trace, dot(a, cross(a, b))[0]) == (9, 5, 0)
    assert counted(trace, *cross(np.array([[0.0], [0.0], [1.0]]), b)[:, 0]) == (0, 0, 0)
    # A change of sign is free.
    assert counted(trace, -(q[0, 0] * q[1, 0])) == (1, 0, 0)


@examples(120)
@given(st.lists(trees, min_size=1, max_size=3), st.integers(0, 2**32 - 1))
def test_programs_compute_what_direct_evaluation_computes(roots, seed):
    """To the last bit: every folding is exact in floating point (signs, 0, 1, order of two operands)."""
    values = np.random.default_rng(seed).uniform(-3, 3, (3, 50))
    inputs, program = {f"x{i + 1}": row for i, row in enumerate(values)}, program_of(*roots)
    found = program.run(inputs)
    for row, root in zip(found, roots, strict=True):
        np.testing.assert_array_equal(row, np.broadcast_to(evaluated(root, list(values)), 50))
    # Written to a file and read back it computes the same bits.
    again = read_back(*json.loads(json.dumps(plain_program(program))), inputs.keys())
    np.testing.assert_array_equal(again.run(inputs), found)
    assert plain_program(again) == plain_program(program)


@pytest.mark.parametrize(
    ("steps", "told"),
    [
        ([["divide", "s0", 1.0]], "is not an operation"),
        ([["input", "q1"], ["cos", "q1"]], "not an earlier step"),
        ([["input", "q1"], ["add", "s0", float("nan")]], "is not a number of a torque"),
        ([["input", "time"]], "no input"),
        ([["input", "q1"], ["input", "q1"]], "occurs twice"),
    ],
)
def test_written_programs_that_are_none(steps, told):
    with pytest.raises(ValueError, match=told):
        read_back(steps, [], {"q1"})


@pytest.mark.parametrize("count", [0, 1, 1023, 1024, 1025, 3000])
def test_chunks_of_a_run_leave_no_seam(trace, count, rng):
    x, y = trace.inputs("x", 2)[:, 0]
    values = rng.normal(size=(2, count))
    found = Program.of(trace, [x * y + x, 4.0]).run({"x1": values[0], "x2": values[1]})
    np.testing.assert_array_equal(found, [values[0] * values[1] + values[0], np.full(count, 4.0)])
