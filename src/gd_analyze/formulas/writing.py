"""Formulas of an arm: exact elements, torques, energies, single terms, base parameters, legends."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby

from gd_analyze.arrays import falling
from gd_analyze.dynamics.base_parameters import BaseParameter, Share
from gd_analyze.formulas import formula as parts
from gd_analyze.formulas.formula import (
    NO_PIECES,
    CircularFunction,
    Formula,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
)
from gd_analyze.harmonics import terms as kinds
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.terms import EnergyTerm, Factor, Monomial, TorqueTerm, Velocity
from gd_analyze.text import inertia_label, joined

_LETTERS = {"cos": "C", "sin": "S", "power": "d"}
QUANTITIES = {"D": "inertia", "h": "coriolis_centrifugal", "c": "gravity_loading"}
_OF = {quantity: letter for letter, quantity in QUANTITIES.items()}
_ORDER = tuple(QUANTITIES.values())
_EFFECTS = {"translation": "tran", "rotation": "rot"}
# Relative difference of coefficients that are equal up to round-off.
_EQUAL_COEFFICIENTS = 1e-12


def element_formula(equation: Equation) -> Formula:
    """Formula of an exact element with its terms in order: D12 = 0.687 S2 - 0.133 C23."""
    letter, index = equation.symbol[0], equation.symbol[1:]
    products = (Product(term.coefficient, powers(term.factors)) for term in equation.terms)
    pieces = tuple(Piece(product, QUANTITIES[letter]) for product in products)
    return Formula(Symbol(letter, index), pieces or NO_PIECES)


def torque_formulas(velocities: AbsoluteVelocities, torques: kinds.Torques) -> tuple[Formula, ...]:
    """Formulas of all joints' torques: torque carried, then inertia, velocity and gravity terms.

    In each group the largest come first; terms with the same velocities are bracketed before these.
    """
    out = []
    for joint, groups in enumerate(grouped(velocities.n_joints, torques)):
        pieces = carried_torque(velocities, joint)
        for before, terms in groups:
            products = tuple(Product(torques[term], powers(term.monomial)) for term in terms)
            pieces += parts.bracketed(kinds.quantity_of(before), products, velocity_powers(before))
        out.append(Formula(torque_symbol(joint), tuple(pieces) or NO_PIECES))
    return tuple(out)


def element_formulas(torques: kinds.Torques, drives: Sequence[float] = ()) -> tuple[Formula, ...]:
    """Formulas of D, J, h and c from torques in joint velocities; D21 is included if it differs from D12.

    J is the drive inertia (kg m^2 or kg) contained in the constants of D.
    """
    inertia: dict[tuple[int, int], dict[Monomial, float]] = {}
    vector_pieces: dict[str, list[Piece]] = defaultdict(list)
    n = max((term.row for term in torques), default=-1) + 1
    for row, groups in enumerate(grouped(n, torques)):
        for before, terms in groups:
            quantity = kinds.quantity_of(before)
            if quantity == "inertia":
                inertia[row, before[0].joint] = {term.monomial: torques[term] for term in terms}
            else:
                products = tuple(Product(torques[term], powers(term.monomial)) for term in terms)
                left = _OF[quantity] + joined((row,))
                vector_pieces[left] += parts.bracketed(quantity, products, velocity_powers(before, "q"))
    elements, drive_formulas = [], []
    for (i, j), element in sorted(inertia.items()):
        if i > j and element == inertia.get((j, i)):
            continue
        if i == j and drives and () in element:
            element = element | {(): element[()] - drives[i]}
            drive = Piece(Product(drives[i], ()), "inertia")
            drive_formulas.append(Formula(Symbol("J", joined((i,))), (drive,)))
        large = (
            Product(w, powers(m))
            for m, w in element.items()
            if abs(w) > _EQUAL_COEFFICIENTS * max(drives, default=0)
        )
        pieces = tuple(Piece(product, "inertia") for product in large)
        elements.append(Formula(Symbol("D", joined((i, j))), pieces))
    vectors = [
        Formula(Symbol(left[0], left[1:]), tuple(vector_pieces[left])) for left in sorted(vector_pieces)
    ]
    vectors.sort(key=lambda formula: formula.left.letter, reverse=True)
    return (*elements, *drive_formulas, *vectors)


def grouped(
    n_joints: int, torques: kinds.Torques
) -> list[list[tuple[tuple[Velocity, ...], list[TorqueTerm]]]]:
    """Terms with the same velocities, by joint, in the order they are written."""
    rows: list[dict[tuple[Velocity, ...], list[TorqueTerm]]] = [defaultdict(list) for _ in range(n_joints)]
    for term in sorted(torques, key=lambda term: (falling(torques[term]), term)):
        rows[term.row][term.velocities].append(term)
    return [sorted(row.items(), key=lambda item: _ORDER.index(kinds.quantity_of(item[0]))) for row in rows]


def carried_torque(velocities: AbsoluteVelocities, joint: int) -> list[Piece]:
    """Torque of the next joint with a parallel axis, which a joint carries."""
    outer = velocities.carried.get(joint)
    if outer is None:
        return []
    return [Piece(Product(float(outer.sign), (Power(torque_symbol(outer.joint)),)), "carried")]


def energy_formulas(energies: kinds.Energies) -> tuple[Formula, ...]:
    """Formulas of D' (mass matrix in absolute velocities), row by row, and of the potential U."""
    ordered = sorted(
        energies, key=lambda term: (term.is_potential, term.i, term.j, falling(energies[term]), term.monomial)
    )
    single = (term_formula(term, energies[term]) for term in ordered)
    return tuple(
        Formula(left, tuple(piece for formula in formulas for piece in formula.pieces))
        for left, formulas in groupby(single, key=lambda formula: formula.left)
    )


