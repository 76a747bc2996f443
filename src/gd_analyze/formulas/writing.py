"""Formulas of what an arm's dynamics is made of: exact elements, torques, energies, single terms."""

from __future__ import annotations

from collections import defaultdict
from itertools import groupby

from gd_analyze.arrays import falling
from gd_analyze.formulas.formula import NOTHING, Formula, Function, Piece, Power, Product, Symbol, bracketed
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.terms import (
    Energies,
    EnergyTerm,
    Factor,
    Monomial,
    Rate,
    Torques,
    TorqueTerm,
    quantity_of,
)
from gd_analyze.text import joined

_LETTERS = {"cos": "C", "sin": "S", "power": "d"}
_QUANTITIES = {"D": "inertia", "h": "coriolis_centrifugal", "c": "gravity_loading"}
_ORDER = tuple(_QUANTITIES.values())


def element_formula(equation: Equation) -> Formula:
    """Formula of an exact element, its terms in the order they have: D12 = 0.687 S2 - 0.133 C23."""
    letter, number = equation.symbol[0], equation.symbol[1:]
    terms = (Product(term.coefficient, powers(term.factors)) for term in equation.terms)
    return Formula(
        Symbol(letter, number), tuple(Piece(term, _QUANTITIES[letter]) for term in terms) or NOTHING
    )


def torque_formulas(rates: AbsoluteRates, torques: Torques) -> tuple[Formula, ...]:
    """Formulas of all joints' torques: what a joint carries, then inertia, velocity, gravity.

    Within each the largest come first; terms with the same rates stand in brackets before them.
    """
    out = []
    for joint, groups in enumerate(grouped(rates.n_joints, torques)):
        pieces = carried(rates, joint)
        for before, terms in groups:
            products = tuple(Product(torques[term], powers(term.monomial)) for term in terms)
            pieces += bracketed(quantity_of(before), products, rate_powers(before))
        out.append(Formula(torque_symbol(joint), tuple(pieces) or NOTHING))
    return tuple(out)


def grouped(n_joints: int, torques: Torques) -> list[list[tuple[tuple[Rate, ...], list[TorqueTerm]]]]:
    """Terms with the same rates, by the joint they act on, in the order they are written."""
    rows: list[dict[tuple[Rate, ...], list[TorqueTerm]]] = [defaultdict(list) for _ in range(n_joints)]
    for term in sorted(torques, key=lambda term: (falling(torques[term]), term)):
        rows[term.row][term.rates].append(term)
    return [sorted(row.items(), key=lambda item: _ORDER.index(quantity_of(item[0]))) for row in rows]


def carried(rates: AbsoluteRates, joint: int) -> list[Piece]:
    """Torque of the next joint with a parallel axis, which a joint carries; nothing where there is none."""
    outer = rates.carried[joint]
    if outer is None:
        return []
    return [Piece(Product(float(outer.sign), (Power(torque_symbol(outer.joint)),)), "carried")]


def energy_formulas(energies: Energies) -> tuple[Formula, ...]:
    """Formulas of the elements of D' (inertia in absolute rates), row by row, and of the potential U."""
    ordered = sorted(
        energies, key=lambda term: (term.is_potential, term.i, term.j, falling(energies[term]), term.monomial)
    )
    single = (term_formula(term, energies[term]) for term in ordered)
    return tuple(
        Formula(left, tuple(piece for formula in formulas for piece in formula.pieces))
        for left, formulas in groupby(single, key=lambda formula: formula.left)
    )


def term_formula(term: TorqueTerm | EnergyTerm, weight: float) -> Formula:
    """Formula of a single term; the left-hand side says where it stands."""
    product = Product(weight, powers(term.monomial))
    if isinstance(term, TorqueTerm):
        return Formula(torque_symbol(term.row), bracketed(term.quantity, (product,), rate_powers(term.rates)))
    if term.is_potential:
        return Formula(Symbol("U"), (Piece(product, "gravity_loading"),))
    return Formula(Symbol("D'", joined((term.i, term.j))), (Piece(product, "inertia"),))


def powers(monomial: Monomial) -> tuple[Power, ...]:
    """Powers that a monomial is the product of."""
    return tuple(Power(_base(factor), exponent) for factor, exponent in exponents(monomial))


def exponents(monomial: Monomial) -> tuple[tuple[Factor, int], ...]:
    """Distinct factors with their exponents, in the order of their joints."""
    distinct = sorted(set(monomial), key=lambda factor: (factor.joints, factor.kind))
    return tuple((factor, monomial.count(factor)) for factor in distinct)


def abbreviation(factor: Factor) -> Symbol:
    """Symbol of a factor that is plain: C23 for cos(q2 + q3), d3 for a sliding joint's variable."""
    return Symbol(_LETTERS[factor.kind], joined(factor.joints))


def written_out(factor: Factor) -> Function:
    """Cosine or sine with its argument."""
    return Function(
        factor.kind,
        tuple(Product(factor.multiples[j], (Power(Symbol("q", joined((j,)))),)) for j in factor.joints),
    )


def rate_symbol(rate: Rate) -> Symbol:
    """Symbol of an absolute rate or acceleration."""
    return Symbol("p", joined((rate.joint,)), dots=rate.order)


def _base(factor: Factor) -> Symbol | Function:
    return abbreviation(factor) if factor.is_plain else written_out(factor)


def torque_symbol(joint: int) -> Symbol:
    """Symbol of a joint's torque, joints from 0."""
    return Symbol("tau", joined((joint,)))


def rate_powers(rates: tuple[Rate, ...]) -> tuple[Power, ...]:
    """Powers of rates that a term is multiplied with."""
    return tuple(Power(rate_symbol(rate), len([*same])) for rate, same in groupby(rates))
