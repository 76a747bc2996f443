"""Layout of a program in arrays, as the compiled kernels change it.

A node is a leaf, a sum, a product, or a number times a node. A reference to a node is twice its place, plus 1
for its negative: signs are free, so that a difference and its negative are one node. Leaves come first: the
number 1, then the inputs and the sines and cosines of the programs that a search begins from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace

# Kinds of a node.
LEAF, SUM, PRODUCT, SCALED = 0, 1, 2, 3
# Reference of the number 0.
ZERO = -1
# Place of the leaf of the number 1.
ONE = 0
# Arrays have room for this multiple of the nodes of the longest program.
_ROOM = 2
# Further nodes for which they have room.
_MORE = 128


class Nodes(NamedTuple):
    """A program; entries beyond `length[0]` are unused."""

    kind: NDArray[np.int8]
    left: NDArray[np.int32]  # reference; of a scaled node the one that its number multiplies
    right: NDArray[np.int32]  # reference of a sum's or a product's second operand
    number: FloatArray  # factor of a scaled node
    source: NDArray[np.int32]  # node of the current program whose number a trial's number derives from, or -1
    outputs: NDArray[np.int32]  # references
    length: NDArray[np.int64]  # number of nodes, shape (1,)


class Leaves(NamedTuple):
    """What the kernels must know of the leaves."""

    degree: NDArray[np.int8]  # in the motion: 1 for velocities, 2 for accelerations
    steps: NDArray[np.uint64]  # a bit for every operation in the argument of a sine or cosine
    price: FloatArray  # of a sine or cosine
    partner: NDArray[np.int32]  # leaf of the cosine of a sine's angle, and the reverse; -1 without one


def nodes_of_size(room: int, outputs: int) -> Nodes:
    """Arrays for programs of at most `room` nodes."""
    whole = [np.zeros(room, dtype=np.int32) for _ in range(3)]
    return Nodes(
        np.zeros(room, dtype=np.int8),
        whole[0],
        whole[1],
        np.zeros(room),
        whole[2],
        np.full(outputs, ZERO, dtype=np.int32),
        np.zeros(1, dtype=np.int64),
    )


def copied(nodes: Nodes) -> Nodes:
    """A copy that no kernel changes."""
    return Nodes._make(array.copy() for array in nodes)


@dataclass(frozen=True)
class Layout:
    """A program in arrays, its leaves, and the way back from programs over the same leaves."""

    trace: Trace
    leaves: tuple[Expression, ...]  # behind the number 1
    about: Leaves
    exact: Nodes

    @classmethod
    def of(cls, program: Program, sine_price: float) -> Layout:
        """Lay a program out."""
        trace = Trace()
        whole = Program.of(trace, [*map(program.folded(trace, {}), program.outputs)])
        leaves = tuple(
            step
            for step in whole.steps
            if step.operation in ("cos", "sin")
            or (step.operation == "input" and (step.arguments[0].startswith("qd") or _is_factor(whole, step)))
        )
        room = _ROOM * len(whole.steps) + len(leaves) + _MORE
        return cls(trace, leaves, _about(leaves, sine_price), _nodes_of(whole, leaves, room))

    def values(self, inputs: Any) -> FloatArray:
        """Values of the leaves, shape (leaves, N), from an array (N,) per input."""
        count = len(next(iter(inputs.values())))
        return np.vstack([np.ones(count), Program.of(self.trace, self.leaves).run(inputs)])

    def program(self, nodes: Nodes) -> Program:
        """Write arrays as a program, step by step.

        If only the negative of a difference is needed, the difference is written the other way round.
        """
        trace, count = Trace(), int(nodes.length[0])
        values: dict[int, Any] = {ONE: 1.0}
        fold = Program.of(self.trace, self.leaves).folded(trace, {})
        values |= {place: fold(leaf) for place, leaf in enumerate(self.leaves, start=1)}
        users = np.zeros(count, dtype=int)
        for place in range(len(values), count):
            for reference in _operands(nodes, place):
                users[reference >> 1] += 1
        turned = {
            reference >> 1
            for reference in nodes.outputs.tolist()
            if reference & 1
            and reference != ZERO
            and nodes.kind[reference >> 1] == SUM
            and users[reference >> 1] == 0
            and (nodes.outputs >> 1 == reference >> 1).sum() == 1
        }

        def signed(reference: int) -> Any:
            if reference == ZERO:
                return 0.0
            value = values[reference >> 1]
            if not reference & 1 or reference >> 1 in turned:
                return value
            return trace.record("negative", value) if isinstance(value, Expression) else -value

        for place in range(len(values), count):
            left, right = int(nodes.left[place]), int(nodes.right[place])
            a = values[left >> 1]
            if nodes.kind[place] == SCALED:
                number = float(nodes.number[place])
                values[place] = trace.record("multiply", number, a) if isinstance(a, Expression) else number
                continue
            b = values[right >> 1]
            if nodes.kind[place] == PRODUCT:
                values[place] = trace.record("multiply", a, b)
            elif place in turned:
                # -(a + b) has no form without a change of sign, which is free
                values[place] = (
                    trace.record("subtract", b, a)
                    if right & 1
                    else trace.record("negative", trace.record("add", a, b))
                )
            else:
                values[place] = trace.record("subtract" if right & 1 else "add", a, b)
        return Program.of(trace, [signed(int(reference)) for reference in nodes.outputs])


def _is_factor(program: Program, leaf: Expression) -> bool:
    """Whether an input is used outside the arguments of sines and cosines."""
    inside = {leaf.order}
    for step in program.steps:
        uses = any(isinstance(x, Expression) and x.order in inside for x in step.arguments)
        if not uses or step.operation in ("cos", "sin"):
            continue
        if step.operation == "multiply" and all(isinstance(x, Expression) for x in step.arguments):
            return True
        inside.add(step.order)
    return any(isinstance(x, Expression) and x.order in inside for x in program.outputs)


def _operands(nodes: Nodes, place: int) -> list[int]:
    left, right = int(nodes.left[place]), int(nodes.right[place])
    return [left] if nodes.kind[place] == SCALED else [left, right]


def _about(leaves: Sequence[Expression], sine_price: float) -> Leaves:
    steps = dict[int, int]()  # number of an operation in an argument
    count = len(leaves) + 1
    degree, masks = np.zeros(count, dtype=np.int8), np.zeros(count, dtype=np.uint64)
    price, partner = np.zeros(count), np.full(count, -1, dtype=np.int32)
    by_angle: dict[int, int] = {}
    for place, leaf in enumerate(leaves, start=1):
        if leaf.operation == "input":
            degree[place] = leaf.arguments[0].count("d")
            continue
        price[place] = sine_price
        (argument,) = leaf.arguments
        mask = 0
        for step in Program.of(leaf.trace, [argument]).steps:
            if step.operation in ("add", "subtract", "multiply"):
                mask |= 1 << steps.setdefault(step.order, len(steps))
        if len(steps) > masks.itemsize * 8:
            raise ModelError(
                "level fast has no room for so many operations in arguments of sines and cosines",
                found=f"more than {masks.itemsize * 8}",
                next_step="take the default level term",
            )
        masks[place] = mask
        partner_place = by_angle.setdefault(argument.order, place)
        if partner_place != place:
            partner[place], partner[partner_place] = partner_place, place
    return Leaves(degree, masks, price, partner)


def _nodes_of(program: Program, leaves: Sequence[Expression], room: int) -> Nodes:
    """Nodes in the order of the steps; numbers are multiples of the leaf 1."""
    nodes = nodes_of_size(room, len(program.outputs))
    count = len(leaves) + 1
    references = {leaf.order: 2 * place for place, leaf in enumerate(leaves, start=1)}

    def append(kind: int, left: int, right: int = 0, number: float = 0.0) -> int:
        nonlocal count
        nodes.kind[count], nodes.left[count], nodes.right[count] = kind, left, right
        nodes.number[count] = number
        count += 1
        return 2 * (count - 1)

    def reference(x: Any) -> int:
        if isinstance(x, Expression):
            return references[x.order]
        return append(SCALED, 2 * ONE, 0, float(x)) if x else ZERO

    arguments = {
        step.order
        for leaf in leaves
        if leaf.operation != "input"
        for step in Program.of(leaf.trace, leaf.arguments).steps
    }
    for step in program.steps:
        if step.order in references or (step.order in arguments and not _is_known(step, references)):
            continue
        if step.operation == "negative":
            references[step.order] = reference(step.arguments[0]) ^ 1
            continue
        first, second = step.arguments
        if step.operation == "multiply" and not isinstance(first, Expression):
            references[step.order] = append(SCALED, reference(second), 0, float(first))
        elif step.operation == "multiply":
            references[step.order] = append(PRODUCT, reference(first), reference(second))
        else:
            flip = step.operation == "subtract"
            references[step.order] = append(SUM, reference(first), reference(second) ^ flip)
    nodes.outputs[:] = [reference(output) for output in program.outputs]
    nodes.length[0] = count
    return nodes


def _is_known(step: Expression, references: dict[int, int]) -> bool:
    return step.operation != "input" and all(
        x.order in references for x in step.arguments if isinstance(x, Expression)
    )
