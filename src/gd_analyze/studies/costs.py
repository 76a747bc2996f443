"""What a formulation's torque costs: counted on the very code, as it stands and with waste folded away."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import ClassVar, Literal

import numpy as np

from gd_analyze.dynamics.methods import METHODS, Method
from gd_analyze.operations.counting import count_operations
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.generic_chain import generic_chain
from gd_analyze.studies.polynomial import Polynomial, exact_polynomial
from gd_analyze.studies.text_costs import text_costs

Counted = Literal["executed", "folded", "text"]

# The founding text's polynomials are set beside ours for these numbers of joints.
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


@dataclass(frozen=True, eq=False)
class Growth:
    """Costs on the generic chain over the number of joints.

    Parameters
    ----------
    costs
        By method, one for each of `sizes`, the numbers of joints.
    """

    costs: Mapping[str, tuple[Cost, ...]]
    sizes: ClassVar[tuple[int, ...]] = SIZES

    def counts(self, method: str, which: Counted) -> tuple[OperationCount, ...]:
        """Counts by size, ours or FGL87's; none where it has no polynomial of the method."""
        if which != "text":
            return tuple(getattr(cost, which) for cost in self.costs[method])
        stated = text_costs().of(method)
        return () if stated is None else tuple(stated.at(n) for n in self.sizes)

    def slope(self, method: str, which: Counted) -> float | None:
        """Slope of log(operations) over log(n) from six joints on; None where less than two are counted."""
        counts = zip(self.sizes, self.counts(method, which), strict=False)
        large = [(n, count.total) for n, count in counts if n >= _ASYMPTOTIC]
        return exponent(*zip(*large, strict=True)) if len(large) > 1 else None

    @cached_property
    def polynomials(self) -> dict[str, tuple[Polynomial, Polynomial]]:
        """Multiplications and additions as executed: the polynomials that all from three joints on obey."""
        found = {}
        for name, costs in self.costs.items():
            regular = {n: cost.executed for n, cost in zip(self.sizes, costs, strict=True) if n >= _REGULAR}
            multiplications, additions = (
                exact_polynomial(list(regular), [getattr(count, what) for count in regular.values()])
                for what in ("multiplications", "additions")
            )
            if multiplications is not None and additions is not None:
                found[name] = (multiplications, additions)
        return found


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
    code = partial(method.torque, arm)
    # Values do not matter to a count, only that they are there.
    executed = count_operations(code, *np.full((3, n), 0.5))
    trace = Trace()
    torque = code(*(trace.inputs(name, n) for name in ("q", "qd", "qdd")))
    return Cost(executed, Program.of(trace, list(torque[:, 0])).count)


def growth(progress: Callable[[int], None] = lambda done: None) -> Growth:
    """Count every method on generic chains of `SIZES` joints.

    Parameters
    ----------
    progress
        Called with the number of counts done since the last call; there are sizes times methods of them.
    """

    def counted(method: Method, n: int) -> Cost:
        cost = _count_chain(method, n)
        progress(1)
        return cost

    return Growth({name: tuple(counted(method, n) for n in SIZES) for name, method in METHODS.items()})


@cache
def _count_chain(method: Method, n: int) -> Cost:
    """Cost on the generic chain; a count never changes within a run."""
    return count_cost(method, generic_chain(n))


def exponent(sizes: Sequence[int], totals: Sequence[int]) -> float:
    """Slope of log(total) against log(size): the power that fits best."""
    return float(np.polyfit(np.log(sizes), np.log(totals), 1)[0])
