"""What a search gives."""

from __future__ import annotations

from typing import NamedTuple

from gd_analyze.operations.program import Program
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.level import Terms


class Found(NamedTuple):
    """What a model is made of, and how it was found.

    Parameters
    ----------
    terms, program, refitted
        As of `gd_analyze.simplification.model.SimplifiedModel`.
    steps, solved, cut_short
        As of `gd_analyze.simplification.accuracy.Accuracy`.
    """

    terms: Terms
    program: Program
    refitted: bool
    steps: tuple[SearchStep, ...]
    solved: bool = False
    cut_short: bool = False
