"""Numbers for the array code of `gd_analyze.dynamics` that consist of symbols.

Sines and cosines are sums of exponentials, so that equal expressions have equal sums and nothing needs to be
simplified. Coefficients are sums and products of 0.5, 1, 2 and i, which floating point holds exactly.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

# Exponents are the signed digits of one integer, the key: a product of powers is a sum of keys. The array
# code multiplies far fewer than 127 equal factors.
_BITS_PER_EXPONENT = 8
_HALF_RANGE = 1 << (_BITS_PER_EXPONENT - 1)
# Numbers of more terms take minutes, and nobody reads a formula of a hundredth of them.
MOST_SYMBOLIC_TERMS = 100_000


class TooManySymbolsError(Exception):
    """A number has more than `MOST_SYMBOLIC_TERMS` terms."""


class SymbolicNumber:
    """A sum of coefficient times prod_v b_v^e_v.

    b_v is exp(i v) for an angle, and v itself for any other variable. Variables are numbered, and the
    exponent of variable v is digit v of the term's key.
    """

    __slots__ = ("terms",)

    def __init__(self, terms: dict[int, complex]) -> None:
        self.terms = terms

    @classmethod
    def variable(cls, number: int) -> SymbolicNumber:
        """A variable that is no angle."""
        return cls({_key(number, 1): 1.0})

    @classmethod
    def cosine(cls, number: int) -> SymbolicNumber:
        """Cosine of a variable that is an angle."""
        return cls({_key(number, 1): 0.5, _key(number, -1): 0.5})

    @classmethod
    def sine(cls, number: int) -> SymbolicNumber:
        """Sine of a variable that is an angle."""
        return cls({_key(number, 1): -0.5j, _key(number, -1): 0.5j})

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, int | float):
            return self.terms == ({0: other} if other else {})
        return self.terms == other.terms if isinstance(other, SymbolicNumber) else NotImplemented

    def __neg__(self) -> SymbolicNumber:
        return SymbolicNumber({key: -value for key, value in self.terms.items()})

    def __add__(self, other: Any) -> SymbolicNumber:
        if isinstance(other, SymbolicNumber):
            small, large = sorted((self.terms, other.terms), key=len)
            return SymbolicNumber(_sum(dict(large), small.items()))
        if not isinstance(other, int | float):
            return NotImplemented
        return SymbolicNumber(_sum(dict(self.terms), [(0, complex(other))])) if other else self

    __radd__ = __add__

    def __sub__(self, other: Any) -> SymbolicNumber:
        return self + -other

    def __rsub__(self, other: Any) -> SymbolicNumber:
        return -self + other

    def __mul__(self, other: Any) -> SymbolicNumber:
        if isinstance(other, int | float):
            if other == 1:
                return self
            return SymbolicNumber({key: value * other for key, value in self.terms.items()} if other else {})
        if not isinstance(other, SymbolicNumber):
            return NotImplemented
        small, large = sorted((self.terms, other.terms), key=len)
        out: dict[int, complex] = {}
        for key, value in small.items():
            if len(out) > MOST_SYMBOLIC_TERMS:
                raise TooManySymbolsError
            _sum(out, ((key + large_key, value * factor) for large_key, factor in large.items()))
        return SymbolicNumber(out)

    __rmul__ = __mul__

    def derivative(self, number: int, is_angle: bool) -> SymbolicNumber:
        """Derivative by a variable; exact."""
        out: dict[int, complex] = {}
        for key, value in self.terms.items():
            exponent = digits_of(key, number + 1)[0][number]
            if exponent and is_angle:
                out[key] = value * 1j * exponent
            elif exponent:
                out[key - _key(number, 1)] = value * exponent
        return SymbolicNumber(out)


def digits_of(key: int, count: int) -> tuple[tuple[int, ...], int]:
    """Exponents of the first `count` variables, and the key of the others, whose first becomes number 0."""
    out = []
    for _ in range(count):
        digit = ((key + _HALF_RANGE) & (2 * _HALF_RANGE - 1)) - _HALF_RANGE
        out.append(digit)
        key = (key - digit) >> _BITS_PER_EXPONENT
    return tuple(out), key


def _key(number: int, exponent: int) -> int:
    return exponent * (1 << (_BITS_PER_EXPONENT * number))


def _sum(out: dict[int, complex], terms: Iterable[tuple[int, complex]]) -> dict[int, complex]:
    """Add terms to `out`, and drop those that cancel."""
    for key, value in terms:
        total = out.get(key, 0.0) + value
        if total:
            out[key] = total
        else:
            del out[key]
    return out
