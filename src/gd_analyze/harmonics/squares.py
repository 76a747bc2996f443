"""One form of squares: 1 and C^2 wherever two of 1, C^2, S^2 and cos(2 a) stand beside the same factors.

S^2 is 1 - C^2, cos(2 a) is 2 C^2 - 1 and sin(2 a) is 2 C S. The exact terms of an element decide, so that the
terms of a model, which are some of them, are written alike: S^2 or cos(2 a) stays where it stands alone.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import compress, pairwise
from typing import NamedTuple

from gd_analyze.harmonics.terms import Factor, Monomial, Torques, TorqueTerm, half_of, summed

_Angle = tuple[int, ...]
# A term without the factors of an angle, and the angle.
_Place = tuple[TorqueTerm, _Angle]


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

    rewritten: Container[_Place]

    @classmethod
    def of(cls, exact: Iterable[TorqueTerm]) -> Squares:
        """Decide by the exact terms of D, h and c."""
        elements = defaultdict[TorqueTerm, set[TorqueTerm]](set)
        for term in exact:
            elements[term._replace(monomial=())].add(term)
        rewritten = set[_Place]()
        for terms in elements.values():
            with_squares = {term for term in terms if has_squares(term.monomial)}
            while True:  # what is rewritten may stand beside other squares
                written = {new for term in with_squares for new in cls(rewritten).written(term)}
                more = _side_by_side(written, terms - with_squares)
                if not more:
                    break
                rewritten |= more
        return cls(rewritten)

    def written(self, term: TorqueTerm) -> dict[TorqueTerm, float]:
        """Write a term as a sum of terms, with their factors."""
        for angle in _angles(term.monomial):
            forms = _forms(angle)
            beside, form = _parted(term, angle)
            if form == forms.double_sine:
                parts = {_with(beside, forms.mixed): 2.0}
            elif form == forms.sines and (beside, angle) in self.rewritten:
                parts = {beside: 1.0, _with(beside, forms.cosines): -1.0}
            elif form == forms.double_cosine and (beside, angle) in self.rewritten:
                parts = {beside: -1.0, _with(beside, forms.cosines): 2.0}
            else:
                continue
            out = defaultdict[TorqueTerm, float](float)
            for part, weight in parts.items():
                for new, factor in self.written(part).items():
                    out[new] += weight * factor
            return out
        return {term: 1.0}

    def sum(self, torques: Torques) -> dict[TorqueTerm, float]:
        """Write a sum of terms; those that cancel are left out."""
        return summed((weight, self.written(term)) for term, weight in torques.items())


@lru_cache
def _forms(angle: _Angle) -> _Forms:
    cosine, sine = Factor("cos", angle), Factor("sin", angle)
    doubled = tuple(2 * multiple for multiple in angle)
    double_cosine, double_sine = Factor("cos", doubled), Factor("sin", doubled)
    return _Forms((cosine, cosine), (sine, sine), (cosine, sine), (double_cosine,), (double_sine,))


def has_squares(monomial: Monomial) -> bool:
    """Whether a term has a squared sine, or a sine or cosine of a double angle."""
    return bool(_angles(monomial))


@lru_cache(maxsize=1 << 14)
def _angles(monomial: Monomial) -> tuple[_Angle, ...]:
    """Angles whose sine is squared, or whose double has a sine or cosine, ascending."""
    squared = [one.multiples for one, other in pairwise(monomial) if one == other and one.kind == "sin"]
    halves = (half_of((factor,)) for factor in monomial)
    return tuple(sorted({*squared, *(half for half in halves if half is not None)}))


def _parted(term: TorqueTerm, angle: _Angle) -> tuple[TorqueTerm, Monomial]:
    """A term without the factors of an angle and its double, and these."""
    own = {angle, _forms(angle).double_cosine[0].multiples}
    is_own = [factor.kind != "power" and factor.multiples in own for factor in term.monomial]
    beside = tuple(compress(term.monomial, (not mine for mine in is_own)))
    return term._replace(monomial=beside), tuple(compress(term.monomial, is_own))


def _with(term: TorqueTerm, factors: Monomial) -> TorqueTerm:
    return term._replace(monomial=tuple(sorted(term.monomial + factors)))


def _side_by_side(terms: set[TorqueTerm], others: set[TorqueTerm]) -> set[_Place]:
    """Where S^2 or cos(2 a) of terms stands beside 1, C^2 or the other, of these terms or of others."""
    out = set()
    for term in terms:
        for angle in _angles(term.monomial):
            forms = _forms(angle)
            beside, form = _parted(term, angle)
            alike = ((), forms.cosines, forms.sines, forms.double_cosine)
            if form in alike[2:]:
                near = {_with(beside, other) for other in alike if other != form}
                if not (near.isdisjoint(terms) and near.isdisjoint(others)):
                    out.add((beside, angle))
    return out
