"""Compiled kernels of the program search: canonical form, edits, values, derivatives, and tries.

Arrays are laid out as `layout` says. Functions change the arrays they are given; nothing is allocated in a
try. Sums over states run in a fixed order, so that every machine finds the same numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from gd_analyze.program_search.layout import LEAF, ONE, PRODUCT, SCALED, SUM, ZERO, Leaves, Nodes

# Functions that only kernels call need no way in from Python, which halves the time of the first run.
_WITHOUT_WRAPPERS: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_inner = njit(cache=True, error_model="numpy", **_WITHOUT_WRAPPERS)
_entry = njit(cache=True, error_model="numpy")


# Numba's cache names these tuples: after one is renamed, a cache of before (*.nbi) must be removed.
class Canon(NamedTuple):
    """Memory for the canonical form, of one entry per node but for the table."""

    table: Any  # int32, places of nodes by their hash, plus 1; its size is a power of 2
    image: Any  # int32, reference of the new node of every old one
    mark: Any  # int8: 0 new, 1 waiting for its operands, 2 done
    stack: Any  # int32
    degree: Any  # int8, of the new nodes


@_inner
def _node(nodes: Nodes, canon: Canon, kind: int, left: int, right: int, number: float, source: int) -> int:
    """Reference of a node: the one that exists, or a new one."""
    size = canon.table.size
    key = (int(left) * 31 + int(right)) * 5 + kind
    if kind == SCALED:
        key += int(number * 1048576.0) * 2654435
    slot = (key * 2654435761 >> 7) & (size - 1)
    while canon.table[slot]:
        place = canon.table[slot] - 1
        if (
            nodes.kind[place] == kind
            and nodes.left[place] == left
            and nodes.right[place] == right
            and nodes.number[place] == number
        ):
            return 2 * place
        slot = (slot + 1) & (size - 1)
    place = nodes.length[0]
    if place >= nodes.kind.size:
        return -2
    nodes.length[0] = place + 1
    canon.table[slot] = place + 1
    nodes.kind[place], nodes.left[place], nodes.right[place] = kind, left, right
    nodes.number[place], nodes.source[place] = number, source
    first = canon.degree[left >> 1]
    if kind == SCALED:
        canon.degree[place] = first
    elif kind == PRODUCT:
        canon.degree[place] = first + canon.degree[right >> 1]
        if canon.degree[place] > 2:
            return -2
    else:
        second = canon.degree[right >> 1]
        if first != second and (first == 1 or second == 1):
            return -2
        canon.degree[place] = max(first, second)
    return 2 * place


@_inner
def _scaled(nodes: Nodes, canon: Canon, number: float, a: int, source: int) -> int:
    """A number times a node."""
    if a < 0 or number == 0.0:
        return min(a, ZERO)
    flip = a & 1
    a ^= flip
    if number < 0.0:
        number, flip = -number, flip ^ 1
    if nodes.kind[a >> 1] == SCALED:
        number *= nodes.number[a >> 1]
        if source < 0:
            source = nodes.source[a >> 1]
        a = nodes.left[a >> 1]
    if number == 1.0:
        return a ^ flip
    reference = _node(nodes, canon, SCALED, a, 0, number, source)
    return reference if reference < 0 else reference ^ flip


@_inner
def _sum(nodes: Nodes, canon: Canon, a: int, b: int) -> int:
    """A sum; multiples of one node are one multiple."""
    if a < ZERO or b < ZERO:
        return -2
    if a < 0:
        return b
    if b < 0:
        return a
    own_a, own_b, size_a, size_b, source = a, b, 1.0, 1.0, -1
    if nodes.kind[a >> 1] == SCALED:
        own_a, size_a = nodes.left[a >> 1] | (a & 1), nodes.number[a >> 1]
        source = nodes.source[a >> 1]
    if nodes.kind[b >> 1] == SCALED:
        own_b, size_b = nodes.left[b >> 1] | (b & 1), nodes.number[b >> 1]
        if source < 0:
            source = nodes.source[b >> 1]
    if own_a >> 1 == own_b >> 1:
        return _scaled(nodes, canon, size_a + (size_b if own_a == own_b else -size_b), own_a, source)
    if a >> 1 > b >> 1:
        a, b = b, a
    flip = a & 1
    reference = _node(nodes, canon, SUM, a ^ flip, b ^ flip, 0.0, -1)
    return reference if reference < 0 else reference ^ flip


@_inner
def _product(nodes: Nodes, canon: Canon, a: int, b: int) -> int:
    """A product; numbers and signs are moved outside."""
    if a < ZERO or b < ZERO:
        return -2
    if a < 0 or b < 0:
        return ZERO
    flip = (a ^ b) & 1
    a, b = a >> 1 << 1, b >> 1 << 1
    for _ in range(2):
        if a == 2 * ONE:
            return b ^ flip
        if nodes.kind[a >> 1] == SCALED and nodes.left[a >> 1] == 2 * ONE:
            return _scaled(nodes, canon, nodes.number[a >> 1], b ^ flip, nodes.source[a >> 1])
        a, b = b, a
    if a > b:
        a, b = b, a
    reference = _node(nodes, canon, PRODUCT, a, b, 0.0, -1)
    return reference if reference < 0 else reference ^ flip


@_entry
def canonical(old: Nodes, new: Nodes, canon: Canon, leaves: Leaves) -> bool:
    """Write the canonical form of `old` into `new`: equal nodes once, numbers folded, dead nodes gone.

    False if it has a cycle, is too long, or is not a torque: linear in accelerations, and quadratic in
    velocities. `canon.mark` tells which leaves are used, `canon.degree` degrees of the new nodes.
    """
    count = leaves.degree.size
    canon.table[:] = 0
    canon.mark[: old.length[0]] = 0
    for place in range(count):
        new.kind[place] = LEAF
        canon.image[place] = 2 * place
        canon.degree[place] = leaves.degree[place]
    new.length[0] = count
    for row in range(old.outputs.size):
        top = 0
        root = old.outputs[row]
        if root >= 0:
            canon.stack[0] = root >> 1
            top = 1
        while top:
            place = canon.stack[top - 1]
            if canon.mark[place] == 2:
                top -= 1
                continue
            if place < count:
                canon.mark[place] = 2
                top -= 1
                continue
            canon.mark[place] = 1
            waiting = top
            for side in range(1 if old.kind[place] == SCALED else 2):
                operand = old.left[place] if side == 0 else old.right[place]
                if operand >= 0 and canon.mark[operand >> 1] != 2:
                    if canon.mark[operand >> 1] == 1 or top >= canon.stack.size:
                        return False
                    canon.stack[top] = operand >> 1
                    top += 1
            if top > waiting:
                continue
            a = old.left[place]
            a = canon.image[a >> 1] ^ (a & 1) if a >= 0 and canon.image[a >> 1] >= 0 else ZERO
            if old.kind[place] == SCALED:
                reference = _scaled(new, canon, old.number[place], a, old.source[place])
            else:
                b = old.right[place]
                b = canon.image[b >> 1] ^ (b & 1) if b >= 0 and canon.image[b >> 1] >= 0 else ZERO
                reference = _sum(new, canon, a, b) if old.kind[place] == SUM else _product(new, canon, a, b)
            if reference < ZERO:
                return False
            canon.image[place] = reference
            canon.mark[place] = 2
            top -= 1
        image = ZERO if root < 0 else canon.image[root >> 1]
        new.outputs[row] = image ^ (root & 1) if image >= 0 else ZERO
    return True


@_entry
def cost(nodes: Nodes, leaves: Leaves, used: Any) -> float:
    """Operations, with sines and cosines at their price; `used` (nodes,) is overwritten."""
    count, total = leaves.degree.size, 0.0
    used[: nodes.length[0]] = 0
    for row in range(nodes.outputs.size):
        if nodes.outputs[row] >= 0:
            used[nodes.outputs[row] >> 1] = 1
    steps = np.uint64(0)
    for place in range(nodes.length[0] - 1, -1, -1):
        if not used[place]:
            continue
        if place < count:
            total += leaves.price[place]
            steps |= leaves.steps[place]
            continue
        used[nodes.left[place] >> 1] = 1
        if nodes.kind[place] != SCALED:
            used[nodes.right[place] >> 1] = 1
            total += 1.0
        elif nodes.left[place] != 2 * ONE:
            total += 1.0
    while steps:
        total += 1.0
        steps &= steps - np.uint64(1)
    return total


@_entry
def evaluate_nodes(nodes: Nodes, values: Any, first_node: int, begin: int, end: int) -> None:
    """Values of the nodes from `first_node` on at states `begin` to `end`, (nodes, states), in place."""
    for place in range(first_node, nodes.length[0]):
        out = values[place, begin:end]
        a = values[nodes.left[place] >> 1, begin:end]
        if nodes.kind[place] == SCALED:
            number = nodes.number[place]
            for s in range(out.size):
                out[s] = number * a[s]
            continue
        b = values[nodes.right[place] >> 1, begin:end]
        if nodes.kind[place] == PRODUCT:
            for s in range(out.size):
                out[s] = a[s] * b[s]
        elif nodes.right[place] & 1:
            for s in range(out.size):
                out[s] = a[s] - b[s]
        else:
            for s in range(out.size):
                out[s] = a[s] + b[s]


@_entry
def errors(nodes: Nodes, values: Any, targets: Any, scale: Any, begin: int, end: int, out: Any) -> float:
    """Errors over allowed ones at states, (outputs, states), from values; returns the largest."""
    worst = 0.0
    for row in range(nodes.outputs.size):
        reference = nodes.outputs[row]
        e, t, w = out[row, begin:end], targets[row, begin:end], scale[row, begin:end]
        if reference < 0:
            for s in range(e.size):
                e[s] = -t[s] * w[s]
        elif reference & 1:
            v = values[reference >> 1, begin:end]
            for s in range(e.size):
                e[s] = (-v[s] - t[s]) * w[s]
        else:
            v = values[reference >> 1, begin:end]
            for s in range(e.size):
                e[s] = (v[s] - t[s]) * w[s]
        for s in range(e.size):
            worst = max(worst, abs(e[s]))
    return worst


@_entry
def largest_errors(
    nodes: Nodes, leaf_values: Any, targets: Any, scale: Any, values: Any, block: Any, out: Any
) -> None:
    """Errors over allowed ones at many states, (outputs, states), block by block; `values` is scratch."""
    count, size, first = targets.shape[1], values.shape[1], leaf_values.shape[0]
    for begin in range(0, count, size):
        end = min(begin + size, count)
        values[:first, : end - begin] = leaf_values[:, begin:end]
        evaluate_nodes(nodes, values, first, 0, end - begin)
        errors(nodes, values, targets[:, begin:end], scale[:, begin:end], 0, end - begin, block)
        out[:, begin:end] = block[:, : end - begin]


class NumberFit(NamedTuple):
    """Derivatives of errors by relative changes of a program's numbers, at some states."""

    numbers: Any  # int32 (nodes,): index of a scaled node's number, or -1
    members: Any  # int32 (outputs, numbers): numbers that an output depends on
    sizes: Any  # int64 (outputs,): how many
    slopes: Any  # (outputs, states, numbers): derivatives by `members`
    adjoint: Any  # (nodes, states)
    touched: Any  # int8 (nodes,)
    normal: Any  # (numbers, numbers), factored: its lower half is the Cholesky factor
    gradient: Any  # (numbers,)
    total: Any  # int64 (1,): how many numbers
    # (nodes, states that numbers are estimated at): sum over outputs of squared derivatives of the errors by
    # a node's value
    consequence: Any


