"""Right angles written with few digits, made exact.

A maker's file says 1.5708 where pi/2 is meant. The rest of 4e-6 rad would turn zeros of the equations of
motion into terms, and parallel axes into skew ones.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable
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
    """Changes of angles and lengths by the link they are about, and angles that look like right ones.

    A joint's numbers are about the link that it leads to.
    """

    angles: dict[str, float] = field(default_factory=dict)
    lengths: dict[str, float] = field(default_factory=dict)
    suspects: list[tuple[str, str]] = field(default_factory=list)

    def angle(self, text: str, link: str, place: str, turn: float = 2 * math.pi) -> str:
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
        value = abs(float(text))
        if 0 < value < _NO_LENGTH:
            _note(self.lengths, link, value)
            return "0"
        return text

    def direction(self, numbers: Iterable[float], link: str) -> FloatArray:
        """Unit vector along a direction of any length, with exact zeros."""
        vector = np.array(list(numbers), dtype=float)
        vector = vector / np.abs(vector).max()
        vector = vector / np.linalg.norm(vector)
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
    kept = np.where(np.abs(rotation) <= tolerance, 0.0, rotation)
    rows: dict[int, FloatArray] = {}
    for i in sorted(range(3), key=lambda i: -int((kept[i] == 0.0).sum())):
        row = kept[i]
        for other in rows.values():
            row = row - (row @ other) * other
        row = np.where(np.abs(row) <= tolerance, 0.0, row)
        rows[i] = row / np.linalg.norm(row)
    return np.array([rows[i] for i in range(3)])


def without_round_off(values: FloatArray, scale: float) -> FloatArray:
    """Set to 0 what is round-off beside `scale`."""
    out: FloatArray = np.where(np.abs(values) <= _ROUND_OFF * scale, 0.0, values)
    return out


def _decimals(text: str) -> int:
    """Digits behind the point of a number as written."""
    mantissa, _, exponent = text.lower().partition("e")
    return len(mantissa.partition(".")[2]) - int(exponent or 0)
