"""Level "recursive": the exact Newton-Euler recursion with some steps changed, and its equations.

A force twice as large with levers half as long gives the same torque. Refitted numbers use this freedom; for
readable equations such factors (`scales`) are removed.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from pydantic import TypeAdapter

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import (
    PRIME,
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
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Expression
from gd_analyze.simplification.effort import COUNTING, Effort, inputs_of
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.level import Checked, Coefficient, Level, Terms
from gd_analyze.simplification.recursion import (
    CONSTANT,
    INWARD,
    NUMBER,
    OUTWARD,
    Change,
    Changes,
    Quantity,
    Recursion,
)
from gd_analyze.text import joined

# Usual order of letters in products, and of summands by their last letter.
_ORDER = ("C", "S", "n", "f", "a", "q", "p", "omega", "r", "A", "tau")
# Only these may have a factor: moments act as torques, and joint velocities are inputs.
_FREE = ("f", "a", "A", "omegad", "omega")
# Number of states, with velocities and accelerations (per s, s^2) if the arm states no limits.
_STATES, _VELOCITY, _ACCELERATION = 300, 1.0, 10.0
# A quantity has a factor if it correlates this much with the original and its size differs this much; factors
# of neighbouring links that differ by less than `_ONE` are equal.
_ALIKE, _FAR, _ONE = 0.9, math.log(1.15), math.log(1.2)

# Meaning of the symbols, grouped.
MEANINGS: tuple[tuple[tuple[Symbol, ...], str], ...] = (
    (
        (Symbol("omega"), Symbol("omega", dots=1)),
        "angular velocity and acceleration of a link, in its frame on the joint's axis",
    ),
    ((Symbol("a"),), "acceleration of that frame's origin, minus gravity"),
    ((Symbol("A"),), "matrix of the acceleration A r of a point at r of the link relative to the origin"),
    ((Symbol("f"), Symbol("n")), "force and moment, about the origin, on the link and those beyond"),
    (
        (Symbol("a", primes=1), Symbol("a", primes=2)),
        "the same in that frame before its joint turns, and in the frame of the previous link",
    ),
)


class Names:
    """Names of one trace's expressions; `values` are quantities as a sign and an expression or number."""

    def __init__(self, steps: Sequence[Expression], values: Mapping[Quantity, tuple[float, Any]]) -> None:
        self.known: dict[int, tuple[float, Symbol]] = {}
        self.quantity: dict[int, Quantity] = {}
        self.functions: dict[Symbol, Function] = {}
        for step in steps:
            if step.operation == "input":
                letters = step.arguments[0].rstrip("0123456789")
                joint = int(step.arguments[0][len(letters) :]) - 1
                self.known[step.order] = 1.0, Symbol("q", joined((joint,)), dots=len(letters) - 1)
        for step in steps:
            if step.operation in ("cos", "sin"):
                argument = tuple(sorted(self.terms(step.arguments[0]), key=_index))
                joints = tuple(int(_index(term)) - 1 for term in argument if term.powers)
                symbol = Symbol("C" if step.operation == "cos" else "S", joined(joints))
                while symbol in self.functions:
                    symbol = replace(symbol, primes=symbol.primes + 1)
                self.functions[symbol] = Function(str(step.operation), argument)
                self.known[step.order] = 1.0, symbol
        # One name each, preferably of its own frame.
        for quantity, (sign, base) in sorted(values.items(), key=lambda pair: pair[0].kind.count(PRIME)):
            if isinstance(base, Expression):
                self.known.setdefault(base.order, (sign, quantity.symbol))
                self.quantity.setdefault(base.order, quantity)

    def terms(
        self,
        x: Any,
        weight: float = 1.0,
        *,
        inside: bool = False,
        instead: Mapping[int, Sequence[Product]] | None = None,
    ) -> list[Product]:
        """Write x, expanded itself if `inside`, as products of named expressions or of their `instead`."""
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
        return [Product(weight * u.weight * v.weight, _product(u.powers + v.powers)) for u in a for v in b]

    def parts(self, steps: Iterable[Expression]) -> dict[int, Quantity]:
        """Quantity that each expression equals or belongs to; the last of several."""
        of = dict(self.quantity)
        for step in sorted(steps, key=lambda step: -step.order):
            for argument in step.arguments:
                if isinstance(argument, Expression) and step.order in of:
                    of.setdefault(argument.order, of[step.order])
        return of

    def sum(self, x: Any, weight: float = 1.0, *, inside: bool = False) -> tuple[Product, ...]:
        """Write an expression as an ordered sum, see `merged`."""
        return merged(self.terms(x, weight, inside=inside))


