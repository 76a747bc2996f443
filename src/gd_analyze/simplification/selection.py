"""Which terms to keep: the cheapest selection whose error stays within the budget at every state.

Terms are dropped one by one, each time the one that raises the eighth power of the errors least per operation
saved: it stands for the largest error. Then, over and over, a few dropped terms are put back, of
which those that relieve the largest errors are likelier, and the descent drops others instead; the result is
taken if it costs no more. All numbers are counted, none timed: the same input gives the same selection.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.effects import Effects, Mask
from gd_analyze.simplification.search_time import UNLIMITED, SearchTime

# Operations by the set of terms, by index, that need them.
Costs = Mapping[frozenset[int], int]

_TRIES = 1500  # most attempts to improve a selection
_PATIENCE = 400  # attempts without success after which they end
_MOST_PUT_BACK = 6  # terms put back in an attempt, at most
_EXCHANGING = 0.5  # share of the attempts that begin by dropping a term or two
_NOISE = 1.0  # standard deviation of the logarithm of a term's merit in an attempt
_SEVERAL = 10  # cheapest selections by estimate, whose operations are counted
_NUMBERS_AT_ONCE = 500_000  # errors formed at once
AT_ONCE = 1 / 200  # share of the terms dropped at once while there are many
# Smallest credit of a term that saves nothing while others share its steps, in operations.
_LEAST_CREDIT = 0.5


@dataclass(frozen=True, eq=False)
class TermChoice:
    """Terms to choose from.

    Parameters
    ----------
    effects
        Their torques over the allowed error; the sum of all, and `base`, is the exact torque.
    base
        Error over the allowed one of terms dropped beforehand, shape (n, N).
    costs
        Estimated operations by the set of terms that need them.
    """

    effects: Effects
    base: FloatArray
    costs: Costs

    def __len__(self) -> int:
        return self.effects.count

    def joined_by(self, terms: NDArray[np.intp], errors: FloatArray, remainder: FloatArray) -> TermChoice:
        """The same with one more limited error: of some terms, shape (M, N), and of everything else, (N,)."""
        return TermChoice(
            self.effects.joined_by(terms, errors), np.vstack([self.base, remainder]), self.costs
        )

    @cached_property
    def weights(self) -> FloatArray:
        """Operations of every step, shape (steps,)."""
        return np.array(list(self.costs.values()), dtype=float)

    @cached_property
    def users(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Step and term of every pair of a step and a term that needs it."""
        pairs = [(step, term) for step, terms in enumerate(self.costs) for term in sorted(terms)]
        step, term = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        return step, term

    @cached_property
    def steps_of(self) -> list[NDArray[np.intp]]:
        """Steps that each term needs."""
        step, term = self.users
        order = np.argsort(term, kind="stable")
        return np.split(step[order], np.searchsorted(term[order], np.arange(1, len(self))))


