"""Double angles of one joint as squares and products, in all products at once.

The same as `products` does for any run of joints, where this is one joint: then no two cosines or sines are
those of a sum and a difference, and there is one double angle.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.product_table import ProductTable
from gd_analyze.harmonics.terms import Factor, Monomial, half_of


def has_one_double(table: ProductTable, r: int) -> bool:
    """Whether run r is of one joint and has at most one double angle of a cosine."""
    factors = [factor for name in table.names[r] for factor in name]
    doubles = [name for name in table.names[r] if name and name[0].kind == "cos" and half_of(name)]
    return len({joint for factor in factors for joint in factor.joints}) <= 1 and len(doubles) <= 1


def with_squares(table: ProductTable, r: int, close: float) -> ProductTable:
    """Rewrite run r, of which `has_one_double` holds; see `products.with_products`."""
    names, codes, weights = list(table.names[r]), table.codes.copy(), table.weights.copy()
    code, group = codes[:, r], table.groups(r)
    # Within a group what is rewritten comes last.
    place = np.zeros(len(table), dtype=np.int64)
    for k, name in enumerate(table.names[r]):
        half = half_of(name)
        if half is None:
            continue
        if name[0].kind == "sin":
            rows = code == k
            weights[rows] *= 2.0
            code[rows], place[rows] = len(names), 1
            names.append((Factor("cos", half), Factor("sin", half)))
        elif () in names:
            constants, doubles = np.flatnonzero(code == names.index(())), np.flatnonzero(code == k)
            _, one, other = np.intersect1d(group[constants], group[doubles], return_indices=True)
            constants, doubles = constants[one], doubles[other]
            signs = _signs(weights[constants], weights[doubles], close)
            weights[constants] -= signs * weights[doubles]
            weights[doubles] *= 2.0 * signs
            code[doubles] = np.where(signs[:, 0] > 0, len(names), len(names) + 1)
            place[doubles], place[constants] = 2, 3
            names += [_square("cos", half), _square("sin", half)]
    gone = (place == 3) & (np.abs(weights).max(axis=1, initial=0.0) <= close)
    order = np.lexsort((place, group))
    order = order[~gone[order]]
    return table.rewritten(r, names, codes[order], weights[order])


def _signs(constants: FloatArray, doubles: FloatArray, close: float) -> FloatArray:
    """Of w cos 2a = 2 w C^2 - w = w - 2 w S^2, 1 for the first and -1 for the second, shape (T, 1).

    The second where only it makes the constant vanish.
    """
    with_cos, with_sin = (
        np.abs(constants - sign * doubles).max(axis=1, initial=0.0) <= close for sign in (1.0, -1.0)
    )
    return np.where(with_sin & ~with_cos, -1.0, 1.0)[:, None]


def _square(kind: str, half: tuple[int, ...]) -> Monomial:
    return (Factor("cos" if kind == "cos" else "sin", half),) * 2