# Mean squared error over allowed, to first order, beyond which an edit is not tried.
_HOPELESS = 9.0
# Relative size of what is added to the diagonal of the normal equations: numbers that make up for each other
# leave them singular.
DAMPING = 1e-7


@_inner
def slopes_at(nodes: Nodes, values: Any, scale: Any, first_node: int, fit: NumberFit) -> None:
    """Derivatives at the states of `fit.slopes`, by reverse accumulation, an output at a time."""
    states, count = fit.slopes.shape[1], nodes.length[0]
    total = 0
    for place in range(count):
        fit.numbers[place] = -1
        if nodes.kind[place] == SCALED and total < fit.gradient.size:
            fit.numbers[place] = total
            total += 1
    fit.total[0] = total
    estimated = fit.consequence.shape[1]
    fit.consequence[:count] = 0.0
    for row in range(nodes.outputs.size):
        fit.sizes[row] = 0
        reference = nodes.outputs[row]
        if reference < 0:
            continue
        fit.touched[:count] = 0
        top = reference >> 1
        fit.touched[top] = 1
        sign = -1.0 if reference & 1 else 1.0
        for s in range(states):
            fit.adjoint[top, s] = sign * scale[row, s]
        for place in range(top, first_node - 1, -1):
            if not fit.touched[place]:
                continue
            adjoint = fit.adjoint[place, :states]
            squares = fit.consequence[place]
            for s in range(estimated):
                squares[s] += adjoint[s] * adjoint[s]
            left = nodes.left[place] >> 1
            a = values[left, :states]
            if nodes.kind[place] == SCALED:
                number, member = nodes.number[place], fit.sizes[row]
                if fit.numbers[place] >= 0:
                    fit.members[row, member] = fit.numbers[place]
                    for s in range(states):
                        fit.slopes[row, s, member] = number * adjoint[s] * a[s]
                    fit.sizes[row] = member + 1
                if left >= first_node:
                    _add_scaled(fit, left, adjoint, number, states)
                continue
            right = nodes.right[place] >> 1
            if nodes.kind[place] == PRODUCT:
                b = values[right, :states]
                if left >= first_node:
                    _add_product(fit, left, adjoint, b, states)
                if right >= first_node:
                    _add_product(fit, right, adjoint, a, states)
                continue
            if left >= first_node:
                _add_scaled(fit, left, adjoint, 1.0, states)
            if right >= first_node:
                _add_scaled(fit, right, adjoint, -1.0 if nodes.right[place] & 1 else 1.0, states)


