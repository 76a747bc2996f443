"""Sums of cosines and sines as a person would write them: products and squares where they are shorter.

0.372 sin(q3) + 0.372 sin(2 q2 + q3) is 0.744 C2 S23, and 1.35 + 0.80 cos(2 q2) is 0.55 + 1.60 C2^2. Both
forms are exact; the second has fewer terms or simpler ones.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.product_table import ProductTable
from gd_analyze.harmonics.squares import has_one_double, with_squares
from gd_analyze.harmonics.terms import Factor, FactorKind, Monomial, half_of

# Beyond it, trying every choice of squares would take longer than it helps; no arm known comes near.
_MOST_CHOICES = 2**10


def with_products(
    table: ProductTable, r: int, close: float, is_part: Callable[[FloatArray], bool]
) -> ProductTable:
    """Rewrite run r, for every combination of the other runs' factors apart.

    Parameters
    ----------
    table
        Products, of which all sums are rewritten alike; of a run at most one cosine or sine.
    r
        Place of a run of turning joints.
    close
        Weights no farther apart are taken for equal; nothing larger is ever lost.
    is_part
        Whether multiples are those of an angle between two links, see `AbsoluteRates.is_part`: a product is
        one of two such angles.
    """
    if has_one_double(table, r):
        return with_squares(table, r, close)
    names = {name: k for k, name in enumerate(table.names[r])}
    codes, weights = [], []
    for members in _members(table.groups(r)):
        group = {table.names[r][table.codes[t, r]]: table.weights[t] for t in members}
        for product, value in _squared(_paired(group, close, is_part), close).items():
            code = table.codes[members[0]].copy()
            code[r] = names.setdefault(product, len(names))
            codes.append(code)
            weights.append(value)
    if not codes:
        return table
    return table.rewritten(r, [*names], np.array(codes), np.array(weights))


def _members(group: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Places of the members of every group."""
    order = np.argsort(group, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[order])) + 1) if len(order) else []


def _paired(
    group: dict[Monomial, FloatArray], close: float, is_part: Callable[[FloatArray], bool]
) -> dict[Monomial, FloatArray]:
    """Turn two functions of equal weight, of a sum and a difference of two angles, into one product."""
    out = dict(group)
    for one, other in itertools.combinations(list(group), 2):
        if one not in out or other not in out or not one or not other:
            continue
        (f,), (g,) = one, other
        ratio = _ratio(out[one], out[other], close)
        if f.kind != g.kind or ratio == 0:
            continue
        for (u, v), sign in itertools.product(((f, g), (g, f)), (1, -1)):
            total, difference = np.array(u.multiples), sign * np.array(v.multiples)
            alpha, beta = (total + difference) / 2, (total - difference) / 2
            if is_part(alpha) and is_part(beta) and not np.array_equal(alpha, beta):
                a, b = tuple(int(x) for x in alpha), tuple(int(x) for x in beta)
                # kind(a + b) and kind(a - b); an odd function takes the sign out of its argument.
                same_sign = ratio * (sign if u.kind == "sin" else 1) > 0
                kinds, factor = _product_kinds(u.kind, same_sign)
                product = tuple(sorted((Factor(kinds[0], a), Factor(kinds[1], b))))
                weight = out[one] if u is f else out[other]
                out[product] = out.get(product, 0.0) + factor * weight
                del out[one], out[other]
                break
    return out


def _ratio(one: FloatArray, other: FloatArray, close: float) -> int:
    """1 where all weights are equal, -1 where all are opposite, 0 otherwise."""
    return int(np.abs(one - other).max() <= close) - int(np.abs(one + other).max() <= close)


def _product_kinds(kind: FactorKind, same_sign: bool) -> tuple[tuple[FactorKind, FactorKind], float]:
    """kind(a+b) + kind(a-b), or their difference, as twice a product."""
    if kind == "cos":
        return (("cos", "cos"), 2.0) if same_sign else (("sin", "sin"), -2.0)
    return (("sin", "cos"), 2.0) if same_sign else (("cos", "sin"), 2.0)


def _squared(group: dict[Monomial, FloatArray], close: float) -> dict[Monomial, FloatArray]:
    """Turn double angles into squares and products where that needs no further term."""
    out = dict(group)
    doubles = []
    for product in list(out):
        half = half_of(product)
        if half is None:
            continue
        if product[0].kind == "sin":
            out[Factor("cos", half), Factor("sin", half)] = 2.0 * out.pop(product)
        else:
            doubles.append((product, half))
    if not doubles or () not in out:
        return out
    constant = out.pop(())
    weights = [out.pop(product) for product, _ in doubles]

    # w cos 2a = 2 w C^2 - w = w - 2 w S^2: choose so that the constant vanishes if it can.
    def left(signs: tuple[int, ...]) -> FloatArray:
        return constant - sum(s * w for s, w in zip(signs, weights, strict=True))

    choices = itertools.islice(itertools.product((1, -1), repeat=len(doubles)), _MOST_CHOICES)
    best = min(choices, key=lambda signs: (float(np.abs(left(signs)).max()) > close, -sum(signs)))
    for (_, half), weight, sign in zip(doubles, weights, best, strict=True):
        out[(Factor("cos" if sign > 0 else "sin", half),) * 2] = 2.0 * sign * weight
    if float(np.abs(left(best)).max()) > close:
        out[()] = left(best)
    return out
