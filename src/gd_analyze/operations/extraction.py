"""Common subexpressions of several sums become variables, the most valuable first.

After the fast extraction of logic synthesis and its use on polynomials (Hosangadi, Fallah and Kastner,
Optimizing polynomial expressions by algebraic factorization and common subexpression elimination, IEEE
Transactions on Computer-Aided Design 25, 2006): candidates are sums of two terms that occur in several
places up to a product and a factor, products of two variables, and the cofactors of a variable in a sum.
Sums of more terms grow from sums of two.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from heapq import nlargest
from random import Random
from typing import NamedTuple

from gd_analyze.operations.sums import (
    PairProduct,
    Sums,
    SumTerms,
    TermPair,
    VariableProduct,
    over,
    times,
    without,
)


class _Place(NamedTuple):
    """Where a divisor occurs: in the sum of variable v, times a product and a factor."""

    v: int
    beside: VariableProduct
    scale: float


@dataclass(frozen=True)
class _Divisor:
    """A sum, its places, the operations saved by evaluating it once, and the factor of its definition."""

    terms: SumTerms
    places: tuple[_Place, ...]
    gain: int
    gauge: float


class _Factor(NamedTuple):
    """A variable or a coefficient's magnitude in several terms of one sum."""

    v: int
    magnitude: float
    variable: VariableProduct


class _Product(NamedTuple):
    """A product of two, and the operations saved by evaluating it once."""

    pair: PairProduct
    gain: int


_Candidate = TermPair | PairProduct | _Factor
_Step = _Divisor | _Product


# Most valuable sums of two to grow before one is chosen; more took longer and gained nothing.
_GROWN_SUMS = 16


def extract(sums: Sums, random: Random | None = None, noise: float = 0.0) -> None:
    """Extract in place until nothing saves operations.

    Random gains up to `noise` operations vary the choice among nearly equal candidates.
    """
    steps: dict[_Candidate, _Step] = {}
    while True:
        sums.tidy()
        _update(sums, steps)
        if not steps:
            return
        luck = random.random if random else lambda: 0.0
        scores = {candidate: step.gain + noise * luck() for candidate, step in steps.items()}
        best, best_score = None, -math.inf
        for candidate in nlargest(_GROWN_SUMS, scores, key=scores.__getitem__):
            step = steps[candidate]
            grown = _grown(sums, step) if isinstance(step, _Divisor) and len(step.places) > 1 else step
            score = scores[candidate] + grown.gain - step.gain
            if score > best_score:
                best, best_score = grown, score
        if isinstance(best, _Product):
            _name_product(sums, best.pair)
        elif best is not None:
            _name_divisor(sums, best)


def _update(sums: Sums, steps: dict[_Candidate, _Step]) -> None:
    """Re-evaluate the candidates that involve touched terms."""
    for changed in sums.touched:
        updates: list[tuple[_Candidate, _Step | None]]
        if isinstance(changed, TermPair):
            updates = [(changed, _pair(sums, changed))]
        elif isinstance(changed, PairProduct):
            updates = [(changed, _Product(changed, len(sums.products[changed]) - 1))]
        else:
            for factor in [c for c in steps if isinstance(c, _Factor) and c.v == changed]:
                del steps[factor]
            updates = list(_factors(sums, changed))
        for candidate, step in updates:
            if step is not None and step.gain > 0:
                steps[candidate] = step
            else:
                steps.pop(candidate, None)
    sums.touched.clear()


def _pair(sums: Sums, pair: TermPair) -> _Divisor | None:
    """Divisor of two terms in all places that do not overlap."""
    occurrences = sums.pairs[pair]
    if not occurrences:
        return None
    if len(occurrences) == 1:
        ((common, scale),) = occurrences.values()
        if not common and (abs(pair.ratio) != 1.0 or abs(scale) == 1.0):
            return None
    used: set[tuple[int, VariableProduct]] = set()
    places = []
    for (v, first, second), (common, scale) in occurrences.items():
        if (v, first) not in used and (v, second) not in used:
            used |= {(v, first), (v, second)}
            places.append(_Place(v, common, scale))
    return _divisor(sums, {pair.a: 1.0, pair.b: pair.ratio}, places)