@_inner
def _add_scaled(fit: NumberFit, place: int, adjoint: Any, number: float, states: int) -> None:
    out = fit.adjoint[place, :states]
    if fit.touched[place]:
        for s in range(states):
            out[s] += number * adjoint[s]
    else:
        fit.touched[place] = 1
        for s in range(states):
            out[s] = number * adjoint[s]


@_inner
def _add_product(fit: NumberFit, place: int, adjoint: Any, factors: Any, states: int) -> None:
    out = fit.adjoint[place, :states]
    if fit.touched[place]:
        for s in range(states):
            out[s] += factors[s] * adjoint[s]
    else:
        fit.touched[place] = 1
        for s in range(states):
            out[s] = factors[s] * adjoint[s]


@_inner
def factor(fit: NumberFit, weights: Any, dense: Any) -> None:
    """Factor the normal equations of weighted least squares; weights (outputs, states)."""
    total, states = fit.total[0], fit.slopes.shape[1]
    normal = fit.normal
    normal[:total, :total] = 0.0
    for row in range(fit.sizes.size):
        size = fit.sizes[row]
        dense[:size, :size] = 0.0
        for s in range(states):
            weight, slopes = weights[row, s], fit.slopes[row, s]
            if weight == 0.0:
                continue
            for p in range(size):
                x = weight * slopes[p]
                line = dense[p]
                for q in range(p + 1):
                    line[q] += x * slopes[q]
        members = fit.members[row]
        for p in range(size):
            for q in range(p + 1):
                i, j = members[p], members[q]
                if i >= j:
                    normal[i, j] += dense[p, q]
                else:
                    normal[j, i] += dense[p, q]
    largest = 0.0
    for p in range(total):
        largest = max(largest, normal[p, p])
    for p in range(total):
        normal[p, p] += DAMPING * largest + 1e-300
    for p in range(total):
        # rows are contiguous: each row subtracts the products of those above it
        for q in range(p + 1):
            value = normal[p, q]
            for k in range(q):
                value -= normal[p, k] * normal[q, k]
            if p == q:
                normal[p, p] = np.sqrt(max(value, DAMPING * DAMPING * largest + 1e-300))
            else:
                normal[p, q] = value / normal[q, q]


