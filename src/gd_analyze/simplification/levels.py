"""The levels there are, and how to simplify at one."""

from __future__ import annotations

from dataclasses import dataclass

from gd_analyze.errors import UsageError
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.text import SINE_PRICE

# In the order of `text.LEVEL_NAMES`.
LEVELS: dict[str, Level] = {level.name: level for level in (ELEMENT, TERM, RECURSIVE, ENERGY)}


def level_named(level: str | Level) -> Level:
    """Look a level up by its name."""
    if isinstance(level, Level):
        return level
    if level not in LEVELS:
        expected = ", ".join(LEVELS)
        raise UsageError("there is no such level", where="level", expected=expected, found=str(level))
    return LEVELS[level]


@dataclass(frozen=True)
class SearchOptions:
    """How to simplify."""

    level: Level | None = None  # by default the one of fewest operations, of those promising for the arm
    refit: bool = False  # change kept coefficients to absorb what is dropped; level recursive always does
    # Multiplications and additions the model may take: the smallest multiple of the budget that allows it.
    operations: int | None = None
    thorough: bool = True  # search the integer program: seconds; dive into it only: tenths of a second
    write: bool = True  # spend tenths of a second on a program of few operations
    effort: float = 1.0  # a multiple of the usual, a minute at most; where it ends, the best so far is given
    # Of level recursive: changes on the way to a model; one goes on from the last, or back, and adds to it.
    way: list[Terms] | None = None
    sine_price: int = SINE_PRICE  # multiplications and additions that a sine or cosine counts as
    dearer: bool = False  # give what was found even where it takes more operations than the exact torque

    def __post_init__(self) -> None:
        level = None if self.level is None else level_named(self.level)
        object.__setattr__(self, "level", level)
        if self.refit and level is not None and not (level.has_torque_terms or level.always_refits):
            what, expected = f"{level.keeps} have no coefficients to refit", "level term, recursive or energy"
            raise UsageError(what, where="refit", expected=expected, found=f"level {level}")
        if not self.effort > 0.0:
            found = str(self.effort)
            raise UsageError("a search takes some effort", where="effort", expected="above 0", found=found)
        if self.sine_price < 0:
            found = str(self.sine_price)
            raise UsageError(
                "a sine costs something or nothing", where="sine_price", expected="0 or more", found=found
            )
        if self.operations is not None and self.operations < 0:
            raise UsageError("so few operations do not exist", where="operations", found=str(self.operations))
