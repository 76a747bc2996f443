"""The levels there are: one for each of `LEVEL_NAMES`, in the file of its name, as TERM in term.py."""

from __future__ import annotations

from importlib import import_module

from gd_analyze.errors import UsageError
from gd_analyze.simplification.level import Level
from gd_analyze.text import LEVEL_NAMES

LEVELS: dict[str, Level] = {
    name: getattr(import_module(f"gd_analyze.simplification.{name}"), name.upper()) for name in LEVEL_NAMES
}


def level_named(level: str | Level) -> Level:
    """Look a level up by its name."""
    if isinstance(level, Level):
        return level
    if level not in LEVELS:
        raise UsageError(
            "there is no such level", where="level", expected=", ".join(LEVELS), found=str(level)
        )
    return LEVELS[level]
