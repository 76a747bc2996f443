"""A budget of the norm, as of PSDM (Lloyd, Irani, Ahmadi 2021): one for all joints, and for most states."""

from __future__ import annotations

import math
import re
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
# Of PSDM's two figures: the share of the states that keep them.
USUAL_STATES = (0.95, 0.999)


class NormShare(NamedTuple):
    """An error that is allowed to all joints together: norm of the torque error over norm of the torque.

    Revolute and prismatic joints each have a norm; both must keep it.
    """

    share: float  # the share (1 % is 0.01)
    states: float = 1.0  # share of the states that must keep it, above 0; 1 where all must

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1% norm" or "1% of norm at 95% of states"; None where it is nothing of this kind."""
        match = _NORM.fullmatch(text.strip())
        if match is None:
            return None
        share, states = float(match["share"]), float(match["states"] or 100.0)
        if share > LARGEST or not 0.0 < states <= 100.0:
            return None
        return cls(share / 100, round(states / 100, 15))  # 99.9 / 100 is not 0.999, but for the last digits

    def __str__(self) -> str:
        where = "all states" if self.states == 1.0 else f"{self.states * 100:.12g}% of states"
        return f"{self.share * 100:.12g}% norm at {where}"


@dataclass(frozen=True, eq=False)
class NormMeasure:
    """Norm of the torque error over norm of the torque, which most states must keep.

    Revolute and prismatic joints have a norm each, as N m and N have no common one; the larger share counts.
    """

    allowed: float  # share of the norm
    states: float  # share of the states that must keep it; the others may err by whatever they do
    torque: FloatArray  # exact, N m (N), shape (n, N)
    revolute: NDArray[np.bool_]  # (n,)
    round_off: float = 0.0  # errors up to this, N m, count as none

    @cached_property
    def norms(self) -> FloatArray:
        """Norm of the torque of the revolute joints, and of the prismatic ones, shape (1 or 2, N)."""
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
        """The least share that enough states keep, over the allowed one: kept up to 1."""
        least = share_at(self.shares(error), self.states)
        if self.allowed > 0.0:
            return least / self.allowed
        return math.inf if least > 0.0 else 0.0

    @cached_property
    def group(self) -> NDArray[np.intp]:
        """Which norm each joint belongs to, shape (n,)."""
        return np.unique(~self.revolute, return_inverse=True)[1]

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