@_inner
def step(fit: NumberFit, sample_errors: Any, weights: Any) -> None:
    """Relative changes of the numbers that reduce weighted squares of errors, into `fit.gradient`."""
    total, states = fit.total[0], fit.slopes.shape[1]
    gradient = fit.gradient
    gradient[:total] = 0.0
    for row in range(fit.sizes.size):
        size, members = fit.sizes[row], fit.members[row]
        sums = fit.adjoint[0]  # scratch: leaves have no adjoint
        sums[:size] = 0.0
        for s in range(states):
            x = sample_errors[row, s] * weights[row, s]
            slopes = fit.slopes[row, s]
            for p in range(size):
                sums[p] += x * slopes[p]
        for p in range(size):
            gradient[members[p]] -= sums[p]
    normal = fit.normal
    for p in range(total):
        value = gradient[p]
        for q in range(p):
            value -= normal[p, q] * gradient[q]
        gradient[p] = value / normal[p, p]
    for p in range(total - 1, -1, -1):
        value = gradient[p] / normal[p, p]
        gradient[p] = value
        for q in range(p):
            gradient[q] -= normal[p, q] * value


class Sample(NamedTuple):
    """States with their exact outputs."""

    values: Any  # (nodes, states); rows of leaves are given, others are scratch
    targets: Any  # (outputs, states)
    scale: Any  # (outputs, states): 1 over allowed errors
    errors: Any  # (outputs, states), scratch


class Memory(NamedTuple):
    """Scratch of a search; `few` states are the first of the active ones."""

    edited: Nodes
    trial: Nodes
    canon: Canon
    used: Any  # int8 (nodes,)
    values: Any  # (nodes, few): of the current program
    chord: NumberFit  # of the current program at the few states
    fit: NumberFit  # of a trial at the states of its largest errors
    ones: Any  # (outputs, few)
    weights: Any  # (outputs, few)
    numbers: Any  # (nodes,)
    dense: Any  # (numbers, numbers)
    remainder: Any  # (states that numbers are estimated at,)
    gathered: Sample  # at the states of the largest errors
    column: Any  # (active states,)
    block: Any  # (nodes, states of a block)
    block_errors: Any  # (outputs, states of a block)


@_inner
def _moved(
    nodes: Nodes, numbers: Any, fit: NumberFit, share: float, by_source: bool, first_node: int
) -> None:
    """Change a program's numbers from `numbers` by a share of the step in `fit.gradient`."""
    for place in range(first_node, nodes.length[0]):
        if nodes.kind[place] != SCALED:
            continue
        of = nodes.source[place] if by_source else place
        index = fit.numbers[of] if of >= 0 else -1
        if index >= 0:
            change = min(max(share * fit.gradient[index], -0.9), 3.0)
            nodes.number[place] = numbers[place] * (1.0 + change)


@_inner
def _gather(sample: Sample, gathered: Sample, column: Any, nodes: Nodes) -> None:
    """Copy the states of the largest errors, of all joints together, into `few`."""
    outputs, states = sample.errors.shape
    for s in range(states):
        column[s] = 0.0
    for row in range(outputs):
        e = sample.errors[row]
        for s in range(states):
            column[s] = max(column[s], abs(e[s]))
    order = np.argsort(-column[:states], kind="mergesort")
    for k in range(gathered.errors.shape[1]):
        s = order[k]
        for place in range(nodes.length[0]):
            gathered.values[place, k] = sample.values[place, s]
        for row in range(outputs):
            gathered.targets[row, k] = sample.targets[row, s]
            gathered.scale[row, k] = sample.scale[row, s]
            gathered.errors[row, k] = sample.errors[row, s]


@_entry
def refit(nodes: Nodes, active: Sample, memory: Memory, first_node: int, rounds: int, aim: float) -> float:
    """Adjust all numbers for the smallest largest error over the active states; returns that error.

    Each round is a weighted least-squares step: the larger an error, the larger its weight.
    """
    states = active.errors.shape[1]
    count = nodes.length[0]
    evaluate_nodes(nodes, active.values, first_node, 0, states)
    largest = errors(nodes, active.values, active.targets, active.scale, 0, states, active.errors)
    gathered, fit, numbers, weights = memory.gathered, memory.fit, memory.numbers, memory.weights
    for _ in range(rounds):
        if largest <= aim:
            break
        _gather(active, gathered, memory.column, nodes)
        slopes_at(nodes, gathered.values, gathered.scale, first_node, fit)
        for row in range(gathered.errors.shape[0]):
            for s in range(gathered.errors.shape[1]):
                share = gathered.errors[row, s] / largest
                share *= share
                weights[row, s] = share * share * share + 1e-3
        factor(fit, weights, memory.dense)
        step(fit, gathered.errors, weights)
        numbers[:count] = nodes.number[:count]
        best, best_share, share = largest, 0.0, 1.0
        for _ in range(5):
            _moved(nodes, numbers, fit, share, False, first_node)
            evaluate_nodes(nodes, active.values, first_node, 0, states)
            reached = errors(nodes, active.values, active.targets, active.scale, 0, states, active.errors)
            if reached < best:
                best, best_share = reached, share
            elif best_share > 0.0:
                break
            share *= 0.5
        _moved(nodes, numbers, fit, best_share, False, first_node)
        evaluate_nodes(nodes, active.values, first_node, 0, states)
        errors(nodes, active.values, active.targets, active.scale, 0, states, active.errors)
        if best > 0.998 * largest:
            largest = best
            break
        largest = best
    return largest