class Selection:
    """Some of the terms, the error of leaving out the others, and how many terms need each step."""

    def __init__(self, choice: TermChoice, selected: Mask) -> None:
        self.choice = choice
        self.select(selected)

    def select(self, selected: Mask) -> None:
        """Take these terms, (K,), and no others."""
        self.selected = selected.copy()
        self.error = self.choice.base + self.choice.effects.total(~selected)
        step, term = self.choice.users
        self.needed = np.bincount(step[selected[term]], minlength=len(self.choice.weights))
        self._gains: dict[int, FloatArray] = {}

    def copy(self) -> Selection:
        """A selection that changes on its own."""
        selection = object.__new__(Selection)
        selection.choice, selection.selected = self.choice, self.selected.copy()
        selection.error, selection.needed = self.error.copy(), self.needed.copy()
        selection._gains = self.gains.copy()
        return selection

    @property
    def cost(self) -> float:
        """Estimated operations."""
        return float(self.choice.weights[self.needed > 0].sum())

    @property
    def largest(self) -> float:
        """Largest error over the allowed one."""
        return float(np.abs(self.error).max(initial=0.0))

    @property
    def savings(self) -> FloatArray:
        """Operations that dropping each term alone saves, shape (K,)."""
        step, term = self.choice.users
        sole_weights = np.where(self.needed == 1, self.choice.weights, 0.0)
        return np.bincount(term, weights=sole_weights[step], minlength=len(self.choice)).astype(float)

    def drop(self, term: int) -> None:
        """Leave a term out."""
        self._change(term, 1)

    def put_back(self, term: int) -> None:
        """Take a term in again."""
        self._change(term, -1)

    def _change(self, term: int, sign: int) -> None:
        effects = self.choice.effects
        self.selected[term] = sign < 0
        self.needed[self.choice.steps_of[term]] -= sign
        for row in effects.rows_of(term).tolist():
            joint = int(effects.joint[row])
            self.error[joint] += sign * effects.torque[row]
            self._gains.pop(joint, None)

    @property
    def gains(self) -> dict[int, FloatArray]:
        """By joint: first-order decrease of its error's eighth power by every row of `effects` there."""
        effects = self.choice.effects
        for joint, error in enumerate(self.error):
            if joint not in self._gains:
                squares = error * error
                slope = squares * squares * squares * error
                self._gains[joint] = effects.torque[effects.of_joints[joint]] @ slope
        return self._gains

    @property
    def relief(self) -> FloatArray:
        """First-order decrease of the errors' eighth power if each term were put back, shape (K,)."""
        effects, gains = self.choice.effects, self.gains
        by_row = np.concatenate([gains[joint] for joint in range(len(self.error))])
        of_terms = np.bincount(effects.term, weights=by_row, minlength=len(self.choice))
        return np.where(self.selected, 0.0, of_terms)


def descend(
    selection: Selection,
    stays: Mask,
    *,
    limit: float = 1.0,
    at_once: float = AT_ONCE,
    random: np.random.Generator | None = None,
) -> None:
    """Drop terms while every error stays within `limit` allowed ones; those of `stays` are never dropped.

    With `random` the merit of every term varies at random.
    """
    effects, open_ = selection.choice.effects, selection.selected & ~stays
    if_dropped = _IfDropped(selection)
    while open_.any():
        terms = np.flatnonzero(open_)
        largest_square, rise = (values[terms] for values in if_dropped.of(open_))
        fits = largest_square <= limit**2
        # A term that does not fit now may fit later, but seldom does: attempts put others back.
        open_[terms[~fits]] = False
        terms, rise = terms[fits], rise[fits]
        if not len(terms):
            return
        saving = np.maximum(selection.savings[terms], _LEAST_CREDIT)
        merit = np.where(rise > 0.0, rise / saving, rise * saving)
        if random is not None:
            merit *= np.exp(_NOISE * np.sign(merit) * random.standard_normal(len(terms)))
        count = max(1, int(at_once * len(terms)))
        for term in terms[np.argsort(merit, kind="stable")[:count]].tolist():
            if count > 1 and not _fits(selection, term, limit):
                continue
            selection.drop(term)
            if_dropped.changed[effects.joint[effects.rows_of(term)]] = True
            open_[term] = False


