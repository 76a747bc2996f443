"""The levels there are: a new one is a file of its own and a line here."""

from __future__ import annotations

from gd_analyze.errors import UsageError
from gd_analyze.levels.element import ElementLevel
from gd_analyze.levels.energy import EnergyLevel
from gd_analyze.levels.level import Level
from gd_analyze.levels.term import TermLevel

ELEMENT, TERM, ENERGY = ElementLevel(), TermLevel(), EnergyLevel()

LEVELS: dict[str, Level] = {level.name: level for level in (ELEMENT, TERM, ENERGY)}


def level_named(level: str | Level) -> Level:
    """Look a level up by its name.

    Raises
    ------
    UsageError
        If there is none of that name.
    """
    if isinstance(level, Level):
        return level
    if level not in LEVELS:
        raise UsageError(
            "there is no such level", where="level", expected=", ".join(LEVELS), found=str(level)
        )
    return LEVELS[level]
