"""A lower bound on the smallest eigenvalue of a model's inertia matrix D over a box of positions.

For any fixed vector x, x^T D(q) x is a polynomial like the torque error, and its minimum over a box lies
below that over a grid by no more than its curvature allows between the nodes (`grid`). The losses of the
elements D_ij form a matrix whose norm bounds the loss for every x at once. The eigenvalues of an arm's D
differ a lot, as its last joints carry little, and a loss that is small for the first joint would swallow
them. So the bound is on K (D - shift 1) K^T with a K that makes a typical D - shift 1 the identity; if that
matrix has no eigenvalue below some b > 0, D has none below the shift plus b / |K|^2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of, expansion_of
from gd_analyze.certification.climbing import local_maximum
from gd_analyze.certification.error_field import round_off_of
from gd_analyze.certification.grid import Grid, shared_out
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.simplification.model import SimplifiedModel

# Positions: about 9 per angle for an arm like the PUMA 560, whose D depends on four angles.
EFFORT = 8_000
# Shares of the smallest eigenvalue found to try as the shift; the first that can be proven is taken.
_SHIFTS = (0.999, 0.99, 0.9, 0.0)
# Roundings of an eigenvalue, per joint.
_ROUNDINGS = 64
_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Definiteness:
    """Smallest eigenvalue of a model's D over a box, kg m^2 (if all joints are revolute)."""

    box: Box
    # No position of the box has a smaller one. If it is at most 0, D is not proven positive definite
    proven: float
    smallest_found: float  # smallest one found; the truth lies between
    position: FloatArray  # position of that, rad (m), shape (n,)
    round_off: float  # largest round-off of an eigenvalue found

    @property
    def is_proven(self) -> bool:
        """Whether D is proven positive definite over the whole box."""
        return self.proven > 0.0

    @property
    def is_singular(self) -> bool:
        """Whether an eigenvalue found is zero up to round-off, so that some motion has no inertia."""
        return abs(self.smallest_found) <= self.round_off


def certify_positive_definite(
    model: SimplifiedModel, box: Box | None = None, *, effort: int = EFFORT
) -> Definiteness:
    """Bound the smallest eigenvalue of a model's D from below over a box of positions.

    Parameters
    ----------
    model
        A mechanical system, such as a model of level "energy", whose D is symmetric.
    box
        The positions; the arm's own ranges by default.
    effort
        Most positions at which D is evaluated; the same effort gives the same result on any machine.

    Returns
    -------
    Definiteness
        Proven bound and smallest eigenvalue found.

    Raises
    ------
    ModelError
        If the model is no mechanical system.
    UsageError
        If the box is of another number of joints, or `effort` is not positive.
    """
    if not model.level.is_mechanical:
        raise ModelError(
            "only a model of the energies has a symmetric D",
            expected="a model of level energy",
            found=f"level {model.level}",
            next_step="make one with `gd-analyze simplify --level energy`",
        )
    box = box_of(box, model.arm, effort)
    inertia = _GriddedInertia.of(model, box, effort)
    smallest, position = inertia.smallest()
    found = Definiteness(box, -np.inf, smallest, position, inertia.round_off)
    proven = -np.inf
    # For an eigenvalue of zero K would consist of round-off.
    for share in () if found.is_singular else _SHIFTS:
        shift = smallest - (1.0 - share) * abs(smallest)
        proven = max(proven, inertia.proven_above(shift))
        if proven > shift:
            break
    if not proven > 0.0:
        proven = max(proven, inertia.proven_plainly())
    return replace(found, proven=float(proven))


