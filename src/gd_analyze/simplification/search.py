"""The cheapest set of candidates within a budget: elimination, integer program, exchange, refit.

The integer program accounts for shared arithmetic by an estimate, and stops after some nodes. Exchange counts
operations: it drops one more candidate, or swaps it for a cheaper one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.angles import priced
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.candidates import Candidates, Elimination, Kept, candidates_of, eliminate
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH, Work
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel, Found
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.linear_programs import Refit, select

# A selection, shape (K,), and the factors of its coefficients, shape (K,), all 1 without refit.
Step = tuple[Kept, FloatArray]
# Operations of a selection with given factors of its coefficients.
Count = Callable[[Kept, FloatArray], int]
# Called with the number of candidates dropped since the last call.
Progress = Callable[[int], None] | None

# Share of the budget that a first sweep may use for candidates too small to weigh one by one.
_SWEEP_SHARE = 0.02
# Most selections that an exchange fits, and candidates it takes back per dropped one.
_TRIALS, _TAKEN_BACK = 200, 4
# Most candidates for which more than elimination is tried: minutes beyond.
_MOST = 1200
# Errors above this share of the budget indicate which candidate would help.
_HOT = 0.8


def search(
    candidates: Candidates,
    count: Count,
    *,
    refit: bool = False,
    thorough: bool = True,
    work: Work | None = None,
    progress: Progress = None,
) -> dict[str, Step]:
    """Find few candidates whose model is within the budget at every state; return the result of each step."""
    one = np.ones(len(candidates))
    tell, work = progress or (lambda _: None), work or Work()
    best = eliminate(candidates, work=work).within()
    tell(int((~best).sum()))
    steps = {"elimination": (best, one)}
    if len(best) > _MOST:
        work.was_short = True
        return steps
    programmed = _programmed(candidates, thorough, work)
    if count(programmed, one) < count(best, one):
        best = programmed
    steps["integer program" if thorough else "integer program, one descent"] = best, one
    best, _ = _exchanged(candidates, (best, one), None, count, work)
    steps["exchange"] = best, one
    if not refit:
        return steps
    refitting = Refit(candidates, work)
    first = refitting.within(best)
    starts = [None if first is None else (best, first)]
    starts.append(_refitted_start(eliminate(candidates, refit=True, work=work), refitting))
    found = [(best, one)]
    found += [_exchanged(candidates, start, refitting, count, work) for start in starts if start is not None]
    # The last of equal ones has been fitted.
    kept, scale = min(reversed(found), key=lambda one: count(*one))
    tell(int(best.sum()) - int(kept.sum()))
    steps["refit"] = kept, refitting.best(kept, scale)
    return steps


def _programmed(candidates: Candidates, thorough: bool, work: Work) -> Kept:
    """Keep the integer program's selection of the candidates that matter."""
    effects = candidates.effects
    kept = np.zeros(len(effects), dtype=bool)
    largest = np.abs(effects).max(axis=2, initial=0.0)
    order = np.argsort(largest.max(axis=1), kind="stable")
    together = np.cumsum(largest[order], axis=0).max(axis=1)
    matter = np.sort(order[together > _SWEEP_SHARE])
    if not len(matter):
        return kept
    place = {int(k): p for p, k in enumerate(matter)}
    costs: dict[frozenset[int], int] = {}
    for members, operations in candidates.costs.items():
        left = frozenset(place[k] for k in members if k in place)
        if left:
            costs[left] = costs.get(left, 0) + operations
    kept[matter] = select(effects[matter], 1.0 - _SWEEP_SHARE, costs, thorough=thorough, work=work)
    return kept


def _refitted_start(elimination: Elimination, refitting: Refit) -> Step | None:
    """Drop as many candidates, in the given order, as a refit can compensate."""
    few, many, found = -1, len(elimination.order) + 1, None
    while many - few > 1:
        middle = (few + many) // 2
        trial = elimination.kept(middle)
        scale = refitting.within(trial)
        if scale is None:
            many = middle
        else:
            few, found = middle, (trial, scale)
    return found


