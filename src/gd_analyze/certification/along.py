"""The bound along a tube: boxes are halved where the error may be largest, until that is known closely."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.taylor import TaylorForm
from gd_analyze.certification.tube import Tube

# Where no state can be worse than the worst found by more than this, there is nothing left to look for.
_CLOSE = 1.01
# Boxes halved at a time.
_AT_A_TIME = 256


class Bounded(NamedTuple):
    """One joint: bounds of pieces of its states (pieces,), largest error found, and its state (n,)."""

    bounds: FloatArray
    found: float
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


def bound_along(field: ErrorField, tube: Tube, effort: int) -> Bounded:
    """Bound one joint's error in every piece of a tube.

    Parameters
    ----------
    field
        The error, over the box that encloses the tube.
    tube
        The states.
    effort
        Boxes that may be looked at. Every piece is looked at once, however many there are.
    """
    box = tube.enclosing
    limits = np.stack([np.ones(tube.n_joints), box.rate, box.acceleration])
    # Where a limit is zero so are all rates, and any share of it will do.
    limits = np.where(limits > 0.0, limits, 1.0)
    form = TaylorForm(field)
    lower, upper = ((x / limits).reshape(len(tube), -1).T for x in (tube.lower, tube.upper))
    # Rounding of middles and halves is that of the places of nodes, which the field's round-off has in it.
    boxes = _Boxes.of(form, (lower + upper) / 2, (upper - lower) / 2, np.arange(len(tube)))
    worst = boxes.worst
    spent = len(tube)
    while True:
        # What rounding and what cancels amount to is in every bound, however small the box.
        near = np.flatnonzero(boxes.bounds > _CLOSE * worst.found + field.rest + 8 * field.round_off)
        if not near.size or spent + 2 > effort:
            break
        near = near[np.argsort(-boxes.bounds[near], kind="stable")[: min(_AT_A_TIME, (effort - spent) // 2)]]
        halves = boxes.at(near).halved(form)
        worst = max(worst, halves.worst, key=lambda found: found.found)
        boxes = boxes.at(np.delete(np.arange(len(boxes.bounds)), near)).joined_by(halves)
        spent += 2 * near.size
    bounds = np.zeros(len(tube))
    np.maximum.at(bounds, boxes.pieces, boxes.bounds)
    state = worst.state.reshape(3, -1) * limits
    q, qd, qdd = np.clip(state, tube.lower[worst.piece], tube.upper[worst.piece])
    return Bounded(bounds, worst.found, q, qd, qdd)


class _Worst(NamedTuple):
    """Largest error found, where, and in which piece."""

    found: float
    state: FloatArray
    piece: int


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Boxes, the pieces of the tube they are of, and what is known of the error in each."""

    centre: FloatArray
    half: FloatArray
    pieces: NDArray[np.intp]
    bounds: FloatArray
    longest: NDArray[np.intp]
    found: FloatArray
    states: FloatArray

    @classmethod
    def of(cls, form: TaylorForm, centre: FloatArray, half: FloatArray, pieces: NDArray[np.intp]) -> _Boxes:
        known = form.bounds(centre, half)
        return cls(centre, half, pieces, known.bound, known.longest, known.found, known.state)

    @property
    def worst(self) -> _Worst:
        top = int(self.found.argmax())
        return _Worst(float(self.found[top]), self.states[:, top], int(self.pieces[top]))

    def at(self, chosen: NDArray[np.intp]) -> _Boxes:
        return _Boxes(*(x[..., chosen] for x in self._arrays))

    def joined_by(self, other: _Boxes) -> _Boxes:
        pairs = zip(self._arrays, other._arrays, strict=True)
        return _Boxes(*(np.concatenate(pair, axis=-1) for pair in pairs))

    def halved(self, form: TaylorForm) -> _Boxes:
        """Both halves of every box; no half's bound is larger than the whole's."""
        numbers = np.arange(len(self.bounds))
        half = self.half.copy()
        half[self.longest, numbers] /= 2
        step = np.zeros_like(half)
        step[self.longest, numbers] = half[self.longest, numbers]
        centres = np.hstack([self.centre - step, self.centre + step])
        out = _Boxes.of(form, centres, np.hstack([half, half]), np.tile(self.pieces, 2))
        return replace(out, bounds=np.minimum(out.bounds, np.tile(self.bounds, 2)))

    @property
    def _arrays(self) -> list[Any]:
        return [getattr(self, field.name) for field in fields(self)]
