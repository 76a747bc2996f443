"""Sums of cosines and sines as a person would write them: products and squares where they are shorter.

0.372 sin(q3) + 0.372 sin(2 q2 + q3) is 0.744 C2 S23, and 1.35 + 0.80 cos(2 q2) is 0.55 + 1.60 C2^2. Both
forms are exact; the second has fewer terms or simpler ones.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray, falling
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Factor, FactorKind, Monomial, half_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial, numbers


@dataclass(frozen=True, eq=False)
class ProductTable:
    """K sums over the same T products.

    Parameters
    ----------
    names
        For every run of joints the monomials that occur, all distinct.
    codes
        Which of them goes into every product, shape (T, runs); no two rows are equal.
    weights
        Shape (T, K).
    """

    names: tuple[tuple[Monomial, ...], ...]
    codes: NDArray[np.int64]
    weights: FloatArray

    def __len__(self) -> int:
        return len(self.codes)

    def only(self, chosen: NDArray[np.bool_]) -> ProductTable:
        """Leave out the other products."""
        return ProductTable(self.names, self.codes[chosen], self.weights[chosen])

    def rewritten(
        self, r: int, names: Sequence[Monomial], codes: NDArray[np.int64], weights: FloatArray
    ) -> ProductTable:
        """Put other products in their place, whose codes of run r are of these names."""
        return ProductTable((*self.names[:r], tuple(names), *self.names[r + 1 :]), codes, weights)

    def groups(self, r: int) -> NDArray[np.int64]:
        """Number of every product's group, shape (T,): those alike in all runs but r, as they first occur."""
        if len(self.names) == 1:
            return np.zeros(len(self), dtype=np.int64)
        others = numbers(np.delete(self.codes, r, axis=1))
        _, first, group = np.unique(others, return_index=True, return_inverse=True)
        return np.argsort(np.argsort(first))[group]

    def monomials(self) -> list[Monomial]:
        """Every product as one monomial."""
        return [
            tuple(sorted(factor for name, k in zip(self.names, code, strict=True) for factor in name[k]))
            for code in self.codes.tolist()
        ]

    def largest(self, values: Sequence[Sequence[float]]) -> FloatArray:
        """Product of the largest values of every run's monomials, shape (T,)."""
        out = np.ones(len(self))
        for value, code in zip(values, self.codes.T, strict=True):
            out *= np.array(value)[code]
        return out


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
        Place of a run of revolute joints.
    close
        Weights no farther apart are taken for equal; nothing larger is ever lost.
    is_part
        Whether multiples are those of an angle between two links, see `AbsoluteVelocities.is_part`: a
        product is one of two such angles.
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


# cos x = (e^ix + e^-ix) / 2, sin x = -i (e^ix - e^-ix) / 2; a power is itself.
_EXPONENTIALS = {"cos": (0.5, 0.5), "sin": (-0.5j, 0.5j), "power": (1.0, 0.0)}


def to_terms(
    waves: TrigonometricPolynomial, velocities: AbsoluteVelocities, noise: float = 0.0, deciding: int = 1
) -> dict[Monomial, FloatArray]:
    """Write polynomials in products of sines and cosines; exact, and the same for all of them.

    Parameters
    ----------
    waves, velocities, noise, deciding
        As for `to_products`.

    Returns
    -------
    dict
        Weights of shape (K,) by monomial, largest of the first polynomial first.
    """
    table = to_products(waves, velocities, noise, deciding)
    joined = zip(table.monomials(), table.weights, strict=True)
    return dict(sorted(joined, key=lambda item: (falling(item[1][0]), item[0])))


def to_products(
    waves: TrigonometricPolynomial, velocities: AbsoluteVelocities, noise: float = 0.0, deciding: int = 1
) -> ProductTable:
    """Write polynomials in products of sines and cosines; exact, and the same for all of them.

    Parameters
    ----------
    waves
        K polynomials: the first is the sum that shall be short, the others (its effects, its links) follow.
    velocities
        The arm's runs: within a run the sines and cosines are of sums of its angles.
    noise
        What round-off can do to a weight: products below it are left out, and two weights no farther apart
        than twice this are taken for equal; nothing larger is ever lost.
    deciding
        So many of the first polynomials decide which products there are.
    """
    keys, weights = _split(waves, velocities)
    kept = (np.abs(weights[:deciding]) > noise).any(axis=0)
    table = _table(keys[kept], weights.T[kept], waves.prismatic, velocities)
    for r, run in enumerate(velocities.runs):
        if not waves.prismatic[run[0]]:
            table = with_products(table, r, 2 * noise, velocities.is_part)
    return table


