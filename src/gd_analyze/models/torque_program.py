"""Torque terms as a straight-line program of few operations: several ways to write it, and the best kept."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import Any

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import TorqueTerm
from gd_analyze.models.nested_torque import nested_programs
from gd_analyze.models.torque_variables import TorqueVariables
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.sharing import shared_sums

_PARTNER = {"cos": "sin", "sin": "cos"}


def torque_programs(
    basis: AbsoluteRates, terms: Mapping[TorqueTerm, float], *, thorough: bool = True
) -> dict[str, Program]:
    """Programs of torque, D, h and c; of several ways to write the torque the one of fewest operations.

    Parameters
    ----------
    basis
        The arm's basis functions.
    terms
        Weights of the torque terms, in absolute rates.
    thorough
        Look for what all rows share, and rearrange it: about a second, and a third fewer operations where
        there are more than a hundred. Otherwise brackets are nested, which takes milliseconds.

    Returns
    -------
    dict
        "torque", "coriolis_centrifugal", "gravity_loading" with n outputs each and "inertia" with n x n,
        row by row, all in the joints' own coordinates.
    """
    programs = nested_programs(basis, terms)
    ways = [programs["torque"], nested_programs(basis, terms, in_line=True)["torque"]]
    if thorough:
        ways += _shared(basis, terms)
    return programs | {"torque": _fewest(ways)}


def shared_torque(basis: AbsoluteRates, terms: Mapping[TorqueTerm, float]) -> Program:
    """Torque with all that its rows share extracted once, not rearranged.

    Between the two efforts of `torque_programs`: within a few hundredths of the thorough count, in 10 ms for
    50 terms, 0.1 s for 150 and 1 s for 400.

    Parameters
    ----------
    basis, terms
        As for `torque_programs`.
    """
    return next(_shared(basis, terms))


def _fewest(ways: list[Program]) -> Program:
    return min(ways, key=lambda way: way.count.total)


def _shared(basis: AbsoluteRates, terms: Mapping[TorqueTerm, float]) -> Iterator[Program]:
    rows: list[dict[Any, float]] = [{} for _ in range(basis.n_joints)]
    # In an order of its own: the program must not depend on the order the terms came in.
    for term in sorted(terms):
        if terms[term] != 0.0:
            rows[term.row][(*term.rates, *term.monomial)] = terms[term]
    circles: dict[Hashable, Hashable] = {
        (kind, multiples): (_PARTNER[kind], multiples)
        for term in sorted(terms)
        for kind, multiples in term.monomial
        if kind in _PARTNER
    }
    for sums in shared_sums(rows, circles):
        trace = Trace()
        variables = TorqueVariables(basis, trace)
        yield Program.of(trace, basis.joint_rows(sums.values(variables)))
