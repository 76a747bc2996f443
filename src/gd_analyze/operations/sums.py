"""Sums of products with shared parts: changed term by term, reversible, always counted, and evaluated.

Every defined variable is a sum of products of inputs and other defined variables. An index lists what occurs
in several terms: pairs of terms that are equal up to a common product and factor, and products of two
variables, or of a coefficient and a variable.
"""

from __future__ import annotations

import bisect
from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

_V = TypeVar("_V")

# A product of variables (numbers) in ascending order, each as often as its power.
VariableProduct = tuple[int, ...]

# Relative difference of coefficients that are equal up to the round-off of their computation.
EQUAL_WITHIN = 1e-9


@lru_cache(maxsize=1 << 12)
def split(a: VariableProduct, b: VariableProduct) -> tuple[VariableProduct, VariableProduct, VariableProduct]:
    """Greatest common divisor of two products, and their quotients."""
    common: list[int] = []
    rest_a: list[int] = []
    rest_b: list[int] = []
    i = j = 0
    while i < len(a) and j < len(b):
        if a[i] == b[j]:
            common.append(a[i])
            i, j = i + 1, j + 1
        elif a[i] < b[j]:
            rest_a.append(a[i])
            i += 1
        else:
            rest_b.append(b[j])
            j += 1
    return tuple(common), (*rest_a, *a[i:]), (*rest_b, *b[j:])


def times(a: VariableProduct, b: VariableProduct) -> VariableProduct:
    """Multiply two products."""
    return tuple(sorted(a + b)) if a and b else a or b


def over(a: VariableProduct, b: VariableProduct) -> VariableProduct | None:
    """Divide a by b; None if b is not a divisor."""
    _, quotient, missing = split(a, b)
    return None if missing else quotient


def multiplications(monomial: VariableProduct, coefficient: float) -> int:
    """Multiplications in coefficient times product; a change of sign is free."""
    if not monomial:
        return 0
    return len(monomial) - (coefficient == 1.0 or coefficient == -1.0)


class Magnitudes:
    """Replaces numbers that are equal within a relative tolerance by the first of them; keeps their signs."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._sorted = [1.0]
        self.representatives = {1.0: 1.0}

    def __call__(self, x: float) -> float:
        """Look up a number other than 0."""
        magnitude = abs(x)
        representative = self.representatives.get(magnitude)
        if representative is None:
            place = bisect.bisect_left(self._sorted, magnitude)
            near = self._sorted[max(place - 1, 0) : place + 1]
            representative = next(
                (y for y in near if abs(y - magnitude) <= self.tolerance * magnitude), magnitude
            )
            if representative is magnitude:
                self._sorted.insert(place, magnitude)
            self.representatives[magnitude] = representative
        return representative if x > 0.0 else -representative


def without(monomial: tuple[_V, ...], v: _V) -> tuple[_V, ...]:
    """Remove one factor v."""
    place = monomial.index(v)
    return monomial[:place] + monomial[place + 1 :]


SumTerms = dict[VariableProduct, float]

# Relative round-off of a few multiplications and divisions.
_ROUND_OFF = 1e-12


class TermPair(NamedTuple):
    """Two terms up to a common product and factor: a + ratio b."""

    a: VariableProduct
    b: VariableProduct
    ratio: float


class PairProduct(NamedTuple):
    """Product of two variables, or of a coefficient's magnitude and one."""

    coefficient: float
    variables: VariableProduct


# A named tuple's constructor without the surrounding call.
_new = tuple.__new__


@lru_cache(maxsize=1 << 12)
def _products(monomial: VariableProduct, coefficient: float) -> tuple[PairProduct, ...]:
    """Products of two in a term: of its variables, and of its coefficient and one of them."""
    products = {PairProduct(1.0, (x, y)) for k, y in enumerate(monomial) for x in monomial[:k]}
    if coefficient != 1.0:
        products |= {PairProduct(coefficient, (y,)) for y in monomial}
    return tuple(sorted(products))


