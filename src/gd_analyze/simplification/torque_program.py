"""Torque terms as a straight-line program of few operations: the best of several forms."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import DYNAMICS_QUANTITIES, Factor, Monomial, Torques, TorqueTerm, Velocity
from gd_analyze.operations.functions import Functions, inertia_program
from gd_analyze.operations.program import UFUNCS, Program, fewest
from gd_analyze.operations.sharing import factored, shared_sums
from gd_analyze.operations.trace import Trace

# Most torque terms for which common parts of rows are searched, beside nested sums.
Effort: TypeAlias = int
# Milliseconds, within a search.
ROUGH: Effort = 0
# Hundredths of a second, within a search.
COUNTING: Effort = 80
# Hundredths of a second, for a model whose count is stated.
FINAL: Effort = 600
# Most terms of D, h and c that a person reads; of more, a program is not searched for shared parts.
READABLE = 250


class TorqueVariables:
    """Sines, cosines, powers, absolute velocities and accelerations at states, for values of any type."""

    def __init__(self, velocities: AbsoluteVelocities, states: Iterable[Any]) -> None:
        self._q, qd, qdd = states
        self._moving = {1: velocities.absolute(qd), 2: velocities.absolute(qdd)}
        self._values: dict[Velocity | Factor, Any] = {}

    @classmethod
    def traced(cls, velocities: AbsoluteVelocities, trace: Trace) -> TorqueVariables:
        """Expressions on a trace."""
        states = (trace.inputs(name, velocities.n_joints)[:, 0] for name in ("q", "qd", "qdd"))
        return cls(velocities, states)

    def __call__(self, variable: Velocity | Factor) -> Any:
        """Value of a velocity or a factor."""
        if variable not in self._values:
            self._values[variable] = self._value(variable)
        return self._values[variable]

    def _value(self, variable: Velocity | Factor) -> Any:
        if isinstance(variable, Velocity):
            return self._moving[variable.order][variable.joint]
        kind, multiples = variable
        argument: Any = 0.0
        for joint, multiple in enumerate(multiples):
            for _ in range(abs(multiple)):
                argument = argument + self._q[joint] if multiple > 0 else argument - self._q[joint]
        return argument if kind == "power" else UFUNCS[kind](argument)


# Relative difference, from round-off, up to which one bracket counts as a multiple of another and shares it.
_PROPORTIONAL = 1e-9

_Key = tuple[int, tuple[Velocity, ...]]
_Polynomial = dict[Monomial, float]
_Polynomials = dict[_Key, _Polynomial]


def nested_program(velocities: AbsoluteVelocities, terms: Torques, *, in_line: bool = False) -> Program:
    """Write torques in nested form; `in_line` expands brackets of one term, to share velocities."""
    polynomials: _Polynomials = defaultdict(dict)
    for term, weight in terms.items():
        if weight != 0.0:
            polynomials[term.row, term.velocities][term.monomial] = weight
    trace = Trace()
    variables = TorqueVariables.traced(velocities, trace)
    distinct, places = _distinct(polynomials)
    brackets = [factored(polynomial, variables) for polynomial in distinct]
    rows: list[dict[tuple[Hashable, ...], float]] = [{} for _ in range(velocities.n_joints)]
    for (row, moving), polynomial in polynomials.items():
        number, ratio = places[row, moving]
        if isinstance(brackets[number], float):
            rows[row][moving] = ratio * brackets[number]
        elif in_line and len(polynomial) == 1:
            ((monomial, weight),) = polynomial.items()
            rows[row][(*moving, *monomial)] = weight
        else:
            rows[row][(*moving, number)] = _without_last_digits(ratio)

    def value(variable: Any) -> Any:
        return brackets[variable] if isinstance(variable, int) else variables(variable)

    return Program.of(trace, velocities.joint_rows(factored(row, value) for row in rows))


def _distinct(polynomials: _Polynomials) -> tuple[list[_Polynomial], dict[_Key, tuple[int, float]]]:
    """Polynomials that are not multiples of each other; also index and factor by key of `polynomials`."""
    distinct: list[_Polynomial] = []
    places: dict[_Key, tuple[int, float]] = {}
    numbers: dict[tuple[Monomial, ...], list[int]] = defaultdict(list)
    # Long ones first: a short one then more likely finds its inner sums computed.
    for key, polynomial in sorted(polynomials.items(), key=lambda item: (-len(item[1]), item[0])):
        support = tuple(sorted(polynomial))
        for number in numbers[support]:
            reference = distinct[number]
            ratio = polynomial[support[0]] / reference[support[0]]
            differences = (abs(polynomial[m] - ratio * reference[m]) / abs(polynomial[m]) for m in support)
            if all(share <= _PROPORTIONAL for share in differences):
                places[key] = (number, ratio)
                break
        else:
            numbers[support].append(len(distinct))
            places[key] = (len(distinct), 1.0)
            distinct.append(polynomial)
    return distinct, places


def torque_program(velocities: AbsoluteVelocities, terms: Torques, effort: Effort) -> Program:
    """Write torque terms as a program: nested, or with shared parts if the effort allows that many terms."""
    return program_of_terms("torque", velocities, terms, effort)


def program_of_terms(
    quantity: str, velocities: AbsoluteVelocities, terms: Torques, effort: Effort
) -> Program:
    """Write the torque, or D ("inertia"), h or c, from terms."""
    return _program_of_terms(quantity, velocities, tuple(sorted(terms.items())), effort)


@lru_cache(maxsize=512)
def _program_of_terms(
    quantity: str, velocities: AbsoluteVelocities, terms: tuple[tuple[TorqueTerm, float], ...], effort: Effort
) -> Program:
    """The same of sorted terms; models of one search often share some."""
    weights = dict(terms)
    programs = [nested_program(velocities, weights)]
    if len(weights) <= effort:
        programs += [nested_program(velocities, weights, in_line=True), _shared_program(velocities, weights)]
    program = fewest(programs)
    return inertia_program(program, velocities.n_joints, symmetric=True) if quantity == "inertia" else program


def program_of_parameters(
    velocities: AbsoluteVelocities, terms: Mapping[TorqueTerm, FloatArray], count: int
) -> Program:
    """Write torque terms whose weights are sums of inputs parameters1, parameters2, ..., times (count,)."""
    trace = Trace()
    parameters, variables = (
        trace.inputs("parameters", count)[:, 0],
        TorqueVariables.traced(velocities, trace),
    )
    rows: list[dict[tuple[Hashable, ...], float]] = [{} for _ in range(velocities.n_joints)]
    numbers: dict[tuple[float, ...], int] = {}
    for term in sorted(terms):
        weights = terms[term]
        if weights.any():
            # Sums that are multiples of each other are formed once.
            ratio = float(weights[np.abs(weights).argmax()])
            shares = tuple(_without_last_digits(share) for share in (weights / ratio).tolist())
            number = numbers.setdefault(shares, len(numbers))
            rows[term.row][(*term.velocities, *term.monomial, number)] = _without_last_digits(ratio)
    polynomials = ({(k,): share for k, share in enumerate(shares)} for shares in numbers)
    sums = [factored(polynomial, parameters.__getitem__) for polynomial in polynomials]

    def value(variable: Any) -> Any:
        return sums[variable] if isinstance(variable, int) else variables(variable)

    return Program.of(trace, velocities.joint_rows(factored(row, value) for row in rows))


def _without_last_digits(number: float) -> float:
    """The number to 13 digits: the others are round-off, and 0.75 is to be printed as 0.75."""
    return float(f"{number:.13g}")


def functions_of_terms(velocities: AbsoluteVelocities, terms: Torques, effort: Effort) -> Functions:
    """D, of which the upper half is computed, h and c from their own terms, each written for itself."""
    parts: dict[str, dict[TorqueTerm, float]] = {name: {} for name in DYNAMICS_QUANTITIES}
    for term, weight in terms.items():
        parts[term.quantity][term] = weight
    return Functions(
        *(program_of_terms(quantity, velocities, part, effort) for quantity, part in parts.items())
    )


def _shared_program(velocities: AbsoluteVelocities, terms: Torques) -> Program:
    """Sums of products with shared parts."""
    trace = Trace()
    sums = shared_sums(_rows(velocities, terms))
    return Program.of(trace, velocities.joint_rows(sums.values(TorqueVariables.traced(velocities, trace))))


def _rows(velocities: AbsoluteVelocities, terms: Torques) -> list[dict[Any, float]]:
    rows: list[dict[Any, float]] = [{} for _ in range(velocities.n_joints)]
    # In canonical order: the program must not depend on the order of the terms.
    for term in sorted(terms):
        if terms[term] != 0.0:
            rows[term.row][(*term.velocities, *term.monomial)] = terms[term]
    return rows
