"""Equations in Typst's mathematics, translated from their text form so that the two cannot disagree."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Energies, TorqueTerm
from gd_analyze.harmonics.torque_rendering import energy_term_text, torque_legend, torques_to_text

_NAMES = {
    "tau": "tau",
    "C": "C",
    "S": "S",
    "d": "d",
    "D'": "D'",
    "U": "U",
    "q": "q",
    "qd": "dot(q)",
    "qdd": "dot.double(q)",
    "p": "dot(p)",
    "pd": "dot.double(p)",
}

_TOKEN = re.compile(
    r"""
    (?P<space>\s+)
    | (?P<number>\d+(?:\.\d+)?)(?:e(?P<power>-?\d+))?(?![\dA-Za-z])
    | (?P<function>cos|sin)(?P<squared>²?)\((?P<argument>[^)]*)\)
    | (?P<words>any\ other|is|in\ m)\b
    | (?P<name>tau|qdd|qd|pd|[qpCSd]|D')(?P<index>\d+(?:,\d+)*|_j)(?P<square>²?)
    | (?P<potential>U)\b
    | (?P<bracket>[()])
    | (?P<sign>[-+=,])
    """,
    re.VERBOSE,
)


@dataclass(frozen=True)
class Piece:
    """What stands between two places where a line may break.

    Parameters
    ----------
    sign
        "+" or "-".
    math
        Typst mathematics of the rest.
    quantity
        "inertia", "coriolis_centrifugal" or "gravity_loading"; "" for the torque a joint carries.
    """

    sign: str
    math: str
    quantity: str


def torques_to_typst(
    basis: AbsoluteRates, torques: Mapping[TorqueTerm, float], digits: int = 3
) -> tuple[tuple[Piece, ...], ...]:
    """Write the right-hand side of every joint's torque; inertia, Coriolis and centrifugal, gravity.

    Parameters
    ----------
    basis, torques, digits
        As for `torques_to_text`.

    Returns
    -------
    tuple
        Pieces per joint; one piece 0 where a joint has no terms.
    """
    rows = (text.partition(" = ")[2] for text in torques_to_text(basis, torques, digits))
    return tuple(_quantified(_split(text)) for text in rows)


def energy_to_typst(energies: Energies, digits: int = 3) -> dict[str, tuple[Piece, ...]]:
    """Write D' in absolute rates and the potential U by element, each one's largest term first.

    Parameters
    ----------
    terms
        Energy terms.
    digits
        Significant digits.

    Returns
    -------
    dict
        Pieces by the element's symbol in Typst's mathematics, elements row by row, U last.
    """
    ordered = sorted(energies, key=lambda term: (term.is_potential, term.i, term.j, -abs(energies[term])))
    out: dict[str, tuple[Piece, ...]] = {}
    for term in ordered:
        comma = "," if max(term.i, term.j) >= 9 else ""
        symbol = "U" if term.is_potential else f"D'_({term.i + 1}{comma}{term.j + 1})"
        quantity = "gravity_loading" if term.is_potential else "inertia"
        (cut,) = _split(energy_term_text(term, energies[term], digits))
        out[symbol] = (*out.get(symbol, ()), Piece(cut.sign, to_typst(cut.body), quantity))
    return out


def legend_to_typst(basis: AbsoluteRates, torques: Mapping[TorqueTerm, float]) -> tuple[str, ...]:
    """Say what the names in the equations mean, see `torque_legend`."""
    return tuple(map(to_typst, torque_legend(basis, torques)))


def to_typst(text: str) -> str:
    """Translate a fragment of the text form, such as -3.2 C2 S23² p1 p2, to Typst's mathematics.

    Parameters
    ----------
    text
        What `torques_to_text`, `torque_term_text`, `energy_term_text` or `torque_legend` wrote.

    Raises
    ------
    ValueError
        If it holds anything that those do not write.

    Examples
    --------
    >>> to_typst("-5.85e-5 C23² pd3")
    '- 5.85 times 10^(-5) thin C_(23)^2 thin dot.double(p)_(3)'
    """
    out: list[str] = []
    previous = ""
    for match in _tokens(text):
        kind = match.lastgroup or ""
        factor = match["number"] or match["function"] or match["name"] or match["potential"]
        if match["space"]:
            continue
        if factor and previous in {"factor", ")"}:
            out.append("thin")
        out.append(_translated(match))
        previous = "factor" if factor else match["bracket"] or kind
    return " ".join(out)


def _tokens(text: str) -> Iterator[re.Match[str]]:
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise ValueError(f"not the text form of an equation, from character {place}: {text!r}")
        yield match
        place = match.end()


def _translated(match: re.Match[str]) -> str:
    if match["number"]:
        return match["number"] + (f" times 10^({match['power']})" if match["power"] else "")
    if match["function"]:
        return f"{match['function']}{'^2' if match['squared'] else ''}({to_typst(match['argument'])})"
    if match["name"]:
        index = match["index"].removeprefix("_")
        return f"{_NAMES[match['name']]}_({index}){'^2' if match['square'] else ''}"
    if match["words"]:
        return f'"{match["words"]}"'
    if match["bracket"]:
        return "paren.l" if match["bracket"] == "(" else "paren.r"
    return match["potential"] or match["sign"]


@dataclass
class _Cut:
    """A piece of the text, and whether a bracket is open at its end."""

    sign: str = "+"
    body: str = ""
    open_: bool = False


def _split(text: str) -> list[_Cut]:
    """Cut before every sign that is not inside a cosine's or sine's argument."""
    cuts = [_Cut()]
    for match in _tokens(text):
        cut = cuts[-1]
        if match["sign"] in {"+", "-"} and cut.body.strip():
            cuts.append(_Cut(match["sign"], open_=cut.open_))
        elif match["sign"]:
            cut.sign = match["sign"]
        else:
            cut.body += match[0]
            cut.open_ = match["bracket"] == "(" if match["bracket"] else cut.open_
    return cuts


def _quantified(cuts: list[_Cut]) -> tuple[Piece, ...]:
    """Tell what every piece belongs to; the rates of a bracket stand behind its last piece."""
    out: list[Piece] = []
    for cut in reversed(cuts):
        quantity = out[-1].quantity if cut.open_ else _quantity(cut.body)
        out.append(Piece(cut.sign, to_typst(cut.body), quantity))
    return tuple(reversed(out))


def _quantity(body: str) -> str:
    names = {match["name"] for match in _tokens(body)}
    if "tau" in names:
        return ""
    if "pd" in names:
        return "inertia"
    return "coriolis_centrifugal" if "p" in names else "gravity_loading"