class Sums:
    """Definitions of variables: outputs are numbered -1, -2, .., inputs from 0 to `first` - 1."""

    def __init__(self, inputs: Sequence[Hashable], outputs: int) -> None:
        self.inputs = tuple(inputs)  # meaning of the numbers from 0 on
        self.outputs = outputs
        self.first = len(self.inputs)
        self.terms: dict[int, SumTerms] = {}
        self.users: defaultdict[int, Counter[int]] = defaultdict(Counter)
        self.pairs: defaultdict[
            TermPair, dict[tuple[int, VariableProduct, VariableProduct], tuple[VariableProduct, float]]
        ] = defaultdict(dict)
        self.products: defaultdict[PairProduct, dict[tuple[int, VariableProduct], None]] = defaultdict(dict)
        self.operations = 0
        # Dictionaries as ordered sets: the same order in every run.
        self.touched: dict[TermPair | PairProduct | int, None] = {}
        self.changed: dict[int, None] = {}
        self.magnitude = Magnitudes(_ROUND_OFF)
        self._next = self.first
        self._log: list[tuple[int, VariableProduct, float]] = []

    @property
    def defined(self) -> list[int]:
        """Defined variables other than outputs."""
        return [v for v in self.terms if v >= self.first]

    def define(self, terms: Mapping[VariableProduct, float]) -> int:
        """Define a new variable and return its number."""
        number = self._next
        self._next += 1
        for monomial, coefficient in terms.items():
            self.put(number, monomial, coefficient)
        return number

    def add(self, v: int, monomial: VariableProduct, coefficient: float) -> None:
        """Add a term to the definition of v."""
        old = self.terms.get(v, {}).get(monomial, 0.0)
        total = old + coefficient
        if abs(total) <= _ROUND_OFF * abs(old):
            total = 0.0
        self.put(v, monomial, self.magnitude(total) if old and total else total)

    def put(self, v: int, monomial: VariableProduct, coefficient: float) -> None:
        """Set a coefficient in the definition of v; 0 removes the term."""
        terms = self.terms.setdefault(v, {})
        old = terms.pop(monomial, 0.0)
        self._log.append((v, monomial, old))
        self.changed[v] = None
        self.touched[v] = None
        if old:
            self._count(v, monomial, old, terms, -1)
        if coefficient:
            self._count(v, monomial, coefficient, terms, 1)
            terms[monomial] = coefficient
        if not terms:
            del self.terms[v]

    def inline(self, v: int) -> None:
        """Replace v by its definition wherever it occurs, and forget it."""
        definition = dict(self.terms.get(v, {}))
        for user in list(self.users[v]):
            while self.users[v][user]:
                for monomial, coefficient in list(self.terms[user].items()):
                    if v in monomial:
                        cofactor = without(monomial, v)
                        self.put(user, monomial, 0.0)
                        for inner, factor in definition.items():
                            self.add(user, times(cofactor, inner), self.magnitude(coefficient * factor))
        for monomial in definition:
            self.put(v, monomial, 0.0)

    def values(self, value: Callable[[Any], Any]) -> list[Any]:
        """Evaluate the outputs, given an input's value: a number, an array or an expression."""
        values: dict[int, Any] = {}

        def of(v: int) -> Any:
            if v not in values:
                values[v] = value(self.inputs[v]) if 0 <= v < self.first else total(v)
            return values[v]

        def total(v: int) -> Any:
            # Positive terms come first; if there are none, the sum is negated last. Otherwise a - b and b - a
            # would be two operations.
            terms = sorted(self.terms.get(v, {}).items(), key=lambda term: term[1] < 0.0)
            sign = 1.0 if terms and terms[0][1] > 0.0 else -1.0
            result: Any = 0.0
            for product, c in terms:
                term: Any = abs(c)
                for x in product:
                    term = of(x) * term
                result = result + term if c * sign > 0.0 else result - term
            return sign * result

        return [of(-number) for number in range(1, self.outputs + 1)]

    def mark(self) -> None:
        """Make the present state the one that `undo` returns to."""
        self._log.clear()

    def undo(self) -> None:
        """Return to the marked state."""
        log, self._log = self._log, []
        for v, monomial, old in reversed(log):
            self.put(v, monomial, old)
        self._log.clear()
        self.touched.clear()
        self.changed.clear()

    def tidy(self) -> None:
        """Inline variables that are used once or take no operation; remove unused ones."""
        while self.changed:
            v = next(iter(self.changed))
            del self.changed[v]
            if v >= self.first and self._superfluous(v):
                self.inline(v)

    def _superfluous(self, v: int) -> bool:
        definition, users = self.terms.get(v, {}), self.users[v]
        if len(definition) <= 1:
            # A product used once, a number, another name for a variable, or nothing.
            cost = sum(multiplications(*term) for term in definition.items())
            return cost == 0 or users.total() <= 1
        if users.total() != 1:
            return not users
        (user,) = users
        return abs(self.terms[user].get((v,), 0.0)) == 1.0

    def _count(self, v: int, monomial: VariableProduct, c: float, other_terms: SumTerms, sign: int) -> None:
        """Add a term to the index (sign 1), or remove it (sign -1); `other_terms` are those of its sum."""
        self.operations += sign * (multiplications(monomial, c) + (1 if other_terms else 0))
        for x in monomial:
            self.users[x][v] += sign
            if x >= self.first:
                self.changed[x] = None
            if not self.users[x][v]:
                del self.users[x][v]
        touched, add = self.touched, sign > 0
        for product in _products(monomial, abs(c)):
            touched[product] = None
            if add:
                self.products[product][v, monomial] = None
            else:
                del self.products[product][v, monomial]
        magnitudes, pairs = self.magnitude.representatives, self.pairs
        for other_monomial, c_other in other_terms.items():
            common, a, b = split(monomial, other_monomial)
            if a < b:
                ratio, place, scale = c_other / c, (v, monomial, other_monomial), c
            else:
                a, b = b, a
                ratio, place, scale = c / c_other, (v, other_monomial, monomial), c_other
            size = magnitudes.get(abs(ratio)) or self.magnitude(abs(ratio))
            pair = _new(TermPair, (a, b, size if ratio > 0.0 else -size))
            touched[pair] = None
            if add:
                pairs[pair][place] = common, scale
            else:
                del pairs[pair][place]
