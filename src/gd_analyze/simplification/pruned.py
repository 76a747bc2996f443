"""Simplifying at level recursive: steps of the exact recursion are changed.

Of a motion the budget is kept near its set points, too, as all numbers are fitted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.effort import COUNTING, POINT, ROUGH, THOROUGH
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_model import exactly, measured
from gd_analyze.simplification.found import Found
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.near_states import joined_by_near_states
from gd_analyze.simplification.pruning import prune
from gd_analyze.simplification.recursion import Change
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search import Progress
from gd_analyze.simplification.search_options import SearchOptions

# Shares of a usual search's effort, a minute. For one of many searches, or one that is not thorough: hardly
# more than the first descent, which always ends. Otherwise seconds beyond it for six joints, 20 for seven, by
# this power of the number of joints.
_QUICK, _SIX_JOINTS, _POWER, _MOST = 1e-6, 0.06, 15, 0.6


def pruned(
    exact: ExactDynamics,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
    start: Mapping[Change, float] | None = None,
) -> Found:
    """Search for changes of the recursion, and write it in few operations."""
    usual = min(_SIX_JOINTS * (exact.arm.n_joints / 6) ** _POWER, _MOST)
    effort = how.effort * (usual if how.thorough else _QUICK)
    near = joined_by_near_states(exact)
    changes = prune(near, allowed, effort=effort, start=start, progress=progress)
    rough = RECURSIVE.write(exact.form, changes, ROUGH)
    program = RECURSIVE.write(exact.form, changes, THOROUGH if how.write else COUNTING)
    steps = [SearchStep("pruning", rough.count.total), SearchStep("rewriting", program.count.total)]
    return Found(changes, program, bool(changes), tuple(steps[: 2 if how.write else 1]))


def quick_count(exact: ExactDynamics, allowed: FloatArray) -> Callable[[float], int]:
    """Tell about how many operations multiples of a budget take; each goes on from the next smaller known."""
    known: dict[float, dict[Change, float]] = {0.0: {}}
    near = joined_by_near_states(exact)

    def count(factor: float) -> int:
        if factor not in known:
            start = known[max(smaller for smaller in known if smaller < factor)]
            known[factor] = prune(near, factor * allowed, effort=_QUICK, start=start)
        return RECURSIVE.write(exact.form, known[factor], ROUGH).count.total

    return count


def pruned_path(
    exact: ExactDynamics, allowed: Sequence[FloatArray], start: Mapping[Change, float] | None = None
) -> Iterator[SimplifiedModel]:
    """Change more and more for growing budgets, each time going on from what was changed before."""
    changes, near = dict(start or {}), joined_by_near_states(exact)
    for most in allowed:
        changes = prune(near, most, effort=_QUICK, start=changes)
        everything = exactly(exact, RECURSIVE, most, str(Budget.of_torques(most)))
        program = RECURSIVE.write(exact.form, changes, POINT)
        yield measured(exact, replace(everything, terms=changes, program=program, refitted=bool(changes)))
