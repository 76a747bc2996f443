r"""Grids of positions that bound a polynomial f of known curvature between the nodes, too.

With G_k the largest |f| when joints 1..k are at nodes, h_k half the spacing and K_k the largest curvature,
G_{k-1} <= G_k + h_k^2 K_k / 2. K_k is bounded by amplitudes or Bernstein's inequality (docs/certificate.md).
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

# Gaps per unit of a joint's order, beyond which the loss, 1 / (2 gaps^2) of the maximum, is negligible.
_MOST_GAPS = 60.0
# Share of its amplitudes that a polynomial typically reaches: a guess that only directs effort.
_TYPICAL = 0.5


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of every joint, and the largest distance of a position in the box from one."""

    nodes: tuple[FloatArray, ...]  # positions of every joint, rad (m)
    reaches: FloatArray  # h, rad (m), shape (n,)
    # Degree d of joints whose curvature is bounded by f itself; 0 (default) where amplitudes bound it
    degrees: tuple[int, ...] = ()

    @classmethod
    def at(cls, position: FloatArray) -> Grid:
        """One position, shape (n,), which suffices for a constant."""
        return cls(tuple(position[:, None]), np.zeros(len(position)))

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of nodes of every joint."""
        return tuple(len(node) for node in self.nodes)

    @property
    def size(self) -> int:
        """Number of positions."""
        return math.prod(self.counts)

    def positions(self, index: NDArray[np.int64]) -> FloatArray:
        """Positions by index in row-major order, shape (n, K)."""
        places = np.unravel_index(index, self.counts)
        return np.stack([node[place] for node, place in zip(self.nodes, places, strict=True)])

    def between(self, polynomial: TrigonometricPolynomial, box: Box) -> FloatArray:
        """Largest gain of every polynomial between the nodes, by its amplitudes, shape (P,)."""
        return np.asarray(polynomial.curvatures(box.farthest).sum(axis=1) @ (self.reaches**2 / 2))

    def over_box(self, polynomial: TrigonometricPolynomial, box: Box, largest: float) -> float:
        """Bound the largest value over the box, given that over the grid."""
        degrees = self.degrees or (0,) * len(self.nodes)
        return _Spectrum.of(polynomial, box).bound(self.reaches, degrees, largest)


@dataclass(frozen=True, eq=False)
class Reached:
    """Expected largest value of a polynomial: a guess that only directs effort."""

    in_box: float
    around: float  # with every revolute joint going around the circle


def grid_of(
    polynomial: TrigonometricPolynomial, box: Box, effort: int, reached: Reached | None = None
) -> Grid | None:
    """Spread at most `effort` positions over a box; None if two ends per joint are more than that.

    Without `reached` the amplitudes bound all curvatures, as in `Grid.between`.
    """
    spectrum = _Spectrum.of(polynomial, box)
    planned = _best_plan(spectrum, _coverings(polynomial, box, reached, spectrum.total), effort)[1]
    if planned is None:
        return None
    covering, gaps, degrees = planned
    nodes = []
    for k, count in enumerate(gaps):
        if not count:
            nodes.append(box.centre[k : k + 1])
        elif covering.circle[k] or degrees[k]:
            nodes.append(box.lower[k] + 2 * np.pi * np.arange(count) / count)
        else:
            nodes.append(np.linspace(box.lower[k], box.upper[k], count + 1))
    return Grid(tuple(nodes), covering.reaches(gaps, degrees), degrees)


def shared_out(
    polynomial: TrigonometricPolynomial, box: Box, effort: int, groups: int, reached: Reached | None = None
) -> tuple[list[tuple[TrigonometricPolynomial, Grid]], TrigonometricPolynomial]:
    """Split harmonics into groups of few joints with a grid each, and a rest bounded by its amplitudes.

    A grid over many joints would be too coarse. The joints chosen promise the smallest bound if all harmonics
    of other joints are left to the next group, or to the rest.
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
    """Harmonics for the next grid, and their expected maximum; none if amplitudes are as good."""
    whole = _Spectrum.of(polynomial, box)
    total = best = whole.total
    joints = [k for k, degree in enumerate(polynomial.degrees) if degree]
    choice, expected = np.zeros(len(whole.sizes), dtype=bool), reached
    coverings = _coverings(polynomial, box, reached, total)
    for count in range(len(joints) + 1):
        for left_out in itertools.combinations(joints, count):
            chosen = (whole.multiples[:, left_out] == 0).all(axis=1)
            part = whole.only(chosen)
            # A part reaches at least its share, and at least the total less the others.
            guesses = [
                max(covering.reached * part.total / total, covering.reached - total + part.total)
                if total
                else 0.0
                for covering in coverings
            ]
            part_coverings = [
                replace(covering, reached=guess) for covering, guess in zip(coverings, guesses, strict=True)
            ]
            promised = _best_plan(part, part_coverings, effort)[0] + total - part.total
            if promised < best:
                best, choice = promised, chosen
                expected = reached and Reached(guesses[0], guesses[-1])
    return choice, expected


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Amplitudes and curvatures of all polynomials together, by harmonic, and their sums by joint."""

    sizes: FloatArray  # (W,)
    curved: FloatArray  # (W, n)
    multiples: NDArray[np.int64]  # magnitudes, (W, n)

    @classmethod
    def of(cls, polynomial: TrigonometricPolynomial, box: Box) -> _Spectrum:
        magnitudes = polynomial.magnitudes()
        sizes, curved = magnitudes.sizes(box.farthest)[0], magnitudes.curvatures(box.farthest)[0]
        return cls(sizes, curved, np.abs(polynomial.multiples))

    def only(self, chosen: NDArray[np.bool_]) -> _Spectrum:
        return _Spectrum(self.sizes[chosen], self.curved[chosen], self.multiples[chosen])

    @cached_property
    def total(self) -> float:
        return float(self.sizes.sum())

    @cached_property
    def curvatures(self) -> FloatArray:
        """Curvatures by joint, shape (n,)."""
        return np.asarray(self.curved.sum(axis=0))

    @cached_property
    def amplitudes(self) -> FloatArray:
        """Amplitudes by joint and multiple, shape (n, D + 1)."""
        highest = int(self.multiples.max(initial=0))
        return np.array([np.bincount(m, self.sizes, highest + 1) for m in self.multiples.T])

    def curvature(self, joint: int, degree: int, largest: float) -> float:
        """Bound on K_k by amplitudes, or by the maximum of f if a degree is given."""
        if not degree:
            return float(self.curvatures[joint])
        high = np.arange(degree + 1, self.amplitudes.shape[1])
        high_amplitudes = self.amplitudes[joint, high]
        return degree**2 * (largest + float(high_amplitudes.sum())) + float(high_amplitudes @ high**2)

    def bound(self, reaches: FloatArray, degrees: Sequence[int], largest: float) -> float:
        """G_0 from G_n; joints whose loss is a share of f come last, which minimizes it."""
        for joint in sorted(range(len(degrees)), key=lambda k: not degrees[k]):
            loss, degree = float(reaches[joint]) ** 2 / 2, degrees[joint]
            remaining = 1.0 - loss * degree**2
            if not remaining > 0.0:
                return math.inf
            largest = (largest + loss * self.curvature(joint, degree, 0.0)) / remaining
        return largest


@dataclass(frozen=True, eq=False)
class _Covering:
    """Ranges over which the nodes of every joint are spread, to cover the box."""

    half: FloatArray  # half of every joint's range, at most half a turn, (n,)
    circle: NDArray[np.bool_]  # whether that is the full circle, (n,)
    around: NDArray[np.bool_]  # joints that may be taken around the circle, (n,)
    reached: float  # expected maximum then

    def reaches(self, gaps: Sequence[int], degrees: Sequence[int]) -> FloatArray:
        """Half the spacing; 0 for a joint that does not matter or has no range."""
        half = np.where(np.array(degrees) > 0, np.pi, self.half)
        return np.asarray(np.where(np.array(gaps) > 0, half / np.maximum(gaps, 1), 0.0))

    def orders(self, spectrum: _Spectrum) -> tuple[list[float], tuple[int, ...]]:
        """Relative number of gaps of every joint, -1 for none, and the degree that minimizes it.

        A polynomial linear in a prismatic joint has no curvature, and its maximum at an end.
        """
        orders, degrees = [], []
        for k, half in enumerate(self.half.tolist()):
            degree = int(np.flatnonzero(spectrum.amplitudes[k]).max(initial=0))
            ranges = [(half, 0), *((math.pi, d) for d in range(1, degree + 1) if self.around[k])]
            candidates = [
                (reach * math.sqrt(spectrum.curvature(k, d, self.reached) / (self.reached or 1.0)), d)
                for reach, d in ranges
            ]
            order, chosen = min(candidates) if half > 0.0 and degree else (-1.0, 0)
            orders.append(order)
            degrees.append(chosen)
        return orders, tuple(degrees)

    def gaps(self, orders: list[float], degrees: Sequence[int], effort: int) -> list[int] | None:
        """Gaps between the nodes of every joint, 0 if one node suffices.

        The loss is half the sum of (order / gaps)^2, a share of the maximum. With a limit on the product of
        the gaps it is least for gaps in proportion to the orders.
        """
        ends = [int(not (is_circle or d)) for is_circle, d in zip(self.circle.tolist(), degrees, strict=True)]

        def fitting(share: float) -> list[int] | None:
            gaps = [max(1, int(share * order)) if order >= 0.0 else 0 for order in orders]
            positions = math.prod(gap + end if gap else 1 for gap, end in zip(gaps, ends, strict=True))
            return gaps if positions <= effort else None

        low, high = 0.0, _MOST_GAPS
        for _ in range(16):
            middle = (low + high) / 2
            low, high = (low, middle) if fitting(middle) is None else (middle, high)
        return fitting(low)


def _coverings(
    polynomial: TrigonometricPolynomial, box: Box, reached: Reached | None, total: float
) -> list[_Covering]:
    """Ways to cover the box: within it, or around the full circle."""
    half = (box.upper - box.lower) / 2
    circle = polynomial.revolute & (half >= np.pi)
    half = np.where(circle, np.pi, half)
    if reached is None:
        return [_Covering(half, circle, np.zeros(len(half), dtype=bool), _TYPICAL * total)]
    within = _Covering(half, circle, circle, reached.in_box)
    return [within, _Covering(half, circle, polynomial.revolute, reached.around)]


def _best_plan(
    spectrum: _Spectrum, coverings: list[_Covering], effort: int
) -> tuple[float, tuple[_Covering, list[int], tuple[int, ...]] | None]:
    """Least promised bound, with its covering, gaps and degrees; None if none fits the effort."""
    best, planned = math.inf, None
    for covering in coverings:
        orders, degrees = covering.orders(spectrum)
        gaps = covering.gaps(orders, degrees, effort)
        if gaps is None:
            continue
        bound = min(
            spectrum.bound(covering.reaches(gaps, degrees), degrees, covering.reached), spectrum.total
        )
        if planned is None or bound < best:
            best, planned = bound, (covering, gaps, degrees)
    return best, planned
