"""From waves to terms and back: the form that is calculated with, and the form that is written."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray, falling
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.product_table import ProductTable
from gd_analyze.harmonics.products import with_products
from gd_analyze.harmonics.terms import Factor, Monomial
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial, numbers

# cos x = (e^ix + e^-ix) / 2, sin x = -i (e^ix - e^-ix) / 2; a power is itself.
_EXPONENTIALS = {"cos": (0.5, 0.5), "sin": (-0.5j, 0.5j), "power": (1.0, 0.0)}


def to_terms(
    waves: TrigonometricPolynomial, rates: AbsoluteRates, noise: float = 0.0, deciding: int = 1
) -> dict[Monomial, FloatArray]:
    """Write polynomials in products of sines and cosines; exact, and the same for all of them.

    Parameters
    ----------
    waves, rates, noise, deciding
        As for `to_products`.

    Returns
    -------
    dict
        Weights of shape (K,) by monomial, largest of the first polynomial first.
    """
    table = to_products(waves, rates, noise, deciding)
    joined = zip(table.monomials(), table.weights, strict=True)
    return dict(sorted(joined, key=lambda item: (falling(item[1][0]), item[0])))


def to_products(
    waves: TrigonometricPolynomial, rates: AbsoluteRates, noise: float = 0.0, deciding: int = 1
) -> ProductTable:
    """Write polynomials in products of sines and cosines; exact, and the same for all of them.

    Parameters
    ----------
    waves
        K polynomials: the first is the sum that shall be short, the others (its effects, its links) follow.
    rates
        The arm's runs: within a run the sines and cosines are of sums of its angles.
    noise
        What round-off can do to a weight: products below it are left out, and two weights no farther apart
        than twice this are taken for equal; nothing larger is ever lost.
    deciding
        So many of the first polynomials decide which products there are.
    """
    keys, weights = _split(waves, rates)
    kept = (np.abs(weights[:deciding]) > noise).any(axis=0)
    table = _table(keys[kept], weights.T[kept], waves.sliding, rates)
    for r, run in enumerate(rates.runs):
        if not waves.sliding[run[0]]:
            table = with_products(table, r, 2 * noise, rates.is_part)
    return table


def _split(waves: TrigonometricPolynomial, rates: AbsoluteRates) -> tuple[NDArray[np.int64], FloatArray]:
    """Waves as products of one cosine or sine, or power, per run.

    A wave is Re(C prod_r exp(i s_r a_r)), a_r the angle of run r with the sign s_r taken out that makes its
    multiples lexically positive, and exp(i s a) = cos a + i s sin a. Keys, shape (T, n + runs), are one run
    behind the other its multiples and then whether it is a sine, ascending; weights have shape (P, T).
    """
    ends = np.cumsum([len(run) for run in rates.runs])
    keys = np.insert(waves.multiples[:, [*itertools.chain(*rates.runs)]], ends, 0, axis=1)
    weights = waves.coefficients
    for r, (run, end) in enumerate(zip(rates.runs, ends.tolist(), strict=True)):
        if waves.sliding[run[0]]:
            continue
        place = slice(end + r - len(run), end + r)
        sign = np.sign(numbers(keys[:, place]))
        keys[:, place] *= np.where(sign < 0, -1, 1)[:, None]
        turned = np.flatnonzero(sign)
        sines = keys[turned]
        sines[:, place.stop] = 1
        keys = np.concatenate([keys, sines])
        weights = np.concatenate([weights, weights[:, turned] * (1j * sign[turned])], axis=1)
        keys, weights = _gathered(keys, weights)
    return keys, np.ascontiguousarray(weights.real)


def _gathered(keys: NDArray[np.int64], weights: Array) -> tuple[NDArray[np.int64], Array]:
    """Sum up the columns of equal keys, which come out ascending."""
    number = numbers(keys)
    order = np.argsort(number, kind="stable")
    starts = np.flatnonzero(np.diff(number[order], prepend=np.iinfo(np.int64).min))
    if not starts.size:
        return keys, weights
    return keys[order[starts]], np.add.reduceat(weights[:, order], starts, axis=1)


def _table(
    keys: NDArray[np.int64], weights: FloatArray, sliding: tuple[bool, ...], rates: AbsoluteRates
) -> ProductTable:
    """Products by name."""
    names: list[tuple[Monomial, ...]] = []
    codes = np.empty((len(keys), len(rates.runs)), dtype=np.int64)
    start = 0
    for r, run in enumerate(rates.runs):
        own = keys[:, start : start + len(run) + 1]
        _, first, codes[:, r] = np.unique(numbers(own), return_index=True, return_inverse=True)
        names.append(tuple(_factors(key, run, sliding) for key in own[first].tolist()))
        start += len(run) + 1
    return ProductTable(tuple(names), codes, weights)


def _factors(key: list[int], run: tuple[int, ...], sliding: tuple[bool, ...]) -> Monomial:
    """Factors of a run, from its multiples or power and whether it is a sine."""
    *own, sine = key
    joints = range(len(sliding))
    if sliding[run[0]]:
        return (Factor("power", tuple(int(j == run[0]) for j in joints)),) * own[0]
    part = dict(zip(run, own, strict=True))
    return (Factor("sin" if sine else "cos", tuple(part.get(j, 0) for j in joints)),) if any(own) else ()


def to_waves(
    polynomials: Sequence[Mapping[Monomial, float]], sliding: Sequence[bool]
) -> TrigonometricPolynomial:
    """Multiply products of sines and cosines out.

    Parameters
    ----------
    polynomials
        P sums of monomials with their weights.
    sliding
        Whether each joint slides.
    """
    pairs = [(p, *item) for p, polynomial in enumerate(polynomials) for item in polynomial.items()]
    rows = np.array([p for p, _, _ in pairs], dtype=np.int64)
    multiples = np.zeros((len(pairs), len(sliding)), dtype=np.int64)
    weights = np.array([weight for _, _, weight in pairs], dtype=complex)
    source = np.arange(len(pairs))
    for place in range(max((len(monomial) for _, monomial, _ in pairs), default=0)):
        nothing = Factor("power", (0,) * len(sliding))
        factors = [monomial[place] if place < len(monomial) else nothing for _, monomial, _ in pairs]
        step = np.array([factor[1] for factor in factors], dtype=np.int64)[source]
        up, down = np.array([_EXPONENTIALS[factor[0]] for factor in factors])[source].T
        weights = np.concatenate([weights * up, weights * down])
        there = weights != 0.0
        multiples = np.concatenate([multiples + step, multiples - step])[there]
        weights, source = weights[there], np.tile(source, 2)[there]
    turning = ~np.array(sliding)
    mirrored = numbers(multiples * turning) < 0
    multiples = np.where(mirrored[:, None] & turning, -multiples, multiples)
    weights = np.where(mirrored, weights.conj(), weights)
    _, first, column = np.unique(numbers(multiples), return_index=True, return_inverse=True)
    out = np.zeros((len(polynomials), len(first)), dtype=complex)
    np.add.at(out, (rows[source], column), weights)
    return TrigonometricPolynomial(tuple(sliding), multiples[first], out)
