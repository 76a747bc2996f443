"""One form of squares: 1 and C^2 wherever two of 1, C^2, S^2 and cos(2 a) stand beside the same factors.

S^2 is 1 - C^2, cos(2 a) is 2 C^2 - 1 and sin(2 a) is 2 C S. The exact terms of an element decide, so that the
terms of a model, which are some of them, are written alike: S^2 or cos(2 a) stays where it stands alone.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from gd_analyze.harmonics.terms import Factor, Monomial, Torques, TorqueTerm, half_of

_Angle = tuple[int, ...]

# Share of its summands' magnitudes below which a sum of a few terms counts as cancelled.
_CANCELLED_SHARE = 1e-13


class _Forms(NamedTuple):
    """What may stand for an angle in a term."""

    cosines: Monomial  # C^2
    sines: Monomial  # S^2
    mixed: Monomial  # C S
    double_cosine: Monomial
    double_sine: Monomial


@dataclass(frozen=True)
class Squares:
    """Where S^2 and cos(2 a) are written by 1 and C^2: at these terms, for these angles, without either."""

    rewritten: Container[tuple[TorqueTerm, _Angle]]

    @classmethod
    def of(cls, exact: Iterable[TorqueTerm]) -> Squares:
        """Decide by the exact terms of D, h and c."""
        elements = defaultdict[TorqueTerm, set[Monomial]](set)
        for term in exact:
            elements[term._replace(monomial=())].add(term.monomial)
        rewritten: set[tuple[TorqueTerm, _Angle]] = set()
        for element, monomials in elements.items():
            for angle in sorted({angle for monomial in monomials for angle in _angles(monomial)}):
                forms = _forms(angle)
                alike = ((), forms.cosines, forms.sines, forms.double_cosine)
                for monomial in monomials:
                    cofactor, form = _parted(monomial, angle)
                    others = (_product(cofactor, other) for other in alike if other != form)
                    if form in alike[2:] and not monomials.isdisjoint(others):
                        rewritten.add((element._replace(monomial=cofactor), angle))
                terms = (element._replace(monomial=monomial) for monomial in monomials)
                monomials = {new for term in terms for new in _written(term, angle, rewritten)}
        return cls(rewritten)

    def written(self, term: TorqueTerm) -> dict[TorqueTerm, float]:
        """Write a term as a sum of terms, with their factors."""
        parts = {term.monomial: 1.0}
        for angle in sorted(_angles(term.monomial)):
            sums = defaultdict[Monomial, float](float)
            for part, weight in parts.items():
                for new, factor in _written(term._replace(monomial=part), angle, self.rewritten).items():
                    sums[new] += weight * factor
            parts = sums
        return {term._replace(monomial=part): weight for part, weight in parts.items()}

    def sum(self, torques: Torques) -> dict[TorqueTerm, float]:
        """Write a sum of terms; those that cancel are left out."""
        sums, sizes = defaultdict[TorqueTerm, float](float), defaultdict[TorqueTerm, float](float)
        for term, weight in torques.items():
            for new, factor in self.written(term).items():
                sums[new] += factor * weight
                sizes[new] += abs(factor * weight)
        return {term: value for term, value in sums.items() if abs(value) > _CANCELLED_SHARE * sizes[term]}


@lru_cache
def _forms(angle: _Angle) -> _Forms:
    cosine, sine = Factor("cos", angle), Factor("sin", angle)
    doubled = tuple(2 * multiple for multiple in angle)
    double_cosine, double_sine = Factor("cos", doubled), Factor("sin", doubled)
    return _Forms((cosine, cosine), (sine, sine), (cosine, sine), (double_cosine,), (double_sine,))


def _angles(monomial: Monomial) -> set[_Angle]:
    """Angles whose sine is squared, or whose double has a sine or cosine."""
    squared = {
        factor.multiples for factor in monomial if factor.kind == "sin" and monomial.count(factor) == 2
    }
    halves = (half_of((factor,)) for factor in monomial)
    return squared | {half for half in halves if half is not None}


def _parted(monomial: Monomial, angle: _Angle) -> tuple[Monomial, Monomial]:
    """The factors beside an angle, and those of the angle or its double."""
    own = {angle, _forms(angle).double_cosine[0].multiples}
    is_own = [factor.kind != "power" and factor.multiples in own for factor in monomial]
    beside = tuple(factor for factor, mine in zip(monomial, is_own, strict=True) if not mine)
    return beside, tuple(factor for factor, mine in zip(monomial, is_own, strict=True) if mine)


def _product(first: Monomial, second: Monomial) -> Monomial:
    return tuple(sorted(first + second))


def _written(
    term: TorqueTerm, angle: _Angle, rewritten: Container[tuple[TorqueTerm, _Angle]]
) -> dict[Monomial, float]:
    """Monomials of a term after the squares of one angle, and their factors."""
    forms = _forms(angle)
    beside, form = _parted(term.monomial, angle)
    if form == forms.double_sine:
        return {_product(beside, forms.mixed): 2.0}
    if form in (forms.sines, forms.double_cosine) and (term._replace(monomial=beside), angle) in rewritten:
        sign, share = (1.0, -1.0) if form == forms.sines else (-1.0, 2.0)
        return {beside: sign, _product(beside, forms.cosines): share}
    return {term.monomial: 1.0}
