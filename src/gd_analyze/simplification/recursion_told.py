"""What the quantities of a recursion are once it is changed, and their names there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from typing import Any

from gd_analyze.formulas.formula import Function, Power, Product, Symbol
from gd_analyze.operations.trace import Expression
from gd_analyze.simplification.recursion import Changes, Recursion
from gd_analyze.simplification.recursion_names import Names, Quantity, unsigned


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
