"""Random programs as steps on fixed leaves: in arrays with everything that folds, traced, and evaluated.

A step takes any earlier ones, so that parts are shared, and equal, and used by nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.program_search.layout import ONE, PRODUCT, SCALED, SUM, ZERO, Layout, Nodes
from uncompiled import guarded, guarded_layout, kernels, nodes_of_size, search

NAMES = ("q1", "q2", "qd1", "qd2", "qdd1", "qdd2")
PRICE = 3.0
EPS = float(np.finfo(float).eps)


def _base() -> Program:
    """Every leaf once: the motion, sines and cosines of two angles, and the position of a sliding joint."""
    trace = Trace()
    q1, q2, qd1, qd2, qdd1, qdd2 = (trace.record("input", name) for name in NAMES)
    cos_1, sin_1, cos_12, sin_12 = (trace.apply(name, x) for x in (q1, q1 + q2) for name in ("cos", "sin"))
    return Program.of(trace, [qd1 * qd2 + cos_1 * qdd1 * cos_12, sin_1 * qdd2 + sin_12 + q2 * qdd1])


LAYOUT = guarded_layout(Layout.of(_base(), PRICE))
FIRST = LAYOUT.about.degree.size
_DEGREES = LAYOUT.about.degree.tolist()
# Most factors of a summand that is written out: values stay within some powers of ten.
_MOST_FACTORS = 6


class Step(NamedTuple):
    """An operation on earlier nodes, leaves first; an operand is its place and whether it is negative."""

    kind: int
    left: tuple[int, bool]
    right: tuple[int, bool]
    number: float


class Drawn(NamedTuple):
    """Steps behind the leaves, and outputs as operands; None is 0."""

    steps: tuple[Step, ...]
    outputs: tuple[tuple[int, bool] | None, ...]


# Numbers that fold, equal ones, and any that no quotient of a few makes very large.
_NUMBERS = st.sampled_from([1.0, -1.0, 2.0, -0.5, 0.25]) | st.floats(0.1, 10.0) | st.floats(-10.0, -0.1)


@st.composite
def drawn(
    draw: st.DrawFn, most: int = 16, torques: bool = True, zeros: bool = True, numbers: Any = _NUMBERS
) -> Drawn:
    """Steps and two outputs; `torques` are sums of equal degree in the motion, or of gravity and motion."""
    degrees, factors = [*_DEGREES], [0] + [1] * (FIRST - 1)
    made: list[Step] = []
    wish = st.tuples(
        st.sampled_from([SUM, SUM, PRODUCT, PRODUCT, SCALED]), st.integers(0, 999), st.booleans(),
        st.integers(0, 999), st.booleans(), (st.just(0.0) | numbers) if zeros else numbers,
    )  # fmt: skip
    for kind, first, is_negative, second, is_other_negative, number in draw(st.lists(wish, max_size=most)):
        # Half of the operands are steps.
        count = len(degrees)
        left = first % count if first % 2 or not made else FIRST + first // 2 % len(made)
        fitting = [place for place in range(count) if _fits(kind, left, place, degrees, factors, torques)]
        right = fitting[second % len(fitting)] if fitting else 0
        if not fitting:
            kind = SCALED
        made.append(Step(kind, (left, is_negative), (right, is_other_negative), number))
        if kind == SCALED:
            degrees.append(degrees[left])
            factors.append(factors[left])
        elif kind == PRODUCT:
            degrees.append(degrees[left] + degrees[right])
            factors.append(factors[left] + factors[right])
        else:
            degrees.append(max(degrees[left], degrees[right]))
            factors.append(max(factors[left], factors[right]))
    of_torques = [place for place, degree in enumerate(degrees) if degree != 1 or not torques]
    last = st.integers(0, 999).map(lambda k: of_torques[-1 - k % min(len(of_torques), 6)])
    operand = st.tuples(last, st.booleans())
    outputs = draw(st.tuples(operand, st.none() | operand if zeros else operand))
    return Drawn(tuple(made), outputs)


def _fits(
    kind: int, left: int, right: int, degrees: Sequence[int], factors: Sequence[int], torques: bool
) -> bool:
    if kind == SCALED:
        return True
    if kind == PRODUCT:
        fits = degrees[left] + degrees[right] <= 2 or not torques
        return fits and factors[left] + factors[right] <= _MOST_FACTORS
    return not torques or degrees[left] == degrees[right] or 1 not in (degrees[left], degrees[right])


def nodes_of(program: Drawn, zero_from: int | None = None) -> Nodes:
    """Arrays, with nothing folded; uses of one place, if given, are of the number 0 instead."""
    nodes = nodes_of_size(8 * (FIRST + len(program.steps)) + 64, len(program.outputs))

    def reference(operand: tuple[int, bool] | None) -> int:
        return ZERO if operand is None or operand[0] == zero_from else 2 * operand[0] + operand[1]

    for place, step in enumerate(program.steps, start=FIRST):
        nodes.kind[place], nodes.number[place], nodes.source[place] = step.kind, step.number, -1
        nodes.left[place], nodes.right[place] = reference(step.left), reference(step.right)
    nodes.outputs[:] = [*map(reference, program.outputs)]
    nodes.length[0] = FIRST + len(program.steps)
    return nodes


def traced(program: Drawn) -> Program:
    """The same, written as formulas are: what folds is folded."""
    trace = Trace()
    of = Program.of(LAYOUT.trace, LAYOUT.leaves).folded(trace, {})
    known: list[Any] = [1.0, *map(of, LAYOUT.leaves)]

    def value(operand: tuple[int, bool] | None) -> Any:
        if operand is None:
            return 0.0
        return trace.negative(known[operand[0]]) if operand[1] else known[operand[0]]

    for step in program.steps:
        a, b = value(step.left), value(step.right)
        if step.kind == SCALED:
            known.append(trace.multiply(step.number, a))
        else:
            known.append((trace.add if step.kind == SUM else trace.multiply)(a, b))
    return Program.of(trace, [*map(value, program.outputs)])


def states(seed: int, count: int = 7) -> dict[str, FloatArray]:
    """Inputs by name at random states."""
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(-2.0, 2.0, count) for name in NAMES}


class Evaluated(NamedTuple):
    """Values of nodes and outputs, (nodes, N) and (outputs, N), and what the rounding of either may be."""

    values: Any
    outputs: Any
    rounding: FloatArray
    output_rounding: FloatArray


def evaluated(
    nodes: Nodes,
    leaf_values: FloatArray,
    *,
    of_number: int = 1,
    factors: Any = None,
    nudged: tuple[int, complex] = (-1, 0.0),
) -> Evaluated:
    """Evaluate arrays with signs and zeros everywhere, apart from the kernels.

    The rounding of a value is eps times the sum of its written-out summands' magnitudes, times the roundings
    that a summand takes part in: those of its leaves, its operations, and `of_number` for every number.
    `factors` multiply the numbers, `nudged` is a place and what is added to its value; both may be complex.
    """
    count = int(nodes.length[0])
    values = [*leaf_values.astype(complex)]
    sizes, roundings = [*np.abs(leaf_values)], [1] * len(leaf_values)
    nothing = np.zeros(leaf_values.shape[1])

    def operand(reference: int) -> tuple[Any, FloatArray, int]:
        if reference < 0:
            return nothing, nothing, 0
        place = reference >> 1
        return (-values[place] if reference & 1 else values[place]), sizes[place], roundings[place]

    for place in range(len(leaf_values), count):
        a, size_a, rounding_a = operand(int(nodes.left[place]))
        if nodes.kind[place] == SCALED:
            number = nodes.number[place] * (1.0 if factors is None else factors[place])
            values.append(number * a)
            sizes.append(abs(nodes.number[place]) * size_a)
            roundings.append(rounding_a + 1 + of_number)
        else:
            b, size_b, rounding_b = operand(int(nodes.right[place]))
            if nodes.kind[place] == PRODUCT:
                values.append(a * b)
                sizes.append(size_a * size_b)
                roundings.append(rounding_a + rounding_b + 1)
            else:
                values.append(a + b)
                sizes.append(size_a + size_b)
                roundings.append(max(rounding_a, rounding_b) + 1)
        if place == nudged[0]:
            values[place] = values[place] + nudged[1]
    own = [operand(int(reference)) for reference in nodes.outputs]
    is_real = factors is None and nudged[0] < 0
    part = np.real if is_real else np.asarray
    return Evaluated(
        part(np.array(values)),
        part(np.array([value + nothing for value, _, _ in own])),
        EPS * np.array(sizes) * np.array(roundings)[:, None],
        EPS * np.array([size * rounding for _, size, rounding in own]),
    )


def used_places(nodes: Nodes) -> set[int]:
    """Places of the nodes that the outputs need, leaves included."""
    waiting = [int(reference) >> 1 for reference in nodes.outputs if reference >= 0]
    found: set[int] = set()
    while waiting:
        place = waiting.pop()
        if place in found:
            continue
        found.add(place)
        if place >= FIRST:
            sides = (
                [nodes.left[place]]
                if nodes.kind[place] == SCALED
                else [nodes.left[place], nodes.right[place]]
            )
            waiting += [int(reference) >> 1 for reference in sides if reference >= 0]
    return found


def operations_of(nodes: Nodes) -> int:
    """Sums, products, and multiples of nodes that the outputs need; numbers themselves are no operation."""
    return sum(
        place >= FIRST and (nodes.kind[place] != SCALED or nodes.left[place] != 2 * ONE)
        for place in used_places(nodes)
    )


def scratch_of(
    nodes: Nodes, inputs: dict[str, FloatArray], targets: FloatArray, scale: FloatArray, few: int
) -> tuple[Any, Any]:
    """Memory of a search from a program, of which the first states are the few, and all states as sample."""
    laid = Layout(LAYOUT.trace, LAYOUT.leaves, LAYOUT.about, nodes)
    pool = search.Pool(laid, inputs, targets, scale)
    count = len(pool)
    sizes = search.SearchSizes(active=count, few=few, watched=count)
    found = search.ProgramSearch(laid, pool, kernels.SearchSettings(), sizes)
    return guarded(found._memory), guarded(pool.sample(np.arange(count), nodes.kind.size))