def term_formula(term: TorqueTerm | EnergyTerm, weight: float) -> Formula:
    """Formula of a single term; its left-hand side is the torque, element or energy it belongs to."""
    product = Product(weight, powers(term.monomial))
    if isinstance(term, TorqueTerm):
        pieces = parts.bracketed(term.quantity, (product,), velocity_powers(term.velocities))
        return Formula(torque_symbol(term.row), pieces)
    if term.is_potential:
        return Formula(Symbol("U"), (Piece(product, "gravity_loading"),))
    return Formula(Symbol("D'", joined((term.i, term.j))), (Piece(product, "inertia"),))


def powers(monomial: Monomial) -> tuple[Power, ...]:
    """Powers whose product a monomial is."""
    return tuple(
        Power(_abbreviation(factor) if factor.is_plain else _written_out(factor), exponent)
        for factor, exponent in exponents(monomial)
    )


def exponents(monomial: Monomial) -> tuple[tuple[Factor, int], ...]:
    """Distinct factors with their exponents, in the order of their joints."""
    distinct = sorted(set(monomial), key=lambda factor: (factor.joints, factor.kind))
    return tuple((factor, monomial.count(factor)) for factor in distinct)


def _abbreviation(factor: Factor) -> Symbol:
    """C23 for cos(q2 + q3), d3 for a prismatic joint's variable."""
    return Symbol(_LETTERS[factor.kind], joined(factor.joints))


def _written_out(factor: Factor) -> CircularFunction:
    argument = (Product(factor.multiples[j], (Power(_joint_symbol("q", j)),)) for j in factor.joints)
    return CircularFunction(factor.kind, tuple(argument))


def _joint_symbol(letter: str, joint: int, order: int = 0) -> Symbol:
    return Symbol(letter, joined((joint,)), dots=order)


def velocity_powers(velocities: tuple[Velocity, ...], letter: str = "p") -> tuple[Power, ...]:
    """Powers of the velocities in a term."""
    return tuple(
        Power(_joint_symbol(letter, joint, order), len([*same]))
        for (order, joint), same in groupby(velocities)
    )


def torque_symbol(joint: int) -> Symbol:
    """Symbol of a joint's torque, joints from 0."""
    return _joint_symbol("tau", joint)


def factor_legend(factors: set[Factor]) -> Legend:
    """Meaning of the names of sines, cosines and prismatic variables."""
    return Legend((), (), _factor_formulas(factors))


