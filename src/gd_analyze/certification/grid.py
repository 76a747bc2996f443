r"""Grids of positions that a polynomial of known curvature cannot hide a large value between.

Let G_k be the largest |f| when joints 1..k are at nodes and the others anywhere in the box, so that G_0 is
the maximum over the box and G_n that over the grid. Where G_{k-1} is reached, |f| is largest along joint k.
With nodes evenly spaced from end to end one lies within h of that place, h being half the spacing. Either the
place is an end, and a node, or f has no slope there, so that by Taylor's theorem f at the node is less by at
most h^2 / 2 times the largest second derivative K_k:

    G_{k-1} <= G_k + h_k^2 K_k / 2.

Two things bound K_k. The amplitudes of the harmonics do: sum_w |C_w| m_wk^2. And if joint k goes around the
circle, f itself does: its harmonics with |m_k| <= d are a trigonometric polynomial of degree d along joint k,
no larger than G_{k-1} + a, where a are the amplitudes of the others, and by Bernstein's inequality its second
derivative is no larger than d^2 times that:

    K_k <= d^2 (G_{k-1} + a) + b,      b = sum over the others |C_w| m_wk^2.

With many harmonics in many joints the amplitudes add up to several times what f reaches, and d^2 is less. A
joint of limited range may be taken around the circle for it. All this holds as well for the largest of many
such f, as the error over all velocities and accelerations is, if K_k bounds all of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# Gaps per unit of a joint's order, beyond which 1 / (2 gaps^2) of the maximum has nothing left to give.
_MOST_GAPS = 60.0
# Share of its amplitudes that a polynomial typically reaches: a guess that only directs effort.
_TYPICAL = 0.5


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of every joint, and how far a place of the box can be from one."""

    nodes: tuple[FloatArray, ...]  # positions of every joint, rad (m)
    reaches: FloatArray  # h, rad (m), shape (n,)
    # d of every joint whose curvature f itself bounds; 0 where the amplitudes do, the default
    degrees: tuple[int, ...] = ()

    @classmethod
    def at(cls, position: FloatArray) -> Grid:
        """One position, shape (n,), which suffices for a constant."""
        return cls(tuple(position[:, None]), np.zeros(len(position)))

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of nodes of every joint."""
        return tuple(len(node) for node in self.nodes)

    @property
    def size(self) -> int:
        """Number of positions."""
        return math.prod(self.counts)

    def positions(self, index: NDArray[np.int64]) -> FloatArray:
        """Positions by their number in row-major order, shape (n, K)."""
        places = np.unravel_index(index, self.counts)
        return np.stack([node[place] for node, place in zip(self.nodes, places, strict=True)])

    def between(self, polynomial: TrigonometricPolynomial, box: Box) -> FloatArray:
        """Largest gain of every polynomial between the nodes, by its amplitudes, shape (P,)."""
        return np.asarray(polynomial.curvatures(box.farthest).sum(axis=1) @ (self.reaches**2 / 2))

    def over_box(self, polynomial: TrigonometricPolynomial, box: Box, largest: float) -> float:
        """Bound the largest value over the box, given that over the grid."""
        spectrum = _Spectra.of(polynomial, box)(np.ones(len(polynomial), dtype=bool))
        return spectrum.bound(self.reaches, self.degrees or (0,) * len(self.nodes), largest)


@dataclass(frozen=True, eq=False)
class Reached:
    """Expected largest value of a polynomial: a guess that only directs effort."""

    # Within the box, and with every revolute joint going around the circle
    in_box: float
    around: float


def grid_of(
    polynomial: TrigonometricPolynomial, box: Box, effort: int, reached: Reached | None = None
) -> Grid | None:
    """Spread at most `effort` positions over a box; None if two ends per joint are more than that.

    Without `reached` the amplitudes bound all curvatures, as in `Grid.between`.
    """
    spectrum = _Spectra.of(polynomial, box)(np.ones(len(polynomial), dtype=bool))
    planned = _best_plan(spectrum, _axes(polynomial, box, reached, spectrum.total), effort)[1]
    if planned is None:
        return None
    axes, gaps, degrees = planned
    nodes = []
    for k, count in enumerate(gaps):
        if not count:
            nodes.append(box.centre[k : k + 1])
        elif axes.circle[k] or degrees[k]:
            nodes.append(box.lower[k] + 2 * np.pi * np.arange(count) / count)
        else:
            nodes.append(np.linspace(box.lower[k], box.upper[k], count + 1))
    return Grid(tuple(nodes), axes.reaches(gaps, degrees), degrees)


def shared_out(
    polynomial: TrigonometricPolynomial, box: Box, effort: int, groups: int, reached: Reached | None = None
) -> tuple[list[tuple[TrigonometricPolynomial, Grid]], TrigonometricPolynomial]:
    """Part harmonics into groups of few joints with a grid each, and a rest that its amplitudes bound.

    A grid over many joints would be too coarse. So those joints are chosen that promise the smallest bound if
    all harmonics of other joints are left to the next group, or to the rest.

    Parameters
    ----------
    polynomial, box
        To be bounded in the box.
    effort
        Most positions of each grid.
    groups
        Most grids.
    reached
        Expected largest value, for grids whose bound follows from that, too.
    """
    shares: list[tuple[TrigonometricPolynomial, Grid]] = []
    while len(shares) < groups and polynomial.multiples.size:
        chosen, expected = _promising(polynomial, box, effort, reached)
        part = polynomial if chosen.all() else polynomial.only(chosen)
        grid = grid_of(part, box, effort, expected)
        if grid is None or not chosen.any():
            break
        shares.append((part, grid))
        polynomial = polynomial.only(~chosen)
        if reached is not None:
            total = _TYPICAL * float(polynomial.sizes(box.farthest).sum())
            reached = Reached(total, total)
    return shares, polynomial


def _promising(
    polynomial: TrigonometricPolynomial, box: Box, effort: int, reached: Reached | None
) -> tuple[NDArray[np.bool_], Reached | None]:
    """Harmonics for the next grid, and what they reach; none if amplitudes promise no less."""
    spectra = _Spectra.of(polynomial, box)
    used = polynomial.multiples != 0
    joints = [k for k, degree in enumerate(polynomial.degrees) if degree]
    total = best = float(spectra.sizes.sum())
    choice, expected = np.zeros(len(spectra.sizes), dtype=bool), reached
    axes = _axes(polynomial, box, reached, total)
    for count in range(len(joints) + 1):
        for left_out in itertools.combinations(joints, count):
            chosen = ~used[:, left_out].any(axis=1)
            spectrum = spectra(chosen)
            ways = [way.of_part(total, spectrum.total) for way in axes]
            promised = _best_plan(spectrum, ways, effort)[0] + total - spectrum.total
            if promised < best:
                best, choice = promised, chosen
                expected = reached and Reached(ways[0].reached, ways[-1].reached)
    return choice, expected


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Amplitudes and curvatures by harmonic; called with a choice, shape (W,), it adds them up by joint."""

    sizes: FloatArray
    curvatures: FloatArray
    multiples: NDArray[np.int64]

    @classmethod
    def of(cls, polynomial: TrigonometricPolynomial, box: Box) -> _Spectra:
        every = polynomial.magnitudes()
        sizes, curvatures = every.sizes(box.farthest), every.curvatures(box.farthest)
        return cls(sizes[0], curvatures[0], np.abs(polynomial.multiples))

    def __call__(self, chosen: NDArray[np.bool_]) -> _Spectrum:
        sizes, most = self.sizes * chosen, int(self.multiples.max(initial=0))
        by_multiple = [np.bincount(m, weights=sizes, minlength=most + 1) for m in self.multiples.T]
        return _Spectrum(np.array(by_multiple), chosen @ self.curvatures, float(sizes.sum()))


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Amplitudes by joint and |multiple|, shape (n, D + 1), curvatures by joint, (n,), and all amplitudes."""

    amplitudes: FloatArray
    curvatures: FloatArray
    total: float

    def curvature(self, joint: int, degree: int, largest: float) -> float:
        """Bound on K_k by amplitudes, or by what f reaches if a degree is given."""
        if not degree:
            return float(self.curvatures[joint])
        high = np.arange(degree + 1, self.amplitudes.shape[1])
        others = self.amplitudes[joint, high]
        return degree**2 * (largest + float(others.sum())) + float(others @ high**2)

    def bound(self, reaches: FloatArray, degrees: Sequence[int], largest: float) -> float:
        """G_0 from G_n; joints that lose a share of f come last, which makes it least."""
        for joint in sorted(range(len(degrees)), key=lambda k: not degrees[k]):
            loss, degree = float(reaches[joint]) ** 2 / 2, degrees[joint]
            left = 1.0 - loss * degree**2
            if not left > 0.0:
                return math.inf
            largest = (largest + loss * self.curvature(joint, degree, 0.0)) / left
        return largest


_Plan = tuple["_Axes", list[int], tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class _Axes:
    """One way to go over the box.

    `half` is half of every joint's range, at most half a turn, `circle` whether that is the full circle,
    `around` which joints may be taken around the circle, shape (n,), and `reached` what is expected then.
    """

    half: FloatArray
    circle: NDArray[np.bool_]
    around: NDArray[np.bool_]
    reached: float

    def reaches(self, gaps: Sequence[int], degrees: Sequence[int]) -> FloatArray:
        """Half the spacing; 0 for a joint that does not matter or has no range."""
        half = np.where(np.array(degrees) > 0, np.pi, self.half)
        return np.asarray(np.where(np.array(gaps) > 0, half / np.maximum(gaps, 1), 0.0))

    def of_part(self, total: float, inside: float) -> _Axes:
        """The same way for some harmonics, of amplitudes `inside` out of `total`."""
        part = max(self.reached * inside / total, self.reached - total + inside) if total else 0.0
        return replace(self, reached=part)

    def orders(self, spectrum: _Spectrum) -> tuple[list[float], tuple[int, ...]]:
        """Gaps that every joint takes compared with others, and the degree that makes them fewest.

        A polynomial linear in a prismatic joint has no curvature, and its maximum at an end.
        """
        orders, degrees = [], []
        for k, half in enumerate(self.half.tolist()):
            degree = max((int(m) for m in np.flatnonzero(spectrum.amplitudes[k])), default=0)
            ways = [(half, 0), *((math.pi, d) for d in range(1, degree + 1) if self.around[k])]
            found = []
            for reach, d in ways:
                curved = spectrum.curvature(k, d, self.reached) / (self.reached or 1.0)
                found.append((reach * math.sqrt(curved), d))
            order, chosen = min(found) if half > 0.0 and degree else (0.0, 0)
            orders.append(order if degree and half > 0.0 else -1.0)
            degrees.append(chosen)
        return orders, tuple(degrees)

    def gaps(self, orders: list[float], degrees: Sequence[int], effort: int) -> list[int] | None:
        """Gaps between the nodes of every joint, 0 if one node suffices.

        The loss is half the sum of (order / gaps)^2, a share of the maximum. With a limit on the product of
        the gaps it is least for gaps in proportion to the orders.
        """
        ends = [int(not (one or d)) for one, d in zip(self.circle.tolist(), degrees, strict=True)]

        def gaps_of(share: float) -> list[int]:
            return [max(1, int(share * order)) if order >= 0.0 else 0 for order in orders]

        def positions(gaps: list[int]) -> int:
            return math.prod(gap + end if gap else 1 for gap, end in zip(gaps, ends, strict=True))

        low, high = 0.0, _MOST_GAPS
        for _ in range(16):
            middle = (low + high) / 2
            low, high = (middle, high) if positions(gaps_of(middle)) <= effort else (low, middle)
        gaps = gaps_of(low)
        return gaps if positions(gaps) <= effort else None


def _axes(
    polynomial: TrigonometricPolynomial, box: Box, reached: Reached | None, total: float
) -> list[_Axes]:
    """Ways to go over the box: within it, and around the circle where that is farther."""
    half = (box.upper - box.lower) / 2
    circle = polynomial.revolute & (half >= np.pi)
    half = np.where(circle, np.pi, half)
    if reached is None:
        return [_Axes(half, circle, np.zeros(len(half), dtype=bool), _TYPICAL * total)]
    within = _Axes(half, circle, circle, reached.in_box)
    return [within, _Axes(half, circle, polynomial.revolute, reached.around)]


def _best_plan(spectrum: _Spectrum, ways: list[_Axes], effort: int) -> tuple[float, _Plan | None]:
    """Least promised bound, with its way, gaps and degrees; None if no way fits the effort."""
    best, planned = math.inf, None
    for axes in ways:
        orders, degrees = axes.orders(spectrum)
        gaps = axes.gaps(orders, degrees, effort)
        if gaps is None:
            continue
        bound = min(spectrum.bound(axes.reaches(gaps, degrees), degrees, axes.reached), spectrum.total)
        if planned is None or bound < best:
            best, planned = bound, (axes, gaps, degrees)
    return best, planned
