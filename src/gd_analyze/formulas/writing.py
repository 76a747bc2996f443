"""Formulas of what an arm's dynamics is made of: exact elements, torques, energies, single terms."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from itertools import groupby

from gd_analyze.arrays import falling
from gd_analyze.dynamics.base_parameters import BaseParameter, Share
from gd_analyze.formulas.formula import (
    NOTHING,
    Formula,
    Function,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
    bracketed,
    one,
)
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities, Signed
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.terms import (
    Energies,
    EnergyTerm,
    Factor,
    Monomial,
    Torques,
    TorqueTerm,
    Velocity,
    quantity_of,
)
from gd_analyze.text import inertia_label, joined

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


def torque_formulas(velocities: AbsoluteVelocities, torques: Torques) -> tuple[Formula, ...]:
    """Formulas of all joints' torques: what a joint carries, then inertia, velocity, gravity.

    Within each the largest come first; terms with the same velocities stand in brackets before them.
    """
    out = []
    for joint, groups in enumerate(grouped(velocities.n_joints, torques)):
        pieces = carried(velocities, joint)
        for before, terms in groups:
            products = tuple(Product(torques[term], powers(term.monomial)) for term in terms)
            pieces += bracketed(quantity_of(before), products, velocity_powers(before))
        out.append(Formula(torque_symbol(joint), tuple(pieces) or NOTHING))
    return tuple(out)


def grouped(n_joints: int, torques: Torques) -> list[list[tuple[tuple[Velocity, ...], list[TorqueTerm]]]]:
    """Terms with the same velocities, by the joint they act on, in the order they are written."""
    rows: list[dict[tuple[Velocity, ...], list[TorqueTerm]]] = [defaultdict(list) for _ in range(n_joints)]
    for term in sorted(torques, key=lambda term: (falling(torques[term]), term)):
        rows[term.row][term.velocities].append(term)
    return [sorted(row.items(), key=lambda item: _ORDER.index(quantity_of(item[0]))) for row in rows]


def carried(velocities: AbsoluteVelocities, joint: int) -> list[Piece]:
    """Torque of the next joint with a parallel axis, which a joint carries; nothing where there is none."""
    outer = velocities.carried[joint]
    if outer is None:
        return []
    return [Piece(Product(float(outer.sign), (Power(torque_symbol(outer.joint)),)), "carried")]


def energy_formulas(energies: Energies) -> tuple[Formula, ...]:
    """Formulas of the elements of D' (inertia in absolute velocities), row by row, and of the potential U."""
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
        return Formula(
            torque_symbol(term.row), bracketed(term.quantity, (product,), velocity_powers(term.velocities))
        )
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
    """Symbol of a factor that is plain: C23 for cos(q2 + q3), d3 for a prismatic joint's variable."""
    return Symbol(_LETTERS[factor.kind], joined(factor.joints))


def written_out(factor: Factor) -> Function:
    """Cosine or sine with its argument."""
    return Function(
        factor.kind,
        tuple(Product(factor.multiples[j], (Power(Symbol("q", joined((j,)))),)) for j in factor.joints),
    )


def velocity_symbol(velocity: Velocity) -> Symbol:
    """Symbol of an absolute velocity or acceleration."""
    return Symbol("p", joined((velocity.joint,)), dots=velocity.order)


def _base(factor: Factor) -> Symbol | Function:
    return abbreviation(factor) if factor.is_plain else written_out(factor)


def torque_symbol(joint: int) -> Symbol:
    """Symbol of a joint's torque, joints from 0."""
    return Symbol("tau", joined((joint,)))


def velocity_powers(velocities: tuple[Velocity, ...]) -> tuple[Power, ...]:
    """Powers of velocities that a term is multiplied with."""
    return tuple(Power(velocity_symbol(velocity), len([*same])) for velocity, same in groupby(velocities))


def factor_legend(factors: set[Factor]) -> Legend:
    """Say what the names of sines, cosines and prismatic joints' variables mean."""
    return Legend((), (), _factors(factors))


