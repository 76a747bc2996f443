"""Formulas of what an arm's dynamics is made of: exact elements, torques, energies, single terms."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from itertools import groupby

from gd_analyze.formulas.formula import Formula, Function, Power, Product, Summand, Symbol
from gd_analyze.harmonics.basis import Basis
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
from gd_analyze.labels import joined

_LETTERS = {"cos": "C", "sin": "S", "power": "d"}
_QUANTITIES = {"D": "inertia", "h": "coriolis_centrifugal", "c": "gravity_loading"}
_ORDER = tuple(_QUANTITIES.values())


def element_formula(equation: Equation) -> Formula:
    """Formula of an exact element, its terms in the order they have: D12 = 0.687 S2 - 0.138 C23."""
    letter = equation.symbol[0]
    return Formula(
        Symbol(letter, equation.symbol[1:]),
        tuple(
            Summand(_QUANTITIES[letter], (Product(term.coefficient, powers(term.factors)),))
            for term in equation.terms
        ),
    )


def torque_formulas(basis: Basis, torques: Torques) -> tuple[Formula, ...]:
    """Formulas of all joints' torques: what a joint carries, then inertia, velocity, gravity.

    Within each the largest come first; terms with the same rates stand in brackets before them.

    Parameters
    ----------
    basis
        The arm's basis functions.
    torques
        Weights of the terms, in absolute rates.
    """
    rows: list[dict[tuple[Rate, ...], dict[Monomial, float]]] = [
        defaultdict(dict) for _ in range(basis.n_joints)
    ]
    for term, weight in torques.items():
        rows[term.row][term.rates][term.monomial] = weight
    # Within a run a joint carries what the next one carries, in absolute rates.
    carried = {joint for run in basis.runs for joint in run.joints[:-1]}
    out = []
    for joint, row in enumerate(rows):
        summands: list[Summand] = []
        if joint in carried:
            summands.append(Summand("carried", (Product(1.0, (Power(_torque(joint + 1)),)),)))
        largest = {rates: max(map(abs, weights.values())) for rates, weights in row.items()}
        for rates in sorted(row, key=lambda rates: (_ORDER.index(quantity_of(rates)), -largest[rates])):
            summands += _summands(rates, row[rates])
        out.append(Formula(_torque(joint), tuple(summands)))
    return tuple(out)


def energy_formulas(energies: Energies) -> tuple[Formula, ...]:
    """Formulas of the elements of D' (inertia in absolute rates), row by row, and of the potential U."""
    ordered = sorted(energies, key=lambda term: (term.is_potential, term.i, term.j, -abs(energies[term])))
    return tuple(
        Formula(left, tuple(_summand(term, energies[term]) for term in terms))
        for left, terms in groupby(ordered, key=_owner)
    )


def term_formula(term: TorqueTerm | EnergyTerm, weight: float) -> Formula:
    """Formula of a single term; the left-hand side says where it stands."""
    return Formula(_owner(term), (_summand(term, weight),))


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


def _torque(joint: int) -> Symbol:
    return Symbol("tau", joined((joint,)))


def _owner(term: TorqueTerm | EnergyTerm) -> Symbol:
    """Torque, element of D' or potential that a term belongs to."""
    if isinstance(term, TorqueTerm):
        return _torque(term.row)
    return Symbol("U") if term.is_potential else Symbol("D'", joined((term.i, term.j)))


def _summand(term: TorqueTerm | EnergyTerm, weight: float) -> Summand:
    if isinstance(term, TorqueTerm):
        return Summand(term.quantity, (Product(weight, powers(term.monomial)),), _rates(term.rates))
    quantity = "gravity_loading" if term.is_potential else "inertia"
    return Summand(quantity, (Product(weight, powers(term.monomial)),))


def _summands(rates: tuple[Rate, ...], weights: dict[Monomial, float]) -> Iterable[Summand]:
    """Products of these rates: one summand, or one each where nothing is common to them."""
    ordered = sorted(weights.items(), key=lambda item: -abs(item[1]))
    terms = tuple(Product(weight, powers(monomial)) for monomial, weight in ordered)
    quantity, behind = quantity_of(rates), _rates(rates)
    return [Summand(quantity, terms, behind)] if behind else [Summand(quantity, (term,)) for term in terms]


def _rates(rates: tuple[Rate, ...]) -> tuple[Power, ...]:
    return tuple(Power(rate_symbol(rate), len([*same])) for rate, same in groupby(rates))
