"""Torque equations and exact elements as MathML, in pieces that a line may break between."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.rendering import mathml_factor as factor_mathml
from gd_analyze.harmonics.rendering import mathml_number as exponent_mathml
from gd_analyze.harmonics.rendering import powers, rounded
from gd_analyze.harmonics.terms import EnergyTerm, Monomial, Rate, TorqueTerm
from gd_analyze.harmonics.torque_rendering import Bracket, brackets

# Browsers set factors without any space between them.
_THIN = '<mspace width=".16em"/>'
_OPEN, _CLOSE = '<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>'
_DOTS = {1: "˙", 2: "¨"}


@dataclass(frozen=True)
class Share:
    """What inertia, velocity or gravity adds to a torque, or the next joint of a run.

    Parameters
    ----------
    quantity
        "inertia", "coriolis_centrifugal", "gravity_loading", or "carried".
    pieces
        Formulas to be read one after the other.
    """

    quantity: str
    pieces: tuple[str, ...]


@dataclass(frozen=True)
class JointTorque:
    """Equation of one joint: what stands on its left, with the sign of equality, and its shares."""

    left: str
    shares: tuple[Share, ...]


def torques_to_mathml(
    basis: AbsoluteRates, torques: Mapping[TorqueTerm, float], digits: int = 3
) -> tuple[JointTorque, ...]:
    """Write one equation per joint; the same order and brackets as `torques_to_text`.

    Parameters
    ----------
    basis
        The arm's runs of parallel joints.
    torques
        Weights of the terms, in absolute rates.
    digits
        Significant digits of the weights.
    """
    return tuple(_joint(basis, i, row, digits) for i, row in enumerate(brackets(basis, torques)))


def torque_term_mathml(term: TorqueTerm, weight: float, digits: int = 3) -> str:
    """Write one torque term: -3.2 C2 S2 p1 p2."""
    return _math(_sign(weight, first=True) + _product(term.monomial, weight, digits, term.rates))


def energy_term_mathml(term: EnergyTerm, weight: float, digits: int = 3) -> str:
    """Write one term of D in absolute rates, or of the potential energy: 0.687 S2."""
    return _math(_sign(weight, first=True) + _product(term.monomial, weight, digits))


def element_mathml(equation: Equation, digits: int = 3) -> tuple[str, tuple[str, ...]]:
    """Write an exact element: its symbol with the sign of equality, and one formula per term."""
    left = f"<msub><mi>{equation.symbol[0]}</mi><mn>{equation.symbol[1:]}</mn></msub><mo>=</mo>"
    terms = tuple(
        _math(_sign(term.coefficient, place == 0) + _product(term.factors, term.coefficient, digits))
        for place, term in enumerate(equation.terms)
    )
    return _math(left), terms or (_math("<mn>0</mn>"),)


def torque_legend_mathml(basis: AbsoluteRates, torques: Iterable[TorqueTerm]) -> tuple[str, ...]:
    """Say what the names in these equations mean: rates first, then one cosine, sine and distance each."""
    torques = tuple(torques)
    used = {rate for term in torques for rate in term.rates}
    out, named = [], set()
    for run in basis.runs:
        for place, joint in enumerate(run[1:], start=2):
            for rate in sorted(rate for rate in used if rate.joint == joint):
                behind = "<mo>+</mo>".join(_dotted("q", j, rate.order) for j in run[:place])
                out.append(_math(f"{_rate(rate)}<mo>=</mo>{behind}"))
                named.add(rate)
    for order in sorted({rate.order for rate in used - named}):
        index = "<mi>j</mi>"
        other = f"<msub>{_over('p', order)}{index}</msub><mo>=</mo><msub>{_over('q', order)}{index}</msub>"
        otherwise = "<mspace width='.3em'/><mtext>otherwise</mtext>" if named else ""
        out.append(_math(other + otherwise))
    return (*out, *_factor_meanings({literal for term in torques for literal in term.monomial}))


def _factor_meanings(used: Iterable[tuple[str, tuple[int, ...]]]) -> list[str]:
    out = []
    for kind, group in groupby(sorted(used), key=lambda literal: literal[0]):
        # The longest sum explains the shorter ones.
        plain = [m for _, m in group if set(m) <= {0, 1}]
        if kind == "power":
            out += [_math(f"<msub><mi>d</mi><mn>{j}</mn></msub><mo>=</mo>{_q(j)}") for j in _joints(plain)]
        elif plain:
            longest = max(plain, key=lambda m: (sum(m), m))
            joints = [j for j, multiple in enumerate(longest, start=1) if multiple]
            index = ("," if joints[-1] > 9 else "").join(map(str, joints))
            argument = "<mo>+</mo>".join(map(_q, joints))
            out.append(
                _math(
                    f"<msub><mi>{kind[0].upper()}</mi><mn>{index}</mn></msub><mo>=</mo><mi>{kind}</mi>"
                    f"{_OPEN}{argument}{_CLOSE}"
                )
            )
    return out


def _joints(multiples: Iterable[tuple[int, ...]]) -> list[int]:
    return sorted({m.index(1) + 1 for m in multiples})


def _q(joint: int) -> str:
    return f"<msub><mi>q</mi><mn>{joint}</mn></msub>"


def _joint(basis: AbsoluteRates, i: int, row: list[Bracket], digits: int) -> JointTorque:
    shares = []
    if basis.carries_next(i):
        shares.append(Share("carried", (_math(_torque(i + 1)),)))
    for quantity, group in groupby(row, key=lambda bracket: TorqueTerm(0, bracket[0], ()).quantity):
        pieces: list[str] = []
        for bracket in group:
            pieces += _bracket(*bracket, digits, first=not shares and not pieces)
        shares.append(Share(quantity, tuple(pieces)))
    left = _math(f"{_torque(i)}<mo>=</mo>")
    return JointTorque(left, tuple(shares) or (Share("carried", (_math("<mn>0</mn>"),)),))


def _bracket(
    rates: tuple[Rate, ...], polynomial: Mapping[Monomial, float], digits: int, first: bool
) -> list[str]:
    """Rates times the sum of their terms, as `torques_to_text` has it."""
    terms = sorted(polynomial.items(), key=lambda item: -abs(item[1]))
    if not rates or len(terms) == 1:
        return [
            _math(_sign(weight, first and place == 0) + _product(monomial, weight, digits, rates))
            for place, (monomial, weight) in enumerate(terms)
        ]
    outer = terms[0][1]
    pieces = [
        (_sign(weight, first) + _OPEN if place == 0 else _sign(weight * outer, False))
        + _product(monomial, weight, digits)
        for place, (monomial, weight) in enumerate(terms)
    ]
    pieces[-1] += _CLOSE + _THIN + _rates(rates)
    return [_math(piece) for piece in pieces]


def _product(factors: Monomial, weight: float, digits: int, rates: tuple[Rate, ...] = ()) -> str:
    """Magnitude of a term; its sign stands before it."""
    mantissa, exponent = rounded(abs(weight), digits)
    parts = [factor_mathml(*power) for power in powers(factors)]
    if rates:
        parts.append(_rates(rates))
    if exponent:
        ten = f"<msup><mn>10</mn>{exponent_mathml(exponent)}</msup>"
        parts.insert(0, f"<mn>{mantissa}</mn><mo>·</mo>{ten}")
    elif mantissa != "1" or not parts:
        parts.insert(0, f"<mn>{mantissa}</mn>")
    return _THIN.join(parts)


def _sign(weight: float, first: bool) -> str:
    if first:
        return "<mo>−</mo>" if weight < 0 else ""
    # At the beginning of a piece browsers take it for a prefix, without any space behind it.
    return f'<mo rspace=".25em">{"−" if weight < 0 else "+"}</mo>'


def _rates(rates: tuple[Rate, ...]) -> str:
    if len(rates) == 2 and rates[0] == rates[1]:
        base = _over("p", rates[0].order)
        return f"<msubsup>{base}<mn>{rates[0].joint + 1}</mn><mn>2</mn></msubsup>"
    return _THIN.join(map(_rate, rates))


def _rate(rate: Rate) -> str:
    return _dotted("p", rate.joint, rate.order)


def _dotted(letter: str, joint: int, order: int) -> str:
    return f"<msub>{_over(letter, order)}<mn>{joint + 1}</mn></msub>"


def _over(letter: str, order: int) -> str:
    dots = f'<mo stretchy="false">{_DOTS[order]}</mo>'
    return f'<mover accent="true"><mi>{letter}</mi>{dots}</mover>'


def _torque(joint: int) -> str:
    return f"<msub><mi>τ</mi><mn>{joint + 1}</mn></msub>"


def _math(content: str) -> str:
    return f"<math>{content}</math>"
