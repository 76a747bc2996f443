"""A program as named steps: a step has a name if several others use it, or a product has it as a sum."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gd_analyze.formulas.formula import (
    CircularFunction,
    Formula,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
    alone,
    as_formula,
)
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression
from gd_analyze.text import joined

# Letter of a named step, and the order of letters in a product.
_STEP = "u"
_ORDER = ("C", "S", _STEP, "q")


class NamedSteps:
    """Equations of a program's named steps and of its torques, in the order of evaluation."""

    def __init__(self, program: Program) -> None:
        self._names: dict[int, Symbol] = {}
        self._functions: dict[Symbol, CircularFunction] = {}
        named = _named(program)
        formulas: list[Formula] = []
        for step in program.steps:
            if step.operation == "input":
                letters = step.arguments[0].rstrip("0123456789")
                joint = int(step.arguments[0][len(letters) :]) - 1
                self._names[step.order] = Symbol("q", joined((joint,)), dots=len(letters) - 1)
            elif step.operation in ("cos", "sin"):
                self._names[step.order] = self._function(step)
            elif step.order in named:
                symbol = Symbol(_STEP, str(len(formulas) + 1))
                formulas.append(as_formula(symbol, self._sum(step)))
                self._names[step.order] = symbol
        torques = (
            as_formula(Symbol("tau", joined((joint,))), self._sum(output))
            for joint, output in enumerate(program.outputs)
        )
        self.formulas: tuple[Formula, ...] = (*formulas, *torques)

    @property
    def legend(self) -> Legend:
        """The longest plain cosine and sine, which explain the shorter ones, and all that are not plain."""
        formulas: list[Formula] = []
        for letter in ("C", "S"):
            functions = {symbol: of for symbol, of in self._functions.items() if symbol.letter == letter}
            plain = [symbol for symbol, of in functions.items() if not symbol.primes and _is_plain(of)]
            longest = max(plain, key=lambda symbol: len(symbol.index), default=None)
            formulas += [
                Formula(symbol, (Piece(alone(of)),))
                for symbol, of in functions.items()
                if symbol == longest or symbol not in plain
            ]
        return Legend((), (), tuple(formulas))

    def _function(self, step: Expression) -> Symbol:
        """Name of a sine or cosine by the joints of its angle: S23; of equal joints with primes."""
        argument = tuple(self._sum(step.arguments[0]))
        indices = [
            power.base.index for term in argument for power in term.powers if isinstance(power.base, Symbol)
        ]
        symbol = Symbol("C" if step.operation == "cos" else "S", joined([int(x) - 1 for x in indices]))
        while symbol in self._functions:
            symbol = replace(symbol, primes=symbol.primes + 1)
        self._functions[symbol] = CircularFunction(str(step.operation), argument)
        return symbol

    def _sum(self, x: Any) -> tuple[Product, ...]:
        """An expression or number as a sum of products of named ones; products without numbers first."""
        terms = self._terms(x, 1.0)
        return tuple(sorted(terms, key=lambda term: max(map(_rank, term.powers), default=(len(_ORDER), ""))))

    def _terms(self, x: Any, weight: float) -> list[Product]:
        if not isinstance(x, Expression):
            return [Product(weight * x)] if x else []
        if x.order in self._names:
            return [Product(weight, (Power(self._names[x.order]),))]
        if x.operation == "negative":
            return self._terms(x.arguments[0], -weight)
        first, second = x.arguments
        if x.operation in ("add", "subtract"):
            sign = -1.0 if x.operation == "subtract" else 1.0
            return [*self._terms(first, weight), *self._terms(second, sign * weight)]
        a, b = self._terms(first, 1.0), self._terms(second, 1.0)
        return [Product(weight * u.weight * v.weight, _powers(u.powers + v.powers)) for u in a for v in b]


def _named(program: Program) -> set[int]:
    """Orders of the steps with a name.

    An angle, which sines and cosines use, has one only if several sums or products use it.
    """
    uses: Counter[int] = Counter(x.order for x in program.outputs if isinstance(x, Expression))
    in_arithmetic: Counter[int] = Counter()
    in_products: set[int] = set()
    sums: set[int] = set()
    for step in program.steps:
        operands = [x.order for x in step.arguments if isinstance(x, Expression)]
        uses.update(operands)
        if step.operation not in ("cos", "sin"):
            in_arithmetic.update(operands)
        if step.operation in ("add", "subtract") or (step.operation == "negative" and operands[0] in sums):
            sums.add(step.order)
        elif step.operation == "multiply":
            in_products.update(operands)
    angles = _angles(program)
    arithmetic = (step.order for step in program.steps if step.operation in ("add", "subtract", "multiply"))
    several = {order for order in arithmetic if (in_arithmetic if order in angles else uses)[order] > 1}
    return several | sums & in_products


def _angles(program: Program) -> set[int]:
    """Orders of the steps that only sines and cosines need."""
    outside = {x.order for x in program.outputs if isinstance(x, Expression)}
    for step in reversed(program.steps):
        if step.order in outside and step.operation not in ("cos", "sin", "input"):
            outside |= {x.order for x in step.arguments if isinstance(x, Expression)}
    return {step.order for step in program.steps} - outside


def _is_plain(function: CircularFunction) -> bool:
    return all(term.powers and term.weight == 1.0 for term in function.argument)


def _powers(factors: Sequence[Power]) -> tuple[Power, ...]:
    """Merge equal factors to one power."""
    exponents: dict[Symbol | CircularFunction, int] = {}
    for base, exponent in factors:
        exponents[base] = exponents.get(base, 0) + exponent
    return tuple(sorted((Power(*item) for item in exponents.items()), key=_rank))


def _rank(power: Power) -> tuple[int, str]:
    base = power.base
    return (0, "") if isinstance(base, CircularFunction) else (_ORDER.index(base.letter), f"{base.index:>5}")