def _exchanged(
    candidates: Candidates, start: Step, refitting: Refit | None, count: Count, work: Work
) -> Step:
    """Drop one more candidate, or swap it for a cheaper one, while operations decrease."""
    kept, scale = start
    flat = candidates.flat
    size = np.maximum(np.einsum("ks,ks->k", flat, flat), np.finfo(float).tiny)
    needs = np.zeros((len(candidates.costs), len(flat)), dtype=bool)
    for row, members in zip(needs, candidates.costs, strict=True):
        row[list(members)] = True
    operations = np.array(list(candidates.costs.values()), dtype=float)

    def neighbours() -> Iterator[tuple[Kept, FloatArray]]:
        """Selections that should be cheaper, and errors: first with one dropped, then with one swapped."""
        error = (kept * scale - 1.0) @ flat
        harm = {int(k): float(np.abs(error - scale[k] * flat[k]).max()) for k in np.flatnonzero(kept)}
        leaving = sorted(harm, key=harm.__getitem__)
        for k in leaving:
            trial = kept.copy()
            trial[k] = False
            yield trial, error - scale[k] * flat[k]
        alone = (needs & kept).sum(axis=1) == 1
        saved = np.where(kept, (operations * alone) @ needs, 0.0)
        others = np.flatnonzero(~kept)
        for k in leaving:
            without = kept.copy()
            without[k] = False
            beyond = error - scale[k] * flat[k]
            hot = np.flatnonzero(np.abs(beyond) > _HOT)
            worth = (flat[np.ix_(others, hot)] @ beyond[hot]) ** 2 / size[others]
            unused = ~(needs & without).any(axis=1)
            added = (operations * unused) @ needs
            for j in others[np.argsort(-worth, kind="stable")[:_TAKEN_BACK]]:
                if added[j] < saved[k]:
                    trial = without.copy()
                    trial[j] = True
                    yield trial, beyond + flat[j]

    fewest, trials = count(kept, scale), _TRIALS
    while True:
        for trial, error in neighbours():
            if trials == 0 or not work.affords(0.0):
                return kept, scale
            trials -= 1
            if refitting is not None:
                fitted = refitting.within(trial)
            else:
                fitted = scale if np.abs(error).max(initial=0.0) <= 1.0 else None
            if fitted is not None and (found := count(trial, fitted)) < fewest:
                kept, scale, fewest = trial, fitted, found
                break
        else:
            return kept, scale


# Writing a program to count it takes as long as this many multiplications per term.
_WRITING = 3e5


def dropped(
    exact: ExactDynamics,
    level: CandidateLevel,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
) -> Found:
    """Search for the terms to keep; a TooManyTermsError if there are too many for a search."""
    candidates = candidates_of(exact, level, allowed, sine_price=how.sine_price)
    writing, work = COUNTING if how.thorough else ROUGH, Work(how.effort)

    def count(kept: Kept, scale: FloatArray) -> int:
        work.spend(_WRITING * int(kept.sum()))
        return priced(candidates.write(kept, scale, writing), how.sine_price)

    options = {"refit": how.refit, "thorough": how.thorough}
    found = search(candidates, count, **options, work=work, progress=progress)
    effort = THOROUGH if how.write else COUNTING
    written = {name: level.write(exact.form, candidates.keep(*step), effort) for name, step in found.items()}
    steps = tuple(SearchStep(name, program.count.total) for name, program in written.items())
    # The search counts roughly; the last of steps with equal operations has been fitted.
    best = min(reversed(written), key=lambda name: priced(written[name], how.sine_price))
    kept, scale = found[best]
    refitted = bool((scale[kept] != 1.0).any())
    return Found(candidates.keep(kept, scale), written[best], refitted, steps, work.was_short)


def quick_count(exact: ExactDynamics, level: CandidateLevel, allowed: FloatArray) -> Callable[[float], int]:
    """Estimate operations for multiples of a budget from one elimination."""
    candidates = candidates_of(exact, level, allowed)
    elimination, one = eliminate(candidates), np.ones(len(candidates))
    return lambda factor: candidates.write(elimination.within(factor), one, COUNTING).count.total
