"""A lower bound on the smallest eigenvalue of a model's mass matrix D over a box, or boxes, of positions.

D is evaluated on a grid; the norm of its elements' largest change between the nodes bounds the loss of an
eigenvalue. Both refer to K (D - shift 1) K^T, with a K that makes this the identity at a typical D.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.certification.error_field import local_maximum, polynomial_round_off
from gd_analyze.certification.grid import Grid, shared_out
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import Expansion
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.threads import one_thread

# Positions: about 9 per angle for an arm like the PUMA 560, whose D depends on four angles.
INERTIA_POSITIONS = 8_000

_MOST_BOXES = 32  # most boxes around the pieces of a tube, a few more if it has gaps: each takes 5 ms
# Shares of the smallest eigenvalue found to try as the shift; the first that can be proven is taken.
_SHIFTS: tuple[float, ...] = (0.999, 0.99, 0.9, 0.0)
_ROUNDINGS_PER_JOINT = 64  # roundings of an eigenvalue, per joint

_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Definiteness:
    """Smallest eigenvalue of a model's D over positions, kg m^2 (if all joints are revolute)."""

    box: Box  # the positions, or the smallest box around those of a tube
    proven: float  # lower bound
    smallest_found: float  # smallest one found; the truth lies between
    position: FloatArray  # position of that, rad (m), shape (n,)
    round_off: float  # largest round-off of an eigenvalue found

    @property
    def is_proven(self) -> bool:
        """Whether D is proven positive definite at all positions."""
        return self.proven > 0.0

    @property
    def is_singular(self) -> bool:
        """Whether an eigenvalue found is zero up to round-off, so that some motion has no inertia."""
        return abs(self.smallest_found) <= self.round_off


