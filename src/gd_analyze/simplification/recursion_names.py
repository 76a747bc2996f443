"""What the steps of a recursion are: components of a link's quantities, or part of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import Array
from gd_analyze.formulas.formula import Function, Power, Product, Symbol
from gd_analyze.formulas.printer import PRIME
from gd_analyze.operations.trace import Expression
from gd_analyze.text import joined

# In the order of the steps of one link.
OUTWARD = ("p", "pd", "omega'", "omega", "omegad'", "omegad", "r", "a''", "a'", "a", "A")
INWARD = ("f", "n", "tau", "f'", "f''", "n'", "n''")
_AXES = "xyz"
# Letters as people put them in products, and summands by their last.
_ORDER = ("C", "S", "n", "f", "a", "q", "p", "omega", "r", "A", "tau")


class Quantity(NamedTuple):
    """A component of a quantity of a link.

    Parameters
    ----------
    kind
        As `docs/notation.md` has it; a prime says that it is expressed in the link's frame before its joint
        turns, two that it is in the frame of the link before.
    link
        From 0.
    component
        "x", "xy", or "" of what has only one.
    """

    kind: str
    link: int
    component: str = ""

    @property
    def symbol(self) -> Symbol:
        """Its symbol."""
        kind = self.kind.rstrip(PRIME)
        dots = {"p": 1, "pd": 2, "omegad": 1}.get(kind, 0)
        index = joined((self.link,)) + self.component
        return Symbol(kind.removesuffix("d"), index, dots, primes=len(self.kind) - len(kind))


def components(kind: str, link: int, values: Array) -> list[tuple[Quantity, Any]]:
    """Name the components of a quantity, shape (..., 1)."""
    if kind == "p":
        return [(Quantity("p", link), values[0, 0]), (Quantity("pd", link), values[1, 0])]
    return [
        (Quantity(kind, link, "".join(_AXES[k] for k in index[:-1])), values[index])
        for index in np.ndindex(values.shape)
    ]


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
