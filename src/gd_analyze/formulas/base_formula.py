"""Formulas of base parameters: MX2 = mx2 + 0.432 m3..6."""

from __future__ import annotations

from gd_analyze.dynamics.base_parameters import BaseParameter, Share
from gd_analyze.formulas.formula import Formula, Piece, Power, Product, Symbol

# Masses in a row that count the same are one piece; what differs by less than this share differs by rounding.
_SAME = 1e-12


def base_formula(parameter: BaseParameter) -> Formula:
    """Formula of what a base parameter combines, masses last; m3..6 is that of links 3 to 6 together."""
    symbol = Symbol(parameter.symbol.removesuffix(str(parameter.link)), str(parameter.link))
    first, *others = parameter.combination
    shares = [first, *sorted(others, key=lambda share: share.kind == "m")]
    return Formula(symbol, tuple(map(_piece, _together(shares))))


def _together(shares: list[Share]) -> list[list[Share]]:
    """Put masses of one coefficient together, link by link."""
    runs: list[list[Share]] = []
    for share in shares:
        if runs and _goes_on(runs[-1][-1], share):
            runs[-1].append(share)
        else:
            runs.append([share])
    return runs


def _goes_on(before: Share, share: Share) -> bool:
    coefficient, kind, link = before
    same = abs(coefficient - share.coefficient) <= _SAME * abs(coefficient)
    return kind == share.kind == "m" and link + 1 == share.link and same


def _piece(run: list[Share]) -> Piece:
    first, last = run[0], run[-1]
    index = str(first.link) if first is last else f"{first.link}..{last.link}"
    return Piece(Product(first.coefficient, (Power(Symbol(first.kind, index)),)))
