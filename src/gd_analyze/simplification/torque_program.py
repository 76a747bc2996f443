"""Torque terms as a straight-line program of few operations: several ways to write it, and the best kept."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from functools import reduce
from itertools import takewhile
from typing import Any

import numpy as np

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Factor, Rate, Torques, TorqueTerm
from gd_analyze.operations.program import Program
from gd_analyze.operations.sharing import SharedSums, growing_sums, shared_sums
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.effort import POINT, Effort
from gd_analyze.simplification.kept_programs import Task, inputs_of, kept_programs, some_states
from gd_analyze.simplification.nested_program import nested_program
from gd_analyze.simplification.torque_variables import TorqueVariables

# Where it helps to share them, coefficients that differ by 1e-9 are taken for equal; some may add up.
_SAME = 1e-8

# Brackets nested take up to 1.5 times the operations that are found in the end, on all arms supplied.
_NESTED = 1.5

_PARTNER = {"cos": "sin", "sin": "cos"}


def torque_program(rates: AbsoluteRates, terms: Torques, effort: Effort) -> Program:
    """Write torques as a program.

    Brackets nested take milliseconds. Looking for what all rows share takes 10 ms for 50 terms, 0.1 s for 150
    and 1 s for 400, and finds a third fewer operations where there are more than a hundred. Rearranging takes
    a tenth of a second more, and 3 % off; of several ways the one of fewest operations is then given, and is
    kept for the next run.

    Parameters
    ----------
    rates
        The arm's absolute rates.
    terms
        Weights of the torque terms, in absolute rates.
    effort
        How much time to spend.

    Returns
    -------
    Program
        Torques of the joints themselves.
    """
    if len(terms) > effort.shared:
        return nested_program(rates, terms)
    if not effort.rearranging:
        return next(_shared(rates, terms, effort))
    key = ["torques", rates.runs, rates.signs, _listed(terms), effort]

    def are_right(programs: Sequence[Program]) -> bool:
        return len(programs) == 1 and _is_right(rates, terms, *programs)

    return kept_programs(Task.of(key, rates.n_joints, lambda: [_thorough(rates, terms, effort)], are_right))[
        0
    ]


def torque_programs(rates: AbsoluteRates, steps: Sequence[Torques], most: int) -> tuple[Program, ...]:
    """Write torques that gain terms step by step, each from the one before: as thoroughly, in less time.

    Parameters
    ----------
    rates
        The arm's absolute rates.
    steps
        Weights of the torque terms; the last have all terms that occur.
    most
        Operations with which to end: neither the first program that takes more is given, nor any after it.

    Returns
    -------
    tuple
        A program for each step before the end.
    """
    joins: dict[TorqueTerm, int] = {}
    for number, terms in enumerate(steps):
        joins |= dict.fromkeys(terms.keys() - joins.keys(), number)
    listed = [[*entry, joins[entry[0]]] for entry in _listed(steps[-1])]
    key = ["growing torques", rates.runs, rates.signs, len(steps), listed, most]

    def are_right(programs: Sequence[Program]) -> bool:
        # Fewer where the next took too many operations.
        return all(_is_right(rates, *each) for each in zip(steps, programs, strict=False))

    return kept_programs(Task.of(key, rates.n_joints, lambda: _growing(rates, steps, most), are_right))


def _growing(rates: AbsoluteRates, steps: Sequence[Torques], most: int) -> Iterator[Program]:
    hopeful = [*takewhile(lambda terms: _may_take(rates, terms, most), steps)]
    written: Iterable[Program] = (torque_program(rates, terms, POINT) for terms in hopeful)
    if len(hopeful) > 1:
        rows = [_rows(rates, terms) for terms in hopeful]
        written = (_program(rates, sums) for sums in growing_sums(rows, _circles(hopeful[-1])))
    yield from takewhile(lambda program: program.count.total <= most, written)


def _may_take(rates: AbsoluteRates, terms: Torques, most: int) -> bool:
    """Whether a program may be found of so few operations, as one of brackets nested tells."""
    return len(terms) <= POINT.shared and nested_program(rates, terms).count.total <= _NESTED * most


def _listed(terms: Torques) -> list[Any]:
    """Terms and weights as JSON values, in an order of their own."""
    return [[term, terms[term]] for term in sorted(terms)]


def _thorough(rates: AbsoluteRates, terms: Torques, effort: Effort) -> Program:
    ways = [nested_program(rates, terms, in_line=in_line) for in_line in (False, True)]
    return min([*ways, *_shared(rates, terms, effort)], key=lambda way: way.count.total)


def _is_right(rates: AbsoluteRates, terms: Torques, program: Program) -> bool:
    """Whether a program gives the terms' torques at some states."""
    states = some_states(rates.n_joints)
    values, shape = TorqueVariables(rates, states.last), (rates.n_joints, len(states))
    rows, sizes = np.zeros(shape), np.zeros(shape)
    for term, weight in terms.items():
        variables: tuple[Rate | Factor, ...] = (*term.rates, *term.monomial)
        torque = weight * reduce(np.multiply, map(values, variables), np.ones(len(states)))
        rows[term.row] += torque
        sizes[term.row] += np.abs(torque)
    wanted, size = np.array(rates.joint_rows(rows)), np.array(rates.joint_rows(sizes))
    return bool((np.abs(program.run(inputs_of(states)) - wanted) <= _SAME * size.max()).all())


def _shared(rates: AbsoluteRates, terms: Torques, effort: Effort) -> Iterator[Program]:
    for sums in shared_sums(_rows(rates, terms), _circles(terms), effort.rearranging):
        yield _program(rates, sums)


def _program(rates: AbsoluteRates, sums: SharedSums) -> Program:
    trace = Trace()
    return Program.of(trace, rates.joint_rows(sums.values(TorqueVariables.traced(rates, trace))))


def _rows(rates: AbsoluteRates, terms: Torques) -> list[dict[Any, float]]:
    rows: list[dict[Any, float]] = [{} for _ in range(rates.n_joints)]
    # In an order of its own: the program must not depend on the order the terms came in.
    for term in sorted(terms):
        if terms[term] != 0.0:
            rows[term.row][(*term.rates, *term.monomial)] = terms[term]
    return rows


def _circles(terms: Torques) -> dict[Hashable, Hashable]:
    """Sines and cosines, each with the other of its angle."""
    return {
        (kind, multiples): (_PARTNER[kind], multiples)
        for term in sorted(terms)
        for kind, multiples in term.monomial
        if kind in _PARTNER
    }
