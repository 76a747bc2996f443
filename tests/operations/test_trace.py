"""Counting arithmetic: folding, sharing, and a program that computes what the code computes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_programs import evaluated, program_of, trees

from gd_analyze.arrays import cross, dot
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace, reached
from strategies import examples


@pytest.fixture
def trace() -> Trace:
    return Trace()


def variables(trace: Trace, count: int = 3) -> list[Expression]:
    return list(trace.inputs("x", count)[:, 0])


def counted(trace: Trace, *outputs: object) -> tuple[int, int, int]:
    count = Program.of(trace, outputs).count
    return count.multiplications, count.additions, count.sines_cosines


def test_zeros_and_ones_vanish(trace):
    x, y, _ = variables(trace)
    assert x + 0 is x
    assert 0 + x is x
    assert x - 0 is x
    assert x * 1 is x
    assert 1.0 * x is x
    assert x * 0 == 0.0
    assert 0 * x == 0.0
    assert x - x == 0.0
    assert x * y - y * x == 0.0


def test_signs_move_outside_and_cancel(trace):
    x, y, _ = variables(trace)
    assert trace.negative(-x) is x
    assert x * -1 is -x
    assert (-x) * (-y) is x * y
    assert (-x) * y is -(x * y)
    assert x + (-y) is x - y
    assert (-x) + y is y - x
    assert -(x - y) is y - x
    assert (-x) - y is -(x + y)
    assert x - (-y) is x + y
    assert 0 - x is -x
    assert x * -2.0 is -(x * 2.0)


def test_equal_subexpressions_are_one(trace):
    x, y, z = variables(trace)
    assert x + y is y + x
    assert x * y is y * x
    assert (x * y) * z is (y * x) * z
    assert np.cos(np.array([x], dtype=object))[0] is np.cos(np.array([x], dtype=object))[0]
    assert x - y is not y - x
    assert x + 2 is 2.0 + x


def test_constants_are_folded(trace):
    assert trace.add(2, 3) == 5.0
    assert trace.multiply(2, 3) == 6.0
    assert trace.negative(2) == -2.0
    assert trace.apply("cos", 0.0) == 1.0
    assert trace.apply("sin", 0.0) == 0.0
    assert not trace.expressions


def test_a_count_done_by_hand(trace):
    """l1 cos(q1) + l2 cos(q1 + q2), and the same with sines: 4 products, 3 sums, 4 functions."""
    q = trace.inputs("q", 2)
    elbow = q[0] + q[1]
    x = 0.5 * np.cos(q[0]) + 0.25 * np.cos(elbow)
    y = 0.5 * np.sin(q[0]) + 0.25 * np.sin(elbow)
    assert counted(trace, x[0], y[0]) == (4, 3, 4)
    assert counted(trace, x[0]) == (2, 2, 2)
    assert counted(trace, 1.0, q[0, 0]) == (0, 0, 0)


def test_vector_operations_by_hand(trace):
    """a x b: 6 products, 3 differences; a . b: 3 and 2; a . (a x b) as written: 9 and 5."""
    a, b = trace.inputs("a", 3), trace.inputs("b", 3)
    assert counted(trace, *cross(a, b)[:, 0]) == (6, 3, 0)
    assert counted(trace, dot(a, b)[0]) == (3, 2, 0)
    assert counted(trace, dot(a, cross(a, b))[0]) == (9, 5, 0)
    along_z = np.array([[0.0], [0.0], [1.0]])
    assert counted(trace, *cross(along_z, b)[:, 0]) == (0, 0, 0)


def test_a_change_of_sign_is_free_and_dead_code_is_not_counted(trace):
    x, y, z = variables(trace)
    unused = x * y + z
    assert isinstance(unused, Expression)
    assert counted(trace, -(x * z)) == (1, 0, 0)
    program = Program.of(trace, [-(x * z)])
    assert len(program.steps) == len(reached(program.outputs)) == 4


@examples(120)
@given(trees, st.integers(0, 2**32 - 1))
def test_programs_compute_what_direct_evaluation_computes(tree, seed):
    """To the last bit: every folding is exact in floating point (signs, 0, 1, order of two operands)."""
    values = np.random.default_rng(seed).uniform(-3, 3, (3, 50))
    found = program_of(tree).run({f"x{i + 1}": row for i, row in enumerate(values)})
    expected = evaluated(tree, list(values))
    np.testing.assert_array_equal(found[0], np.broadcast_to(expected, 50))


@pytest.mark.parametrize("count", [0, 1, 1023, 1024, 1025, 3000])
def test_chunks_of_a_run_leave_no_seam(trace, count, rng):
    x, y, _ = variables(trace)
    values = rng.normal(size=(2, count))
    found = Program.of(trace, [x * y + x, 4.0, y]).run({"x1": values[0], "x2": values[1]})
    np.testing.assert_array_equal(found[0], values[0] * values[1] + values[0])
    np.testing.assert_array_equal(found[1], np.full(count, 4.0))
    np.testing.assert_array_equal(found[2], values[1])


def test_traced_formulation_computes_the_torque(puma, rng):
    """The whole formulation, run on expressions, against the same code run on numbers."""
    from gd_analyze.dynamics.decomposition import decompose_states
    from gd_analyze.dynamics.pinocchio_check import round_off_bounds
    from gd_analyze.simplification.element import parts_of, trace_parts

    traced = trace_parts(puma)
    program = Program.of(traced.trace, list(traced.torque(parts_of(6), None)))
    q, qd, qdd = rng.uniform(-3, 3, (3, 100, 6))
    inputs = {f"{name}{i + 1}": x[:, i] for name, x in (("q", q), ("qd", qd), ("qdd", qdd)) for i in range(6)}
    expected = decompose_states(puma, States(q, qd, qdd), drives=False)["torque"]
    # Folded and unfolded arithmetic sum in another order: two correct programs.
    assert np.abs(program.run(inputs).T - expected).max() <= round_off_bounds(puma, q, qd, qdd)["torque"]