def _split(
    waves: TrigonometricPolynomial, velocities: AbsoluteVelocities
) -> tuple[NDArray[np.int64], FloatArray]:
    """Waves as products of one cosine or sine, or power, per run.

    A wave is Re(C prod_r exp(i s_r a_r)), a_r the angle of run r with the sign s_r taken out that makes its
    multiples lexically positive, and exp(i s a) = cos a + i s sin a. Keys, shape (T, n + runs), are one run
    behind the other its multiples and then whether it is a sine, ascending; weights have shape (P, T).
    """
    ends = np.cumsum([len(run) for run in velocities.runs])
    keys = np.insert(waves.multiples[:, [*itertools.chain(*velocities.runs)]], ends, 0, axis=1)
    weights = waves.coefficients
    for r, (run, end) in enumerate(zip(velocities.runs, ends.tolist(), strict=True)):
        if waves.prismatic[run[0]]:
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
    keys: NDArray[np.int64], weights: FloatArray, prismatic: tuple[bool, ...], velocities: AbsoluteVelocities
) -> ProductTable:
    """Products by name."""
    names: list[tuple[Monomial, ...]] = []
    codes = np.empty((len(keys), len(velocities.runs)), dtype=np.int64)
    start = 0
    for r, run in enumerate(velocities.runs):
        own = keys[:, start : start + len(run) + 1]
        _, first, codes[:, r] = np.unique(numbers(own), return_index=True, return_inverse=True)
        names.append(tuple(_factors(key, run, prismatic) for key in own[first].tolist()))
        start += len(run) + 1
    return ProductTable(tuple(names), codes, weights)


def _factors(key: list[int], run: tuple[int, ...], prismatic: tuple[bool, ...]) -> Monomial:
    """Factors of a run, from its multiples or power and whether it is a sine."""
    *own, sine = key
    joints = range(len(prismatic))
    if prismatic[run[0]]:
        return (Factor("power", tuple(int(j == run[0]) for j in joints)),) * own[0]
    part = dict(zip(run, own, strict=True))
    return (Factor("sin" if sine else "cos", tuple(part.get(j, 0) for j in joints)),) if any(own) else ()


def to_polynomial(
    polynomials: Sequence[Mapping[Monomial, float]], prismatic: Sequence[bool]
) -> TrigonometricPolynomial:
    """Multiply products of sines and cosines out.

    Parameters
    ----------
    polynomials
        P sums of monomials with their weights.
    prismatic
        Whether each joint slides.
    """
    pairs = [(p, *item) for p, polynomial in enumerate(polynomials) for item in polynomial.items()]
    rows = np.array([p for p, _, _ in pairs], dtype=np.int64)
    multiples = np.zeros((len(pairs), len(prismatic)), dtype=np.int64)
    weights = np.array([weight for _, _, weight in pairs], dtype=complex)
    source = np.arange(len(pairs))
    for place in range(max((len(monomial) for _, monomial, _ in pairs), default=0)):
        nothing = Factor("power", (0,) * len(prismatic))
        factors = [monomial[place] if place < len(monomial) else nothing for _, monomial, _ in pairs]
        step = np.array([factor[1] for factor in factors], dtype=np.int64)[source]
        up, down = np.array([_EXPONENTIALS[factor[0]] for factor in factors])[source].T
        weights = np.concatenate([weights * up, weights * down])
        there = weights != 0.0
        multiples = np.concatenate([multiples + step, multiples - step])[there]
        weights, source = weights[there], np.tile(source, 2)[there]
    revolute = ~np.array(prismatic)
    mirrored = numbers(multiples * revolute) < 0
    multiples = np.where(mirrored[:, None] & revolute, -multiples, multiples)
    weights = np.where(mirrored, weights.conj(), weights)
    _, first, column = np.unique(numbers(multiples), return_index=True, return_inverse=True)
    out = np.zeros((len(polynomials), len(first)), dtype=complex)
    np.add.at(out, (rows[source], column), weights)
    return TrigonometricPolynomial(tuple(prismatic), multiples[first], out)