@one_thread()
def certify_positive_definite(
    model: SimplifiedModel, region: Box | Tube | None = None, *, effort: int = INERTIA_POSITIONS
) -> Definiteness:
    """Bound the smallest eigenvalue of a model's D from below over a box of positions, or along a motion.

    Parameters
    ----------
    model
        A model with a symmetric D, such as one of level "term" or "energy".
    region
        The positions: a box, or those of a tube, around whose pieces boxes are laid; by default the arm's
        ranges.
    effort
        Most positions at which D is evaluated, at least one in each box; the same effort gives the same
        result on any machine.

    Returns
    -------
    Definiteness
        Proven bound and smallest eigenvalue found, kg m^2 for revolute joints.

    Raises
    ------
    ModelError
        If the model's D is not symmetric by construction.
    UsageError
        If the region has another number of joints, or `effort` is not positive.
    """
    require_model(model)
    if not model.has_terms:
        raise ModelError(
            "only a model of terms has a symmetric D",
            expected="a model of level term or energy",
            found=f"level {model.level}",
            next_step="make one with `gd-analyze simplify --level term`",
        )
    box, n = box_of(region, model.arm, effort), model.arm.n_joints
    expansion = model.expansion
    # The factors of the accelerations in every row.
    inertia = TrigonometricPolynomial.stacked([row[1 : n + 1] for row in expansion.rows])
    boxes = [box]
    if isinstance(region, Tube):
        boxes = _boxes_around(region, -(-len(region) // _MOST_BOXES))
    gridded = [_GriddedInertia.of(expansion, inertia, part, max(1, effort // len(boxes))) for part in boxes]
    if isinstance(region, Tube):
        pieces = _boxes_around(region, 1)
        starts = np.stack([piece.centre for piece in pieces], axis=1)
        lowest = int(_smallest(inertia(starts)).argmin())
        start_box, start = pieces[lowest], starts[:, [lowest]]
    else:
        start_box, start = box, gridded[0].lowest
    position, highest = local_maximum(lambda q: -_smallest(inertia(q)), start_box, start)
    smallest = -highest
    unit = np.eye(n)
    round_off = _ROUNDINGS_PER_JOINT * n * _EPS * max(part.reach(unit, 0.0) for part in gridded)
    proven = -np.inf
    # For an eigenvalue of zero K would consist of round-off.
    for share in () if abs(smallest) <= round_off else _SHIFTS:
        shift = smallest - (1.0 - share) * abs(smallest)
        proven = max(proven, min(part.proven_above(shift) for part in gridded))
        if proven > shift:
            break
    if not proven > 0.0:
        # K = 1 is never far below the truth, nor close to a small eigenvalue.
        proven = max(proven, min(part.proven(unit, 0.0) for part in gridded))
    return Definiteness(box, proven, smallest, position, round_off)


def _boxes_around(tube: Tube, count: int) -> list[Box]:
    """Boxes of positions, each around at most `count` pieces of a tube that follow without a gap."""
    starts = np.flatnonzero(np.append(True, tube.begin[1:] != tube.end[:-1])).tolist()
    firsts = [first for start, end in pairwise([*starts, len(tube)]) for first in range(start, end, count)]
    lower = np.minimum.reduceat(tube.lower[:, 0], firsts)
    upper = np.maximum.reduceat(tube.upper[:, 0], firsts)
    still = np.zeros(tube.n_joints)
    return [Box(*ends, still, still) for ends in zip(lower, upper, strict=True)]


@dataclass(frozen=True, eq=False)
class _GriddedInertia:
    """D over a box: harmonics bounded by a grid, the grid, and the bound on others by element."""

    box: Box
    inertia: TrigonometricPolynomial
    gridded: TrigonometricPolynomial
    grid: Grid
    left_out: FloatArray  # (n, n)

    @classmethod
    def of(
        cls, expansion: Expansion, inertia: TrigonometricPolynomial, box: Box, effort: int
    ) -> _GriddedInertia:
        n = box.n_joints
        # The constant part does not matter for the choice of a grid.
        chosen = (inertia.multiples == 0).all(axis=1)
        shares, remainder = shared_out(inertia.only(~chosen), box, effort, groups=1)
        grid = Grid.at(box.centre)
        if shares:
            ((part, grid),) = shares
            chosen |= (inertia.multiples[:, None] == part.multiples).all(axis=2).any(axis=1)
        gridded = inertia.only(chosen)
        roundings = expansion.round_off(box.farthest, np.zeros(n), np.ones(n))
        left_out = (remainder.sizes(box.farthest).sum(axis=1) + grid.between(gridded, box)).reshape(n, n)
        left_out += np.maximum(roundings, roundings[:, None]) + polynomial_round_off(inertia, box)
        return cls(box, inertia, gridded, grid, left_out)

    @property
    def lowest(self) -> FloatArray:
        """Node with the smallest eigenvalue, shape (n, 1)."""
        values = np.concatenate([_smallest(values) for values in self._values()])
        return self.grid.positions(np.array([values.argmin()]))

    def on_grid(self) -> Iterator[FloatArray]:
        """D of its harmonics on the grid, in pieces of shape (K, n, n)."""
        return (_matrices(values) for values in self._values())

    def _values(self) -> Iterator[FloatArray]:
        return self.gridded.on_grid(self.grid.nodes)

    def proven_above(self, shift: float) -> float:
        """Lower bound on all eigenvalues of D, close where they exceed the shift; -inf if none is found."""
        total = sum(d.sum(axis=0) for d in self.on_grid())
        typical = np.asarray(total / self.grid.size)
        values, vectors = np.linalg.eigh(typical - shift * np.eye(len(typical)))
        # K exists only if the typical D lies above the shift.
        return self.proven((vectors / np.sqrt(values)).T, shift) if values[0] > 0.0 else -np.inf

    def reach(self, k: FloatArray, shift: float) -> float:
        """Bound on the norm of |K| (|D| + |shift| 1) |K|^T in the box."""
        n = len(k)
        sizes = self.inertia.sizes(self.box.farthest).sum(axis=1).reshape(n, n) + abs(shift) * np.eye(n)
        return float(np.linalg.norm(np.abs(k) @ sizes @ np.abs(k).T, 2))

    def proven(self, k: FloatArray, shift: float) -> float:
        """Lower bound on all eigenvalues of D: the shift, plus that of K (D - shift 1) K^T over |K|^2."""
        unit = np.eye(len(k))
        low = min(np.linalg.eigvalsh(k @ (d - shift * unit) @ k.T)[:, 0].min() for d in self.on_grid())
        slack = np.linalg.norm(np.abs(k) @ self.left_out @ np.abs(k).T, 2)
        # Scaling and eigenvalues have errors of some n eps of the largest, at worst times |K|^2 |D|.
        rounding = _ROUNDINGS_PER_JOINT * len(k) * _EPS * self.reach(k, shift)
        bound = low - slack - rounding
        stretch = np.linalg.eigvalsh(k.T @ k)
        # b K^-1 K^-T has no eigenvalue below b / (largest of K^T K), below b / (smallest) for negative b.
        gap = bound / (stretch[-1] if bound > 0.0 else stretch[0])
        return float(shift + gap - rounding * (abs(shift) + abs(gap)))


def _smallest(values: FloatArray) -> FloatArray:
    """Smallest eigenvalue of matrices by element (n^2, K), shape (K,)."""
    return np.asarray(np.linalg.eigvalsh(_matrices(values))[:, 0], dtype=float)


def _matrices(values: FloatArray) -> FloatArray:
    """Matrices (K, n, n) of values by element (n^2, K)."""
    n = round(len(values) ** 0.5)
    return np.ascontiguousarray(values.T).reshape(-1, n, n)
