"""What a simplification may drop: the terms of a level, what each makes of torque, and what it costs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import OperationCount
from gd_analyze.simplification.effort import Effort
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm, has_more_terms
from gd_analyze.simplification.level import CandidateLevel, Costs, Level, Terms

Kept = NDArray[np.bool_]


# Above so many terms the smallest go first: no search could weigh them all.
MANY = 1000
# What those may make of the budget together, and how many may then be left at most.
SWEEP, _MOST = 0.3, 4000
# Terms up to which an arm's torque is written out at all: some seconds.
_WRITTEN = 60_000
# Numbers held at a time while looking for them, and looked at to rank them, or for a first opinion: seconds.
_AT_ONCE, _RANKED, _GLANCE = 10_000_000, 100_000_000, 20_000_000
# Numbers remembered of what terms make of torque: tens of megabytes.
_REMEMBERED = 3_000_000


class TooManyTermsError(UsageError):
    """More terms matter than a search can weigh."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """What may be dropped: terms, with their numbers in the exact dynamics, and what each takes.

    Of very many terms the smallest are no candidates and dropped beforehand.
    """

    level: CandidateLevel
    form: ExactForm
    terms: Terms
    # (K, n, N), torque as it counts, over what is left of the allowed error; the sum is the exact torque
    effects: FloatArray
    costs: Costs
    parameter: NDArray[np.int64]  # (K,), free numbers of a refit, see `level.Numbers`
    magnitude: FloatArray  # (K,), of the coefficients
    ratio: FloatArray  # (K,), factor of every coefficient where its free number is 1; 1 at first
    total: int  # how many terms there are
    swept: float = 0.0  # share of the budget that those dropped beforehand take together
    weights: FloatArray | None = None  # (N, n), how much an error counts, see `States.weights`

    def __len__(self) -> int:
        return len(self.effects)

    def keep(self, kept: Kept, scale: FloatArray) -> dict[Any, float]:
        """Terms of a selection, shape (K,), their coefficients times their factors, shape (K,)."""
        chosen = zip(self.terms.items(), kept, scale, strict=True)
        return {term: float(factor * weight) for (term, weight), keep, factor in chosen if keep}

    def count(self, kept: Kept, scale: FloatArray, effort: Effort) -> OperationCount:
        """Operations of a selection, as a program takes them that is written with so much effort."""
        return self.level.write(self.form, self.keep(kept, scale), effort).count

    @property
    def flat(self) -> FloatArray:
        """Effects with joints and states in one row, shape (K, n N)."""
        return self.effects.reshape(len(self.effects), math.prod(self.effects.shape[1:]))


def candidates_of(
    exact: ExactDynamics, level: Level, allowed: FloatArray, sweep: float = SWEEP
) -> Candidates:
    """Make the candidates of a level at states, with the allowed error of each joint, N m, shape (n,).

    Of very many terms the smallest are dropped beforehand until `MANY` are left, as long as they take no more
    than the share `sweep` of the budget. A TooManyTermsError if far too many would be left.
    """
    if not isinstance(level, CandidateLevel):
        what = f"level {level.name} keeps no terms that could be looked at one by one"
        raise UsageError(what, where="level", expected="term, energy or element", found=level.name)
    if level.has_torque_terms and has_more_terms(exact.form, _WRITTEN):
        raise TooManyTermsError(
            f"the exact torque of {exact.arm.name} has too many terms to look at them one by one",
            where=f"level {level.name}",
            expected=f"at most {_WRITTEN} torque terms",
            found="more",
            next_step="`gd-analyze simplify ROBOT --level recursive` simplifies such an arm, `gd-analyze "
            "equations ROBOT --element D12 --min-share 1%` prints the largest terms of an element",
        )
    every = level.terms(exact.form)
    terms, swept = every, 0.0
    if len(every) > MANY:
        terms, swept = _swept(exact, level, every, allowed, sweep)
    if len(terms) < len(every) or len(every) * exact.states.q.size > _REMEMBERED:
        effects = level.effects(exact, terms)
    else:
        if level.name not in exact.effects:
            exact.effects[level.name] = level.effects(exact, terms)
        effects = exact.effects[level.name]
    listed = list(terms)
    parameter, magnitude = level.numbers(exact.form, listed)
    return Candidates(
        level=level,
        form=exact.form,
        terms=terms,
        effects=_weighed(effects, exact) / ((1.0 - swept) * allowed)[:, None],
        costs=level.costs(exact.form, listed),
        parameter=parameter,
        magnitude=magnitude,
        ratio=np.ones(len(listed)),
        total=len(every),
        swept=swept,
        weights=exact.states.weights,
    )


def _swept(
    exact: ExactDynamics, level: CandidateLevel, every: Terms, allowed: FloatArray, sweep: float
) -> tuple[Terms, float]:
    """Terms left when the smallest have gone, and the error over allowed of those; few states decide."""
    items, n, states = list(every.items()), exact.arm.n_joints, exact.states
    looked_at = _RANKED if np.isinf(sweep) else _GLANCE
    few = states.at(slice(None, None, max(len(items) * n * len(states) // looked_at, 1)))
    peaks = np.zeros((len(items), n))
    step = max(_AT_ONCE // (len(items) * n), 1)
    for start in range(0, len(few), step):
        some = exact.at(few.at(slice(start, start + step)))
        np.maximum(peaks, np.abs(_weighed(level.effects(some, every), some)).max(axis=2), out=peaks)
    order = np.argsort((peaks / allowed).max(axis=1), kind="stable")
    if np.isinf(sweep):
        left = dict(items[k] for k in np.sort(order[-MANY:]))
        rest = exact.torque.T - level.effects(exact, left).sum(axis=0)
        return left, float((np.abs(_weighed(rest, exact)).max(axis=1) / allowed).max())
    gone, share = _gone(exact.at(few), level, [items[k] for k in order], allowed, sweep)
    if len(few) < len(states) and len(items) - gone <= _MOST:
        gone, share = _gone(exact, level, [items[k] for k in order], allowed, sweep)
    if len(items) - gone > _MOST:
        raise TooManyTermsError(
            f"too many of the {len(items)} terms of {exact.arm.name} matter within that budget",
            where="budget",
            expected=f"at most {_MOST}",
            found=str(len(items) - gone),
            next_step="use --level recursive, whose models keep no terms, or allow a larger error",
        )
    return dict(items[k] for k in np.sort(order[gone:])), share


def _gone(
    exact: ExactDynamics,
    level: CandidateLevel,
    items: list[tuple[Any, float]],
    allowed: FloatArray,
    sweep: float,
) -> tuple[int, float]:
    """How many of the terms, from the first, may go together, and the error over allowed that they make."""
    lost = np.zeros((exact.arm.n_joints, len(exact.states)))
    gone, share = 0, 0.0
    step = max(_AT_ONCE // lost.size, 1)
    for start in range(0, len(items) - MANY, step):
        some = dict(items[start : min(start + step, len(items) - MANY)])
        sums = lost + np.cumsum(level.effects(exact, some), axis=0)
        errors = (np.abs(_weighed(sums, exact)).max(axis=2) / allowed).max(axis=1)
        within = np.flatnonzero(errors <= sweep)
        if within.size:
            gone, share = start + int(within[-1]) + 1, float(errors[within[-1]])
        lost = sums[-1]
    return gone, share


def _weighed(effects: FloatArray, exact: ExactDynamics) -> FloatArray:
    """Effects (K, n, N) as they count."""
    return effects if exact.states.weights is None else effects * exact.states.weights.T
