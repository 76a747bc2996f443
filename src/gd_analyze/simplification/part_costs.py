"""What the arithmetic of an element-level model costs, by the parts that need it."""

from __future__ import annotations

from collections import Counter, defaultdict

from gd_analyze.dynamics.elements import Element
from gd_analyze.operations.trace import Expression, Trace, is_constant
from gd_analyze.simplification.parts import Part, TracedParts


def part_costs(traced: TracedParts, parts: tuple[Part, ...], drives: bool) -> dict[frozenset[int], int]:
    """Operations by the set of parts that need them, those that put parts into torques included."""
    shared = blocks(traced.trace, [traced.expression(part) for part in parts])
    return dict(Counter(shared) + Counter(assembly(traced, parts, drives)))


def blocks(trace: Trace, outputs: list[object]) -> dict[frozenset[int], int]:
    """Operations, sines and cosines too, by the set of parts that need them, given each part's expression."""
    above: dict[int, int] = defaultdict(int)
    for p, expression in enumerate(outputs):
        if isinstance(expression, Expression):
            above[expression.order] |= 1 << p
    weights: dict[int, int] = defaultdict(int)
    for node in reversed(trace.expressions):
        parts = above.get(node.order, 0)
        if not parts:
            continue
        for argument in node.arguments:
            if isinstance(argument, Expression):
                above[argument.order] |= parts
        if node.operation not in ("input", "negative"):
            weights[parts] += 1
    return {
        frozenset(p for p in range(len(outputs)) if parts >> p & 1): weight
        for parts, weight in weights.items()
    }


def assembly(traced: TracedParts, parts: tuple[Part, ...], drives: bool) -> dict[frozenset[int], int]:
    """Operations that put the parts into the torques, by the set of parts that need them.

    One addition per part and joint, less one that every joint saves at its first term; an element of D is
    multiplied by an acceleration once for both of its effects and added to each joint once. Constants are
    summed beforehand. A drive's inertia stands on the diagonal already, product and all.
    """
    costs: dict[frozenset[int], int] = {}
    effects: dict[Element, list[int]] = {}
    for p, part in enumerate(parts):
        if is_constant(traced.expression(part), 0.0):
            costs[frozenset([p])] = 1  # nothing is lost without it, so it goes
        else:
            effects.setdefault(part.element, []).append(p)
    for element, live in effects.items():
        varying = any(isinstance(traced.expression(parts[p]), Expression) for p in live)
        if varying or element.j is None:
            costs |= {frozenset([p]): 1 for p in live}
        joints = 1 if element.i == element.j else 2
        if element.j is not None and not (drives and joints == 1):
            either = frozenset(live)
            costs[either] = costs.get(either, 0) + 2 * joints - (1 if varying else 0)
    return costs
