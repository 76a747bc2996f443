r"""Grids of positions that a polynomial of known curvature cannot hide a large value between.

Let G_k be the largest |f| when joints 1..k are at nodes and the others anywhere in the box, so that G_0 is
the maximum over the box and G_n that over the grid. Where G_{k-1} is reached, |f| is largest along joint k.
With nodes evenly spaced from end to end one lies within h of that place, h half the spacing. Either the place
is an end, and a node, or f has no slope there, so that by Taylor's theorem f at the node is less by at most
h^2 / 2 times the largest second derivative K_k:

    G_{k-1} <= G_k + h_k^2 K_k / 2.

Two things bound K_k. The amplitudes of the waves do: sum_w |C_w| m_wk^2. And where joint k goes around the
circle f itself does: of its waves those of |m_k| <= d are a trigonometric polynomial along joint k of degree
d, no larger than G_{k-1} + a, a the amplitudes of the others, and by Bernstein's inequality its second
derivative is no larger than d^2 times that:

    K_k <= d^2 (G_{k-1} + a) + b,      b = sum over the others |C_w| m_wk^2.

Of many waves in many joints the amplitudes add up to several times what f reaches, and d^2 is the lesser. A
joint of a limited range may be taken around the circle for it. All this holds as well for the largest of many
such f, as the error is over all velocities and accelerations, if K_k bounds all of them.
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


@dataclass(frozen=True, eq=False)
class Spectra:
    """Amplitudes and curvatures of waves; called with some chosen, shape (W,), it adds them up by joint."""

    sizes: FloatArray
    curvatures: FloatArray
    multiples: NDArray[np.int64]

    @classmethod
    def of(cls, waves: TrigonometricPolynomial, box: Box) -> Spectra:
        """Those of waves that slide as far as they can in a box."""
        every = waves.magnitudes()
        sizes, curvatures = every.sizes(box.farthest), every.curvatures(box.farthest)
        return cls(sizes[0], curvatures[0], np.abs(waves.multiples))

    def __call__(self, chosen: NDArray[np.bool_]) -> Spectrum:
        """Add up those chosen."""
        sizes, most = self.sizes * chosen, int(self.multiples.max(initial=0))
        by_multiple = [np.bincount(m, weights=sizes, minlength=most + 1) for m in self.multiples.T]
        return Spectrum(np.array(by_multiple), chosen @ self.curvatures, float(sizes.sum()))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes by joint and |multiple|, shape (n, D + 1), curvatures by joint, (n,), and all amplitudes."""

    amplitudes: FloatArray
    curvatures: FloatArray
    total: float

    def beyond(self, joint: int, degree: int) -> tuple[float, float]:
        """Amplitudes a and curvatures b of what has a higher degree in a joint."""
        high = np.arange(degree + 1, self.amplitudes.shape[1])
        return float(self.amplitudes[joint, high].sum()), float(self.amplitudes[joint, high] @ high**2)

    def curvature(self, joint: int, degree: int, largest: float) -> float:
        """Bound K_k by amplitudes, or by what f reaches."""
        if not degree:
            return float(self.curvatures[joint])
        more, curved = self.beyond(joint, degree)
        return degree**2 * (largest + more) + curved

    def bound(self, reaches: FloatArray, degrees: Sequence[int], largest: float) -> float:
        """G_0 from G_n; joints that share of f are moved to their nodes last, so that this is least."""
        for joint in sorted(range(len(degrees)), key=lambda k: not degrees[k]):
            loss, degree = float(reaches[joint]) ** 2 / 2, degrees[joint]
            left = 1.0 - loss * degree**2
            if not left > 0.0:
                return math.inf
            largest = (largest + loss * self.curvature(joint, degree, 0.0)) / left
        return largest