def torque_legend(velocities: AbsoluteVelocities, terms: Iterable[TorqueTerm]) -> Legend:
    """Meaning of the names in torques of these terms, in absolute velocities."""
    terms = tuple(terms)
    used = sorted({velocity for term in terms for velocity in term.velocities})
    shared, orders = [], set()
    for order, joint in sorted(used, key=lambda velocity: velocity.joint):
        summands = [
            Product(float(sign), (Power(_joint_symbol("q", inner, order)),))
            for inner, sign in velocities.inboard(joint)
        ]
        if len(summands) > 1:
            shared.append(parts.as_formula(_joint_symbol("p", joint, order), summands))
        else:
            orders.add(order)
    single = tuple(
        _equal(Symbol("p", "j", dots=order), Symbol("q", "j", dots=order)) for order in sorted(orders)
    )
    factors = {factor for term in terms for factor in term.monomial}
    return Legend(tuple(shared), single, _factor_formulas(factors))


def _factor_formulas(factors: set[Factor]) -> tuple[Formula, ...]:
    out = []
    for kind in ("cos", "sin"):
        # The longest sum explains the shorter ones.
        plain = sorted((f for f in factors if f.kind == kind and f.is_plain), key=lambda f: f.multiples)
        if plain:
            longest = max(plain, key=lambda factor: len(factor.joints))
            out.append(_equal(_abbreviation(longest), _written_out(longest)))
    prismatic = sorted((factor for factor in factors if factor.kind == "power"), key=lambda f: f.joints)
    out += [
        _equal(_abbreviation(factor), Symbol("q", joined(factor.joints)), unit="m") for factor in prismatic
    ]
    return tuple(out)


def _equal(left: Symbol, right: Symbol | CircularFunction, unit: str = "") -> Formula:
    return Formula(left, (Piece(parts.alone(right)),), unit)


def part_symbol(label: str, effect: str = "both") -> Symbol:
    """Symbol of an element such as "D12", with a single effect as superscript.

    Gravity has no effects and no superscript.
    """
    return Symbol(label[0], label[1:], word="" if label.startswith("c") else _EFFECTS.get(effect, ""))


def parts_formulas(effects: Mapping[str, str], n_joints: int, drives: bool) -> tuple[Formula, ...]:
    """Formulas of all joints' torques with the kept effects of elements; [FGL87] Eq. (3.4-24).

    `effects` is "translation", "rotation", "both" or "nothing" by the element's label; drives have inertia J.
    """
    out = []
    for i in range(n_joints):
        index = joined((i,))
        pieces: list[Piece] = []
        for j in range(n_joints):
            label = inertia_label(i, j)
            symbols = [] if effects[label] == "nothing" else [part_symbol(label, effects[label])]
            symbols += [Symbol("J", index)] if drives and i == j else []
            acceleration = (Power(_joint_symbol("q", j, 2)),)
            pieces += parts.bracketed("inertia", tuple(map(parts.alone, symbols)), acceleration)
        for label, quantity in ((f"h{index}", "coriolis_centrifugal"), (f"c{index}", "gravity_loading")):
            if effects[label] != "nothing":
                pieces.append(Piece(parts.alone(part_symbol(label, effects[label])), quantity))
        out.append(Formula(Symbol("tau", index), tuple(pieces) or NO_PIECES))
    return tuple(out)


def base_formula(parameter: BaseParameter) -> Formula:
    """Formula of a base parameter, masses last: MX2 = mx2 + 0.432 m3..6, m3..6 being m3 + m4 + m5 + m6."""
    symbol = Symbol(parameter.symbol.removesuffix(str(parameter.link)), str(parameter.link))
    first, *following = parameter.combination
    runs: list[list[Share]] = []
    for share in [first, *sorted(following, key=lambda share: share.kind == "m")]:
        before = runs[-1][-1] if runs else first
        same = abs(before.coefficient - share.coefficient) <= _EQUAL_COEFFICIENTS * abs(before.coefficient)
        if before.kind == share.kind == "m" and before.link + 1 == share.link and same:
            runs[-1].append(share)
        else:
            runs.append([share])
    pieces = []
    for (coefficient, kind, link), *more in runs:
        index = f"{link}..{more[-1].link}" if more else str(link)
        pieces.append(Piece(Product(coefficient, (Power(Symbol(kind, index)),))))
    return Formula(symbol, tuple(pieces))
