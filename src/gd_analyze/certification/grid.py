r"""Grids of positions that a polynomial of known curvature cannot hide a large value between.

Let G_k be the largest |f| when joints 1..k are at nodes and the others anywhere in the box, so that G_0 is
the maximum over the box and G_n that over the grid. Where G_{k-1} is reached, |f| is largest along joint k.
With nodes evenly spaced from end to end one lies within h of that place, h half the spacing. Either the place
is an end, and a node, or f has no slope there, so that by Taylor's theorem f at the node is less by at most
h^2 / 2 times the largest second derivative K_k. Hence

    max over the box |f| <= max over the grid |f| + sum_k h_k^2 K_k / 2.

The amplitudes of the waves bound K_k: sum_w |C_w| m_wk^2. All this holds as well for the largest of many such
f, as the error is over all rates and accelerations, if K_k bounds all of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.certification.box import Box
from gd_analyze.harmonics import Waves
from gd_analyze.vectors import FloatArray

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
    """

    nodes: tuple[FloatArray, ...]
    reaches: FloatArray

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

    def between(self, waves: Waves, box: Box) -> FloatArray:
        """What every polynomial can gain between the nodes, shape (P,)."""
        return np.asarray(waves.curvatures(box.farthest).sum(axis=1) @ (self.reaches**2 / 2))


def grid_of(waves: Waves, box: Box, effort: int) -> Grid | None:
    """Spread at most `effort` positions over a box; None where two ends per joint are more than that."""
    axes = _Axes.of(waves, box)
    curvatures = waves.curvatures(box.farthest).sum(axis=(0, 1))
    gaps = axes.gaps(np.array(waves.degrees) > 0, curvatures, float(waves.sizes(box.farthest).sum()), effort)
    if gaps is None:
        return None
    nodes = []
    for k, count in enumerate(gaps):
        if not count:
            nodes.append(box.centre[k : k + 1])
        elif axes.circle[k]:
            nodes.append(box.lower[k] + 2 * np.pi * np.arange(count) / count)
        else:
            nodes.append(np.linspace(box.lower[k], box.upper[k], count + 1))
    return Grid(tuple(nodes), axes.reaches(gaps))


@dataclass(frozen=True, eq=False)
class _Axes:
    """Half of every joint's range, at most half a turn, and whether it is the full circle, shape (n,)."""

    half: FloatArray
    circle: NDArray[np.bool_]

    @classmethod
    def of(cls, waves: Waves, box: Box) -> _Axes:
        half, turning = (box.upper - box.lower) / 2, ~np.array(waves.sliding)
        circle = turning & (half >= np.pi)
        return cls(np.where(circle, np.pi, half), circle)

    def reaches(self, gaps: Sequence[int]) -> FloatArray:
        """Half the spacing; 0 where a joint does not matter or has no range."""
        return np.asarray(np.where(np.array(gaps) > 0, self.half / np.maximum(gaps, 1), 0.0))

    def gaps(
        self, matters: NDArray[np.bool_], curvatures: FloatArray, sizes: float, effort: int
    ) -> list[int] | None:
        """Gaps between the nodes of every joint, 0 where one node does.

        The loss is half of (order / gaps)^2, added up, of the maximum; under a limit on the product of the
        gaps it is least with gaps in proportion to the orders.
        """
        orders = (self.half * np.sqrt(curvatures / (_TYPICAL * sizes or 1.0))).tolist()
        # What is linear in a sliding joint has no curvature, and its maximum at an end.
        moving = (matters & (self.half > 0.0)).tolist()
        ends = (~self.circle).astype(int).tolist()

        def gaps_of(share: float) -> list[int]:
            return [max(1, int(share * o)) if moves else 0 for o, moves in zip(orders, moving, strict=True)]

        def positions(gaps: list[int]) -> int:
            return math.prod(gap + end if gap else 1 for gap, end in zip(gaps, ends, strict=True))

        low, high = 0.0, _MOST_GAPS
        for _ in range(16):
            middle = (low + high) / 2
            low, high = (middle, high) if positions(gaps_of(middle)) <= effort else (low, middle)
        gaps = gaps_of(low)
        return gaps if positions(gaps) <= effort else None


def shared_out(waves: Waves, box: Box, effort: int, groups: int) -> tuple[list[tuple[Waves, Grid]], Waves]:
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
    """
    shares: list[tuple[Waves, Grid]] = []
    while len(shares) < groups and waves.multiples.size:
        chosen = _promising(waves, box, effort)
        part = waves.only(chosen)
        grid = grid_of(part, box, effort)
        if grid is None or not chosen.any():
            break
        shares.append((part, grid))
        waves = waves.only(~chosen)
    return shares, waves


def _promising(waves: Waves, box: Box, effort: int) -> NDArray[np.bool_]:
    """Waves for the next grid; none where amplitudes promise no less."""
    sizes = waves.sizes(box.farthest).sum(axis=0)
    curvatures = waves.curvatures(box.farthest).sum(axis=0)
    used, axes = waves.multiples != 0, _Axes.of(waves, box)
    joints = [k for k, degree in enumerate(waves.degrees) if degree]
    total = best = float(sizes.sum())
    choice = np.zeros(len(sizes), dtype=bool)
    for count in range(len(joints) + 1):
        for left_out in itertools.combinations(joints, count):
            chosen = ~used[:, left_out].any(axis=1)
            inside, curved = float(sizes[chosen].sum()), curvatures[chosen].sum(axis=0)
            gaps = axes.gaps(used[chosen].any(axis=0), curved, inside, effort)
            if gaps is None:
                continue
            between = float(curved @ (axes.reaches(gaps) ** 2 / 2))
            promised = min(_TYPICAL * inside + between, inside) + total - inside
            if promised < best:
                best, choice = promised, chosen
    return choice
