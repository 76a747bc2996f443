"""The levels by name."""

from __future__ import annotations

from gd_analyze.arguments import require_word
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.level import Level

# In the order of `text.LEVEL_NAMES`.
LEVELS: dict[str, Level] = {level.name: level for level in (TERM, ELEMENT, ENERGY)}


def level_named(level: str | Level) -> Level:
    """Find a level by its name."""
    if isinstance(level, Level):
        return level
    require_word(level, LEVELS, "level")
    return LEVELS[level]
