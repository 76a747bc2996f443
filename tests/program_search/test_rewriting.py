"""Edits of programs in arrays: rewritings are equal, others stay torques, and none leaves its memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drawn_nodes import FIRST, LAYOUT, drawn, evaluated, nodes_of, scratch_of, states, traced
from gd_analyze.operations.torque_structure import structure_fault
from gd_analyze.program_search.layout import PRODUCT, SCALED, SUM, Nodes, copied
from strategies import examples
from uncompiled import canonical, guarded, kernels, nodes_of_size, values_of

seeds = st.integers(0, 2**32 - 1)
LEAVES = LAYOUT.about
# Quotients of a dozen of these are no larger than 2**12.
NUMBERS = st.sampled_from([0.5, -0.75, 1.25, 2.0, -1.5])


def canonical_of(nodes: Nodes, room: int | None = None) -> Nodes:
    found = canonical(nodes, LEAVES)
    assert found is not None
    if room is None:
        return found[0]
    wider = nodes_of_size(room, nodes.outputs.size)
    for old, new in zip(found[0], wider, strict=True):
        new[: old.size] = old
    return wider


@examples(80)
@given(drawn(most=12, zeros=False, numbers=NUMBERS), seeds, st.lists(st.integers(1, 3), max_size=6))
def test_rewritings_leave_the_outputs_equal(program, seed, tries):
    rng = np.random.default_rng(seed)
    nodes = canonical_of(nodes_of(program), 400)
    leaf_values = LAYOUT.values(states(seed))
    before, done = evaluated(nodes, leaf_values), 0
    for edits in tries:
        edited = guarded(copied(nodes))
        if nodes.length[0] > FIRST:
            done += sum(kernels._rewrite(rng, edited, nodes, LEAVES, FIRST) for _ in range(edits))
        nodes = canonical_of(edited)
    # Each rewriting may divide a number by another, and folding multiplies two: two roundings.
    after = evaluated(nodes, leaf_values, of_number=1 + 2 * done)
    assert (
        np.abs(after.outputs - before.outputs) <= 2 * (before.output_rounding + after.output_rounding)
    ).all()
    assert structure_fault(LAYOUT.program(nodes)) == ""


def written_out(make: Any) -> Nodes:
    """Nodes with one output, the last that `make` appends; leaves are those that it takes by name."""
    nodes = nodes_of_size(100, 1)
    nodes.length[0] = FIRST
    named = {repr(leaf): 2 * place for place, leaf in enumerate(LAYOUT.leaves, start=1)}
    sine, cosine = (next(v for k, v in named.items() if k.startswith(name)) for name in ("sin", "cos"))

    def append(kind: int, left: int, right: int = 0, number: float = 0.0) -> int:
        return kernels._append(nodes, kind, left, right, number)

    nodes.outputs[0] = make(append, sine, cosine)
    return nodes


def rewritten_forms(nodes: Nodes, tries: int = 60) -> set[tuple[int, int]]:
    """Numbers of products and of sums, after one rewriting each."""
    found = set()
    for seed in range(tries):
        edited = guarded(copied(nodes))
        if kernels._rewrite(np.random.default_rng(seed), edited, nodes, LEAVES, FIRST):
            new = canonical_of(canonical_of(edited))
            kinds = new.kind[FIRST : new.length[0]].tolist()
            found.add((kinds.count(PRODUCT) + kinds.count(SCALED), kinds.count(SUM)))
    return found


def test_a_common_factor_is_taken_out_and_multiplied_in():
    def outside(append, s, c):  # s (2 + c)
        return append(PRODUCT, s, append(SUM, append(SCALED, 0, 0, 2.0), c))

    def inside(append, s, c):  # s c c + s s
        return append(SUM, append(PRODUCT, s, append(PRODUCT, c, c)), append(PRODUCT, s, s))

    # (the number 2, and one product) becomes 2 s + s c
    assert (2, 1) in rewritten_forms(written_out(outside))
    # three products become s (c c + s)
    assert (2, 1) in rewritten_forms(written_out(inside))


def test_a_square_is_written_by_its_partners():
    square = written_out(lambda append, s, c: append(PRODUCT, s, s))
    assert rewritten_forms(square) == {(1, 1)}


@examples(60)
@given(drawn(most=12), seeds, st.integers(1, 4))
def test_edits_make_torques_of_nodes_within_memory(program, seed, edits):
    """What is changed by any edits is a torque again, and refers to earlier nodes alone."""
    rng = np.random.default_rng(seed)
    current = canonical_of(nodes_of(program), 400)
    if current.length[0] == FIRST:
        return
    inputs = states(seed, 20)
    memory, active = scratch_of(current, inputs, traced(program).run(inputs), np.ones((2, 20)), 8)
    _, degree = canonical(current, LEAVES)
    kernels.evaluate_nodes(current, active.values, FIRST, 0, 8)
    kernels._keep_values(current, active, memory, FIRST)
    settings = kernels.SearchSettings()
    edited = guarded(copied(current))
    for _ in range(edits):
        choice = rng.integers(4)
        if choice == 0:
            kernels._rewrite(rng, edited, current, LEAVES, FIRST)
        elif choice == 1:
            kernels._replace(rng, edited, current, memory, degree, FIRST, settings.draws)
        elif choice == 2:
            kernels._drop(rng, edited, current, memory, degree, FIRST)
        else:
            kernels._add(rng, edited, current, memory, degree, FIRST)
    found = canonical(edited, LEAVES)
    if found is not None:
        fault = structure_fault(LAYOUT.program(found[0]))
        assert fault == ""
        values = values_of(found[0], LAYOUT.values(states(seed)))
        assert np.isfinite(values).all()
