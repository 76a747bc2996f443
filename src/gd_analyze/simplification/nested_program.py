"""Torque terms nested: a bracket of sines and cosines behind every product of rates, equal brackets once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable
from typing import Any

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Monomial, Rate, Torques
from gd_analyze.operations.factoring import factored
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.torque_variables import TorqueVariables

# Brackets of other rates or rows that are a multiple of a known one share it; equal but for round-off.
_PROPORTIONAL = 1e-9

_Key = tuple[int, tuple[Rate, ...]]
_Polynomial = dict[Monomial, float]
_Polynomials = dict[_Key, _Polynomial]


def nested_program(rates: AbsoluteRates, terms: Torques, *, in_line: bool = False) -> Program:
    """Write torques in nested form: a few milliseconds for some hundred terms.

    With `in_line` a bracket of a single term is multiplied out, so that sums of rates are taken out of it.
    """
    polynomials: _Polynomials = defaultdict(dict)
    for term, weight in terms.items():
        if weight != 0.0:
            polynomials[term.row, term.rates][term.monomial] = weight
    trace = Trace()
    variables = TorqueVariables.traced(rates, trace)
    distinct, places = _distinct(polynomials)
    brackets = [factored(polynomial, variables) for polynomial in distinct]
    rows: list[dict[tuple[Hashable, ...], float]] = [{} for _ in range(rates.n_joints)]
    for (row, moving), polynomial in polynomials.items():
        number, ratio = places[row, moving]
        if isinstance(brackets[number], float):
            rows[row][moving] = ratio * brackets[number]
        elif in_line and len(polynomial) == 1:
            ((monomial, weight),) = polynomial.items()
            rows[row][(*moving, *monomial)] = weight
        else:
            rows[row][(*moving, number)] = ratio

    def value(variable: Any) -> Any:
        return brackets[variable] if isinstance(variable, int) else variables(variable)

    return Program.of(trace, rates.joint_rows(factored(row, value) for row in rows))


def _distinct(polynomials: _Polynomials) -> tuple[list[_Polynomial], dict[_Key, tuple[int, float]]]:
    """Polynomials of which none is a multiple of another, and for each given one its number and factor."""
    distinct: list[_Polynomial] = []
    places: dict[_Key, tuple[int, float]] = {}
    known: dict[tuple[Monomial, ...], list[int]] = defaultdict(list)
    # Long ones first: a short one is then more likely to find its inner sums made.
    for key, polynomial in sorted(polynomials.items(), key=lambda item: (-len(item[1]), item[0])):
        support = tuple(sorted(polynomial))
        for number in known[support]:
            other = distinct[number]
            ratio = polynomial[support[0]] / other[support[0]]
            if all(
                abs(polynomial[m] - ratio * other[m]) <= _PROPORTIONAL * abs(polynomial[m]) for m in support
            ):
                places[key] = (number, ratio)
                break
        else:
            known[support].append(len(distinct))
            places[key] = (len(distinct), 1.0)
            distinct.append(polynomial)
    return distinct, places
