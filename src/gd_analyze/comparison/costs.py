"""What a formulation's torque costs: counted on the very code, as it stands and with waste folded away."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np

from gd_analyze.comparison.chain import generic_chain
from gd_analyze.comparison.methods import METHODS, Method
from gd_analyze.comparison.polynomial import Polynomial, exact_polynomial
from gd_analyze.operations import OperationCount, Program, Trace, count_operations
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array, Elementwise

# The text's polynomials are set beside ours for these numbers of joints.
SIZES = tuple(range(1, 13))
# With one or two joints some sums are empty.
_REGULAR = 3
# Below six joints constant and low-order terms hide the order.
_ASYMPTOTIC = 6


@dataclass(frozen=True)
class Cost:
    """Arithmetic of one torque evaluation.

    Parameters
    ----------
    executed
        What the code carries out as it stands, products with zero included.
    folded
        What is left when constants are folded, products with 0 and 1 vanish and equal subexpressions are
        evaluated once.
    """

    executed: OperationCount
    folded: OperationCount


@dataclass(frozen=True)
class Growth:
    """Costs on the generic chain over the number of joints.

    Parameters
    ----------
    sizes
        Numbers of joints.
    costs
        By method, one per size.
    exponents
        By method: slope of log(executed operations) against log(n) from six joints on; empty where fewer
        than two such sizes were counted.
    exponents_folded
        The same of the folded operations.
    polynomials
        By method: multiplications and additions as executed, as the polynomials in n that all counts from
        three joints on obey; left out where there are none.
    """

    sizes: tuple[int, ...]
    costs: Mapping[str, tuple[Cost, ...]]
    exponents: Mapping[str, float]
    exponents_folded: Mapping[str, float]
    polynomials: Mapping[str, tuple[Polynomial, Polynomial]]


def count_cost(method: Method, arm: RobotArm) -> Cost:
    """Count one method's torque of an arm.

    Parameters
    ----------
    method
        One of `METHODS`.
    arm
        The arm; its numbers are constants, the state is not.
    """
    n = arm.n_joints

    def code(q: Array, qd: Array, qdd: Array, cos: Elementwise, sin: Elementwise) -> Array:
        return method.torque(arm, q, qd, qdd, gravity=True, cos=cos, sin=sin)

    # Values do not matter to a count, only that they are there.
    executed = count_operations(code, *np.full((3, n), 0.5))
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, n) for name in ("q", "qd", "qdd"))
    torque = code(q, qd, qdd, trace.cos, trace.sin)
    return Cost(executed, Program.of(trace, list(torque[:, 0])).count)


def growth(
    sizes: Sequence[int] = SIZES,
    methods: Mapping[str, Method] = MappingProxyType(METHODS),
    progress: Callable[[int], None] | None = None,
) -> Growth:
    """Count every method on generic chains of several sizes.

    Parameters
    ----------
    sizes
        Numbers of joints, ascending.
    methods
        Which methods.
    progress
        Called with the number of counts done since the last call; there are sizes times methods of them.
    """
    costs: dict[str, tuple[Cost, ...]] = {}
    for name, method in methods.items():
        counted = []
        for n in sizes:
            counted.append(_count_chain(method, n))
            if progress is not None:
                progress(1)
        costs[name] = tuple(counted)
    large = [k for k, n in enumerate(sizes) if n >= _ASYMPTOTIC]
    executed, folded = {}, {}
    if len(large) > 1:
        for name, counted_ in costs.items():
            executed[name] = _slope(sizes, [counted_[k].executed.total for k in large], large)
            folded[name] = _slope(sizes, [counted_[k].folded.total for k in large], large)
    return Growth(tuple(sizes), costs, executed, folded, _polynomials(sizes, costs))


def _polynomials(
    sizes: Sequence[int], costs: Mapping[str, tuple[Cost, ...]]
) -> dict[str, tuple[Polynomial, Polynomial]]:
    chosen = [k for k, n in enumerate(sizes) if n >= _REGULAR]
    found = {}
    for name, counted in costs.items() if chosen else ():
        regular = [sizes[k] for k in chosen]
        multiplications = exact_polynomial(regular, [counted[k].executed.multiplications for k in chosen])
        additions = exact_polynomial(regular, [counted[k].executed.additions for k in chosen])
        if multiplications is not None and additions is not None:
            found[name] = (multiplications, additions)
    return found


@cache
def _count_chain(method: Method, n: int) -> Cost:
    """Cost on the generic chain; a count never changes within a run."""
    return count_cost(method, generic_chain(n))


def exponent(sizes: Sequence[int], totals: Sequence[int]) -> float:
    """Slope of log(total) against log(size): the power that fits best."""
    return float(np.polyfit(np.log(sizes), np.log(totals), 1)[0])


def _slope(sizes: Sequence[int], totals: Sequence[int], chosen: Sequence[int]) -> float:
    return exponent([sizes[k] for k in chosen], totals)