def unsigned(x: Any) -> tuple[float, Any]:
    """Split an expression or number into a sign and the rest."""
    if isinstance(x, Expression) and x.operation == "negative":
        return -1.0, x.arguments[0]
    return 1.0, x


def merged(terms: Iterable[Product]) -> tuple[Product, ...]:
    """Merge equal products, in the usual order: factors of A come last."""
    weights: dict[tuple[Power, ...], float] = {}
    for term in terms:
        weights[term.powers] = weights.get(term.powers, 0.0) + term.weight
    left = (Product(weight, powers) for powers, weight in weights.items() if weight)
    return tuple(sorted(left, key=lambda term: max(map(_rank, term.powers), default=(9, ""))))


def _product(powers: tuple[Power, ...]) -> tuple[Power, ...]:
    """Merge equal factors to one power."""
    exponents: dict[Symbol | Function, int] = {}
    for base, exponent in powers:
        exponents[base] = exponents.get(base, 0) + exponent
    return tuple(sorted((Power(*item) for item in exponents.items()), key=_rank))


def _rank(power: Power) -> tuple[int, str]:
    """Rank among factors, and of its product among summands."""
    base = power.base
    return (0, "") if isinstance(base, Function) else (_ORDER.index(base.letter), base.index)


def _index(term: Product) -> str:
    """Joint of an angle; the constant comes last."""
    if not term.powers:
        return "~"
    base = term.powers[0].base
    assert isinstance(base, Symbol), "angles are sums of joint variables"
    return f"{int(base.index):3d}"


class SimplifiedQuantities:
    """Quantities still needed after the changes, without their `factors`, see `scales`."""

    def __init__(
        self, recursion: Recursion, changes: Changes, factors: Mapping[Quantity, float] | None = None
    ) -> None:
        changed = recursion.carried_out(changes)
        self.program = changed.program
        needed = {step.order for step in self.program.steps}

        def now(value: Any) -> tuple[float, Any] | None:
            if not isinstance(value, Expression):
                return unsigned(value)
            for sign, x in ((1.0, value), unsigned(value)):
                if x.order in changed.images:
                    other, base = unsigned(changed.images[x.order])
                    if not isinstance(base, Expression) or base.order in needed:
                        return sign * other, base
            return None

        found = {quantity: now(value) for quantity, value in recursion.quantities}
        torques = [quantity for quantity in found if quantity.kind == "tau"]
        found |= zip(torques, map(unsigned, self.program.outputs), strict=True)
        # A sign, and an expression or number.
        self.values = {quantity: value for quantity, value in found.items() if value is not None}
        self.names = Names(self.program.steps, self.values)
        self._factors: dict[Symbol | Function, float] = {q.symbol: f for q, f in (factors or {}).items()}

    def name(self, quantity: Quantity) -> tuple[float, Symbol] | None:
        """Sign and symbol of a quantity where it is used; None for a number."""
        sign, base = self.values[quantity]
        if not isinstance(base, Expression):
            return None
        own_sign, symbol = self.names.known[base.order]
        return sign * own_sign, symbol

    def sum(self, quantity: Quantity) -> tuple[Product, ...]:
        """Sum of a quantity; the other quantity if both are equal."""
        sign, base = self.values[quantity]
        if not isinstance(base, Expression):
            return (Product(sign * base),) if base else ()
        own_sign, symbol = self.names.known[base.order]
        if symbol != quantity.symbol:
            terms: tuple[Product, ...] = (Product(sign * own_sign, (Power(symbol),)),)
        else:
            terms = self.names.sum(base, own_sign, inside=True)
        factors, own = self._factors, self._factors.get(quantity.symbol, 1.0)

        def factor(term: Product) -> float:
            return math.prod(factors.get(base, 1.0) ** exponent for base, exponent in term.powers)

        return tuple(term._replace(weight=term.weight * factor(term) / own) for term in terms)

    def at(self, states: States) -> dict[Quantity, FloatArray]:
        """Quantities that are computed, at states."""
        program = Program(self.program.steps, tuple(base for _, base in self.values.values()))
        rows = program.run(inputs_of(states))
        signs = ((quantity, sign) for quantity, (sign, _) in self.values.items())
        return {quantity: sign * row for (quantity, sign), row in zip(signs, rows, strict=True)}


