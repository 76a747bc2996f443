"""A budget of the norm: one for all joints together, at most of the states."""

from __future__ import annotations

import re
from typing import NamedTuple, Self

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
