"""Whether a torque error keeps a budget, and how much it counts where.

A budget per joint holds at every state. That of PSDM (Lloyd, Irani, Ahmadi 2021) is the norm of the torque
error over the norm of the torque, state by state, and a share of the states may break it.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.text import LARGEST, UNSIGNED

_NORM = re.compile(
    rf"(?P<share>{UNSIGNED})\s*%\s*(?:of\s+(?:the\s+)?)?norm"
    rf"(?:\s+at\s+(?:all|every|(?P<states>{UNSIGNED})\s*%)(?:\s+(?:of\s+(?:the\s+)?)?states?)?)?",
    re.IGNORECASE,
)


class NormShare(NamedTuple):
    """An error that is allowed to all joints together: norm of the torque error over norm of the torque.

    Joints that turn and joints that slide each have a norm; both must keep it.

    Parameters
    ----------
    share
        The share (1 % is 0.01).
    states
        Share of the states that must keep it, above 0; 1 where all must.
    """

    share: float
    states: float = 1.0

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1% norm" or "1% of norm at 95% of states"; None where it is nothing of this kind."""
        match = _NORM.fullmatch(text.strip())
        if match is None:
            return None
        share, states = float(match["share"]), float(match["states"] or 100.0)
        # 99.9 / 100 is not 0.999, but for the last digits.
        return (
            cls(share / 100, round(states / 100, 15)) if share <= LARGEST and 0.0 < states <= 100.0 else None
        )

    def __str__(self) -> str:
        where = "all states" if self.states == 1.0 else f"{self.states * 100:.12g}% of states"
        return f"{self.share * 100:.12g}% norm at {where}"


# Of PSDM's two figures: the share of the states that keep them.
USUAL_STATES = (0.95, 0.999)


class Measure(ABC):
    """What a budget makes of torque errors at given states."""

    @abstractmethod
    def share(self, error: FloatArray) -> float:
        """How much of the budget an error (n, N), N m, takes: it is kept where that is 1 or less."""

    @abstractmethod
    def weights(self, error: FloatArray) -> FloatArray:
        """How much squared errors count beside an error that is there, both (n, N): for fitting."""


@dataclass(frozen=True, eq=False)
class PeakMeasure(Measure):
    """The largest error of every joint, over what it is allowed.

    Parameters
    ----------
    allowed
        Allowed error of each joint, N m, shape (n,).
    counts
        How much an error counts, shape (N, n), see `gd_analyze.motions.states.States.weights`; None where
        all count
        alike.
    """

    allowed: FloatArray
    counts: FloatArray | None = None

    @cached_property
    def _whole(self) -> FloatArray:
        counts = np.ones((1, len(self.allowed))) if self.counts is None else self.counts
        return np.asarray(counts.T / self.allowed[:, None])

    def share(self, error: FloatArray) -> float:
        """Largest error of any joint at any state over what is allowed."""
        return float((np.abs(error) * self._whole).max(initial=0.0))

    def weights(self, error: FloatArray) -> FloatArray:
        """Alike at all states, but for what counts more there."""
        return np.broadcast_to(self._whole**2, error.shape)


@dataclass(frozen=True, eq=False)
class NormMeasure(Measure):
    """Norm of the torque error over norm of the torque, which most states must keep.

    Joints that turn and joints that slide have a norm each, as N m and N have no common one; the larger share
    counts.

    Parameters
    ----------
    allowed
        The share of the norm that is allowed.
    states
        Share of the states that must keep it; the others may err by whatever they do.
    torque
        Exact torque, N m (N), shape (n, N).
    turning
        Which joints turn, shape (n,).
    round_off
        Error of a joint that is only round-off, and counts as none, N m.
    """

    allowed: float
    states: float
    torque: FloatArray
    turning: NDArray[np.bool_]
    round_off: float = 0.0

    @cached_property
    def norms(self) -> FloatArray:
        """Norm of the torque of the joints that turn, and of those that slide, shape (1 or 2, N)."""
        return self._norms_of(self.torque)

    @property
    def exempt(self) -> int:
        """How many states may break the budget."""
        count = self.torque.shape[1]
        return count - kept_states(self.states, count)

    def shares(self, error: FloatArray) -> FloatArray:
        """Share of the norm at every state, shape (N,); infinite where only an error is."""
        counting = np.where(np.abs(error) <= self.round_off, 0.0, error)
        with np.errstate(divide="ignore", invalid="ignore"):
            each = self._norms_of(counting) / self.norms
        return np.where(np.isnan(each), 0.0, each).max(axis=0)

    def share(self, error: FloatArray) -> float:
        """The least share that enough states keep, over the allowed one."""
        least = share_at(self.shares(error), self.states)
        if self.allowed > 0.0:
            return least / self.allowed
        return math.inf if least > 0.0 else 0.0

    def weights(self, error: FloatArray) -> FloatArray:
        """By the norm of the torque; states beyond what enough keep count no more than the last of these."""
        shares = self.shares(error)
        most = float(shares[np.isfinite(shares)].max(initial=0.0))
        limit = max(min(share_at(shares, self.states), most), self.allowed)
        with np.errstate(divide="ignore", invalid="ignore"):
            tame = np.minimum(1.0, np.where(shares > 0.0, limit / shares, 1.0))
        # Where a torque is next to nothing, nothing is to be gained by an error next to nothing.
        least = np.finfo(float).eps * self.norms.max(axis=1, initial=0.0, keepdims=True)
        whole = np.maximum(limit * np.maximum(self.norms, least), np.finfo(float).tiny)
        return np.asarray((tame / whole[self.group]) ** 2)

    @cached_property
    def group(self) -> NDArray[np.intp]:
        """Which norm each joint belongs to, shape (n,)."""
        return np.unique(~self.turning, return_inverse=True)[1]

    def _norms_of(self, torque: FloatArray) -> FloatArray:
        groups = range(int(self.group.max()) + 1)
        return np.array([np.linalg.norm(torque[self.group == g], axis=0) for g in groups])


def kept_states(share: float, count: int) -> int:
    """How many of so many states a share of them is at least: 95 % of 4000 are 3800."""
    # 0.95 and products with it are rounded: what is a whole number but for that is that number.
    return min(math.ceil(round(share * count, 6)), count)


def share_at(shares: FloatArray, states: float) -> float:
    """The least share that such a part of the states keep, of shares (N,) of norms."""
    last = kept_states(states, len(shares)) - 1
    return float(np.partition(shares, last)[last])