def _factors(sums: Sums, v: int) -> Iterator[tuple[_Candidate, _Step | None]]:
    """Variables and coefficients in three or more terms of a sum; two form a pair."""
    terms = sums.terms.get(v, {})
    for x, count in Counter(x for monomial in terms for x in dict.fromkeys(monomial)).items():
        if count > 2:
            inner = {without(m, x): c for m, c in terms.items() if x in m}
            yield _Factor(v, 1.0, (x,)), _divisor(sums, inner, [_Place(v, (x,), 1.0)])
    for size, count in Counter(abs(c) for c in terms.values() if abs(c) != 1.0).items():
        if count > 2:
            inner = {m: math.copysign(1.0, c) for m, c in terms.items() if abs(c) == size}
            yield _Factor(v, size, ()), _divisor(sums, inner, [_Place(v, (), size)])


def _divisor(sums: Sums, terms: SumTerms, places: list[_Place]) -> _Divisor:
    """Gain of a divisor with the factor that makes most of its coefficients one."""
    magnitude = sums.magnitude
    saved = (len(places) - 1) * (len(terms) - 1)
    for _, beside, scale in places:
        saved -= len(beside)
        for m, c in terms.items():
            if m or beside:
                saved += len(m) + len(beside) - (abs(magnitude(scale * c)) == 1.0)
    # Coefficients that each factor would make one; the first of the best factors is taken.
    ones = {1.0: 0}
    after = len(places)
    for m, c in terms.items():
        factor = magnitude(abs(1.0 / c))
        ones[factor] = ones.get(factor, 0) + (1 if m else 0)
        after += len(m)
    for place in places:
        factor = magnitude(abs(place.scale))
        ones[factor] = ones.get(factor, 0) + 1
    gauge = max(ones, key=ones.__getitem__)
    return _Divisor(terms, tuple(places), saved - after + ones[gauge], gauge)


def _grown(sums: Sums, divisor: _Divisor) -> _Divisor:
    """The best of a divisor and all common sums of two of its places."""
    best = divisor
    for k, first in enumerate(divisor.places):
        for second in divisor.places[:k]:
            shared = _shared(sums, first, second)
            if len(shared) > len(divisor.terms):
                grown = _divisor(
                    sums, shared, [_Place(first.v, first.beside, 1.0), _scaled(sums, first, second)]
                )
                if grown.gain > best.gain:
                    best = grown
    return best


def _scaled(sums: Sums, first: _Place, second: _Place) -> _Place:
    """The second place with its scale relative to that of the first."""
    return _Place(second.v, second.beside, sums.magnitude(second.scale / first.scale))


def _shared(sums: Sums, first: _Place, second: _Place) -> SumTerms:
    """Terms that two places have in the same proportion."""
    ratio = _scaled(sums, first, second).scale
    second_terms, shared, used = sums.terms[second.v], {}, set()
    for monomial, c in sums.terms[first.v].items():
        inner = over(monomial, first.beside)
        if inner is None:
            continue
        image = times(second.beside, inner)
        if image not in second_terms or sums.magnitude(c * ratio) != second_terms[image]:
            continue
        if first.v == second.v and (monomial in used or image in used or image == monomial):
            continue
        used |= {monomial, image}
        shared[inner] = c
    return shared


def _name_product(sums: Sums, product: PairProduct) -> None:
    """Define a product of two, and use it wherever it occurs."""
    coefficient, variables = product
    occurrences = list(sums.products[product])
    number = sums.define({variables: coefficient})
    for v, monomial in occurrences:
        c = sums.terms[v][monomial]
        sums.put(v, monomial, 0.0)
        if len(variables) == 1:
            sums.add(v, times(without(monomial, *variables), (number,)), math.copysign(1.0, c))
            continue
        quotient = over(monomial, variables)
        while quotient is not None:
            monomial = times(quotient, (number,))
            quotient = over(monomial, variables)
        sums.add(v, monomial, c)


def _name_divisor(sums: Sums, divisor: _Divisor) -> None:
    """Define a sum, and use it in all its places."""
    magnitude = sums.magnitude
    number = sums.define({m: magnitude(c * divisor.gauge) for m, c in divisor.terms.items()})
    for place in divisor.places:
        for monomial in divisor.terms:
            sums.put(place.v, times(place.beside, monomial), 0.0)
        sums.add(place.v, times(place.beside, (number,)), magnitude(place.scale / divisor.gauge))
