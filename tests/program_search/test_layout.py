"""Programs in arrays, and back: the same numbers, and no operation more."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drawn_nodes import LAYOUT, NAMES, PRICE, drawn, states, traced
from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Trace
from gd_analyze.program_search.layout import Layout, Nodes
from gd_analyze.types import ExactForm
from strategies import arms, examples, random_states
from uncompiled import canonical, cost, guarded_layout, values_of

seeds = st.integers(0, 2**32 - 1)


def priced(program: Program) -> float:
    return program.count.total + PRICE * program.count.sines_cosines


def outputs_at(layout: Layout, nodes: Nodes, inputs: dict[str, FloatArray]) -> FloatArray:
    """Outputs as the kernels evaluate them."""
    values = values_of(nodes, layout.values(inputs))
    signs = np.where(nodes.outputs & 1, -1.0, 1.0)
    found = signs[:, None] * np.asarray(values)[np.asarray(nodes.outputs) >> 1]
    found[np.asarray(nodes.outputs) < 0] = 0.0
    return found


@examples(80)
@given(drawn(), seeds)
def test_there_and_back_is_the_same_program(steps, seed):
    program = traced(steps)
    layout = guarded_layout(Layout.of(program, PRICE))
    inputs, nodes = states(seed), layout.exact
    again = layout.program(nodes)
    # The same operations on the same operands round equally, in whatever order they are.
    np.testing.assert_array_equal(again.run(inputs), program.run(inputs))
    np.testing.assert_array_equal(outputs_at(layout, nodes, inputs), program.run(inputs))
    assert again.count.total <= program.count.total
    assert priced(again) <= cost(nodes, layout.about)
    assert priced(program) <= cost(nodes, layout.about)
    assert len(layout.leaves) == len(set(map(repr, layout.leaves)))


@examples(80)
@given(drawn(), seeds)
def test_of_the_canonical_form_cost_is_what_the_program_counts(program, seed):
    layout = guarded_layout(Layout.of(traced(program), PRICE))
    new, _ = canonical(layout.exact, layout.about)
    written = layout.program(new)
    inputs = states(seed)
    np.testing.assert_array_equal(written.run(inputs), outputs_at(layout, new, inputs))
    # q2 is a position that slides too: q1 + q2, if it is a step and an angle, is counted once in a program.
    assert 0.0 <= cost(new, layout.about) - priced(written) <= 1.0
    if "q2" not in {leaf.arguments[0] for leaf in layout.leaves}:
        assert cost(new, layout.about) == priced(written)


@examples(15)
@given(arms(max_joints=4), seeds)
def test_so_are_exact_torques_of_any_arm(arm, seed):
    program = ExactForm(arm).recursion
    layout = guarded_layout(Layout.of(program, PRICE))
    nodes = layout.exact
    inputs = program_inputs(random_states(arm.n_joints, 5, seed))
    expected = program.run(inputs)
    again = layout.program(nodes)
    np.testing.assert_array_equal(again.run(inputs), expected)
    assert again.count.total <= program.count.total
    found = canonical(nodes, layout.about)
    assert found is not None
    shorter = layout.program(found[0])
    assert priced(shorter) <= cost(found[0], layout.about) <= cost(nodes, layout.about)
    # Numbers folded into others round a few times more than some thousand operations do, each by eps of a
    # part of the torque, which may be ten times the whole.
    assert np.abs(shorter.run(inputs) - expected).max() <= 1e4 * np.finfo(float).eps * np.abs(expected).max()


def test_a_sine_has_its_cosine_for_a_partner():
    about = LAYOUT.about
    assert about.partner[0] == -1
    for place, leaf in enumerate(LAYOUT.leaves, start=1):
        if leaf.operation == "input":
            assert (about.partner[place], about.price[place]) == (-1, 0.0)
            assert about.degree[place] == NAMES.index(leaf.arguments[0]) // 2
        else:
            other = LAYOUT.leaves[about.partner[place] - 1]
            assert {leaf.operation, other.operation} == {"cos", "sin"}
            assert leaf.arguments[0] is other.arguments[0]
            assert about.price[place] == PRICE
            assert about.partner[about.partner[place]] == place


def test_a_sum_in_a_cosine_and_a_sine_is_one_operation():
    trace = Trace()
    q1, q2 = trace.inputs("q", 2)[:, 0]
    outputs = [trace.apply("sin", q2 + q1) * q1, 2.0 * trace.apply("cos", q1 + q2)]
    layout = guarded_layout(Layout.of(Program.of(trace, outputs), PRICE))
    # q1, and cosine and sine of q1 + q2, whose sum is one operation of both
    assert sorted(leaf.operation for leaf in layout.leaves) == ["cos", "input", "sin"]
    assert cost(layout.exact, layout.about) == 3.0 + 2 * PRICE


def test_outputs_that_are_numbers_or_leaves():
    trace = Trace()
    (qdd,) = trace.inputs("qdd", 1)[:, 0]
    outputs = [0.0, -2.5, 1.0, qdd, -qdd, qdd - 1.0, 1.0 - qdd, -(qdd + 3.0)]
    program = Program.of(trace, outputs)
    layout = guarded_layout(Layout.of(program, PRICE))
    inputs = {"qdd1": np.array([0.3, -2.0])}
    for nodes in (layout.exact, canonical(layout.exact, layout.about)[0]):
        again = layout.program(nodes)
        np.testing.assert_array_equal(again.run(inputs), program.run(inputs))
        assert again.count.total == cost(nodes, layout.about)
