"""What the names in formulas mean."""

from __future__ import annotations

from collections.abc import Iterable

from gd_analyze.formulas.formula import Formula, Function, Legend, Piece, Power, Product, Symbol, one
from gd_analyze.formulas.writing import abbreviation, rate_symbol, written_out
from gd_analyze.harmonics.absolute_rates import AbsoluteRates, Signed
from gd_analyze.harmonics.terms import Factor, Rate, TorqueTerm
from gd_analyze.text import joined


def factor_legend(factors: set[Factor]) -> Legend:
    """Say what the names of sines, cosines and sliding joints' variables mean."""
    return Legend((), (), _factors(factors))


def torque_legend(rates: AbsoluteRates, terms: Iterable[TorqueTerm]) -> Legend:
    """Say what the names in torques of these terms, in absolute rates, mean."""
    terms = tuple(terms)
    used = sorted({rate for term in terms for rate in term.rates})
    inner = {joint: rates.inboard(joint) for joint in range(rates.n_joints)}
    shared = tuple(
        Formula(rate_symbol(rate), tuple(Piece(_own(rate, signed)) for signed in joints))
        for joint, joints in inner.items()
        for rate in used
        if rate.joint == joint and len(joints) > 1
    )
    orders = sorted({rate.order for rate in used if len(inner[rate.joint]) == 1})
    others = tuple(_equal(Symbol("p", "j", dots=order), Symbol("q", "j", dots=order)) for order in orders)
    return Legend(shared, others, _factors({factor for term in terms for factor in term.monomial}))


def _factors(factors: set[Factor]) -> tuple[Formula, ...]:
    out = []
    for kind in ("cos", "sin"):
        # The longest sum explains the shorter ones.
        plain = sorted((f for f in factors if f.kind == kind and f.is_plain), key=lambda f: f.multiples)
        if plain:
            longest = max(plain, key=lambda factor: len(factor.joints))
            out.append(_equal(abbreviation(longest), written_out(longest)))
    slides = sorted((factor for factor in factors if factor.kind == "power"), key=lambda f: f.joints)
    out += [_equal(abbreviation(slide), Symbol("q", joined(slide.joints)), unit="m") for slide in slides]
    return tuple(out)


def _own(rate: Rate, signed: Signed) -> Product:
    """Rate or acceleration of one of the joints that add up to an absolute one."""
    return Product(float(signed.sign), (Power(Symbol("q", joined((signed.joint,)), dots=rate.order)),))


def _equal(left: Symbol, *right: Symbol | Function, unit: str = "") -> Formula:
    return Formula(left, tuple(Piece(one(base)) for base in right), unit)
