"""Torque terms as a straight-line program: sums of parallel angles, rate products and equal brackets once."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import Monomial, Rate, TorqueTerm, absolute_rates
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.factoring import factored
from gd_analyze.vectors import Array

# Brackets of other rates or rows that are a multiple of a known one share it; equal but for round-off.
_PROPORTIONAL = 1e-9


def torque_programs(
    basis: Basis, terms: Mapping[TorqueTerm, float], *, thorough: bool = True
) -> dict[str, Program]:
    """Programs of torque, D, h and c; of several ways to nest the sums the one of fewest operations.

    Parameters
    ----------
    basis
        The arm's basis functions.
    terms
        Weights of the torque terms, in absolute rates.

    Returns
    -------
    dict
        "torque", "coriolis_centrifugal", "gravity_loading" with n outputs each and "inertia" with n x n,
        row by row, all in the joints' own coordinates.
    """
    if not thorough:
        return _programs(basis, terms, _Way(False, 0))
    ways = [_Way(single, seed) for single in (False, True) for seed in range(_WAYS)]
    return min((_programs(basis, terms, way) for way in ways), key=lambda made: made["torque"].count.total)


# Ways to break ties tried, each with short brackets apart and in line; more gained nothing on any arm tried.
_WAYS = 6


@dataclass(frozen=True)
class _Way:
    """One way to nest: whether brackets of one term go in line, and how ties are broken."""

    in_line: bool
    seed: int

    def rank(self, variable: Hashable) -> str:
        """Order of variables: their names, or any other order that is the same in every run."""
        name = repr(variable)
        return name if self.seed == 0 else hashlib.sha256(f"{self.seed}{name}".encode()).hexdigest()


def _programs(basis: Basis, terms: Mapping[TorqueTerm, float], way: _Way) -> dict[str, Program]:
    n = basis.n_joints
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, n)[:, 0] for name in ("q", "qd", "qdd"))
    values = _Values(basis, trace, q, qd, qdd, way)
    polynomials: _Polynomials = defaultdict(dict)
    for term, weight in terms.items():
        if weight != 0.0:
            polynomials[term.row, term.rates][term.monomial] = weight
    brackets = _brackets(polynomials, values)
    outputs = {"torque": _joint_rows(basis, _rows(n, polynomials, brackets, values))}
    for quantity in ("coriolis_centrifugal", "gravity_loading"):
        chosen = {key: p for key, p in polynomials.items() if _quantity(key[1]) == quantity}
        outputs[quantity] = _joint_rows(basis, _rows(n, chosen, brackets, values))
    absolute = np.full((n, n), 0.0, dtype=object)
    for key, (number, ratio) in brackets.items():
        if _quantity(key[1]) == "inertia":
            absolute[key[0], key[1][0].joint] = values.bracket(number) * ratio
    back = np.linalg.inv(absolute_rates(basis))
    outputs["inertia"] = list(np.einsum("ki,kl,lj->ij", back, absolute, back).ravel())
    return {name: Program.of(trace, rows) for name, rows in outputs.items()}


def _quantity(rates: tuple[Rate, ...]) -> str:
    return TorqueTerm(0, rates, ()).quantity


class _Values:
    """Expressions of literals, rates and brackets on one trace."""

    def __init__(self, basis: Basis, trace: Trace, q: Array, qd: Array, qdd: Array, way: _Way) -> None:
        self.way = way
        self._trace = trace
        self._q = q
        self._moving = {1: list(qd), 2: list(qdd)}
        for moving in self._moving.values():
            for run in basis.runs:
                for inner, outer in zip(run.joints[:-1], run.joints[1:], strict=True):
                    moving[outer] = moving[inner] + moving[outer]
        self._brackets: list[Any] = []

    def __call__(self, variable: Any) -> Any:
        """Look a variable up: a rate, a bracket's number, or a literal."""
        if isinstance(variable, Rate):
            return self._moving[variable.order][variable.joint]
        if isinstance(variable, int):
            return self._brackets[variable]
        kind, multiples = variable
        argument: Any = 0.0
        for joint, multiple in enumerate(multiples):
            for _ in range(abs(multiple)):
                argument = argument + self._q[joint] if multiple > 0 else argument - self._q[joint]
        if kind == "power":
            return argument
        one = np.empty(1, dtype=object)
        one[0] = argument
        return (self._trace.cos if kind == "cos" else self._trace.sin)(one)[0]

    def add_bracket(self, polynomial: Mapping[Monomial, float]) -> int:
        """Evaluate a polynomial in the literals; its number."""
        self._brackets.append(factored(polynomial, self, self.way.rank))
        return len(self._brackets) - 1

    def bracket(self, number: int) -> Any:
        """Expression of a bracket."""
        return self._brackets[number]


_Key = tuple[int, tuple[Rate, ...]]
_Polynomials = dict[_Key, dict[Monomial, float]]
_Brackets = dict[_Key, tuple[int, float]]


def _brackets(polynomials: _Polynomials, values: _Values) -> _Brackets:
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
            number = values.add_bracket(polynomial)
            known[support].append((number, polynomial))
            out[key] = (number, 1.0)
    return out


def _rows(n: int, polynomials: _Polynomials, brackets: _Brackets, values: _Values) -> list[Any]:
    """Sum rates times brackets for every row of tau'."""
    rows: list[dict[tuple[Hashable, ...], float]] = [{} for _ in range(n)]
    for (row, rates), polynomial in polynomials.items():
        number, ratio = brackets[row, rates]
        if isinstance(values.bracket(number), float):
            rows[row][rates] = ratio * values.bracket(number)
        elif values.way.in_line and len(polynomial) == 1:
            ((monomial, weight),) = polynomial.items()
            rows[row][(*rates, *monomial)] = weight
        else:
            rows[row][(*rates, number)] = ratio
    return [factored(row, values, values.way.rank) for row in rows]


def _joint_rows(basis: Basis, rows: list[Any]) -> list[Any]:
    """Tau = A^-T tau': within a run a joint carries what the joints behind it carry."""
    out = list(rows)
    for run in basis.runs:
        for inner, outer in reversed(list(zip(run.joints[:-1], run.joints[1:], strict=True))):
            out[inner] = out[inner] + out[outer]
    return out
