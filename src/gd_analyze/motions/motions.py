"""Which set points of a trajectory are which motion, where it consists of several."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Motion:
    """One of several motions that a trajectory consists of.

    Parameters
    ----------
    name
        Different from those of the others.
    first, end
        Its set points, from 0: `first` is the first of them, `end` the first that is not.
    start
        Instant of its first set point by its own clock, s.
    origin, rates_from, fingerprint
        Of the motion by itself, see `gd_analyze.motions.trajectory.Trajectory`.
    """

    name: str
    first: int
    end: int
    start: float = 0.0
    origin: str = ""
    rates_from: str = "given"
    fingerprint: str = ""

    @property
    def rows(self) -> slice:
        """Its set points."""
        return slice(self.first, self.end)

    @property
    def n_set_points(self) -> int:
        """How many."""
        return self.end - self.first


def listed(motions: Iterable[Motion]) -> str:
    """Name them, comma-separated; a comma in a name is left out."""
    return ", ".join(motion.name.replace(",", " ") for motion in motions)


def in_words(names: tuple[str, ...] | list[str], most: int = 4) -> str:
    """Say how many motions, and their names where these are few: "2 motions (a, b)"."""
    told = f" ({', '.join(names)})" if len(names) <= most else ""
    return f"{len(names)} motions{told}"