def torque_legend(velocities: AbsoluteVelocities, terms: Iterable[TorqueTerm]) -> Legend:
    """Say what the names in torques of these terms, in absolute velocities, mean."""
    terms = tuple(terms)
    used = sorted({velocity for term in terms for velocity in term.velocities})
    inner = {joint: velocities.inboard(joint) for joint in range(velocities.n_joints)}
    shared = tuple(
        Formula(velocity_symbol(velocity), tuple(Piece(_own(velocity, signed)) for signed in joints))
        for joint, joints in inner.items()
        for velocity in used
        if velocity.joint == joint and len(joints) > 1
    )
    orders = sorted({velocity.order for velocity in used if len(inner[velocity.joint]) == 1})
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


def _own(velocity: Velocity, signed: Signed) -> Product:
    """Rate or acceleration of one of the joints that add up to an absolute one."""
    return Product(float(signed.sign), (Power(Symbol("q", joined((signed.joint,)), dots=velocity.order)),))


def _equal(left: Symbol, *right: Symbol | Function, unit: str = "") -> Formula:
    return Formula(left, tuple(Piece(one(base)) for base in right), unit)


_WORDS = {"translation": "tran", "rotation": "rot"}


def part_symbol(label: str, effect: str = "both") -> Symbol:
    """Symbol of an element such as "D12", with the effect as superscript where only one is meant.

    Gravity has no effects: it goes without.
    """
    return Symbol(label[0], label[1:], word="" if label.startswith("c") else _WORDS.get(effect, ""))


def parts_formulas(kept: Mapping[str, str], n_joints: int, drives: bool) -> tuple[Formula, ...]:
    """Formulas of all joints' torques with only what is kept.

    Parameters
    ----------
    kept
        "translation", "rotation", "both" or "neither" by the element's label.
    n_joints
        Joints of the arm.
    drives
        Whether the drives' inertia J is in them.
    """
    out = []
    for i in range(n_joints):
        own = joined((i,))
        pieces: list[Piece] = []
        for j in range(n_joints):
            label = inertia_label(i, j)
            symbols = [] if kept[label] == "neither" else [part_symbol(label, kept[label])]
            symbols += [Symbol("J", own)] if drives and i == j else []
            acceleration = (Power(Symbol("q", joined((j,)), dots=2)),)
            pieces += bracketed("inertia", tuple(map(one, symbols)), acceleration)
        for label, quantity in ((f"h{own}", "coriolis_centrifugal"), (f"c{own}", "gravity_loading")):
            if kept[label] != "neither":
                pieces.append(Piece(one(part_symbol(label, kept[label])), quantity))
        out.append(Formula(Symbol("tau", own), tuple(pieces) or NOTHING))
    return tuple(out)


# Masses in a row that count the same are one piece; what differs by less than this share differs by rounding.
_SAME = 1e-12


def base_formula(parameter: BaseParameter) -> Formula:
    """Formula of what a base parameter combines, masses last; m3..6 is that of links 3 to 6 together."""
    symbol = Symbol(parameter.symbol.removesuffix(str(parameter.link)), str(parameter.link))
    first, *others = parameter.combination
    shares = [first, *sorted(others, key=lambda share: share.kind == "m")]
    return Formula(symbol, tuple(map(_piece, _together(shares))))


def _together(shares: list[Share]) -> list[list[Share]]:
    """Put masses of one coefficient together, link by link."""
    runs: list[list[Share]] = []
    for share in shares:
        if runs and _goes_on(runs[-1][-1], share):
            runs[-1].append(share)
        else:
            runs.append([share])
    return runs


def _goes_on(before: Share, share: Share) -> bool:
    coefficient, kind, link = before
    same = abs(coefficient - share.coefficient) <= _SAME * abs(coefficient)
    return kind == share.kind == "m" and link + 1 == share.link and same


def _piece(run: list[Share]) -> Piece:
    first, last = run[0], run[-1]
    index = str(first.link) if first is last else f"{first.link}..{last.link}"
    return Piece(Product(first.coefficient, (Power(Symbol(first.kind, index)),)))
