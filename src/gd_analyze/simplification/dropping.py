"""Simplifying at a level of candidates: some of the exact dynamics' terms are dropped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.candidates import Kept, candidates_of
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.found import Found
from gd_analyze.simplification.level import CandidateLevel
from gd_analyze.simplification.search import Progress, search
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.work import Work

# Writing a program to count it takes as long as so many multiplications for each term.
_WRITING = 3e5


def dropped(
    exact: ExactDynamics,
    level: CandidateLevel,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
) -> Found:
    """Search for the terms to be kept.

    Raises
    ------
    TooManyTermsError
        If there are more terms than a search can weigh.
    """
    candidates = candidates_of(exact, level, allowed)
    writing, work = COUNTING if how.thorough else ROUGH, Work(how.effort)

    def count(kept: Kept, scale: FloatArray) -> int:
        work.spend(_WRITING * int(kept.sum()))
        return candidates.count(kept, scale, writing).total

    found, solved = search(
        candidates, count, refit=how.refit, thorough=how.thorough, work=work, progress=progress
    )
    effort = THOROUGH if how.write else COUNTING
    written = {name: level.write(exact.form, candidates.keep(*step), effort) for name, step in found.items()}
    steps = tuple(SearchStep(name, program.count.total) for name, program in written.items())
    # The search counts roughly; of steps that take as many operations the last has been fitted.
    best = min(reversed(steps), key=lambda step: step.operations).name
    kept, scale = found[best]
    refitted = bool((scale[kept] != 1.0).any())
    return Found(candidates.keep(kept, scale), written[best], refitted, steps, solved, work.was_short)


def quick_count(exact: ExactDynamics, level: CandidateLevel, allowed: FloatArray) -> Callable[[float], int]:
    """Tell about how many operations multiples of a budget take, from one elimination."""
    candidates = candidates_of(exact, level, allowed)
    elimination, one = eliminate(candidates), np.ones(len(candidates))
    return lambda factor: candidates.count(elimination.within(factor), one, COUNTING).total
