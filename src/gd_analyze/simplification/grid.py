r"""Grids of positions that a polynomial of known degree cannot hide a large value between.

Let f be a trigonometric polynomial of degree d with |f| <= M on an interval of length 2 w < 2 pi around m,
and let psi run from 0 to pi in q = m + 2 arcsin(sin(w / 2) cos psi). Videnskii's inequality says |df/dpsi|
<= 2 d M. Applied to T_k(f / M), T_k the Chebyshev polynomials, of degree k d and magnitude 1, it says
|sin(k u) du/dpsi| <= 2 d for u = arccos(f / M) and every k, hence |du/dpsi| <= 2 d. So where |f| is M, u has
moved by at most 2 d h at the nearest of nodes that are no farther than h apart in psi:

    max |f| <= max over nodes |f| / cos(2 d h),   2 d h < pi / 2.

N nodes psi_j = (j - 1/2) pi / N have h = pi / (2 N). The full circle needs no psi: N equal steps, Bernstein's
inequality and the same factor 1 / cos(pi d / N). A sliding joint's variable q = m + w cos psi makes an
algebraic polynomial of degree d a trigonometric one of degree d in psi: 1 / cos(pi d / (2 N)). One joint
after the other gives the product of the factors for the tensor grid, since every step is about a polynomial
in one variable for any fixed values of the others.

V. S. Videnskii, Extremal estimates of the derivative of a trigonometric polynomial on an interval shorter
than the period, Dokl. Akad. Nauk SSSR 130 (1960); H. Ehlich, K. Zeller, Schwankung von Polynomen zwischen
Gitterpunkten, Math. Z. 86 (1964), for the idea; T. Erdelyi, Basic polynomial inequalities on intervals and
circular arcs, Constr. Approx. 39 (2014), for the inequality with the sine.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.simplification.box import Box
from gd_analyze.simplification.waves import Waves
from gd_analyze.vectors import FloatArray

# Nodes per joint and degree beyond which the factor, 1.0003, has nothing left to give.
_MOST_NODES = 64


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of every joint, and what the maximum over the box can exceed that over the grid by.

    Parameters
    ----------
    nodes
        Positions of every joint, rad (m).
    factor
        max over the box of |f| <= factor times max over the grid of |f|, for every polynomial f of the
        degrees the grid was made for.
    """

    nodes: tuple[FloatArray, ...]
    factor: float

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of nodes of every joint."""
        return tuple(len(node) for node in self.nodes)

    @property
    def size(self) -> int:
        """Number of positions."""
        return int(np.prod(self.counts))

    def positions(self, index: NDArray[np.int64]) -> FloatArray:
        """Positions by their number in row-major order, shape (n, K)."""
        places = np.unravel_index(index, self.counts)
        return np.stack([node[place] for node, place in zip(self.nodes, places, strict=True)])


def grid_of(box: Box, degrees: Sequence[int], sliding: Sequence[bool], effort: int) -> Grid | None:
    """Spread at most `effort` positions over a box; None where that is too few to bound anything."""
    plan = _plan(_orders(box, degrees, sliding), effort)
    if plan is None:
        return None
    counts, factor = plan
    nodes = tuple(_nodes(box.lower[k], box.upper[k], sliding[k], counts[k]) for k in range(len(counts)))
    return Grid(nodes, factor)


def grid_at(position: FloatArray) -> Grid:
    """One position, shape (n,): enough for what is the same everywhere."""
    return Grid(tuple(position[:, None]), 1.0)


def _orders(box: Box, degrees: Sequence[int], sliding: Sequence[bool]) -> list[int]:
    """Of a polynomial in psi: twice the degree for angles, the degree for sliding variables."""
    moving = (box.upper > box.lower).tolist()
    return [
        (d if slides else 2 * d) if moves else 0
        for d, slides, moves in zip(degrees, sliding, moving, strict=True)
    ]


def _plan(orders: Sequence[int], effort: int) -> tuple[list[int], float] | None:
    """Nodes per joint and the factor that they bring."""
    used = [order for order in orders if order]
    # The loss is least where every joint has nodes in proportion to its order.
    share = (effort / math.prod(used)) ** (1 / len(used)) if used else 1.0
    counts = [int(min(share, _MOST_NODES) * order) if order else 1 for order in orders]
    if any(count <= order for count, order in zip(counts, orders, strict=True) if order):
        return None
    return counts, math.prod(1 / math.cos(o * math.pi / (2 * n)) for o, n in zip(orders, counts, strict=True))


def _nodes(lower: float, upper: float, slides: bool, count: int) -> FloatArray:
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    if not slides and half >= np.pi:
        return np.asarray(middle + 2 * np.pi * np.arange(count) / count)
    across = np.cos((np.arange(count) + 0.5) * np.pi / count)
    return np.asarray(middle + (half * across if slides else 2 * np.arcsin(np.sin(half / 2) * across)))


@dataclass(frozen=True, eq=False)
class Share:
    """Some of a sum's waves, and the grid that bounds them."""

    waves: Waves
    grid: Grid


def shared_out(waves: Waves, box: Box, effort: int, groups: int) -> tuple[list[Share], Waves]:
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
    shares: list[Share] = []
    while len(shares) < groups and waves.multiples.size:
        chosen = _promising(waves, box, effort)
        if chosen is None:
            break
        part = waves.only(chosen)
        grid = grid_of(box, part.degrees, part.sliding, effort)
        if grid is None:
            break
        shares.append(Share(part, grid))
        waves = waves.only(~chosen)
    return shares, waves


def _promising(waves: Waves, box: Box, effort: int) -> NDArray[np.bool_] | None:
    """Waves for the next grid; None where amplitudes promise no less."""
    amplitudes = waves.sizes(box.farthest).sum(axis=0)
    total = best = float(amplitudes.sum())
    choice = None
    used = waves.multiples != 0
    joints = [k for k, degree in enumerate(waves.degrees) if degree]
    for count in range(len(joints) + 1):
        for left_out in itertools.combinations(joints, count):
            chosen = ~used[:, left_out].any(axis=1)
            degrees = np.abs(waves.multiples[chosen]).max(axis=0, initial=0).tolist()
            plan = _plan(_orders(box, degrees, waves.sliding), effort)
            if plan is None:
                continue
            inside = float(amplitudes[chosen].sum())
            # A sum of waves reaches about half of its amplitudes.
            promised = min(0.5 * plan[1], 1.0) * inside + total - inside
            if promised < best:
                best, choice = promised, chosen
    return choice