# Gaps per unit of a joint's order, beyond which 1 / (2 gaps^2) of the maximum has nothing left to give.
_MOST_GAPS = 60.0
# What a sum of waves reaches, of its amplitudes: a guess that only tells where effort pays.
_TYPICAL = 0.5


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of every joint, and how far a place of the box can be from one.

    Parameters
    ----------
    nodes
        Positions of every joint, rad (m).
    reaches
        h, rad (m), shape (n,).
    degrees
        d of every joint whose curvature f itself bounds; 0 where the amplitudes do, as everywhere by default.
    """

    nodes: tuple[FloatArray, ...]
    reaches: FloatArray
    degrees: tuple[int, ...] = ()

    @classmethod
    def at(cls, position: FloatArray) -> Grid:
        """One position, shape (n,): enough for what is the same everywhere."""
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

    def between(self, waves: TrigonometricPolynomial, box: Box) -> FloatArray:
        """What every polynomial can gain between the nodes by its amplitudes, shape (P,)."""
        return np.asarray(waves.curvatures(box.farthest).sum(axis=1) @ (self.reaches**2 / 2))

    def over_box(self, waves: TrigonometricPolynomial, box: Box, largest: float) -> float:
        """Bound the largest value over the box, given that over the grid."""
        spectrum = Spectra.of(waves, box)(np.ones(len(waves), dtype=bool))
        return spectrum.bound(self.reaches, self.degrees or (0,) * len(self.nodes), largest)


@dataclass(frozen=True, eq=False)
class Reached:
    """What a sum of waves is expected to reach: a guess that only tells where effort pays.

    Parameters
    ----------
    in_box, around
        Within the box, and with every revolute joint going around the circle.
    """

    in_box: float
    around: float


def grid_of(
    waves: TrigonometricPolynomial, box: Box, effort: int, reached: Reached | None = None
) -> Grid | None:
    """Spread at most `effort` positions over a box; None where two ends per joint are more than that.

    Without a word on what is reached amplitudes bound all curvatures, as those of `Grid.between`.
    """
    spectrum = Spectra.of(waves, box)(np.ones(len(waves), dtype=bool))
    planned = _cheapest(spectrum, _axes(waves, box, reached, spectrum.total), effort)
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


@dataclass(frozen=True, eq=False)
class _Axes:
    """Half of every joint's range, at most half a turn, whether it is the full circle, and the use of that.

    `around` are the joints, shape (n,), that may be taken around the circle, `reached` what is expected then.
    """

    half: FloatArray
    circle: NDArray[np.bool_]
    around: NDArray[np.bool_]
    reached: float

    def reaches(self, gaps: Sequence[int], degrees: Sequence[int]) -> FloatArray:
        """Half the spacing; 0 where a joint does not matter or has no range."""
        half = np.where(np.array(degrees) > 0, np.pi, self.half)
        return np.asarray(np.where(np.array(gaps) > 0, half / np.maximum(gaps, 1), 0.0))

    def of_part(self, total: float, inside: float) -> _Axes:
        """For some of the waves, of amplitudes `inside` out of `total`."""
        part = max(self.reached * inside / total, self.reached - total + inside) if total else 0.0
        return replace(self, reached=part)

    def orders(self, spectrum: Spectrum) -> tuple[list[float], tuple[int, ...]]:
        """How many gaps every joint takes compared with others, and the degree that it takes so few with.

        What is linear in a prismatic joint has no curvature, and its maximum at an end.
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
        """Gaps between the nodes of every joint, 0 where one node does.

        The loss is half of (order / gaps)^2, added up, of the maximum; under a limit on the product of the
        gaps it is least with gaps in proportion to the orders.
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


def _axes(waves: TrigonometricPolynomial, box: Box, reached: Reached | None, total: float) -> list[_Axes]:
    """Ways to go over the box: within it, and around the circle where that is farther."""
    half, revolute = (box.upper - box.lower) / 2, ~np.array(waves.prismatic)
    circle = revolute & (half >= np.pi)
    half = np.where(circle, np.pi, half)
    if reached is None:
        return [_Axes(half, circle, np.zeros(len(half), dtype=bool), _TYPICAL * total)]
    within = _Axes(half, circle, circle, reached.in_box)
    return [within, _Axes(half, circle, revolute, reached.around)]


def _cheapest(
    spectrum: Spectrum, ways: list[_Axes], effort: int
) -> tuple[_Axes, list[int], tuple[int, ...]] | None:
    """Of the ways to go over a box that of the least promised bound; None where no effort allows for one."""
    return _promised(spectrum, ways, effort)[1]


def _promised(
    spectrum: Spectrum, ways: list[_Axes], effort: int
) -> tuple[float, tuple[_Axes, list[int], tuple[int, ...]] | None]:
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


def shared_out(
    waves: TrigonometricPolynomial, box: Box, effort: int, groups: int, reached: Reached | None = None
) -> tuple[list[tuple[TrigonometricPolynomial, Grid]], TrigonometricPolynomial]:
    """Part waves into groups of few joints with a grid each, and a rest that is bounded by its amplitudes.

    A grid over many joints would be too coarse. So the joints are chosen that promise the smallest bound when
    all waves of other joints are left to the next group, or to the rest.

    Parameters
    ----------
    waves, box
        What is to be bounded, and where.
    effort
        Most positions of each grid.
    groups
        Most grids.
    reached
        What all waves together are expected to reach, for grids whose bound follows from that, too.
    """
    shares: list[tuple[TrigonometricPolynomial, Grid]] = []
    while len(shares) < groups and waves.multiples.size:
        chosen, expected = _promising(waves, box, effort, reached)
        part = waves if chosen.all() else waves.only(chosen)
        grid = grid_of(part, box, effort, expected)
        if grid is None or not chosen.any():
            break
        shares.append((part, grid))
        waves = waves.only(~chosen)
        if reached is not None:
            total = _TYPICAL * float(waves.sizes(box.farthest).sum())
            reached = Reached(total, total)
    return shares, waves


def _promising(
    waves: TrigonometricPolynomial, box: Box, effort: int, reached: Reached | None
) -> tuple[NDArray[np.bool_], Reached | None]:
    """Waves for the next grid, and what they reach; none where amplitudes promise no less."""
    spectra = Spectra.of(waves, box)
    used = waves.multiples != 0
    joints = [k for k, degree in enumerate(waves.degrees) if degree]
    total = best = float(spectra.sizes.sum())
    choice, expected = np.zeros(len(spectra.sizes), dtype=bool), reached
    axes = _axes(waves, box, reached, total)
    for count in range(len(joints) + 1):
        for left_out in itertools.combinations(joints, count):
            chosen = ~used[:, left_out].any(axis=1)
            spectrum = spectra(chosen)
            ways = [way.of_part(total, spectrum.total) for way in axes]
            promised = _promised(spectrum, ways, effort)[0] + total - spectrum.total
            if promised < best:
                best, choice = promised, chosen
                expected = reached and Reached(ways[0].reached, ways[-1].reached)
    return choice, expected
