"""Polynomials in the same variables, and whole programs, evaluated in few operations."""

from __future__ import annotations

import itertools
from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.program import Program, fewest
from gd_analyze.operations.rearrangement import rearrange
from gd_analyze.operations.sums import EQUAL_WITHIN, Magnitudes, Sums, SumTerms, times, without
from gd_analyze.operations.trace import Expression, Trace

# Coefficients by product: a tuple of variables, each as often as its power.
Polynomial = Mapping[Any, float]

# Most rearrangements of a program.
MOST_TRIES_OF_PROGRAM = 400
# Most rearrangements of a program times its operations, as each takes longer where it is long.
_TRIES_TIMES_OPERATIONS = 200_000
_PARTNER = {"cos": "sin", "sin": "cos"}


def factored(polynomial: Polynomial, value: Callable[[Any], Any]) -> Any:
    """Evaluate a polynomial in nested form (a multivariate Horner scheme); 0.0 without terms.

    The variable in most terms is factored out repeatedly; then coefficients that several terms share.
    """
    terms = {variables: c for variables, c in polynomial.items() if c != 0.0}
    counts = Counter(itertools.chain.from_iterable(map(set, terms)))
    most = max(counts.values(), default=0)
    if most > 1:
        # Ties between variables are broken consistently: equal polynomials nest equally.
        common = max((variable for variable, count in counts.items() if count == most), key=repr)
        inside = {without(variables, common): c for variables, c in terms.items() if common in variables}
        outside = {variables: c for variables, c in terms.items() if common not in variables}
        nested = value(common) * factored(inside, value)
        return nested + factored(outside, value) if outside else nested
    total: Any = 0.0
    equal = Magnitudes(EQUAL_WITHIN)
    alike: dict[float, list[tuple[Hashable, ...]]] = defaultdict(list)
    for variables in sorted(terms, key=repr):
        alike[abs(equal(terms[variables]))].append(variables)
    for members in alike.values():
        coefficient, inner = terms[members[0]], 0.0
        for variables in members:
            product: Any = 1.0
            for variable in sorted(variables, key=repr):
                product = value(variable) * product
            inner = inner + (1.0 if terms[variables] * coefficient > 0 else -1.0) * product
        total = total + coefficient * inner
    return total


def shared_sums(polynomials: Sequence[Polynomial]) -> Sums:
    """Write polynomials as sums with shared parts, found by extraction."""
    numbers: dict[Hashable, int] = {}
    for variable in (x for polynomial in polynomials for product in polynomial for x in product):
        numbers.setdefault(variable, len(numbers))
    sums, equal = Sums([*numbers], len(polynomials)), Magnitudes(EQUAL_WITHIN)
    for row, polynomial in enumerate(polynomials, start=1):
        terms: SumTerms = {}
        for variables, c in polynomial.items():
            product = tuple(sorted(numbers[x] for x in variables))
            terms[product] = terms.get(product, 0.0) + c
        for product, c in terms.items():
            if c:
                sums.add(-row, product, sums.magnitude(equal(c)))
    extract(sums)
    return sums


def rewritten(program: Program, times: int = 1, seed: int = 0) -> Program:
    """Rewrite a program in fewer operations.

    The rearrangement takes `times` one to two seconds. Sines, cosines and their arguments are unchanged. The
    outputs are equal up to round-off.
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
    affordable = _TRIES_TIMES_OPERATIONS // max(sums.operations, 1)
    tries = times * min(MOST_TRIES_OF_PROGRAM, affordable)
    rearrange(sums, tries, partners, seed)
    trace = Trace()
    return fewest([program, Program.of(trace, sums.values(program.folded(trace, {})))])


def _sums_of(program: Program, leaves: list[Expression]) -> Sums:
    """Every step as a definition."""
    sums = Sums(leaves, len(program.outputs))
    number = {leaf.order: k for k, leaf in enumerate(leaves)}

    def of(x: Any) -> SumTerms:
        if isinstance(x, Expression):
            return {(number[x.order],): 1.0}
        return {(): float(x)} if x else {}

    for step in program.steps:
        if step.order in number:
            continue
        terms: SumTerms = {}
        a, b = of(step.arguments[0]), of(step.arguments[-1])
        if step.operation == "multiply":
            terms = {times(x, y): c * d for x, c in a.items() for y, d in b.items()}
        elif step.operation == "negative":
            terms = {x: -c for x, c in a.items()}
        else:
            sign = -1.0 if step.operation == "subtract" else 1.0
            for x, c in [*a.items(), *((y, sign * d) for y, d in b.items())]:
                terms[x] = terms.get(x, 0.0) + c
        number[step.order] = sums.define(terms)
    for k, output in enumerate(program.outputs, start=1):
        for x, c in of(output).items():
            sums.add(-k, x, c)
    return sums
