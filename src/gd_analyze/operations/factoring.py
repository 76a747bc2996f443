"""Polynomials as nested products: few operations, found greedily."""

from __future__ import annotations

import itertools
from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Mapping
from typing import Any

from gd_analyze.operations.monomials import EQUAL, Magnitudes, without

Variables = tuple[Hashable, ...]


def factored(polynomial: Mapping[Any, float], value: Callable[[Any], Any]) -> Any:
    """Evaluate a polynomial in nested form (a multivariate Horner scheme).

    The variable in most terms is taken out of them, again and again, inside and in what is left; then the
    coefficients that several terms share. On traced numbers equal inner sums and products are formed
    once, also between polynomials.

    Parameters
    ----------
    polynomial
        Coefficients by monomial: a tuple of variables, each as often as its power.
    value
        The value of a variable: a number, an array or an expression.

    Returns
    -------
    The polynomial's value, of the kind that `value` gives; 0.0 for no terms.
    """
    terms = {variables: c for variables, c in polynomial.items() if c != 0.0}
    counts = Counter(itertools.chain.from_iterable(map(set, terms)))
    if counts:
        times = max(counts.values())
        if times > 1:
            # Of equally frequent variables always the same one: equal polynomials nest alike.
            common = max((variable for variable, t in counts.items() if t == times), key=repr)
            inside, rest = {}, {}
            for variables, c in terms.items():
                if common in variables:
                    inside[without(variables, common)] = c
                else:
                    rest[variables] = c
            nested = value(common) * factored(inside, value)
            return nested + factored(rest, value) if rest else nested
    total: Any = 0.0
    equal = Magnitudes(EQUAL)
    alike: dict[float, list[Variables]] = defaultdict(list)
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