@_inner
def _score(errors_at_states: Any, total_cost: float) -> float:
    """Cost that a search minimises: operations, the largest error, and the joints' mean squared largest."""
    largest, mean = 0.0, 0.0
    for row in range(errors_at_states.shape[0]):
        e, most = errors_at_states[row], 0.0
        for s in range(e.size):
            most = max(most, abs(e[s]))
        largest = max(largest, most)
        mean += most * most
    return total_cost + largest + 3.0 * mean / errors_at_states.shape[0]


@_inner
def _append(nodes: Nodes, kind: int, left: int, right: int, number: float) -> int:
    """Append a node to an edited program; its reference, or -2 if there is no room."""
    place = nodes.length[0]
    if place >= nodes.kind.size:
        return -2
    nodes.length[0] = place + 1
    nodes.kind[place], nodes.left[place], nodes.right[place] = kind, left, right
    nodes.number[place], nodes.source[place] = number, -1
    return 2 * place


@_inner
def _put(
    rng: Any, nodes: Nodes, before: int, place: int, reference: int, everywhere: bool, first: int
) -> None:
    """Replace a node by a reference, everywhere or in one place; nodes from `before` on are the new ones."""
    chosen, uses = -1, 0
    if not everywhere:
        for k in range(first, before):
            uses += nodes.left[k] >= 0 and nodes.left[k] >> 1 == place
            uses += nodes.kind[k] != SCALED and nodes.right[k] >= 0 and nodes.right[k] >> 1 == place
        for row in range(nodes.outputs.size):
            uses += nodes.outputs[row] >= 0 and nodes.outputs[row] >> 1 == place
        if uses == 0:
            return
        chosen = rng.integers(0, uses)
    use = 0
    for k in range(first, before):
        for side in range(1 if nodes.kind[k] == SCALED else 2):
            operand = nodes.left[k] if side == 0 else nodes.right[k]
            if operand < 0 or operand >> 1 != place:
                continue
            if everywhere or use == chosen:
                new = ZERO if reference < 0 else reference ^ (operand & 1)
                if side == 0:
                    nodes.left[k] = new
                else:
                    nodes.right[k] = new
            use += 1
    for row in range(nodes.outputs.size):
        operand = nodes.outputs[row]
        if operand < 0 or operand >> 1 != place:
            continue
        if everywhere or use == chosen:
            nodes.outputs[row] = ZERO if reference < 0 else reference ^ (operand & 1)
        use += 1


@_inner
def _dot(weights: Any, a: Any, b: Any) -> float:
    value = 0.0
    for s in range(weights.size):
        value += weights[s] * a[s] * b[s]
    return value


@_inner
def _alike(
    rng: Any,
    current: Nodes,
    values: Any,
    degree: Any,
    weights: Any,
    target: Any,
    required: int,
    avoid: int,
    most_draws: float,
) -> int:
    """A node of a degree, the best of some random ones: a multiple of it comes near the target's values."""
    best, most = -1, -1.0
    draws = 1 + int(most_draws * rng.random() ** 3)
    for _ in range(draws):
        place = rng.integers(1, current.length[0])
        if degree[place] != required or place == avoid:
            continue
        square = _dot(weights, values[place], values[place])
        if square > 0.0:
            product = _dot(weights, target, values[place])
            gain = product * product / square
            if gain > most:
                best, most = place, gain
    return best


@_inner
def _replace(
    rng: Any, nodes: Nodes, current: Nodes, memory: Memory, degree: Any, first: int, draws: float
) -> bool:
    """Replace a step, or one use of it, by something simpler that is alike where it matters."""
    place = rng.integers(first, current.length[0])
    values, required = memory.values, degree[place]
    weights, node_values, remainder = memory.chord.consequence[place], values[place], memory.remainder
    count, before = weights.size, nodes.length[0]
    whole = _dot(weights, node_values, node_values)
    most = _HOPELESS * count
    choice = rng.random()
    if choice < 0.08:
        if whole > most or required == 1:
            return False
        reference = ZERO
        if required == 0:
            total, mean = 0.0, 0.0
            for s in range(count):
                mean += weights[s] * node_values[s]
                total += weights[s]
            reference = _append(nodes, SCALED, 2 * ONE, 0, mean / total) if total > 0.0 else ZERO
        if reference < ZERO:
            return False
        _put(rng, nodes, before, place, reference, rng.random() < 0.6, first)
        return True
    x = _alike(rng, current, values, degree, weights, node_values, required, place, draws)
    if x < 0:
        return False
    xx, kx = _dot(weights, values[x], values[x]), _dot(weights, node_values, values[x])
    number = kx / xx
    if choice < 0.6:
        is_plain = choice < 0.3
        factor_of = 1.0 if is_plain and number > 0.0 else -1.0 if is_plain else number
        if whole - 2.0 * factor_of * kx + factor_of * factor_of * xx > most:
            return False
        reference = 2 * x + (number < 0.0) if is_plain else _append(nodes, SCALED, 2 * x, 0, number)
    else:
        for s in range(count):
            remainder[s] = node_values[s] - number * values[x, s]
        y = _alike(rng, current, values, degree, weights, remainder, required, place, draws)
        if y < 0 or y == x:
            return False
        yy, xy = _dot(weights, values[y], values[y]), _dot(weights, values[x], values[y])
        ky = _dot(weights, node_values, values[y])
        bottom = xx * yy - xy * xy
        if bottom <= 1e-9 * xx * yy:
            return False
        c, d = (kx * yy - ky * xy) / bottom, (ky * xx - kx * xy) / bottom
        if whole - c * kx - d * ky > most:
            return False
        reference = -2
        if choice < 0.7:
            reference = _append(nodes, SUM, 2 * x + (c < 0.0), 2 * y + (d < 0.0), 0.0)
        elif choice < 0.8:
            inner_sum = _append(nodes, SUM, 2 * x + (c < 0.0), 2 * y + (d < 0.0), 0.0)
            reference = (
                _append(nodes, SCALED, inner_sum, 0, 0.5 * (abs(c) + abs(d))) if inner_sum >= 0 else -2
            )
        else:
            left = 2 * x + (c < 0.0) if rng.random() < 0.3 else _append(nodes, SCALED, 2 * x, 0, c)
            right = _append(nodes, SCALED, 2 * y, 0, d) if rng.random() < 0.6 else 2 * y + (d < 0.0)
            reference = _append(nodes, SUM, left, right, 0.0) if left >= 0 and right >= 0 else -2
    if reference < ZERO:
        return False
    _put(rng, nodes, before, place, reference, rng.random() < 0.6, first)
    return True


