"""Pruning of the recursion: steps replaced by simpler ones while the torque stays within the budget."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from random import Random

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.tape import Tape
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.effort import COUNTING, POINT, ROUGH, THOROUGH, Work, inputs_of
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import Found
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.simplification.recursion import (
    CONSTANT,
    NUMBER,
    Change,
    Changed,
    Changes,
    Recursion,
    restated,
)
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.replacement import (
    Aim,
    Columns,
    Fit,
    Replacement,
    columns_of,
    fitted,
    norm,
    replacements,
    rounded,
    unfitted,
)
from gd_analyze.simplification.search import Progress
from gd_analyze.text import SINE_PRICE

# Margins of position, revolute and prismatic, and as shares of peak velocity and acceleration, as in the
# default `Margin`.
_ANGLE, _DISTANCE, _VELOCITY, _ACCELERATION = math.radians(1.0), 1e-3, 0.02, 0.05
# Number of states drawn, always the same. With a budget of 1 % along 61 set points of a seven-joint arm the
# largest error within these margins was 27 % of peak torque without, 1.8 % with 100 to 200, 1.5 % with 1000.
_COUNT = 120
# Initial states, twice as many beyond six joints; states that turn out to matter are added in batches. With
# 100 states a Panda, which has many numbers to fit, found no model over its limits within 16 rounds.
_STATES, _MANY_JOINTS, _JOINING = 100, 7, 40
# Several replacements are made at a time while the mean square error grows by at most these factors, below
# and above a share of the budget, or stays small; above another share only single ones are tried.
_FEW_ERRORS, _GROWS, _GROWS_LESS, _SMALL, _AT_ONCE, _ROOM = 0.15, 2.0, 1.1, 0.01**2, 24, 0.6
# Errors over the allowed ones above which the largest decide.
_LEADING = 0.3
# Shares of the changed steps that are undone at once, and probability of choosing neighbouring ones.
_UNDONE, _NEAR = (0.03, 0.06, 0.12), 0.6
# If a model exceeds its budget at other states: growth of the step back on the way with each attempt.
_FARTHER = 1.3
# Multiplications in matrix products that take as long as a single one, and as writing one step.
_AT_A_TIME, _WRITING = 8.0, 1.5e4
# Replacements evaluated together; tries before giving up; largest promised error over the allowed one; error
# at which a try is abandoned after one fit; a power of errors that approximates the maximum.
_SCREENED, _TRIES, _PROMISED, _HOPELESS, _NEARLY_LARGEST = 16, 16, 1.03, 1.4, 12.0
# Shares of a usual search's effort: one of many searches does little more than the first descent; a thorough
# one takes seconds beyond it for six joints, 20 s for seven, by this power of the number of joints.
_QUICK, _SIX_JOINTS, _POWER, _MOST = 1e-6, 0.06, 15, 0.6


def _joined_by_near_states(exact: ExactDynamics) -> ExactDynamics:
    """Add some states near those of a motion, with equal weights; none to other states."""
    states = exact.states
    if "trajectory" not in states.described:
        return exact
    random = np.random.default_rng(0)
    some = np.linspace(0, len(states) - 1, _COUNT).round().astype(np.intp)
    velocity, acceleration = (np.abs(x).max(axis=0, initial=0.0) for x in (states.qd, states.qdd))
    revolute = np.array(exact.arm.is_revolute)
    margins = (np.where(revolute, _ANGLE, _DISTANCE), _VELOCITY * velocity, _ACCELERATION * acceleration)

    q, qd, qdd = (
        values[some] + margin * random.uniform(-1.0, 1.0, (_COUNT, len(margin)))
        for values, margin in zip(states.arrays, margins, strict=True)
    )
    weights = None if states.weights is None else states.weights[some]
    return exact.at(states.joined_by(q, qd, qdd, weights))


@dataclass(frozen=True, eq=False)
class _Pruned:
    """Changes, the changed recursion, and its errors at the states used."""

    changes: dict[Change, float]
    changed: Changed
    tape: Tape
    aim: Aim
    fit: Fit

    @cached_property
    def slopes(self) -> FloatArray:
        """Effect of every step on the errors, shape (steps, n, N)."""
        return self.tape.slopes(self.fit.values, self.fit.numbers, self.aim.scale) * self.aim.weights

    @cached_property
    def operations(self) -> int:
        return int(self.tape.operations.sum())

    @cached_property
    def stated(self) -> dict[Change, float]:
        """Changes that state the fitted numbers."""
        numbers = {self.tape.steps[k].order: float(self.fit.numbers[k]) for k in self.tape.scaled}
        return restated(self.changes, numbers, self.changed)

    @property
    def replaced(self) -> list[int]:
        """Steps replaced by others or by numbers."""
        return sorted({change.step for change in self.changes if change.source != CONSTANT})


class _Pruning:
    """A recursion, the exact torque, and the states used."""

    def __init__(
        self, recursion: Recursion, aim: Aim, work: Work, progress: Progress, sine_price: int
    ) -> None:
        self.recursion, self.every, self.work, self.progress = recursion, aim, work, progress
        self.sine_price = sine_price
        self.reached = 0  # operations last reported
        count = aim.torque.shape[1]
        most = _STATES * (1 + (len(aim.torque) >= _MANY_JOINTS))
        evenly = np.linspace(0, count - 1, min(most, count)).astype(np.intp)
        extremes = np.abs(aim.torque * aim.weights).argmax(axis=1)
        self.looked_at: NDArray[np.intp] = np.unique(np.concatenate([evenly, extremes]))
        self.aim = aim.at(self.looked_at)

    def join(self, states: NDArray[np.intp]) -> None:
        """Add states."""
        new = np.setdiff1d(states, self.looked_at)
        if new.size:
            self.looked_at = np.concatenate([self.looked_at, new])
            self.aim = self.every.at(self.looked_at)

    def with_changes(self, changes: Changes) -> _Pruned | None:
        """Carry changes out; None if steps would replace each other in a cycle."""
        self.work.spend(_WRITING * len(self.recursion.steps))
        try:
            changed = self.recursion.carried_out(changes)
        except ValueError:
            return None
        tape = Tape(changed.program, changed.scales, self.sine_price)
        return _Pruned(dict(changes), changed, tape, self.aim, unfitted(tape, self.aim))

    def again(self, pruned: _Pruned) -> _Pruned:
        """The same at the states now in use."""
        if pruned.aim is self.aim:
            return pruned
        return replace(pruned, aim=self.aim, fit=unfitted(pruned.tape, self.aim, pruned.fit.numbers))

    def fitted(self, pruned: _Pruned, power: float, turns: int, enough: float = 0.0) -> _Pruned:
        """Fit the numbers."""
        fit = fitted(pruned.tape, self.aim, pruned.fit, power, turns, enough)
        squares = power * turns * float(fit.errors.size) * len(pruned.tape.scaled) ** 2
        self.work.spend(squares / _AT_A_TIME)
        return replace(pruned, fit=fit)

    def beyond(self, pruned: _Pruned) -> NDArray[np.intp]:
        """States at which the budget is exceeded, the worst first."""
        tape = pruned.tape
        values = tape.values(self.every.inputs, pruned.fit.numbers)
        errors = np.abs(self.every.errors(tape, values)).max(axis=0)
        found = np.flatnonzero(errors > 1.0)
        return found[np.argsort(-errors[found], kind="stable")]

    def kept_everywhere(self, pruned: _Pruned) -> _Pruned | None:
        """Fit until the budget is kept at every state; None if this fails."""
        if pruned.fit.largest > 1.0:
            pruned = self.fitted(pruned, _NEARLY_LARGEST, 3, 1.0)
        for _ in range(3):
            if pruned.fit.largest > 1.0:
                return None
            worst = self.beyond(pruned)
            if not worst.size:
                return pruned
            self.join(worst[:_JOINING])
            pruned = self.fitted(self.again(pruned), _NEARLY_LARGEST, 4, 1.0)
        return None

    def promising(self, here: _Pruned) -> tuple[list[Replacement], float]:
        """Replacements by merit, and the mean square error."""
        fit, tape = here.fit, here.tape
        known = np.array([bool(origins) for origins in here.changed.origins])
        products = 4.0 * len(tape) ** 2 * fit.errors.shape[1] + 3.0 * len(tape) ** 3
        self.work.spend(products / _AT_A_TIME)
        return replacements(tape, fit, here.slopes, known, 6.0 if fit.largest > _LEADING else 4.0)

    def replaced(self, here: _Pruned, chosen: Sequence[Replacement]) -> _Pruned | None:
        """Carry replacements out, if this saves operations."""
        origins, changes = here.changed.origins, dict(here.stated)
        for one in chosen:
            for place in origins[one.step]:
                for change in [change for change in changes if change.step == place]:
                    del changes[change]
                for u, number in one.by:
                    changes[Change(place, NUMBER if u == NUMBER else origins[u][0])] = number
        found = self.with_changes(changes)
        return found if found is not None and found.operations < here.operations else None

    def several(self, here: _Pruned, found: Sequence[Replacement], mean_square: float) -> _Pruned | None:
        """Make several replacements at once."""
        few = here.fit.largest < _FEW_ERRORS
        most = max((_GROWS if few else _GROWS_LESS) * mean_square, _SMALL)
        chosen = _apart(here.tape, found, most, mean_square)
        while len(chosen) > 1:
            trial = self.replaced(here, chosen)
            if trial is not None:
                trial = self.fitted(trial, 2.0 if few else 4.0, 1)
                near = trial.fit.largest <= min(max(2.5 * here.fit.largest, 0.3), _ROOM)
                if near and not self.beyond(trial).size:
                    return trial
            chosen = chosen[: len(chosen) // 2]
        return None

    def one(self, here: _Pruned, found: Sequence[Replacement]) -> _Pruned | None:
        """Make the one of the most promising replacements that uses least of the budget per operation."""
        tries = 0
        for start in range(0, len(found), _SCREENED):
            here = self.again(here)
            for replacement in self._screened(here, found[start : start + _SCREENED]):
                trial = self.replaced(here, [replacement])
                if trial is None:
                    continue
                tries += 1
                trial = self.fitted(trial, _NEARLY_LARGEST, 1)
                kept = self.kept_everywhere(trial) if trial.fit.largest < _HOPELESS else None
                if kept is not None:
                    return kept
                if tries == _TRIES:
                    return None
        return None

    def _screened(self, here: _Pruned, some: Sequence[Replacement]) -> list[Replacement]:
        """Replacements that keep the budget after a fit of numbers, to first order."""
        fit, slopes = here.fit, here.slopes
        numbers = columns_of(here.tape, fit, slopes)
        self.work.spend(len(some) * 4.0 * numbers.size * len(numbers) / _AT_A_TIME)
        columns, kept = Columns(numbers), []
        _, left = columns.least(fit.errors.ravel(), _NEARLY_LARGEST)
        before = norm(left, _NEARLY_LARGEST)
        for one in some:
            errors = fit.errors + slopes[one.step] * one.change(fit.values)
            _, after = columns.least(errors.ravel(), _NEARLY_LARGEST)
            if np.abs(after).max(initial=0.0) <= _PROMISED:
                added = rounded(norm(after, _NEARLY_LARGEST) - before)
                kept.append(one._replace(added=added))
        return sorted(kept, key=lambda one: one.order)

    def mended(self, way: list[Changes]) -> _Pruned:
        """Go back on a way as little as needed to keep the budget everywhere after a fit."""
        place, back = len(way) - 1, 1
        while place >= 0:
            past = self.with_changes(way[place])
            assert past is not None
            kept = self.kept_everywhere(self.fitted(past, 4.0, 1))
            if kept is not None:
                way[place:] = [kept.stated]
                return kept
            place, back = place - back, math.ceil(_FARTHER * back)
        way.clear()
        nothing = self.with_changes({})
        assert nothing is not None
        return nothing

    def partly_undone(self, here: _Pruned, random: Random) -> _Pruned:
        """Undo some of the changes, and fit."""
        steps = here.replaced
        count = max(int(random.choice(_UNDONE) * len(steps)), 1)
        if random.random() < _NEAR:
            first = random.choice(steps)
            gone = set(sorted(steps, key=lambda step: abs(step - first))[:count])
        else:
            gone = set(random.sample(steps, count))
        left = self.with_changes({change: c for change, c in here.stated.items() if change.step not in gone})
        if left is None:
            return here
        return self.fitted(left, 4.0, 1)

    def descend(self, here: _Pruned, way: list[Changes] | None = None) -> _Pruned:
        """Replace steps while possible, and within the effort or, to note the `way`, to the end."""
        while here.operations and (way is not None or self.work.affords(0.0)):
            here = self.again(here)
            found, mean_square = self.promising(here)
            trial = self.several(here, found, mean_square) if here.fit.largest < _ROOM else None
            if trial is None:
                trial = self.one(here, found)
            if trial is None:
                break
            here = trial
            if way is not None:
                way.append(here.stated)
            if self.progress is not None and here.operations < self.reached:
                self.progress(self.reached - here.operations)
                self.reached = here.operations
        return here


def _apart(tape: Tape, found: Sequence[Replacement], most: float, mean_square: float) -> list[Replacement]:
    """The first independent replacements, while the mean square error remains small."""
    chosen: list[Replacement] = []
    used, total = np.zeros(len(tape), dtype=bool), mean_square
    for one in found:
        sources = [u for u, _ in one.by if u != NUMBER]
        if used[one.step] or any(used[u] for u in sources):
            continue
        if chosen and total + max(one.added, 0.0) > most:
            break
        gone = tape.alone_for[one.step].copy()
        for u in sources:
            gone &= ~tape.needs[u]
        # Replacing steps only by earlier ones closes no cycle; others are made alone.
        later = any(u > one.step for u in sources)
        if used[gone].any() or (later and chosen):
            continue
        total += max(one.added, 0.0)
        chosen.append(one)
        used[gone] = used[one.step] = True
        if later or len(chosen) == _AT_ONCE:
            break
    return chosen


def prune(
    exact: ExactDynamics,
    allowed: FloatArray,
    *,
    effort: float = 1.0,
    way: list[Changes] | None = None,
    progress: Progress = None,
    sine_price: int = SINE_PRICE,
) -> dict[Change, float]:
    """Prune a recursion to the allowed error, N m, (n,); one descent is always completed.

    It continues from the last changes of a `way` within that error, and extends it.
    """
    states, scale, way = exact.states, 1.0 / allowed, [] if way is None else way
    weights = np.ones(exact.torque.T.shape) if states.weights is None else states.weights.T
    aim = Aim(inputs_of(states), exact.torque.T * scale[:, None], scale, weights)
    pruning = _Pruning(exact.form.recursion, aim, Work(effort), progress, sine_price)
    here = pruning.with_changes(way[-1] if way else {})
    assert here is not None
    if way and pruning.beyond(here).size:
        here = pruning.mended(way)
    pruning.reached = here.operations
    here = pruning.descend(here, way)
    random = Random(0)
    while here.replaced and pruning.work.affords(0.0):
        trial = pruning.descend(pruning.partly_undone(here, random))
        # If nothing replaces undone changes, unused states may exceed the budget.
        if trial.operations <= here.operations and not pruning.beyond(trial).size:
            here = trial
            way.append(here.stated)
    return here.stated


def pruned(
    exact: ExactDynamics,
    allowed: FloatArray,
    how: SearchOptions,
    progress: Progress = None,
) -> Found:
    """Search for changes of the recursion, and write it in few operations."""
    usual = min(_SIX_JOINTS * (exact.arm.n_joints / 6) ** _POWER, _MOST)
    effort = how.effort * (usual if how.thorough else _QUICK)
    near = _joined_by_near_states(exact)
    found = prune(near, allowed, effort=effort, way=how.way, progress=progress, sine_price=how.sine_price)
    changes = exact.form.recursion.acting(found)
    rough = RECURSIVE.write(exact.form, changes, ROUGH)
    program = RECURSIVE.write(exact.form, changes, THOROUGH if how.write else COUNTING)
    steps = [SearchStep("pruning", rough.count.total), SearchStep("rewriting", program.count.total)]
    return Found(changes, program, bool(changes), tuple(steps[: 2 if how.write else 1]))


def quick_pruned_count(exact: ExactDynamics, allowed: FloatArray) -> Callable[[float], int]:
    """Estimate operations for multiples of a budget, each from the next smaller known one."""
    known: dict[float, dict[Change, float]] = {0.0: {}}
    near = _joined_by_near_states(exact)

    def count(factor: float) -> int:
        if factor not in known:
            start = known[max(smaller for smaller in known if smaller < factor)]
            known[factor] = prune(near, factor * allowed, effort=_QUICK, way=[start])
        return RECURSIVE.write(exact.form, known[factor], ROUGH).count.total

    return count


def pruned_path(
    exact: ExactDynamics, allowed: Sequence[FloatArray], start: Mapping[Change, float] | None = None
) -> Iterator[SimplifiedModel]:
    """Change more and more for growing budgets, each time continuing from the previous changes."""
    way, near, acting = [start or {}], _joined_by_near_states(exact), exact.form.recursion.acting
    path = [acting(prune(near, most, effort=_QUICK, way=way)) for most in allowed]
    for most, changes in zip(allowed, path, strict=True):
        everything = exactly(exact, RECURSIVE, most, str(Budget.of_torques(most)))
        program = RECURSIVE.write(exact.form, changes, POINT)
        yield measured(exact, replace(everything, terms=changes, program=program, refitted=bool(changes)))