def scales(form: ExactForm, changes: Changes) -> dict[Quantity, float]:
    """Factors of quantities relative to the exact ones, if not 1, estimated at fixed random states."""
    n, random = form.arm.n_joints, np.random.default_rng(0)
    limits = form.arm.limits("velocity_limit"), form.arm.limits("acceleration_limit")
    usual = zip(limits, (_VELOCITY, _ACCELERATION), strict=True)
    ranges = [np.full(n, math.pi), *(np.where(np.isfinite(most), most, own) for most, own in usual)]
    states = States(*(random.uniform(-1.0, 1.0, (_STATES, n)) * most for most in ranges))
    exact, model = (SimplifiedQuantities(form.recursion, some) for some in ({}, changes))
    was, now = exact.at(states), model.at(states)
    # Exact squares, products, and present squares.
    sums: dict[tuple[str, int], FloatArray] = defaultdict(lambda: np.zeros(3))
    members: dict[tuple[str, int], list[Quantity]] = defaultdict(list)
    for quantity in was.keys() & now.keys():
        group = quantity.kind.rstrip(PRIME), quantity.link
        one, other = was[quantity], now[quantity]
        sums[group] += one @ one, one @ other, other @ other
        members[group].append(quantity)

    def logarithm(before: float, product: float, after: float) -> float:
        if product <= max(_ALIKE * math.sqrt(before * after), 0.0):
            return 0.0
        found = math.log(product / before)
        return found if abs(found) > _FAR else 0.0

    out: dict[Quantity, float] = {}
    for kind in _FREE:
        logarithms = [logarithm(*sums[kind, link].tolist()) for link in range(n)]
        runs: list[list[int]] = []  # neighbouring links whose factors differ little
        for link, found in enumerate(logarithms):
            first = logarithms[runs[-1][0]] if runs else 0.0
            if first and found and abs(found - first) < _ONE:
                runs[-1].append(link)
            else:
                runs.append([link])
        for run in runs:
            mean = sum(logarithms[link] for link in run) / len(run)
            own = [quantity for link in run for quantity in members[kind, link]]
            if mean and _is_made_up_for(mean, frozenset(own), exact, model):
                out |= dict.fromkeys(own, math.exp(mean))
    return out


def _is_made_up_for(
    found: float, group: Set[Quantity], exact: SimplifiedQuantities, model: SimplifiedQuantities
) -> bool:
    """Whether results of the quantities compensate their factors; otherwise part of them is lost."""
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


@dataclass(frozen=True)
class Passage:
    """Equations of one link (from 0), outward (motion) or back (forces), in the order of evaluation."""

    link: int
    outward: bool
    formulas: tuple[Formula, ...]

    @property
    def heading(self) -> str:
        """Heading of the equations."""
        return f"Link {self.link + 1}: {'motion' if self.outward else 'forces and torque'}"


@dataclass(frozen=True)
class Reading:
    """Readable form of a simplified recursion: passages outward and back, and sines and cosines."""

    passages: tuple[Passage, ...]
    functions: tuple[Formula, ...]

    @property
    def legend(self) -> Legend:
        """One plain cosine and sine, which explain the others, and all that are not plain."""

        def is_plain(formula: Formula) -> bool:  # of a sum of angles
            ((function, _),) = formula.pieces[0].product.powers
            assert isinstance(function, Function)
            return all(term.powers and term.weight == 1.0 for term in function.argument)

        shown: list[Formula] = []
        for letter in ("C", "S"):
            own = [formula for formula in self.functions if formula.left.letter == letter]
            plain = [formula for formula in own if is_plain(formula)]
            shown += [max(plain, key=lambda formula: len(formula.left.index))] if plain else []
            shown += [formula for formula in own if formula not in plain]
        return Legend((), (), tuple(shown))

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """All equations, in order of evaluation."""
        return tuple(formula for passage in self.passages for formula in passage.formulas)


class _ChangeEntry(Checked):
    step: int
    source: int
    number: Coefficient


