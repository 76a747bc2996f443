"""Torque terms nested: a bracket of sines and cosines behind every product of rates, equal brackets once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping
from typing import Any

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Monomial, Rate, Torques
from gd_analyze.levels.torque_variables import TorqueVariables
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.factoring import factored

# Brackets of other rates or rows that are a multiple of a known one share it; equal but for round-off.
_PROPORTIONAL = 1e-9

_Key = tuple[int, tuple[Rate, ...]]
_Polynomials = dict[_Key, dict[Monomial, float]]
_Brackets = dict[_Key, tuple[int, float]]


def nested_program(rates: AbsoluteRates, terms: Torques, *, in_line: bool = False) -> Program:
    """Write torques in nested form: a few milliseconds for some hundred terms.

    Parameters
    ----------
    rates
        The arm's absolute rates.
    terms
        Weights of the torque terms, in absolute rates.
    in_line
        Whether a bracket of a single term is multiplied out, so that sums of rates are taken out of it.
    """
    nest = _Nest(rates, in_line)
    polynomials: _Polynomials = defaultdict(dict)
    for term, weight in terms.items():
        if weight != 0.0:
            polynomials[term.row, term.rates][term.monomial] = weight
    return Program.of(nest.trace, _rows(rates.n_joints, polynomials, _brackets(polynomials, nest), nest))


class _Nest:
    """Expressions of variables and, by number, of brackets on one trace."""

    def __init__(self, rates: AbsoluteRates, in_line: bool) -> None:
        self.in_line = in_line
        self.trace = Trace()
        self.variables = TorqueVariables(rates, self.trace)
        self.joint_rows = rates.joint_rows
        self.brackets: list[Any] = []

    def __call__(self, variable: Any) -> Any:
        return self.brackets[variable] if isinstance(variable, int) else self.variables(variable)

    def add_bracket(self, polynomial: Mapping[Monomial, float]) -> int:
        self.brackets.append(factored(polynomial, self))
        return len(self.brackets) - 1


def _brackets(polynomials: _Polynomials, nest: _Nest) -> _Brackets:
    """Number and factor of the bracket behind every row's rates; proportional ones are the same."""
    known: dict[tuple[Monomial, ...], list[tuple[int, dict[Monomial, float]]]] = defaultdict(list)
    out: _Brackets = {}
    # Long ones first: a short one is then more likely to find its inner sums made.
    for key, polynomial in sorted(polynomials.items(), key=lambda item: (-len(item[1]), item[0])):
        support = tuple(sorted(polynomial))
        for number, other in known[support]:
            ratio = polynomial[support[0]] / other[support[0]]
            if all(
                abs(polynomial[m] - ratio * other[m]) <= _PROPORTIONAL * abs(polynomial[m]) for m in support
            ):
                out[key] = (number, ratio)
                break
        else:
            number = nest.add_bracket(polynomial)
            known[support].append((number, polynomial))
            out[key] = (number, 1.0)
    return out


def _rows(n: int, polynomials: _Polynomials, brackets: _Brackets, nest: _Nest) -> list[Any]:
    """Sum rates times brackets for every row of tau', and from them the joints' torques."""
    rows: list[dict[tuple[Hashable, ...], float]] = [{} for _ in range(n)]
    for (row, rates), polynomial in polynomials.items():
        number, ratio = brackets[row, rates]
        if isinstance(nest.brackets[number], float):
            rows[row][rates] = ratio * nest.brackets[number]
        elif nest.in_line and len(polynomial) == 1:
            ((monomial, weight),) = polynomial.items()
            rows[row][(*rates, *monomial)] = weight
        else:
            rows[row][(*rates, number)] = ratio
    return nest.joint_rows([factored(row, nest) for row in rows])