@_inner
def _drop(rng: Any, nodes: Nodes, current: Nodes, memory: Memory, degree: Any, first: int) -> bool:
    """Drop a summand, a number, or a factor, which a number replaces."""
    place = rng.integers(first, current.length[0])
    before, values = nodes.length[0], memory.values
    weights, node_values = memory.chord.consequence[place], values[place]
    if nodes.kind[place] == SCALED:
        reference = ZERO if nodes.left[place] == 2 * ONE else nodes.left[place]
    else:
        reference = nodes.left[place] if rng.random() < 0.5 else nodes.right[place]
        if reference < 0:
            return False
        operand_values = values[reference >> 1]
        square, product = (
            _dot(weights, operand_values, operand_values),
            _dot(weights, node_values, operand_values),
        )
        if square <= 0.0:
            return False
        whole = _dot(weights, node_values, node_values)
        if nodes.kind[place] == PRODUCT and degree[reference >> 1] != degree[place]:
            return False
        if whole - product * product / square > _HOPELESS * weights.size:
            return False
        if nodes.kind[place] == PRODUCT:
            number = product / square
            if rng.random() < 0.7:
                reference = _append(nodes, SCALED, reference, 0, number)
            elif number < 0.0:
                reference ^= 1
    if reference < ZERO:
        return False
    _put(rng, nodes, before, place, reference, rng.random() < 0.6, first)
    return True


@_inner
def _partner(rng: Any, current: Nodes, degree: Any, required: int) -> int:
    """A random node of a degree; -1 if chance finds none."""
    for _ in range(12):
        place = rng.integers(1, current.length[0])
        if degree[place] == required:
            return place
    return -1


@_inner
def _add(rng: Any, nodes: Nodes, current: Nodes, memory: Memory, degree: Any, first: int) -> bool:
    """Add a multiple of a node to a step, or a number to one."""
    place = rng.integers(first, current.length[0])
    before = nodes.length[0]
    summand = 2 * ONE
    if degree[place] == 1 or rng.random() < 0.7:
        x = _partner(rng, current, degree, degree[place])
        if x < 0 or x == place:
            return False
        summand = 2 * x
    weights, values = memory.chord.consequence[place], memory.values
    node_values, summand_values = (values[place], values[summand >> 1])
    size = np.sqrt(
        _dot(weights, node_values, node_values) / max(_dot(weights, summand_values, summand_values), 1e-300)
    )
    if summand == 2 * ONE or rng.random() < 0.8:
        summand = _append(nodes, SCALED, summand, 0, 0.02 * size * (2.0 * rng.random() - 1.0))
    elif rng.random() < 0.5:
        summand ^= 1
    if summand < 0:
        return False
    reference = _append(nodes, SUM, 2 * place, summand, 0.0)
    if reference < 0:
        return False
    _put(rng, nodes, before, place, reference, True, first)
    return True


