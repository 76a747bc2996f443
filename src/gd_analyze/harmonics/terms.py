"""Terms of an arm's torques and energies.

A term is a monomial in sines and cosines of sums of angles and in the variables of prismatic joints; in a
torque it is multiplied by up to two velocities or one acceleration. Coefficients are separate: torques and
energies are mappings from terms to numbers.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, NamedTuple

# Share of its summands' magnitudes below which a coefficient counts as cancelled: those of small terms are
# known to some ten digits.
CANCELLED_SHARE = 1e-10

FactorKind = Literal["cos", "sin", "power"]


class Factor(NamedTuple):
    """Cosine or sine of a sum of angles, or the variable of a prismatic joint."""

    kind: FactorKind
    multiples: tuple[int, ...]  # of every joint's variable in the argument; 1 for a prismatic joint

    def __repr__(self) -> str:
        return repr(tuple(self))

    @property
    def joints(self) -> tuple[int, ...]:
        """Joints in the argument, from 0."""
        return tuple(j for j, multiple in enumerate(self.multiples) if multiple)

    @property
    def is_plain(self) -> bool:
        """Whether the argument is a sum of angles, each once, so that C23 or S234 names the factor."""
        return any(self.multiples) and all(m in (0, 1) for m in self.multiples)


# Factors in ascending order, each as often as its power.
Monomial = tuple[Factor, ...]


@lru_cache(maxsize=1 << 14)
def half_of(monomial: Monomial) -> tuple[int, ...] | None:
    """Multiples of half the angle of a single sine or cosine of a double angle; otherwise None."""
    if len(monomial) != 1 or monomial[0].kind == "power" or any(m % 2 for m in monomial[0].multiples):
        return None
    return tuple(m // 2 for m in monomial[0].multiples)


class Velocity(NamedTuple):
    """An absolute velocity p_joint (order 1) or acceleration pd_joint (order 2) in a torque term."""

    order: int
    joint: int


class TorqueTerm(NamedTuple):
    """Row of tau', velocities or acceleration, and monomial; joints from 0."""

    row: int
    velocities: tuple[Velocity, ...]
    monomial: Monomial

    @property
    def quantity(self) -> str:
        """Name of D, h or c, whichever the term belongs to."""
        return quantity_of(self.velocities)

    @property
    def is_upper(self) -> bool:
        """Whether the term is of h', c' or the upper triangle of D'."""
        return self.quantity != "inertia" or self.row <= self.velocities[0].joint

    def weight_unit(self, revolute: Sequence[bool]) -> str:
        """Unit of the coefficient: that of the torque without velocities and prismatic variables."""
        metres = 1 + revolute[self.row] - sum(factor.kind == "power" for factor in self.monomial)
        if not self.velocities:
            return f"N{_to_the(metres - 1)}"
        return f"kg{_to_the(metres - sum(not revolute[velocity.joint] for velocity in self.velocities))}"


class EnergyTerm(NamedTuple):
    """A monomial in D'_ij (i <= j), or in the potential energy, where i and j are -1."""

    i: int
    j: int
    monomial: Monomial

    @property
    def quantity(self) -> str:
        """Name of the energy, "kinetic" or "potential"."""
        return "potential" if self.is_potential else "kinetic"

    @property
    def is_potential(self) -> bool:
        """Whether this is a term of the potential energy."""
        return self.i < 0


Torques = Mapping[TorqueTerm, float]
Energies = Mapping[EnergyTerm, float]


# Names of D, h and c.
DYNAMICS_QUANTITIES = ("inertia", "coriolis_centrifugal", "gravity_loading")


def quantity_of(velocities: tuple[Velocity, ...]) -> str:
    """Name of D, h or c, whichever torque terms with these velocities belong to."""
    if not velocities:
        return "gravity_loading"
    return "inertia" if velocities[0].order == 2 else "coriolis_centrifugal"


def summed(sources: Iterable[tuple[float, Torques]]) -> dict[TorqueTerm, float]:
    """Sum of torque terms, each source times its factor; those that cancel are left out."""
    sums, sizes = accumulated(sources)
    return {term: weight for term, weight in sums.items() if abs(weight) > CANCELLED_SHARE * sizes[term]}


def accumulated(
    sources: Iterable[tuple[Any, Torques]],
) -> tuple[dict[TorqueTerm, Any], dict[TorqueTerm, Any]]:
    """Sums of the weights of every term, and of their magnitudes."""
    sums: dict[TorqueTerm, Any] = defaultdict(float)
    sizes: dict[TorqueTerm, Any] = defaultdict(float)
    for factor, torques in sources:
        for term, weight in torques.items():
            summand = factor * weight
            sums[term] += summand
            sizes[term] += abs(summand)
    return sums, sizes


def _to_the(power: int) -> str:
    """Write a power of the metre behind another unit."""
    exponent = f"^{abs(power)}" if abs(power) > 1 else ""
    return f"{'/' if power < 0 else ' '}m{exponent}" if power else ""
