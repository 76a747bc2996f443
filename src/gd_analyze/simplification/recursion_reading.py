"""A simplified recursion as equations that a person reads: link by link, outward and back."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.formula import (
    Formula,
    Function,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
    as_formula,
    one,
)
from gd_analyze.formulas.printer import PRIME
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import INWARD, OUTWARD, Changes, Quantity, Recursion
from gd_analyze.text import joined

# Letters as people put them in products, and summands by their last.
_ORDER = ("C", "S", "n", "f", "a", "q", "p", "omega", "r", "A", "tau")


def unsigned(x: Any) -> tuple[float, Any]:
    """Part an expression or number into a sign and the rest."""
    if isinstance(x, Expression) and x.operation == "negative":
        return -1.0, x.arguments[0]
    return 1.0, x


class Names:
    """Names of the expressions of one trace.

    Parameters
    ----------
    steps
        The expressions.
    told
        Quantities and what they are there: a sign, and an expression or number.
    """

    def __init__(self, steps: Iterable[Expression], told: Mapping[Quantity, tuple[float, Any]]) -> None:
        self.known: dict[int, tuple[float, Symbol]] = {}
        self.quantity: dict[int, Quantity] = {}
        self.functions: dict[Symbol, Function] = {}
        for step in steps:
            if step.operation == "input":
                self.known[step.order] = 1.0, _input(step.arguments[0])
        for step in steps:
            if step.operation in ("cos", "sin"):
                self.known[step.order] = 1.0, self._function(step)
        # One name each: of the frame it belongs to rather than of another.
        for quantity, (sign, base) in sorted(told.items(), key=lambda pair: pair[0].kind.count(PRIME)):
            if isinstance(base, Expression):
                self.known.setdefault(base.order, (sign, quantity.symbol))
                self.quantity.setdefault(base.order, quantity)

    def _function(self, step: Expression) -> Symbol:
        argument = tuple(sorted(self.terms(step.arguments[0]), key=lambda term: _index(term)))
        joints = tuple(int(_index(term)) - 1 for term in argument if term.powers)
        symbol = Symbol("C" if step.operation == "cos" else "S", joined(joints))
        while symbol in self.functions:
            symbol = replace(symbol, primes=symbol.primes + 1)
        self.functions[symbol] = Function(str(step.operation), argument)
        return symbol

    def terms(
        self,
        x: Any,
        weight: float = 1.0,
        *,
        inside: bool = False,
        instead: Mapping[int, Sequence[Product]] | None = None,
    ) -> list[Product]:
        """Write an expression as a sum of products of what has a name.

        Parameters
        ----------
        x, weight
            An expression, or a number, and what it is multiplied with.
        inside
            Whether to write what it is made of, though it has a name.
        instead
            What stands in for expressions, by their order.
        """
        if not isinstance(x, Expression):
            return [Product(weight * x)] if x else []
        if instead and x.order in instead:
            return [Product(weight * term.weight, term.powers) for term in instead[x.order]]
        if x.order in self.known and not inside:
            sign, symbol = self.known[x.order]
            return [Product(weight * sign, (Power(symbol),))]
        if x.operation in ("add", "subtract"):
            signs = (weight, -weight if x.operation == "subtract" else weight)
            both = zip(x.arguments, signs, strict=True)
            return [term for one, own in both for term in self.terms(one, own, instead=instead)]
        if x.operation == "negative":
            return self.terms(x.arguments[0], -weight, instead=instead)
        assert x.operation == "multiply", "inputs, sines and cosines have names"
        a, b = (self.terms(argument, instead=instead) for argument in x.arguments)
        return [
            Product(weight * one.weight * other.weight, _product(one.powers + other.powers))
            for one in a
            for other in b
        ]

    def parts(self, steps: Iterable[Expression]) -> Mapping[int, Quantity]:
        """Quantity that each expression is, or is a part of; of several the last that takes it."""
        of = dict(self.quantity)
        for step in sorted(steps, key=lambda step: -step.order):
            for argument in step.arguments:
                if isinstance(argument, Expression) and step.order in of:
                    of.setdefault(argument.order, of[step.order])
        return of

    def sum(self, x: Any, weight: float = 1.0, *, inside: bool = False) -> tuple[Product, ...]:
        """Write an expression as people order a sum, see `merged`."""
        return merged(self.terms(x, weight, inside=inside))


def merged(terms: Iterable[Product]) -> tuple[Product, ...]:
    """Equal products as one, and in the order in which people put them: what A goes into comes last."""
    weights: dict[tuple[Power, ...], float] = {}
    for term in terms:
        weights[term.powers] = weights.get(term.powers, 0.0) + term.weight
    left = (Product(weight, powers) for powers, weight in weights.items() if weight)
    return tuple(sorted(left, key=lambda term: max(map(_rank, term.powers), default=(9, ""))))


def _product(powers: tuple[Power, ...]) -> tuple[Power, ...]:
    """Equal factors as one power."""
    exponents: dict[Symbol | Function, int] = {}
    for base, exponent in powers:
        exponents[base] = exponents.get(base, 0) + exponent
    return tuple(sorted((Power(*item) for item in exponents.items()), key=_rank))


def _rank(power: Power) -> tuple[int, str]:
    """Place among factors, and of what it multiplies among summands."""
    base = power.base
    if isinstance(base, Function):
        return 0, ""
    return _ORDER.index(base.letter), base.index


def _input(name: str) -> Symbol:
    letters = name.rstrip("0123456789")
    return Symbol("q", joined((int(name[len(letters) :]) - 1,)), dots=len(letters) - 1)


def _index(term: Product) -> str:
    """Joint of an angle, last of all the constant."""
    if not term.powers:
        return "~"
    base = term.powers[0].base
    assert isinstance(base, Symbol), "angles are sums of joint variables"
    return f"{int(base.index):3d}"


class Told:
    """A changed recursion's quantities.

    Parameters
    ----------
    recursion
        The exact one.
    changes
        Of it.
    factors
        By what quantities are larger than they are said to be, see `recursion_scales`.
    """

    def __init__(
        self, recursion: Recursion, changes: Changes, factors: Mapping[Quantity, float] | None = None
    ) -> None:
        self.program, known = recursion.images(changes)
        needed = {step.order for step in self.program.steps}
        now = {quantity: _now(value, known, needed) for quantity, value in recursion.quantities}
        torques = [quantity for quantity in now if quantity.kind == "tau"]
        now |= zip(torques, map(unsigned, self.program.outputs), strict=True)
        # By quantity a sign, and an expression or number; what is not needed is not there.
        self.values = {quantity: value for quantity, value in now.items() if value is not None}
        self.names = Names(self.program.steps, self.values)
        factors = factors or {}
        self._factors: dict[Symbol | Function, float] = {
            quantity.symbol: factor for quantity, factor in factors.items()
        }

    def name(self, quantity: Quantity) -> tuple[float, Symbol] | None:
        """Sign and symbol by which it is called where it is used; None of a number."""
        sign, base = self.values[quantity]
        if not isinstance(base, Expression):
            return None
        own_sign, symbol = self.names.known[base.order]
        return sign * own_sign, symbol

    def sum(self, quantity: Quantity) -> tuple[Product, ...]:
        """What a quantity is the sum of; of one that is another by name, that."""
        sign, base = self.values[quantity]
        if not isinstance(base, Expression):
            return (Product(sign * base),) if base else ()
        own_sign, symbol = self.names.known[base.order]
        if symbol != quantity.symbol:
            terms: tuple[Product, ...] = (Product(sign * own_sign, (Power(symbol),)),)
        else:
            terms = self.names.sum(base, own_sign, inside=True)
        own = self._factors.get(quantity.symbol, 1.0)
        return tuple(term._replace(weight=term.weight * self._factor(term) / own) for term in terms)

    def _factor(self, term: Product) -> float:
        return math.prod(self._factors.get(base, 1.0) ** exponent for base, exponent in term.powers)


def _now(value: Any, known: Mapping[int, Any], needed: Set[int]) -> tuple[float, Any] | None:
    """Sign and what became of an expression; None where nothing needs it."""
    if not isinstance(value, Expression):
        return unsigned(value)
    for sign, x in ((1.0, value), unsigned(value)):
        if x.order in known:
            other, base = unsigned(known[x.order])
            if not isinstance(base, Expression) or base.order in needed:
                return sign * other, base
    return None


# Moments act as torques, and rates come from outside: these only may be larger.
_FREE = ("f", "a", "A", "omegad", "omega")
# States looked at, and rates and accelerations there, per s and s^2, where the arm states no limits.
_STATES, _RATE, _ACCELERATION = 300, 1.0, 10.0
# A factor is one where what is there is so much like what was, and so far from being as large.
_ALIKE, _FAR = 0.9, math.log(1.15)
# Factors of neighbouring links that differ less are one.
_ONE = math.log(1.2)


def scales(form: ExactForm, changes: Changes) -> dict[Quantity, float]:
    """Factors of quantities, those that are not 1, as some states tell them, always the same."""
    states = _some_states(form.arm)
    exact, model = (Told(form.recursion, some) for some in ({}, changes))
    was, now = _values(exact, states), _values(model, states)
    sums: dict[tuple[str, int], FloatArray] = defaultdict(lambda: np.zeros(3))
    members: dict[tuple[str, int], list[Quantity]] = defaultdict(list)
    for quantity in was.keys() & now.keys():
        group = quantity.kind.rstrip(PRIME), quantity.link
        one, other = was[quantity], now[quantity]
        sums[group] += one @ one, one @ other, other @ other
        members[group].append(quantity)
    out: dict[Quantity, float] = {}
    for kind in _FREE:
        logarithms = [_logarithm(sums[kind, link]) for link in range(form.arm.n_joints)]
        for links, found in _runs(logarithms):
            own = [quantity for link in links for quantity in members[kind, link]]
            if found and _is_made_up_for(found, frozenset(own), exact, model):
                out |= dict.fromkeys(own, math.exp(found))
    return out


def _logarithm(sums: FloatArray) -> float:
    """Of a factor, from sums of squares and products; 0 where it is none."""
    squares, product, now = sums
    if product <= max(_ALIKE * math.sqrt(squares * now), 0.0):
        return 0.0
    found = math.log(product / squares)
    return found if abs(found) > _FAR else 0.0


def _runs(logarithms: Sequence[float]) -> list[tuple[list[int], float]]:
    """Neighbouring links whose factors differ little, and the mean."""
    runs: list[list[int]] = []
    for link, found in enumerate(logarithms):
        first = logarithms[runs[-1][0]] if runs else 0.0
        if first and found and abs(found - first) < _ONE:
            runs[-1].append(link)
        else:
            runs.append([link])
    return [(run, sum(logarithms[link] for link in run) / len(run)) for run in runs]


def _is_made_up_for(found: float, group: Set[Quantity], exact: Told, model: Told) -> bool:
    """Whether what quantities go into has them so much less; otherwise something of them is lost."""
    symbols = {quantity.symbol for quantity in group}
    apart = closer = 0.0
    for into in (exact.values.keys() & model.values.keys()) - group:
        weights = {term.powers: term.weight for term in model.sum(into)}
        for term in exact.sum(into):
            ratio = weights.get(term.powers, 0.0) / term.weight
            if ratio > 0.0 and any(base in symbols for base, _ in term.powers):
                apart += abs(math.log(ratio))
                closer += abs(math.log(ratio) + found)
    return closer < apart


def _some_states(arm: RobotArm) -> States:
    """States within the limits that an arm states, or such as arms have."""
    rate, acceleration = arm.limits("velocity_limit"), arm.limits("acceleration_limit")
    ranges = (
        np.full(arm.n_joints, math.pi),
        np.where(np.isfinite(rate), rate, _RATE),
        np.where(np.isfinite(acceleration), acceleration, _ACCELERATION),
    )
    random = np.random.default_rng(0)
    q, qd, qdd = (random.uniform(-1.0, 1.0, (_STATES, arm.n_joints)) * most for most in ranges)
    return States(q, qd, qdd)


def _values(told: Told, states: States) -> dict[Quantity, FloatArray]:
    """Quantities that are computed, at states."""
    quantities = list(told.values)
    program = Program(told.program.steps, tuple(told.values[quantity][1] for quantity in quantities))
    rows = program.run(inputs_of(states))
    return {quantity: told.values[quantity][0] * row for quantity, row in zip(quantities, rows, strict=True)}


# What the symbols in it mean, those of one meaning together.
MEANINGS: tuple[tuple[tuple[Symbol, ...], str], ...] = (
    (
        (Symbol("omega"), Symbol("omega", dots=1)),
        "angular velocity and acceleration of a link, in its frame on the joint's axis",
    ),
    ((Symbol("a"),), "acceleration of that frame's origin, gravity counted in"),
    ((Symbol("A"),), "matrix by which a point r of the link has A r more"),
    ((Symbol("f"), Symbol("n")), "force and moment, about the origin, on the link and those beyond"),
    (
        (Symbol("a", primes=1), Symbol("a", primes=2)),
        "the same in that frame before its joint turns, and in the frame of the link before",
    ),
)


@dataclass(frozen=True)
class Passage:
    """Equations of one link, on the way out or back.

    Parameters
    ----------
    link
        From 0.
    outward
        Whether it tells how the link moves, or what that does to forces.
    formulas
        In the order they can be evaluated in.
    """

    link: int
    outward: bool
    formulas: tuple[Formula, ...]

    @property
    def heading(self) -> str:
        """Words above them."""
        return f"Link {self.link + 1}, {'how it moves' if self.outward else 'forces and torque'}"


@dataclass(frozen=True)
class Reading:
    """A changed recursion, to read.

    Parameters
    ----------
    passages
        Outward from the base, then back to it; links without equations are left out.
    functions
        Sines and cosines.
    """

    passages: tuple[Passage, ...]
    functions: tuple[Formula, ...]

    @property
    def legend(self) -> Legend:
        """The longest plain cosine and sine, which explain the others, and all that are not plain."""
        told: list[Formula] = []
        for letter in ("C", "S"):
            own = [formula for formula in self.functions if formula.left.letter == letter]
            plain = [formula for formula in own if _is_plain(formula)]
            told += [max(plain, key=lambda formula: len(formula.left.index))] if plain else []
            told += [formula for formula in own if formula not in plain]
        return Legend((), (), tuple(told))

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """All equations, in the order they can be evaluated in."""
        return tuple(formula for passage in self.passages for formula in passage.formulas)


def read(recursion: Recursion, changes: Changes, factors: Mapping[Quantity, float] | None = None) -> Reading:
    """Write a changed recursion in equations of the quantities that a reader knows.

    What is zero, is not needed any more, or only is another quantity in another frame, has no equation.

    Parameters
    ----------
    recursion
        The exact one.
    changes
        Of it.
    factors
        What is taken out of quantities, see `recursion_scales`.
    """
    told = Told(recursion, changes, factors)
    links = range(len(recursion.outputs))
    passages: list[tuple[int, bool, list[Formula]]] = []
    for outward, kinds in ((True, OUTWARD), (False, INWARD)):
        for link in links if outward else reversed(links):
            own = sorted(
                (quantity for quantity in told.values if quantity.link == link and quantity.kind in kinds),
                key=lambda quantity: kinds.index(quantity.kind),
            )
            sums = [
                as_formula(quantity.symbol, told.sum(quantity)) for quantity in own if _says(quantity, told)
            ]
            passages.append((link, outward, sums))
    functions = (Formula(symbol, (Piece(one(own)),)) for symbol, own in told.names.functions.items())
    ordered = (Passage(link, outward, sums) for (link, outward, _), sums in _in_order(passages))
    return Reading(tuple(passage for passage in ordered if passage.formulas), tuple(functions))


def _in_order(
    passages: Sequence[tuple[int, bool, Sequence[Formula]]],
) -> Iterator[tuple[tuple[int, bool, Sequence[Formula]], tuple[Formula, ...]]]:
    """Bring forward what an equation before it needs: a changed step may take in what is told of later."""
    left = {formula.left: formula for _, _, formulas in passages for formula in formulas}

    def with_needed(symbol: Symbol | Function) -> Iterator[Formula]:
        if not isinstance(symbol, Symbol) or (formula := left.pop(symbol, None)) is None:
            return
        for piece in formula.pieces:
            for base, _ in piece.product.powers:
                yield from with_needed(base)
        yield formula

    for passage in passages:
        yield passage, tuple(one for formula in passage[2] for one in with_needed(formula.left))


def _says(quantity: Quantity, told: Told) -> bool:
    """Whether a quantity's equation says anything."""
    name = told.name(quantity)
    if quantity.kind == "tau":
        return True
    return name is not None and (name[1] == quantity.symbol or not _is_aside(quantity))


def _is_aside(quantity: Quantity) -> bool:
    """Whether nobody misses it where it is another quantity by name."""
    return PRIME in quantity.kind or quantity.kind in ("p", "pd", "A", "r")


def _is_plain(formula: Formula) -> bool:
    """Whether it is the cosine or sine of a sum of angles."""
    ((function, _),) = formula.pieces[0].product.powers
    assert isinstance(function, Function)
    return all(term.powers and term.weight == 1.0 for term in function.argument)