@_inner
def _rewrite(rng: Any, nodes: Nodes, current: Nodes, leaves: Leaves, first: int) -> bool:
    """Write a step in another way that is equal: reassociate, factor out, distribute, move a number."""
    place = rng.integers(first, nodes.length[0])
    before, kind = nodes.length[0], nodes.kind[place]
    a, b = nodes.left[place], nodes.right[place]
    if a < 0 or (kind != SCALED and b < 0):
        return False
    reference = -2
    if kind == SCALED:
        inner = a >> 1
        number, flip = nodes.number[place], a & 1
        if inner < first:
            return False
        if nodes.kind[inner] == SUM:
            new_a = _append(nodes, SCALED, nodes.left[inner], 0, number)
            new_b = _append(nodes, SCALED, nodes.right[inner], 0, number)
            if new_a >= 0 and new_b >= 0:
                reference = _append(nodes, SUM, new_a, new_b, 0.0)
                nodes.source[new_a >> 1] = nodes.source[place]
                nodes.source[new_b >> 1] = nodes.source[place]
        elif nodes.kind[inner] == PRODUCT:
            x, y = nodes.left[inner], nodes.right[inner]
            if rng.random() < 0.5:
                x, y = y, x
            new_a = _append(nodes, SCALED, x, 0, number)
            if new_a >= 0:
                reference = _append(nodes, PRODUCT, new_a, y, 0.0)
                nodes.source[new_a >> 1] = nodes.source[place]
        if reference >= 0:
            reference ^= flip
    else:
        if rng.random() < 0.5:
            a, b = b, a
        inner = a >> 1
        x, y = nodes.left[inner], nodes.right[inner]
        has_parts = inner >= first
        if has_parts and nodes.kind[inner] != SCALED and rng.random() < 0.5:
            x, y = y, x
        if kind == SUM:
            flip = a & 1
            if has_parts and nodes.kind[inner] == SUM and rng.random() < 0.6:
                # (x + y) + b = x + (y + b)
                new_a = _append(nodes, SUM, y ^ flip, b, 0.0)
                reference = _append(nodes, SUM, x ^ flip, new_a, 0.0) if new_a >= 0 else -2
            elif has_parts and nodes.kind[inner] == SCALED and x != 2 * ONE:
                number = nodes.number[inner]
                place_b = b >> 1
                if place_b >= first and nodes.kind[place_b] == SCALED and nodes.left[place_b] != 2 * ONE:
                    # c x + d y = c (x + d/c y)
                    ratio = nodes.number[place_b] / number
                    new_a = _append(nodes, SCALED, nodes.left[place_b] ^ (b & 1) ^ flip, 0, ratio)
                    if new_a >= 0:
                        nodes.source[new_a >> 1] = nodes.source[place_b]
                else:
                    new_a = _append(nodes, SCALED, b ^ flip, 0, 1.0 / number)
                new_b = _append(nodes, SUM, x, new_a, 0.0) if new_a >= 0 else -2
                reference = _append(nodes, SCALED, new_b, 0, number) if new_b >= 0 else -2
                if reference >= 0:
                    nodes.source[reference >> 1] = nodes.source[inner]
                    reference ^= flip
            elif has_parts and nodes.kind[inner] == PRODUCT:
                place_b = b >> 1
                if place_b >= first and nodes.kind[place_b] == PRODUCT:
                    # x y + x z = x (y + z)
                    for _ in range(2):
                        p, q = nodes.left[place_b], nodes.right[place_b]
                        for _ in range(2):
                            if p == x and reference < 0:
                                new_a = _append(nodes, SUM, y ^ flip, q ^ (b & 1), 0.0)
                                reference = _append(nodes, PRODUCT, x, new_a, 0.0) if new_a >= 0 else -2
                            p, q = q, p
                        x, y = y, x
                if reference < 0 and (x | 1) == (b | 1):
                    # x y + x = x (y + 1)
                    new_a = _append(nodes, SUM, y ^ flip, 2 * ONE + ((b ^ x) & 1), 0.0)
                    reference = _append(nodes, PRODUCT, x, new_a, 0.0) if new_a >= 0 else -2
        else:
            flip = a & 1
            if a >> 1 == b >> 1 and inner < first and leaves.partner[inner] >= 0:
                # the square of a sine is 1 minus that of the cosine
                cosine = 2 * leaves.partner[inner]
                new_a = _append(nodes, PRODUCT, cosine, cosine, 0.0)
                reference = _append(nodes, SUM, 2 * ONE, new_a ^ 1, 0.0) if new_a >= 0 else -2
            elif has_parts and nodes.kind[inner] == PRODUCT:
                new_a = _append(nodes, PRODUCT, y, b, 0.0)
                reference = _append(nodes, PRODUCT, x ^ flip, new_a, 0.0) if new_a >= 0 else -2
            elif has_parts and nodes.kind[inner] == SCALED and x != 2 * ONE:
                number = nodes.number[inner]
                if rng.random() < 0.5:
                    new_a = _append(nodes, SCALED, b, 0, number)
                    reference = _append(nodes, PRODUCT, x ^ flip, new_a, 0.0) if new_a >= 0 else -2
                    if new_a >= 0:
                        nodes.source[new_a >> 1] = nodes.source[inner]
                else:
                    new_a = _append(nodes, PRODUCT, x ^ flip, b, 0.0)
                    reference = _append(nodes, SCALED, new_a, 0, number) if new_a >= 0 else -2
                    if reference >= 0:
                        nodes.source[reference >> 1] = nodes.source[inner]
            elif has_parts and nodes.kind[inner] == SUM:
                new_a = _append(nodes, PRODUCT, x, b, 0.0)
                new_b = _append(nodes, PRODUCT, y, b, 0.0)
                if new_a >= 0 and new_b >= 0:
                    reference = _append(nodes, SUM, new_a, new_b, 0.0) ^ flip
    if reference < 0:
        return False
    _put(rng, nodes, before, place, reference, True, first)
    return True


class SearchSettings(NamedTuple):
    """Settings of a search."""

    temperature: float = 0.12  # of acceptance, in operations
    # Largest errors over allowed: after one chord step at the few states, for a refit of a trial that saves
    # operations, and of one that saves none.
    hopeless: float = 30.0
    screened: float = 1.35
    worth_a_refit: float = 1.35
    worth_an_equal: float = 1.05
    limit: float = 1.0  # what no error over the allowed one exceeds
    rounds: int = 6  # of a refit
    exact: bool = False  # rewritings alone
    # Shares of tries with two edits or more, and with three.
    two_edits: float = 0.45
    three_edits: float = 0.15
    # Shares of edits: rewriting, replacing, dropping; the rest adds.
    rewriting: float = 0.3
    replacing: float = 0.42
    dropping: float = 0.2
    draws: float = 30.0  # most nodes that are compared for a replacement


@_inner
def _keep_values(current: Nodes, active: Sample, memory: Memory, first_node: int) -> None:
    """Keep the current program's values and derivatives at the few states.

    Its numbers become the sources of a trial's.
    """
    count = memory.values.shape[1]
    for place in range(current.length[0]):
        memory.values[place] = active.values[place, :count]
        current.source[place] = place
    slopes_at(current, memory.values, active.scale, first_node, memory.chord)


