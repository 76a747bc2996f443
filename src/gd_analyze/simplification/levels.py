"""The levels, and the options of a search."""

from __future__ import annotations

import math
import numbers
from dataclasses import dataclass

from gd_analyze.arguments import require_flags_of, require_word
from gd_analyze.errors import UsageError, require_type
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.level import Level
from gd_analyze.text import SINE_PRICE

# Those that can be asked for, in the order of `text.LEVEL_NAMES`.
LEVELS: dict[str, Level] = {level.name: level for level in (TERM, ELEMENT, ENERGY)}


def level_named(level: str | Level) -> Level:
    """Find a level by its name."""
    if isinstance(level, Level):
        return level
    require_word(level, LEVELS, "level")
    return LEVELS[level]


@dataclass(frozen=True)
class SearchOptions:
    """Options of a search."""

    level: Level = TERM
    thorough: bool = True  # attempts after the first descent; without them, the descent alone
    effort: float = 1.0  # number of attempts, relative to the usual
    same_velocities: bool = False  # keep the velocities in which the terms of the exact dynamics are
    most_terms: float = math.inf  # of a model over a region: the first search that ends with more is the last
    sine_price: int = SINE_PRICE  # multiplications and additions that a sine or cosine counts as

    def __post_init__(self) -> None:
        require_flags_of(self)
        level = level_named(self.level)
        object.__setattr__(self, "level", level)
        for name, kind, expected in (
            ("effort", numbers.Real, "a number above 0"),
            ("sine_price", numbers.Real, "a number of operations"),
        ):
            require_type(getattr(self, name), kind, name, expected)
        if not self.effort > 0.0:
            value = str(self.effort)
            raise UsageError("the effort is not positive", where="effort", expected="above 0", found=value)
        if self.sine_price < 0:
            value = str(self.sine_price)
            raise UsageError("the price is negative", where="sine_price", expected="0 or more", found=value)
