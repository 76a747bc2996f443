"""How to simplify."""

from __future__ import annotations

from dataclasses import dataclass

from gd_analyze.errors import UsageError
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import level_named


@dataclass(frozen=True)
class SearchOptions:
    """How to simplify."""

    # A name of `gd_analyze.text.LEVEL_NAMES`, or the level itself; by default the one that takes the fewest
    # operations of those that are promising for the arm
    level: Level | None = None
    refit: bool = False  # change kept coefficients to absorb what is dropped; level recursive always does
    # Multiplications and additions the model may take: the budget is then scaled, for all joints alike, to
    # the smallest that so many allow
    operations: int | None = None
    # Search the integer program; dive into it only otherwise: tenths of a second instead of seconds
    thorough: bool = True
    write: bool = True  # spend tenths of a second on a program of few operations, as for all that is shown
    # How much to do, as a multiple of the usual: about a minute at most. Where it ends, the best so far is
    # given, and said to be that
    effort: float = 1.0
    # Give what was found even where the exact torque takes no more operations: to see what matters
    dearer: bool = False

    def __post_init__(self) -> None:
        level = None if self.level is None else level_named(self.level)
        object.__setattr__(self, "level", level)
        if self.refit and level is not None and not (level.has_torque_terms or level.always_refits):
            raise UsageError(
                f"{level.keeps} have no coefficients to refit",
                where="refit",
                expected="level term, recursive or energy",
                found=f"level {level}",
            )
        if not self.effort > 0.0:
            raise UsageError(
                "a search takes some effort", where="effort", expected="above 0", found=f"{self.effort}"
            )
        if self.operations is not None and self.operations < 0:
            raise UsageError("so few operations do not exist", where="operations", found=str(self.operations))