@_inner
def _copy(source: Nodes, target: Nodes) -> None:
    count = source.length[0]
    target.kind[:count] = source.kind[:count]
    target.left[:count] = source.left[:count]
    target.right[:count] = source.right[:count]
    target.number[:count] = source.number[:count]
    target.source[:count] = source.source[:count]
    target.outputs[:] = source.outputs
    target.length[0] = count


@_inner
def _holds(nodes: Nodes, watched: Sample, memory: Memory, limit: float) -> bool:
    """Whether no error at the watched states exceeds the limit."""
    count, size, first = watched.targets.shape[1], memory.block.shape[1], watched.values.shape[0]
    for begin in range(0, count, size):
        end = min(begin + size, count)
        memory.block[:first, : end - begin] = watched.values[:, begin:end]
        evaluate_nodes(nodes, memory.block, first, 0, end - begin)
        targets, scale = watched.targets[:, begin:end], watched.scale[:, begin:end]
        if errors(nodes, memory.block, targets, scale, 0, end - begin, memory.block_errors) > limit:
            return False
    return True


@_entry
def search(
    rng: Any,
    settings: SearchSettings,
    current: Nodes,
    tries: int,
    leaves: Leaves,
    active: Sample,
    watched: Sample,
    memory: Memory,
    statistics: Any,
) -> None:
    """Try edits of the current program, which is changed in place.

    It never exceeds the limit at active or watched states.
    `statistics` counts tries, canonical ones, screened ones, refits, accepted ones, and those that failed at
    watched states.
    """
    first, screened_states, states = leaves.degree.size, memory.values.shape[1], active.errors.shape[1]
    edited, trial, canon = memory.edited, memory.trial, memory.canon
    degree = np.empty(current.kind.size, dtype=np.int8)
    _copy(current, edited)
    canonical(edited, trial, canon, leaves)
    _copy(trial, current)
    degree[: current.length[0]] = canon.degree[: current.length[0]]
    current_cost = cost(current, leaves, memory.used)
    # Equal errors at all states leave the most room for edits.
    _copy(current, trial)
    refit(trial, active, memory, first, settings.rounds, 0.0)
    if _holds(trial, watched, memory, settings.limit):
        _copy(trial, current)
    evaluate_nodes(current, active.values, first, 0, states)
    errors(current, active.values, active.targets, active.scale, 0, states, active.errors)
    score = _score(active.errors, current_cost)
    _keep_values(current, active, memory, first)
    is_factored = False
    for _ in range(tries):
        statistics[0] += 1
        if current.length[0] == first:
            continue  # no step is left
        _copy(current, edited)
        draw = rng.random()
        edits = 1 + (draw < settings.two_edits) + (draw < settings.three_edits)
        changed, is_exact = False, True
        for _ in range(edits):
            choice = rng.random()
            if settings.exact or choice < settings.rewriting:
                changed |= _rewrite(rng, edited, current, leaves, first)
            elif choice < settings.rewriting + settings.replacing:
                is_exact = False
                changed |= _replace(rng, edited, current, memory, degree, first, settings.draws)
            elif choice < settings.rewriting + settings.replacing + settings.dropping:
                is_exact = False
                changed |= _drop(rng, edited, current, memory, degree, first)
            else:
                is_exact = False
                changed |= _add(rng, edited, current, memory, degree, first)
        if not changed or not canonical(edited, trial, canon, leaves):
            continue
        statistics[1] += 1
        total = cost(trial, leaves, memory.used)
        allowance = score - settings.temperature * np.log(1.0 - rng.random())
        if total > allowance:
            continue
        evaluate_nodes(trial, active.values, first, 0, screened_states)
        largest = errors(
            trial, active.values, active.targets, active.scale, 0, screened_states, active.errors
        )
        if not largest < settings.hopeless:
            continue
        if not is_exact:
            if not is_factored:
                factor(memory.chord, memory.ones, memory.dense)
                is_factored = True
            memory.numbers[: trial.length[0]] = trial.number[: trial.length[0]]
            step(memory.chord, active.errors, memory.ones)
            _moved(trial, memory.numbers, memory.chord, 1.0, True, first)
            evaluate_nodes(trial, active.values, first, 0, screened_states)
            after = errors(
                trial, active.values, active.targets, active.scale, 0, screened_states, active.errors
            )
            if not after < largest:
                trial.number[: trial.length[0]] = memory.numbers[: trial.length[0]]
            if not min(after, largest) < settings.screened * settings.limit:
                continue
        statistics[2] += 1
        if is_exact:
            if not largest <= settings.limit:
                continue
            new_score = score - current_cost + total
        else:
            evaluate_nodes(trial, active.values, first, 0, states)
            largest = errors(trial, active.values, active.targets, active.scale, 0, states, active.errors)
            if largest > settings.limit:
                most = settings.worth_a_refit if total < current_cost else settings.worth_an_equal
                if not largest < most * settings.limit:
                    continue
                statistics[3] += 1
                largest = refit(trial, active, memory, first, settings.rounds, 0.995 * settings.limit)
                if not largest <= settings.limit:
                    continue
            new_score = _score(active.errors, total)
        if new_score > allowance:
            continue
        if not is_exact and not _holds(trial, watched, memory, settings.limit):
            statistics[5] += 1
            continue
        statistics[4] += 1
        _copy(trial, current)
        degree[: current.length[0]] = canon.degree[: current.length[0]]
        score, current_cost = new_score, total
        _keep_values(current, active, memory, first)
        is_factored = False
