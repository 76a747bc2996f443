"""Right angles written with few digits, made exact.

A maker's file says 1.5708 where pi/2 is meant. The rest of 4e-6 rad would turn zeros of the equations of
motion into terms, and parallel axes into skew ones.
"""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass, field

import numpy as np

from gd_analyze.arrays import FloatArray

# 1.5708 is 3.7e-6 rad off pi/2, 3.1416 is 7.3e-6 off pi; no joint is assembled as exactly as that.
RIGHT = 1e-5
# 3.14 is 1.6e-3 rad off pi. Joints are misaligned by as much, so that this is only suspected.
_SUSPECT = 2e-3
# Nobody measures nanometres of an arm.
_NO_LENGTH = 1e-9
# What remains of a zero after a dozen products of rotations, of entries up to 1: 50 round-offs and more.
_ROUND_OFF = 1e-12


@dataclass
class RightAngles:
    """Largest changes by link, and doubts; a joint's numbers are about the link that it leads to."""

    angles: dict[str, float] = field(default_factory=dict)  # rad
    lengths: dict[str, float] = field(default_factory=dict)  # m
    suspects: list[tuple[str, str]] = field(default_factory=list)  # link, sentence

    def angle(self, text: str, link: str, place: object, turn: float = 2 * math.pi) -> str:
        """An angle as written, right ones exact; a full turn is `turn`, and `place` its line, for a doubt."""
        value, quarter = float(text), turn / 4
        near = round(value / quarter)
        off = abs(value - near * quarter) * 2 * math.pi / turn
        if off <= RIGHT:
            # Round-off of the number as written is no change.
            if off > 8 * np.finfo(float).eps * max(1.0, abs(near)):
                _note(self.angles, link, off)
            return repr(near * quarter)
        if near and off <= _SUSPECT and off * turn / (2 * math.pi) <= 10.0 ** -_decimals(text):
            doubt = (
                f"{place}: an angle of {text} is {off:.1g} rad off a right angle and taken as written; "
                f"if {near * quarter:.6g} is meant, give it six digits"
            )
            self.suspects.append((link, doubt))
        return text

    def length(self, text: str, link: str) -> str:
        """A coordinate as written; "0" below a nanometre."""
        if not 0 < abs(float(text)) < _NO_LENGTH:
            return text
        _note(self.lengths, link, abs(float(text)))
        return "0"

    def direction(self, numbers: Sequence[float], link: str) -> FloatArray:
        """Unit vector along a direction of any length, with exact zeros."""
        vector = np.array(numbers) / np.abs(numbers).max()  # whose square might overflow
        vector /= np.linalg.norm(vector)
        small = np.abs(vector) <= RIGHT
        self._note_turn(link, float(np.linalg.norm(vector[small])))
        kept = np.where(small, 0.0, vector)
        out: FloatArray = kept / np.linalg.norm(kept)
        return out

    def rotation(self, rotation: FloatArray, link: str) -> FloatArray:
        """A rotation with exact zeros, orthonormal again."""
        found = straight(rotation, RIGHT)
        self._note_turn(link, float(np.linalg.norm(found - rotation)) / math.sqrt(2))
        return found

    def _note_turn(self, link: str, change: float) -> None:
        if change > 16 * np.finfo(float).eps:
            _note(self.angles, link, change)

    def assumptions(self, links: Container[str]) -> tuple[str, ...]:
        """Changes made to some links, and the largest, a sentence for angles and one for lengths."""
        sentences = []
        for changes, what, unit in (
            (self.angles, f"Angles within {RIGHT:g} rad of a right angle are taken as right", "rad"),
            (self.lengths, f"Lengths below {_NO_LENGTH:g} m are taken as 0", "m"),
        ):
            of_these = {link: change for link, change in changes.items() if link in links}
            if of_these:
                worst = max(of_these, key=lambda link: of_these[link])
                largest = f"largest change {of_these[worst]:.2g} {unit} ({worst})"
                sentences.append(f"{what}: links changed {len(of_these)}, {largest}.")
        return tuple(sentences)


def _note(changes: dict[str, float], link: str, change: float) -> None:
    changes[link] = max(change, changes.get(link, 0.0))


def straight(rotation: FloatArray, tolerance: float = _ROUND_OFF) -> FloatArray:
    """Set the smallest entries of a rotation to 0 and make its rows orthonormal again.

    The rows with the most zeros come first, so that no zero is lost to those that follow.
    """
    out = np.where(np.abs(rotation) <= tolerance, 0.0, rotation)
    done: list[FloatArray] = []
    for i in np.argsort(np.count_nonzero(out, axis=1), kind="stable"):
        for other in done:
            out[i] -= (out[i] @ other) * other
        out[i][np.abs(out[i]) <= tolerance] = 0.0
        out[i] /= np.linalg.norm(out[i])
        done.append(out[i])
    return out


def without_round_off(values: FloatArray, scale: float | None = None) -> FloatArray:
    """Set to 0 what is round-off beside `scale`, or else beside the largest value and 1."""
    scale = max(1.0, float(np.abs(values).max())) if scale is None else scale
    out: FloatArray = np.where(np.abs(values) <= _ROUND_OFF * scale, 0.0, values)
    return out


def _decimals(text: str) -> int:
    """Digits behind the point of a number as written."""
    mantissa, _, exponent = text.lower().partition("e")
    return len(mantissa.partition(".")[2]) - int(exponent or 0)
