"""The cheapest set of candidates within a budget: elimination, integer program, exchange, refit.

Elimination always ends and is the start. The integer program knows which arithmetic candidates share and
often proves its selection cheapest, but may be endless, so it stops after some nodes. Exchange tries what
neither did: to drop one more, or one for another that is cheaper. With a refit every trial fits what is kept
anew, and fewer candidates may then do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.candidates import Candidates, Kept, candidates_of
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH, Work
from gd_analyze.simplification.elimination import Elimination, eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel, Found
from gd_analyze.simplification.refit import Refit, share_coefficients
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.selection import select

# A selection, shape (K,), and the factors of its coefficients, shape (K,), all 1 without refit.
Step = tuple[Kept, FloatArray]
# Operations of a selection with given factors of its coefficients.
Count = Callable[[Kept, FloatArray], int]
# Factors with which a selection is within the budget, None if there are none; given the selection and the
# error, over allowed, that it has with the factors before.
Fit = Callable[[Kept, FloatArray], FloatArray | None]
# Told the number of candidates dropped since the last call.
Progress = Callable[[int], None] | None

# Of the budget, what a first sweep may spend on candidates too small to weigh one by one.
_SWEEP_SHARE = 0.02
# Selections an exchange may try to fit, and candidates it may take back for each that goes.
_TRIALS, _TAKEN_BACK = 200, 4
# Candidates up to which more than elimination is tried: minutes, beyond.
_MOST = 1200
# Errors above this share of the budget tell which candidate would help.
_HOT = 0.8


def search(
    candidates: Candidates,
    count: Count,
    *,
    refit: bool = False,
    thorough: bool = True,
    work: Work | None = None,
    progress: Progress = None,
) -> tuple[dict[str, Step], bool]:
    """Find few candidates whose model is within the budget at every state.

    Returned is what was kept after every step, and the factors then: the last is what was found; and whether
    the integer program ended: of the candidates that matter no selection without refit takes fewer
    operations, as `Candidates.costs` count them. If not `thorough` it is only descended once. Where `work`
    ends, the best so far is what was found; `progress` is called with the number of candidates dropped.
    """
    one = np.ones(len(candidates))
    tell, work = progress or (lambda _: None), work or Work()
    if candidates.level.is_priced_exactly:
        kept, solved = select(candidates.effects, 1.0, candidates.costs, work=work)
        return {"integer program": (kept, one)}, solved
    best = eliminate(candidates, work=work).within()
    tell(int((~best).sum()))
    steps = {"elimination": (best, one)}
    if len(best) > _MOST:
        work.was_short = True
        return steps, False
    programmed, solved = _programmed(candidates, thorough, work)
    if count(programmed, one) < count(best, one):
        best = programmed
    steps["integer program" if thorough else "integer program, one descent"] = best, one
    if not solved:
        best, _ = _exchanged(candidates, best, one, _unchanged, count, work)
        steps["exchange"] = best, one
    if not refit:
        return steps, solved
    fit = _refitted(candidates, work)
    found = [(best, one)]
    first = fit(best, np.zeros(0))
    for start in (
        (best, first) if first is not None else None,
        _refitted_start(eliminate(candidates, refit=True, work=work), fit),
    ):
        if start is not None:
            found.append(_exchanged(candidates, *start, fit, count, work))
    # Of equal ones the last: it has been fitted.
    kept, scale = min(reversed(found), key=lambda one: count(*one))
    tell(int(best.sum()) - int(kept.sum()))
    steps["refit"] = kept, scale
    tied, scale = share_coefficients(candidates, kept, scale, count, work)
    if tied is not candidates:
        kept, scale = _exchanged(tied, kept, scale, _refitted(tied, work), count, work)
    steps["shared coefficients"] = kept, Refit(tied, work).best(kept, otherwise=scale)
    return steps, solved


def _programmed(candidates: Candidates, thorough: bool, work: Work) -> tuple[Kept, bool]:
    """Keep what the integer program keeps of the candidates that matter."""
    effects = candidates.effects
    kept = np.zeros(len(effects), dtype=bool)
    largest = np.abs(effects).max(axis=2, initial=0.0)
    order = np.argsort(largest.max(axis=1), kind="stable")
    together = np.cumsum(largest[order], axis=0).max(axis=1)
    matter = np.sort(order[together > _SWEEP_SHARE])
    if not len(matter):
        return kept, True
    place = {int(k): p for p, k in enumerate(matter)}
    costs: dict[frozenset[int], int] = {}
    for members, operations in candidates.costs.items():
        left = frozenset(place[k] for k in members if k in place)
        if left:
            costs[left] = costs.get(left, 0) + operations
    kept[matter], optimal = select(effects[matter], 1.0 - _SWEEP_SHARE, costs, thorough=thorough, work=work)
    return kept, optimal


def _unchanged(kept: Kept, error: FloatArray) -> FloatArray | None:
    """Coefficients stay as they are."""
    return np.ones(len(kept)) if np.abs(error).max(initial=0.0) <= 1.0 else None


def _refitted(candidates: Candidates, work: Work) -> Fit:
    """Coefficients are fitted anew for every selection."""
    refitting = Refit(candidates, work)
    return lambda kept, _: refitting.within(kept)


def _refitted_start(elimination: Elimination, fit: Fit) -> tuple[Kept, FloatArray] | None:
    """Drop as many candidates, in the order given, as a refit can absorb."""
    few, many, found = -1, len(elimination.order) + 1, None
    while many - few > 1:
        middle = (few + many) // 2
        trial = elimination.kept(middle)
        scale = fit(trial, np.zeros(0))
        if scale is None:
            many = middle
        else:
            few, found = middle, (trial, scale)
    return found


def _exchanged(
    candidates: Candidates, kept: Kept, scale: FloatArray, fit: Fit, count: Count, work: Work
) -> tuple[Kept, FloatArray]:
    """Drop one more, or one for another that is cheaper, while operations go down."""
    shared, flat = _Shared(candidates), candidates.flat
    size = np.maximum(np.einsum("ks,ks->k", flat, flat), np.finfo(float).tiny)
    fewest, trials = count(kept, scale), _TRIALS
    while True:
        for trial, error in _neighbours(flat, size, shared, kept, scale):
            if trials == 0 or not work.affords(0.0):
                return kept, scale
            trials -= 1
            fitted = fit(trial, error)
            if fitted is not None and (operations := count(trial, fitted)) < fewest:
                kept, scale, fewest = trial, fitted, operations
                break
        else:
            return kept, scale


def _neighbours(
    flat: FloatArray, size: FloatArray, shared: _Shared, kept: Kept, scale: FloatArray
) -> Iterator[tuple[Kept, FloatArray]]:
    """Selections that should be cheaper, with their error: first without one, then one for another."""
    error = (kept * scale - 1.0) @ flat
    harm = {int(k): float(np.abs(error - scale[k] * flat[k]).max()) for k in np.flatnonzero(kept)}
    leaving = sorted(harm, key=harm.__getitem__)
    for k in leaving:
        trial = kept.copy()
        trial[k] = False
        yield trial, error - scale[k] * flat[k]
    saved = shared.saved(kept)
    others = np.flatnonzero(~kept)
    for k in leaving:
        without = kept.copy()
        without[k] = False
        beyond = error - scale[k] * flat[k]
        hot = np.flatnonzero(np.abs(beyond) > _HOT)
        worth = (flat[np.ix_(others, hot)] @ beyond[hot]) ** 2 / size[others]
        added = shared.added(without)
        for j in others[np.argsort(-worth, kind="stable")[:_TAKEN_BACK]]:
            if added[j] < saved[k]:
                trial = without.copy()
                trial[j] = True
                yield trial, beyond + flat[j]


class _Shared:
    """Operations as candidates share them."""

    def __init__(self, candidates: Candidates) -> None:
        self._in = np.zeros((len(candidates.costs), len(candidates.effects)), dtype=bool)
        for b, members in enumerate(candidates.costs):
            self._in[b, list(members)] = True
        self._operations = np.array(list(candidates.costs.values()), dtype=float)

    def saved(self, kept: Kept) -> FloatArray:
        """Operations that go with each kept candidate alone."""
        alone = (self._in & kept).sum(axis=1) == 1
        return np.asarray(np.where(kept, (self._operations * alone) @ self._in, 0.0))

    def added(self, kept: Kept) -> FloatArray:
        """Operations that each candidate would add."""
        unused = ~(self._in & kept).any(axis=1)
        return np.asarray((self._operations * unused) @ self._in)


# Writing a program to count it takes as long as so many multiplications for each term.
_WRITING = 3e5


def dropped(
    exact: ExactDynamics,
    level: CandidateLevel,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
) -> Found:
    """Search for the terms to be kept; a TooManyTermsError if there are more than a search can weigh."""
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
    """Estimate operations of multiples of a budget from one elimination."""
    candidates = candidates_of(exact, level, allowed)
    elimination, one = eliminate(candidates), np.ones(len(candidates))
    return lambda factor: candidates.count(elimination.within(factor), one, COUNTING).total
