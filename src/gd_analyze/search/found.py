"""What a search gives."""

from __future__ import annotations

from typing import NamedTuple

from gd_analyze.levels import SearchStep
from gd_analyze.levels.level import Terms
from gd_analyze.operations import Program


class Found(NamedTuple):
    """What a model is made of, and how it was found.

    Parameters
    ----------
    terms, program, refitted
        As of `gd_analyze.levels.SimplifiedModel`.
    steps, solved, cut_short
        As of `gd_analyze.levels.Promise`.
    """

    terms: Terms
    program: Program
    refitted: bool
    steps: tuple[SearchStep, ...]
    solved: bool = False
    cut_short: bool = False
