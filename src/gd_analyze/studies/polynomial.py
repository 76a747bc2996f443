"""Counts as polynomials in the number of joints, with rational coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in the number of joints n; coefficients from n^0 upwards."""

    coefficients: tuple[Fraction, ...]

    def __call__(self, n: int) -> int:
        """Value at n, a whole number of operations."""
        value = sum(c * n**k for k, c in enumerate(self.coefficients))
        assert value == int(value), "a count is whole"
        return int(value)

    def __str__(self) -> str:
        """Highest power first, e.g. "128/3 n^4 - 7 n"."""
        terms = []
        for power in reversed(range(len(self.coefficients))):
            coefficient = self.coefficients[power]
            if coefficient:
                factor = "" if abs(coefficient) == 1 and power else str(abs(coefficient))
                symbol = "" if power == 0 else "n" if power == 1 else f"n^{power}"
                terms.append(("-" if coefficient < 0 else "+", f"{factor} {symbol}".strip()))
        if not terms:
            return "0"
        first = terms[0][1] if terms[0][0] == "+" else f"-{terms[0][1]}"
        return " ".join([first, *(f"{sign} {term}" for sign, term in terms[1:])])


def exact_polynomial(sizes: Sequence[int], counts: Sequence[int]) -> Polynomial | None:
    """Find the polynomial of lowest degree through all counts.

    Newton's divided differences vanish beyond its degree; a polynomial that uses up every point explains
    nothing and is none.

    Parameters
    ----------
    sizes
        Different whole numbers.
    counts
        One per size.
    """
    differences = [Fraction(count) for count in counts]
    newton = [differences[0]]
    for order in range(1, len(sizes)):
        differences = [
            (differences[k + 1] - differences[k]) / (sizes[k + order] - sizes[k])
            for k in range(len(differences) - 1)
        ]
        newton.append(differences[0])
    while newton and newton[-1] == 0:
        newton.pop()
    if len(newton) == len(sizes):
        return None
    # Horner's scheme: times (n - size), plus the difference before.
    coefficients: list[Fraction] = []
    for size, factor in reversed(list(zip(sizes, newton, strict=False))):
        raised, lowered = [Fraction(), *coefficients], [size * c for c in coefficients] + [Fraction()]
        coefficients = [a - b for a, b in zip(raised, lowered, strict=True)]
        coefficients[0] += factor
    return Polynomial(tuple(coefficients) or (Fraction(),))
