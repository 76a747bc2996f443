"""What the levels of harmonic terms share: values of terms at states, their price, their form in files."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import defaultdict
from collections.abc import Sequence
from functools import reduce
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.writing import torque_formulas, torque_legend
from gd_analyze.harmonics.lagrangian import gathered
from gd_analyze.harmonics.terms import Energies, EnergyTerm, Factor, Monomial, Torques, TorqueTerm, Velocity
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE
from gd_analyze.operations.program import Program
from gd_analyze.operations.sums import Magnitudes
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.effort import Effort
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import CandidateLevel, Costs, Terms
from gd_analyze.simplification.torque_program import TorqueVariables, torque_program, torque_programs

# Coefficients that are equal in mathematics, or twice or half each other, and differ by round-off.
_EQUAL = 1e-9

# What terms share is looked for from the start where more than this share of them is new.
_FEW = 0.1

# Kind, how often every joint goes into the argument, exponent.
FactorEntry = tuple[Literal["cos", "sin", "power"], list[int], Annotated[int, Field(ge=1, le=DEGREE)]]


class HarmonicLevel(CandidateLevel):
    """A level whose models are sums of harmonic torque terms."""

    has_torque_terms: ClassVar[bool] = True

    @abstractmethod
    def source(self, form: ExactForm, term: Any) -> Torques:
        """Torque terms that a term makes with a number of 1."""

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Add up what the terms make."""
        return gathered((number, self.source(form, term)) for term, number in terms.items())

    def effects(self, exact: ExactDynamics, terms: Terms) -> FloatArray:
        """Torque of everything that a term makes; each product of factors and velocities is formed once."""
        form, states = exact.form, (x.T for x in exact.states.arrays)
        values = TorqueVariables(form.velocities, states)
        known: dict[tuple[Velocity | Factor, ...], FloatArray] = {}
        rows = np.zeros((exact.arm.n_joints, len(terms), len(exact.states)))
        for k, (term, number) in enumerate(terms.items()):
            for made, weight in self.source(form, term).items():
                product: tuple[Velocity | Factor, ...] = (*made.velocities, *made.monomial)
                if product not in known:
                    known[product] = reduce(np.multiply, map(values, product), np.ones(len(exact.states)))
                rows[made.row, k] += number * weight * known[product]
        return np.stack(form.velocities.joint_rows(rows), axis=1)

    def costs(self, form: ExactForm, terms: Sequence[Any]) -> Costs:
        """Operations by the set of terms that need them: a guess at what factoring will find.

        A torque term takes its coefficient and its sum; equal products of sines and cosines are formed once,
        and velocities multiply the sum of all terms behind them.
        """
        users: dict[TorqueTerm, set[int]] = defaultdict(set)
        products: dict[Monomial, set[int]] = defaultdict(set)
        brackets: dict[tuple[int, tuple[Velocity, ...]], set[int]] = defaultdict(set)
        for k, term in enumerate(terms):
            for made in self.source(form, term):
                for needed in (users[made], products[made.monomial], brackets[made.row, made.velocities]):
                    needed.add(k)
        costs: dict[frozenset[int], int] = defaultdict(int)
        for members in users.values():
            costs[frozenset(members)] += 2
        for monomial, members in products.items():
            costs[frozenset(members)] += max(len(monomial) - 1, 0)
        for (_, velocities), members in brackets.items():
            costs[frozenset(members)] += len(velocities)
        return dict(costs)

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Factor the torques that the terms make."""
        return torque_program(form.velocities, self.torques(form, terms), effort)

    def write_steps(self, form: ExactForm, steps: Sequence[Terms], most: int) -> list[Program]:
        """Write each from the one before, as long as torque terms join and none changes."""
        programs: list[Program] = []
        for chain in _chains([self.torques(form, terms) for terms in steps]):
            written = torque_programs(form.velocities, chain, most)
            programs += written
            if len(written) < len(chain):
                break
        return programs

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Torques in absolute velocities, terms with the same velocities in brackets before them."""
        return torque_formulas(form.velocities, self.torques(form, terms))

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Absolute velocities, sines and cosines."""
        return torque_legend(form.velocities, self.torques(form, terms))


def _chains(steps: Sequence[Torques]) -> list[list[Torques]]:
    """Part steps into such that only add terms, and not many, to those before."""
    chains: list[list[Torques]] = []
    for terms in steps:
        before = chains[-1][-1] if chains else {}
        few = len(terms) - len(before) <= _FEW * len(terms)
        if chains and few and all(terms.get(term) == weight for term, weight in before.items()):
            chains[-1].append(terms)
        else:
            chains.append([terms])
    return chains


def numbered(energies: Energies) -> dict[EnergyTerm, int]:
    """Number every coefficient, those alike but for their sign and powers of two the same."""
    equal = Magnitudes(_EQUAL)
    half = equal(0.5)
    mantissas = [equal(math.frexp(abs(coefficient))[0]) for coefficient in energies.values()]
    # 1/2 and 1 are neighbours, too.
    _, number = np.unique([half if x == 1.0 else x for x in mantissas], return_inverse=True)
    return dict(zip(energies, number.tolist(), strict=True))


def factor_entries(monomial: Monomial) -> list[FactorEntry]:
    """Write a monomial for a model file."""
    return [(f.kind, list(f.multiples), monomial.count(f)) for f in dict.fromkeys(monomial)]


def monomial_of(arm: RobotArm, entries: Sequence[FactorEntry]) -> Monomial:
    """Read a monomial back; a ModelError where no arm of this make has it."""
    monomial = sorted(Factor(kind, tuple(m)) for kind, m, exponent in entries for _ in range(exponent))
    for factor in monomial:
        revolute = [turns for turns, m in zip(arm.is_revolute, factor.multiples, strict=False) if m]
        # Beyond the degree of D no multiple of an angle and no further power occurs.
        known = len(factor.multiples) == arm.n_joints and all(abs(m) <= DEGREE for m in factor.multiples)
        if factor.kind == "power":
            fitting = revolute == [False] and sum(factor.multiples) == 1
        else:
            fitting = bool(revolute) and all(revolute)
        if not (known and fitting):
            raise ModelError(f"{factor.kind} of {list(factor.multiples)} is no factor of the arm's equations")
    return tuple(monomial)
