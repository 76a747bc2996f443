"""The canonical form: the same outputs, every part once, and nothing that is no torque."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drawn_nodes import (
    FIRST,
    LAYOUT,
    PRICE,
    Drawn,
    Step,
    drawn,
    evaluated,
    nodes_of,
    operations_of,
    states,
    traced,
    used_places,
)
from gd_analyze.errors import ModelError
from gd_analyze.operations.program import Program
from gd_analyze.operations.torque_structure import structure_fault
from gd_analyze.operations.trace import Trace
from gd_analyze.program_search.layout import ONE, PRODUCT, SCALED, SUM, ZERO, Layout, Nodes
from strategies import examples
from uncompiled import canon_of, canonical, cost, guarded, guarded_layout, kernels, nodes_of_size, values_of

seeds = st.integers(0, 2**32 - 1)
LEAVES = LAYOUT.about


def canonical_of(nodes: Nodes) -> Nodes:
    found = canonical(nodes, LEAVES)
    assert found is not None
    return found[0]


def formula(nodes: Nodes) -> tuple[Any, ...]:
    """Outputs as sign and formula, whatever the order of nodes and operands, and where signs are."""
    made: dict[int, tuple[int, Any]] = {}

    def signed(reference: int) -> tuple[int, Any]:
        if reference < 0:
            return (1, "0")
        sign, own = made[reference >> 1]
        return (-sign if reference & 1 else sign), own

    for place in range(int(nodes.length[0])):
        if place < FIRST:
            made[place] = (1, f"leaf {place}")
            continue
        sign, left = signed(nodes.left[place])
        if nodes.kind[place] == SCALED:
            made[place] = (sign, (SCALED, float(nodes.number[place]), left))
            continue
        other_sign, right = signed(nodes.right[place])
        pair = sorted([(repr(left), sign, left), (repr(right), other_sign, right)])
        if nodes.kind[place] == PRODUCT:
            made[place] = (sign * other_sign, (PRODUCT, pair[0][2], pair[1][2]))
        else:
            made[place] = (pair[0][1], (SUM, pair[0][2], pair[0][1] * pair[1][1], pair[1][2]))
    return tuple(signed(reference) for reference in nodes.outputs.tolist())


@examples(80)
@given(drawn(), seeds, st.integers(0, 40))
def test_outputs_stay_and_operations_do_not_grow(program, seed, place):
    # A place that an edit has replaced by nothing: a leaf, a step, or none.
    nodes = nodes_of(program, place)
    new = canonical_of(nodes)
    leaf_values = LAYOUT.values(states(seed))
    before, after = evaluated(nodes, leaf_values), evaluated(new, leaf_values)
    # Numbers are products and sums of those before: what they are off by is the rounding of what was folded.
    allowed = 2 * (before.output_rounding + after.output_rounding)
    assert (np.abs(before.outputs - after.outputs) <= allowed).all()
    assert operations_of(new) <= operations_of(nodes)


@examples(80)
@given(drawn())
def test_every_part_is_there_once_in_one_form(program):
    new = canonical_of(nodes_of(program))
    length = int(new.length[0])
    assert (new.kind[:FIRST] == 0).all()
    seen = set()
    for place in range(FIRST, length):
        kind, left, right, number = (x[place] for x in (new.kind, new.left, new.right, new.number))
        assert 0 <= left >> 1 < place
        assert left % 2 == 0
        if kind == SCALED:
            assert (right, number > 0.0, number != 1.0) == (0, True, True)
            assert new.kind[left >> 1] != SCALED
        else:
            assert kind in (SUM, PRODUCT)
            assert left >> 1 <= right >> 1 < place
            assert kind == SUM or right % 2 == 0
            own = [x >> 1 if new.kind[x >> 1] != SCALED else new.left[x >> 1] >> 1 for x in (left, right)]
            # A sum of multiples of one node is a multiple, a product with a number is one too.
            assert kind == PRODUCT or own[0] != own[1]
            assert kind == SUM or ONE not in own
        seen.add((kind, left, right, number))
    assert len(seen) == length - FIRST


@examples(80)
@given(drawn())
def test_the_canonical_form_of_it_is_the_same_formula(program):
    new = canonical_of(nodes_of(program))
    again = canonical_of(new)
    assert formula(again) == formula(new)
    assert cost(again, LEAVES) == cost(new, LEAVES)
    # What folding left over is gone.
    assert used_places(again) - set(range(FIRST)) == set(range(FIRST, int(again.length[0])))
    third = canonical_of(again)
    assert third.length[0] == again.length[0]
    assert formula(third) == formula(again)


@examples(60)
@given(drawn(torques=False), seeds)
def test_what_is_no_torque_is_refused(program, seed):
    traced_one = traced(program)
    fault = structure_fault(traced_one)
    layout = guarded_layout(Layout.of(traced_one, PRICE))
    found = canonical(layout.exact, layout.about)
    if not fault:
        assert found is not None
    if found is None:
        assert fault
        return
    # What is accepted is a torque, but for outputs of degree 1, which no edit of a torque makes. A fault in
    # what is folded to nothing is none.
    left = structure_fault(layout.program(found[0]))
    assert left == "" or "linear in velocities" in left


@examples(80)
@given(drawn(torques=False))
def test_a_step_of_a_wrong_degree_is_refused_in_arrays(program):
    """Arrays fold nothing before the canonical form, which is of exact degrees."""
    found = canonical(nodes_of(program), LEAVES)
    if found is None:
        return
    new, degree = found
    assert degree[:FIRST].tolist() == LEAVES.degree.tolist()
    for place in range(FIRST, int(new.length[0])):
        first = degree[new.left[place] >> 1]
        if new.kind[place] == SCALED:
            assert degree[place] == first
            continue
        second = degree[new.right[place] >> 1]
        assert degree[place] == (first + second if new.kind[place] == PRODUCT else max(first, second))
        assert degree[place] <= 2
        assert new.kind[place] == PRODUCT or first == second or 1 not in (first, second)


QD, QDD, SINE = (
    next(
        place for place, leaf in enumerate(LAYOUT.leaves, start=1) if leaf.operation == name and is_such(leaf)
    )
    for name, is_such in (
        ("input", lambda leaf: leaf.arguments[0] == "qd1"),
        ("input", lambda leaf: leaf.arguments[0] == "qdd1"),
        ("sin", lambda leaf: True),
    )
)
WRONG = {
    "degree 3": (PRODUCT, QD, QDD),
    "degree 4": (PRODUCT, QDD, QDD),
    "degrees 0 and 1": (SUM, QD, SINE),
    "a number and degree 1": (SUM, ONE, QD),
    "degrees 1 and 2": (SUM, QD, QDD),
}


@pytest.mark.parametrize(("kind", "left", "right"), WRONG.values(), ids=WRONG)
def test_wrong_degrees(kind, left, right):
    step = Step(kind, (left, False), (right, False), 0.0)
    assert canonical(nodes_of(Drawn((step,), ((FIRST, False),))), LEAVES) is None
    # Nothing needs it: it is not there.
    assert canonical(nodes_of(Drawn((step,), ((QDD, False),))), LEAVES) is not None


@examples(60)
@given(drawn(), st.data())
def test_a_cycle_is_refused_where_outputs_reach_it(program, data):
    nodes = nodes_of(program)
    used = sorted(used_places(nodes) - set(range(FIRST)))
    if not used:
        return
    upper = data.draw(st.sampled_from(used))
    # Of what the step needs, itself included, one now needs the step.
    below = nodes_of(program)
    below.outputs[:] = [2 * upper, ZERO]
    lower = data.draw(st.sampled_from(sorted(used_places(below) - set(range(FIRST)))))
    side = nodes.left if nodes.kind[lower] == SCALED or data.draw(st.booleans()) else nodes.right
    side[lower] = 2 * upper + data.draw(st.integers(0, 1))
    assert canonical(nodes, LEAVES) is None


def test_more_operations_in_arguments_than_a_mask_holds_are_refused():
    """One bit of 64 stands for each: a chain of 65 parallel joints has no room."""
    trace = Trace()
    angle = trace.record("input", "q1")
    for joint in range(2, 67):
        angle = trace.record("add", angle, trace.record("input", f"q{joint}"))
    program = Program.of(trace, [trace.apply("cos", angle)])
    with pytest.raises(ModelError, match="found: more than 64"):
        Layout.of(program, PRICE)


def test_a_program_beyond_its_memory_is_refused():
    """Powers of a sine, one step after another."""
    steps = [Step(PRODUCT, (SINE, False), (SINE, False), 0.0)]
    steps += [Step(PRODUCT, (FIRST + k, False), (SINE, False), 0.0) for k in range(20)]
    nodes = nodes_of(Drawn(tuple(steps), ((FIRST + 20, False),)))
    canon = guarded(canon_of(nodes.kind.size, kernels))
    least = FIRST + len(steps)
    for room in (least, least - 1):
        new = nodes_of_size(room, 1)
        assert kernels.canonical(nodes, new, canon, LEAVES) == (room == least)


@examples(60)
@given(drawn(), seeds)
def test_kernels_evaluate_it(program, seed):
    new = canonical_of(nodes_of(program))
    leaf_values = LAYOUT.values(states(seed))
    found, expected = values_of(new, leaf_values), evaluated(new, leaf_values)
    # The same operations in the same order: complex arithmetic of real numbers rounds as real one does.
    np.testing.assert_array_equal(found, expected.values)


@examples(60)
@given(drawn())
def test_cost_is_what_the_outputs_need(program):
    nodes = nodes_of(program)
    used = used_places(nodes)
    functions = [place for place in used if place < FIRST and LEAVES.price[place]]
    # The one operation in an argument is q1 + q2.
    added = any(LEAVES.steps[place] for place in functions)
    expected = operations_of(nodes) + PRICE * len(functions) + added
    assert cost(nodes, LEAVES) == expected
