"""A program rewritten in fewer operations: what its sums share is looked for beyond what its author wrote."""

from __future__ import annotations

from typing import Any

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.monomials import times
from gd_analyze.operations.program import Program
from gd_analyze.operations.rearrangement import rearrange
from gd_analyze.operations.sharing import SharedSums
from gd_analyze.operations.sums import Sums, Terms
from gd_analyze.operations.trace import Expression, Trace

# Rearrangements to try, and the same times operations, as those of a long program take longer.
_TRIES, _TRIES_TIMES_OPERATIONS = 400, 200_000

_PARTNER = {"cos": "sin", "sin": "cos"}


def rewritten(program: Program, tries: int = _TRIES) -> Program:
    """Write a program with the fewest operations that a second or two of rearranging find.

    Sines and cosines, and what they are taken of, remain as they are.

    Parameters
    ----------
    program
        Any program.
    tries
        Rearrangements to try at most.

    Returns
    -------
    Program
        The same outputs, but for round-off; never more operations.
    """
    leaves = [step for step in program.steps if step.operation in ("input", *_PARTNER)]
    sums = _sums_of(program, leaves)
    functions = {(str(leaf.operation), leaf.arguments): k for k, leaf in enumerate(leaves)}
    partners = {
        k: functions[_PARTNER[operation], arguments]
        for (operation, arguments), k in functions.items()
        if (_PARTNER.get(operation), arguments) in functions
    }
    extract(sums)
    rearrange(sums, min(tries, _TRIES_TIMES_OPERATIONS // max(sums.operations, 1)), partners)
    trace = Trace()
    found = SharedSums.of(sums, leaves, len(program.outputs))
    written = Program.of(trace, found.values(program.folded(trace, {})))
    return min(program, written, key=lambda one: one.count.total)


def _sums_of(program: Program, leaves: list[Expression]) -> Sums:
    """Take every step as a definition."""
    sums = Sums([], len(leaves))
    number = {leaf.order: k for k, leaf in enumerate(leaves)}

    def of(x: Any) -> Terms:
        if isinstance(x, Expression):
            return {(number[x.order],): 1.0}
        return {(): float(x)} if x else {}

    for step in program.steps:
        if step.order in number:
            continue
        terms: Terms = {}
        a, b = of(step.arguments[0]), of(step.arguments[-1])
        if step.operation == "multiply":
            products = {times(x, y): c * d for x, c in a.items() for y, d in b.items()}
            terms |= products
        elif step.operation == "negative":
            terms |= {x: -c for x, c in a.items()}
        else:
            sign = -1.0 if step.operation == "subtract" else 1.0
            for x, c in [*a.items(), *((y, sign * d) for y, d in b.items())]:
                terms[x] = terms.get(x, 0.0) + c
        number[step.order] = sums.define(terms)
    for k, output in enumerate(program.outputs, start=1):
        for x, c in of(output).items():
            sums.add(-k, x, c)
    return sums