class RecursiveLevel(Level):
    """Changes of the recursion, see `recursion.Change`; without changes it is exact."""

    name: ClassVar[str] = "recursive"
    keeps: ClassVar[str] = "steps simplified"
    always_refits: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_ChangeEntry])

    def terms(self, form: ExactForm) -> Terms:
        """No change."""
        return {}

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Carry the changes out; for a final model, rewrite the steps in fewer operations."""
        program = form.recursion.changed(terms)
        if effort.shared <= COUNTING.shared:
            return program
        return rewritten(program, 1 if effort.rearranging else 0)

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Equations of the recursion's quantities, in order of evaluation."""
        return self.reading(form, terms).formulas

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Sines and cosines."""
        return self.reading(form, terms).legend

    def reading(self, form: ExactForm, terms: Terms) -> Reading:
        """Its equations link by link, with factors (`scales`) removed.

        A quantity has no equation if it is zero, not needed, or another quantity in another frame.
        """
        quantities = SimplifiedQuantities(form.recursion, terms, scales(form, terms))
        left: dict[Symbol | Function, Formula] = {}

        def has_equation(quantity: Quantity) -> bool:
            if quantity.kind == "tau":
                return True
            name = quantities.name(quantity)
            is_aside = PRIME in quantity.kind or quantity.kind in ("p", "pd", "A", "r")
            return name is not None and (name[1] == quantity.symbol or not is_aside)

        def with_needed(symbol: Symbol | Function) -> Iterator[Formula]:
            """Inputs of an equation come first: a simplified step may use a later quantity."""
            if not isinstance(symbol, Symbol) or (formula := left.pop(symbol, None)) is None:
                return
            for piece in formula.pieces:
                for base, _ in piece.product.powers:
                    yield from with_needed(base)
            yield formula

        links, passages = range(len(form.recursion.outputs)), []
        for outward, kinds in ((True, OUTWARD), (False, INWARD)):
            for link in links if outward else reversed(links):
                of_link = (x for x in quantities.values if x.link == link and x.kind in kinds)
                own = sorted(of_link, key=lambda quantity: kinds.index(quantity.kind))
                sums = [as_formula(x.symbol, quantities.sum(x)) for x in own if has_equation(x)]
                left |= {formula.left: formula for formula in sums}
                passages.append((link, outward, sums))
        ordered = (
            Passage(link, outward, tuple(each for formula in sums for each in with_needed(formula.left)))
            for link, outward, sums in passages
        )
        functions = (
            Formula(symbol, (Piece(one(own)),)) for symbol, own in quantities.names.functions.items()
        )
        return Reading(tuple(passage for passage in ordered if passage.formulas), tuple(functions))

    def size(self, form: ExactForm, terms: Terms) -> tuple[int, int]:
        """Number of simplified steps, and of all."""
        steps = [step for step in form.recursion.program.steps if step.operation != "input"]
        return len({change.step for change in terms}), len(steps)

    def to_entry(self, term: Change, weight: float) -> Checked:
        """Write the indices of both steps and the number."""
        return _ChangeEntry(step=term.step, source=term.source, number=weight)

    def from_entry(self, form: ExactForm, entry: _ChangeEntry) -> tuple[Change, float]:
        """Read a change back, of steps of the arm's recursion."""
        steps = form.recursion.steps
        for place, least in ((entry.step, 0), (entry.source, min(NUMBER, CONSTANT))):
            if not least <= place < len(steps):
                expected = f"steps from 0 to {len(steps) - 1}"
                raise ModelError(f"the recursion has no step {place}", expected=expected)
        step = steps[entry.step]
        numbers = [x for x in step.arguments if step.operation != "input" and not isinstance(x, Expression)]
        if entry.source == CONSTANT and not numbers:
            raise ModelError(f"step {entry.step} of the recursion has no constant to be replaced")
        return Change(entry.step, entry.source), entry.number

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> dict[Change, float]:
        """Read changes back as every level does, and check that they can be carried out together."""
        changes = super().from_entries(form, entries)
        try:
            acting = form.recursion.acting(changes)
        except ValueError as error:
            raise ModelError(f"the changes cannot be carried out: {error}") from None
        if idle := [change.step for change, number in changes.items() if acting[change] != number]:
            raise ModelError(f"the change of step {min(idle)} does nothing")
        return changes


RECURSIVE: RecursiveLevel = RecursiveLevel()