class _IfDropped:
    """What dropping each term does to errors; evaluated anew at joints whose error has changed since."""

    def __init__(self, selection: Selection) -> None:
        self.selection, effects = selection, selection.choice.effects
        self.changed = np.ones(effects.n_joints, dtype=bool)
        # By row of `effects`: largest square of the error, and sum of its eighth powers.
        self._squares, self._powers = np.empty(len(effects.term)), np.empty(len(effects.term))

    def of(self, terms: Mask) -> tuple[FloatArray, FloatArray]:
        """Largest squared error without each of some terms, and rise of errors' eighth powers, shape (K,)."""
        error, effects = self.selection.error, self.selection.choice.effects
        rows = np.flatnonzero(terms[effects.term])
        self._evaluate(rows[self.changed[effects.joint[rows]]])
        self.changed[:] = False
        term, joint = effects.term[rows], effects.joint[rows]
        largest_square = np.zeros(effects.count)
        np.maximum.at(largest_square, term, self._squares[rows])
        current = _fourth_power(error**2).sum(axis=1)
        rise = np.bincount(term, self._powers[rows] - current[joint], minlength=effects.count).astype(float)
        return largest_square, rise

    def _evaluate(self, rows: NDArray[np.intp]) -> None:
        error, effects = self.selection.error, self.selection.choice.effects
        step = max(1, _NUMBERS_AT_ONCE // error.shape[1])
        for start in range(0, len(rows), step):
            block = rows[start : start + step]
            trial = error[effects.joint[block]]
            trial += effects.torque[block]
            np.multiply(trial, trial, out=trial)
            self._squares[block] = trial.max(axis=1)
            self._powers[block] = _fourth_power(trial).sum(axis=1)


def _fourth_power(squares: FloatArray) -> FloatArray:
    """By squaring twice, in place: NumPy's own power is ten times slower."""
    np.multiply(squares, squares, out=squares)
    return np.multiply(squares, squares, out=squares)


def _fits(selection: Selection, term: int, limit: float) -> bool:
    """Whether a term can be dropped."""
    effects = selection.choice.effects
    rows = effects.rows_of(term)
    return bool(np.abs(selection.error[effects.joint[rows]] + effects.torque[rows]).max() <= limit)


def repair(selection: Selection, *, limit: float = 1.0) -> None:
    """Put terms back, each time the one that relieves the largest errors most, until all are within."""
    while selection.largest > limit:
        relief = selection.relief
        term = int(relief.argmax())
        if relief[term] <= 0.0:  # no single term helps: put everything back
            selection.select(np.ones(len(selection.choice), dtype=bool))
            return
        selection.put_back(term)


def improve(
    selection: Selection, stays: Mask, time: SearchTime = UNLIMITED, *, effort: float = 1.0, seed: int = 0
) -> list[Selection]:
    """Put some terms back and drop others, again and again; return the cheapest distinct selections.

    The cheapest by estimate comes first. With more effort there are more attempts.
    """
    tries, patience = (max(1, round(effort * number)) for number in (_TRIES, _PATIENCE))
    random = np.random.default_rng(seed)
    best = {selection.selected.tobytes(): selection}
    cheapest, waited = selection.cost, 0
    for _ in range(tries):
        if waited >= patience or time.is_closing:
            break
        waited += 1
        trial = selection.copy()
        if random.random() < _EXCHANGING:
            if not _exchange_some(trial, stays, random):
                continue
        else:
            _put_some_back(trial, random)
        descend(trial, stays, random=random)
        cost = trial.cost
        # Terms that cancel others may raise errors when they are put back.
        if cost > selection.cost or trial.largest > 1.0:
            continue
        selection = trial
        best.setdefault(trial.selected.tobytes(), trial)
        if cost < cheapest:
            cheapest, waited = cost, 0
    ordered = sorted(best.values(), key=lambda selection: selection.cost)
    return ordered[:_SEVERAL]


def _exchange_some(selection: Selection, stays: Mask, random: np.random.Generator) -> bool:
    """Drop one or two terms at random, and put others back; whether the errors are then within."""
    open_ = np.flatnonzero(selection.selected & ~stays)
    if not len(open_):
        return False
    leaving = random.choice(open_, size=min(int(random.integers(1, 3)), len(open_)), replace=False)
    for term in leaving.tolist():
        selection.drop(term)
    for _ in range(_MOST_PUT_BACK):
        if selection.largest <= 1.0:
            return True
        relief = selection.relief
        relief[leaving] = 0.0
        relief *= np.exp(_NOISE * random.standard_normal(len(relief)))
        term = int(relief.argmax())
        if relief[term] <= 0.0:
            return False
        selection.put_back(term)
    return selection.largest <= 1.0


def _put_some_back(selection: Selection, random: np.random.Generator) -> None:
    """Put a few dropped terms back at random, likelier those that relieve large errors."""
    dropped = np.flatnonzero(~selection.selected)
    if not len(dropped):
        return
    count = min(int(random.integers(1, _MOST_PUT_BACK + 1)), len(dropped))
    relief = np.sqrt(np.maximum(selection.relief[dropped], 0.0))
    total = relief.sum()
    # One in a thousand is any term, so that none is out of reach.
    odds = 0.999 * relief / total + 0.001 / len(dropped) if total > 0.0 else None
    for term in random.choice(dropped, size=count, replace=False, p=odds).tolist():
        selection.put_back(int(term))
