"""Torque terms as a person would write them: tau2 = tau3 + 3.8 pd2 + (0.77 S3 - 0.02 C3) p2 p3 - 37.2 C2."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.rendering import factors_text, meanings, number
from gd_analyze.harmonics.terms import EnergyTerm, Factor, Monomial, Rate, TorqueTerm

_ORDER = ("inertia", "coriolis_centrifugal", "gravity_loading")

# What stands in brackets before a product of rates, or alone where there is none.
Bracket = tuple[tuple[Rate, ...], dict[Monomial, float]]


def torques_to_text(
    basis: AbsoluteRates, torques: Mapping[TorqueTerm, float], digits: int = 3, width: int | None = None
) -> tuple[str, ...]:
    """Write one equation per joint.

    Parameters
    ----------
    basis
        The arm's runs of parallel joints.
    torques
        Weights of the terms, in absolute rates.
    digits
        Significant digits of the weights.
    width
        Break lines so that none is longer, unless one term is; one line each by default.
    """
    return tuple(
        _wrapped(
            f"tau{i + 1} = ",
            [
                *([f"tau{i + 2}"] if basis.carries_next(i) else []),
                *(piece for bracket in row for piece in _bracket(*bracket, digits)),
            ],
            width,
        )
        for i, row in enumerate(brackets(basis, torques))
    )


def brackets(basis: AbsoluteRates, torques: Mapping[TorqueTerm, float]) -> tuple[list[Bracket], ...]:
    """Every row by the rates behind its terms: inertia, velocity, gravity, in each the largest first."""
    rows: list[dict[tuple[Rate, ...], dict[Monomial, float]]] = [
        defaultdict(dict) for _ in range(basis.n_joints)
    ]
    for term, weight in torques.items():
        rows[term.row][term.rates][term.monomial] = weight

    def place(bracket: Bracket) -> tuple[int, float]:
        rates, polynomial = bracket
        return _ORDER.index(TorqueTerm(0, rates, ()).quantity), -max(map(abs, polynomial.values()))

    return tuple(sorted(row.items(), key=place) for row in rows)


def torque_term_text(term: TorqueTerm, weight: float, digits: int = 3) -> str:
    """Write one torque term: -3.2 C2 S2 p1 p2."""
    behind = f" {_rates(term.rates)}" if term.rates else ""
    return _signed(weight) + _term(term.monomial, weight, digits, behind)


def energy_term_text(term: EnergyTerm, weight: float, digits: int = 3) -> str:
    """Write one term of D in absolute rates, or of the potential energy: 0.687 S2."""
    return _signed(weight) + _term(term.monomial, weight, digits)


def torque_legend(basis: AbsoluteRates, torques: Mapping[TorqueTerm, float]) -> tuple[str, ...]:
    """Say what the names in these equations mean: rates first, then sines and cosines."""
    used = sorted({rate for term in torques for rate in term.rates})
    out = []
    for run in basis.runs:
        for place, joint in enumerate(run):
            for rate in [rate for rate in used if rate.joint == joint and place > 0]:
                parts = " + ".join(f"q{'d' * rate.order}{j + 1}" for j in run[: place + 1])
                out.append(f"{_rate(rate)} = {parts}")
    first = {run[0] for run in basis.runs}
    plain = [rate for rate in used if rate.joint in first]
    out += [f"{'any other ' if out else ''}{name}" for name in _plain(plain)]
    factors: set[Factor] = {factor for term in torques for factor in term.monomial}
    return (*out, *meanings(factors))


def _plain(rates: list[Rate]) -> list[str]:
    """The joints' own rates under the same name as the others."""
    orders = sorted({rate.order for rate in rates})
    return [", ".join(f"p{'d' * (order - 1)}_j is q{'d' * order}_j" for order in orders)] if orders else []


def _bracket(rates: tuple[Rate, ...], polynomial: Mapping[Monomial, float], digits: int) -> list[str]:
    """Rates times the sum of their terms, in pieces that a line may break between, each with its sign."""
    terms = sorted(polynomial.items(), key=lambda item: -abs(item[1]))
    behind = f" {_rates(rates)}" if rates else ""
    if not rates or len(terms) == 1:
        return [_sign(weight) + _term(monomial, weight, digits, behind) for monomial, weight in terms]
    outer = terms[0][1]
    pieces = [
        _sign(weight if place == 0 else weight * outer)
        + ("(" if place == 0 else "")
        + _term(m, weight, digits)
        for place, (m, weight) in enumerate(terms)
    ]
    pieces[-1] += ")" + behind
    return pieces


def _signed(weight: float) -> str:
    return "-" if weight < 0 else ""


def _sign(weight: float) -> str:
    return "- " if weight < 0 else "+ "


def _term(monomial: Monomial, weight: float, digits: int, behind: str = "") -> str:
    shown = number(abs(weight), digits)
    factors = f" {factors_text(monomial)}" if monomial else ""
    written = factors + behind
    return written.strip() if shown == "1" and written else shown + written


def _rates(rates: tuple[Rate, ...]) -> str:
    if len(rates) == 2 and rates[0] == rates[1]:
        return f"{_rate(rates[0])}²"
    return " ".join(map(_rate, rates))


def _rate(rate: Rate) -> str:
    return f"p{'d' * (rate.order - 1)}{rate.joint + 1}"


def _wrapped(start: str, pieces: list[str], width: int | None) -> str:
    first = pieces[0] if pieces else "0"
    if first.startswith("+ "):
        first = first[2:]
    elif first.startswith("- "):
        first = "-" + first[2:]
    lines = [start + first]
    for piece in pieces[1:]:
        if width is None or len(lines[-1]) + 1 + len(piece) <= width:
            lines[-1] += " " + piece
        else:
            lines.append(" " * len(start) + piece)
    return "\n".join(lines)