@dataclass(frozen=True, eq=False)
class _GriddedInertia:
    """D over a box: harmonics bounded by a grid, the grid, and the most that others add to each element."""

    box: Box
    every: TrigonometricPolynomial
    gridded: TrigonometricPolynomial
    grid: Grid
    left_out: FloatArray

    @classmethod
    def of(cls, model: SimplifiedModel, box: Box, effort: int) -> _GriddedInertia:
        n = model.arm.n_joints
        # The factors of the accelerations in every row.
        expansion = expansion_of(model)
        every = TrigonometricPolynomial.stacked([row[1 : n + 1] for row in expansion.rows])
        # The constant part does not matter for the choice of a grid.
        constant = (every.multiples == 0).all(axis=1)
        shares, rest = shared_out(every.only(~constant), box, effort, groups=1)
        chosen = constant.copy()
        if shares:
            chosen |= (every.multiples[:, None] == shares[0][0].multiples).all(axis=2).any(axis=1)
        left_out = rest.sizes(box.farthest).sum(axis=1).reshape(n, n)
        roundings = expansion.round_off(box.farthest, np.zeros(n), np.ones(n))
        left_out += np.maximum(roundings, roundings[:, None]) + round_off_of(every, box)
        grid = shares[0][1] if shares else Grid.at(box.centre)
        left_out += grid.between(every.only(chosen), box).reshape(n, n)
        return cls(box, every, every.only(chosen), grid, left_out)

    def __call__(self, q: FloatArray) -> FloatArray:
        """Exact D at positions (n, K), shape (K, n, n)."""
        return _matrices(self.every(q))

    def _on_grid(self) -> Iterator[FloatArray]:
        return (_matrices(values) for values in self.gridded.on_grid(self.grid.nodes))

    @cached_property
    def _typical(self) -> FloatArray:
        """Mean of D over the grid."""
        return np.asarray(sum(d.sum(axis=0) for d in self._on_grid()) / self.grid.size)

    def smallest(self) -> tuple[float, FloatArray]:
        """Smallest eigenvalue that a search finds, and its position."""
        lows = np.concatenate([np.linalg.eigvalsh(d)[:, 0] for d in self._on_grid()])
        starts = self.grid.positions(np.array([lows.argmin()]))
        position, value = local_maximum(
            lambda q: np.asarray(-np.linalg.eigvalsh(self(q))[:, 0], dtype=float), self.box, starts
        )
        return -value, position

    def proven_above(self, shift: float) -> float:
        """Lower bound on all eigenvalues of D over the box, with one shift."""
        values, vectors = np.linalg.eigh(self._typical - shift * np.eye(len(self._typical)))
        # K exists only if the typical D lies above the shift.
        return self._proven((vectors / np.sqrt(values)).T, shift) if values[0] > 0.0 else -np.inf

    def proven_plainly(self) -> float:
        """Lower bound with K = 1: never far below the truth, nor close to a small eigenvalue."""
        return self._proven(np.eye(len(self._typical)), 0.0)

    @property
    def round_off(self) -> float:
        """Largest round-off of an eigenvalue of D."""
        return _ROUNDINGS * len(self._typical) * _EPS * self._reach(np.eye(len(self._typical)), 0.0)

    def _reach(self, k: FloatArray, shift: float) -> float:
        """Bound on the norm of |K| (|D| + |shift| 1) |K|^T in the box."""
        n = len(k)
        sizes = self.every.sizes(self.box.farthest).sum(axis=1).reshape(n, n) + abs(shift) * np.eye(n)
        return float(np.linalg.norm(np.abs(k) @ sizes @ np.abs(k).T, 2))

    def _proven(self, k: FloatArray, shift: float) -> float:
        unit = np.eye(len(k))
        low = min(np.linalg.eigvalsh(k @ (d - shift * unit) @ k.T)[:, 0].min() for d in self._on_grid())
        slack = np.linalg.norm(np.abs(k) @ self.left_out @ np.abs(k).T, 2)
        # Scaling and eigenvalues are off by some n eps of the largest, at worst times |K|^2 |D|.
        rough = _ROUNDINGS * len(k) * _EPS * self._reach(k, shift)
        bound = low - slack - rough
        stretch = np.linalg.eigvalsh(k.T @ k)
        # b K^-1 K^-T has no eigenvalue below b / (largest of K^T K), below b / (smallest) for negative b.
        below = bound / (stretch[-1] if bound > 0.0 else stretch[0])
        return float(shift + below - rough * (abs(shift) + abs(below)))


def _matrices(values: FloatArray) -> FloatArray:
    n = round(len(values) ** 0.5)
    return np.ascontiguousarray(values.T).reshape(-1, n, n)
