"""Trigonometric polynomials written as products of sines and cosines, where this is shorter.

0.372 sin(q3) + 0.372 sin(2 q2 + q3) is 0.744 C2 S23, and 1.35 + 0.80 cos(2 q2) is 0.55 + 1.60 C2^2. Both
forms are exact; the second has fewer terms or simpler ones.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Factor, FactorKind, Monomial, half_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial, numbers

# Beyond this, trying every choice of squares would take too long; no known arm comes near.
_MOST_CHOICES = 2**10


# The factors of every run of joints.
_Product = tuple[Monomial, ...]


def to_products(
    polynomial: TrigonometricPolynomial, velocities: AbsoluteVelocities, noise: float = 0.0, deciding: int = 1
) -> dict[Monomial, FloatArray]:
    """Write K polynomials exactly in the same products of sines and cosines: weights (K,) by product.

    The first polynomial is the sum to shorten; others, such as its effects or links, follow it, and what they
    have beside its products is left as it is. Harmonics up to `noise`, the largest weight from round-off, in
    the first `deciding` polynomials are left out; weights that differ by up to twice as much count as equal.
    """
    keys, weights = _split(polynomial, velocities)
    is_above = (np.abs(weights[:deciding]) > noise).any(axis=0)
    products = _named(keys[is_above], weights.T[is_above], polynomial.prismatic, velocities)
    for r, run in enumerate(velocities.runs):
        if not polynomial.prismatic[run[0]]:
            products = _shortened(products, r, 2 * noise, velocities)
    return {tuple(sorted(itertools.chain(*product))): weight for product, weight in products.items()}


def _split(
    polynomial: TrigonometricPolynomial, velocities: AbsoluteVelocities
) -> tuple[NDArray[np.int64], FloatArray]:
    """Harmonics as products of one cosine, sine or power per run.

    A harmonic is Re(C prod_r exp(i s_r a_r)), with the angle a_r of run r and the sign s_r that makes its
    multiples lexically positive, and exp(i s a) = cos a + i s sin a. A key holds, run by run, the multiples
    and whether the factor is a sine; keys have shape (T, n + runs), ascending, weights shape (P, T).
    """
    ends = np.cumsum([len(run) for run in velocities.runs])
    keys = np.insert(polynomial.multiples[:, [*itertools.chain(*velocities.runs)]], ends, 0, axis=1)
    weights = polynomial.coefficients
    for r, (run, end) in enumerate(zip(velocities.runs, ends.tolist(), strict=True)):
        if polynomial.prismatic[run[0]]:
            continue
        place = slice(end + r - len(run), end + r)
        sign = np.sign(numbers(keys[:, place]))
        keys[:, place] *= np.where(sign < 0, -1, 1)[:, None]
        moving = np.flatnonzero(sign)
        sines = keys[moving]
        sines[:, place.stop] = 1
        keys = np.concatenate([keys, sines])
        weights = np.concatenate([weights, weights[:, moving] * (1j * sign[moving])], axis=1)
        keys, weights = _gathered(keys, weights)
    return keys, np.ascontiguousarray(weights.real)


def _gathered(keys: NDArray[np.int64], weights: Array) -> tuple[NDArray[np.int64], Array]:
    """Sum the columns with equal keys; keys are returned ascending."""
    number = numbers(keys)
    order = np.argsort(number, kind="stable")
    starts = np.flatnonzero(np.diff(number[order], prepend=np.iinfo(np.int64).min))
    if not starts.size:
        return keys, weights
    return keys[order[starts]], np.add.reduceat(weights[:, order], starts, axis=1)


def _named(
    keys: NDArray[np.int64], weights: FloatArray, prismatic: tuple[bool, ...], velocities: AbsoluteVelocities
) -> dict[_Product, FloatArray]:
    """Weights by product, from the keys of `_split`."""
    names: list[list[Monomial]] = []
    start = 0
    for run in velocities.runs:
        run_keys = keys[:, start : start + len(run) + 1]
        _, first, place = np.unique(numbers(run_keys), return_index=True, return_inverse=True)
        factors = [_factors(key, run, prismatic) for key in run_keys[first].tolist()]
        names.append([factors[k] for k in place.tolist()])
        start += len(run) + 1
    return dict(zip(zip(*names, strict=True), weights, strict=True))


def _factors(key: list[int], run: tuple[int, ...], prismatic: tuple[bool, ...]) -> Monomial:
    """Factors of one run, from its multiples or power and whether it is a sine."""
    *multiples, sine = key
    joints = range(len(prismatic))
    if prismatic[run[0]]:
        return (Factor("power", tuple(int(j == run[0]) for j in joints)),) * multiples[0]
    if not any(multiples):
        return ()
    part = dict(zip(run, multiples, strict=True))
    return (Factor("sin" if sine else "cos", tuple(part.get(j, 0) for j in joints)),)


def _shortened(
    products: Mapping[_Product, FloatArray], r: int, close: float, velocities: AbsoluteVelocities
) -> dict[_Product, FloatArray]:
    """Rewrite the factors of run r in products that are equal in all others.

    Weights that differ by up to `close` count as equal.
    """
    groups: dict[_Product, dict[Monomial, FloatArray]] = defaultdict(dict)
    for product, weight in products.items():
        groups[product[:r] + product[r + 1 :]][product[r]] = weight
    out: dict[_Product, FloatArray] = {}
    for beside, group in groups.items():
        if len(velocities.runs[r]) > 1:
            group = _paired(group, close, velocities)
        for factors, weight in _squared(group, close).items():
            out[*beside[:r], factors, *beside[r:]] = weight
    return out


def _paired(
    group: dict[Monomial, FloatArray], close: float, velocities: AbsoluteVelocities
) -> dict[Monomial, FloatArray]:
    """Turn two functions of equal weight, of the sum and difference of two angles, into one product."""
    out = dict(group)
    for first, second in itertools.combinations(group, 2):
        if first not in out or second not in out or not first or not second:
            continue
        (f,), (g,) = first, second
        # 1 if the weights are equal, -1 if they are opposite, 0 otherwise.
        ratio = int(abs(out[first][0] - out[second][0]) <= close)
        ratio -= int(abs(out[first][0] + out[second][0]) <= close)
        if f.kind != g.kind or ratio == 0:
            continue
        for (u, v), sign in itertools.product(((f, g), (g, f)), (1, -1)):
            total, difference = np.array(u.multiples), sign * np.array(v.multiples)
            alpha, beta = (total + difference) / 2, (total - difference) / 2
            if all(map(velocities.is_part, (alpha, beta))) and not np.array_equal(alpha, beta):
                a, b = tuple(int(x) for x in alpha), tuple(int(x) for x in beta)
                # kind(a + b) and kind(a - b); an odd function takes the sign out of its argument.
                same_sign = ratio * (sign if u.kind == "sin" else 1) > 0
                kinds, scale = _product_kinds(u.kind, same_sign)
                product = tuple(sorted((Factor(kinds[0], a), Factor(kinds[1], b))))
                weight, other = (out.pop(first if factor is f else second) for factor in (u, v))
                out[product] = out.get(product, 0.0) + scale * weight
                rest = other - ratio * weight
                rest[0] = 0.0
                if np.abs(rest).max() > close:
                    out[(v,)] = rest
                break
    return out


def _product_kinds(kind: FactorKind, same_sign: bool) -> tuple[tuple[FactorKind, FactorKind], float]:
    """kind(a+b) + kind(a-b), or their difference, as twice a product."""
    if kind == "cos":
        return (("cos", "cos"), 2.0) if same_sign else (("sin", "sin"), -2.0)
    return (("sin", "cos"), 2.0) if same_sign else (("cos", "sin"), 2.0)


def _squared(group: dict[Monomial, FloatArray], close: float) -> dict[Monomial, FloatArray]:
    """Turn double angles into squares and products where that adds no term."""
    out = dict(group)
    doubles = []
    for product in list(out):
        half = half_of(product)
        if half is None:
            continue
        if product[0].kind == "sin":
            out[Factor("cos", half), Factor("sin", half)] = 2.0 * out.pop(product)
        elif abs(out[product][0]) > close / 2.0:
            doubles.append((product, half))
    if not doubles or () not in out or abs(out[()][0]) <= close / 2.0:
        return out
    constant = out.pop(())
    weights = [out.pop(product) for product, _ in doubles]

    # w cos 2a = 2 w C^2 - w = w - 2 w S^2: choose so that the constant vanishes if it can.
    first, *others = (float(values[0]) for values in (constant, *weights))

    def is_left(signs: tuple[int, ...]) -> bool:
        return abs(first - sum(s * w for s, w in zip(signs, others, strict=True))) > close

    choices = itertools.islice(itertools.product((1, -1), repeat=len(doubles)), _MOST_CHOICES)
    best = min(choices, key=lambda signs: (is_left(signs), -sum(signs)))
    for (_, half), weight, sign in zip(doubles, weights, best, strict=True):
        out[(Factor("cos" if sign > 0 else "sin", half),) * 2] = 2.0 * sign * weight
    constant = constant - sum(s * w for s, w in zip(best, weights, strict=True))
    if np.abs(constant).max() > close:
        out[()] = constant
    return out
