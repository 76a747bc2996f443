"""Rotations, exact at right angles, and Denavit-Hartenberg rows, standard (FGL87) and modified (Craig).

Makers' files write 1.5708 for pi/2. The difference of 4e-6 rad would turn zeros of the equations of motion
into terms, and parallel axes into skew ones.
"""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass, field

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.parts import DHRow, JointKind, Placement

# 1.5708 is 3.7e-6 rad off pi/2, 3.1416 is 7.3e-6 off pi; no joint is assembled that exactly.
RIGHT = 1e-5
# 3.14 is 1.6e-3 rad off pi. Real joints may be misaligned as much, so this is only suspected.
_SUSPECT_RIGHT_ANGLE = 2e-3
# No dimension of an arm is known to nanometres.
_NEGLIGIBLE_METRES = 1e-9
# Residue of a zero after a dozen products of rotations with entries up to 1: over 50 round-offs.
_ROUND_OFF = 1e-12


def exact_cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine with exact zeros and ones at multiples of a right angle.

    cos(pi/2) in floating point is 6e-17, which would turn structural zeros of the dynamics into noise.
    """
    quarter_turns = angle / (math.pi / 2)
    nearest = round(quarter_turns)
    if abs(quarter_turns - nearest) <= 4 * np.finfo(float).eps * max(1.0, abs(quarter_turns)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(angle), math.sin(angle)


def _about(axis: int, angle: float) -> FloatArray:
    """Rotation about x (0), y (1) or z (2)."""
    turn, j, k = np.eye(3), (axis + 1) % 3, (axis + 2) % 3
    cosine, sine = exact_cos_sin(angle)
    turn[j, j] = turn[k, k] = cosine
    turn[k, j], turn[j, k] = sine, -sine
    return turn


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rotation about x, then y, then z of the fixed frame, as in URDF; no negative zeros."""
    return _about(2, yaw) @ _about(1, pitch) @ _about(0, roll) + 0.0


def angles_of(rotation: FloatArray) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a rotation, rad, to round-off; pitch within a quarter turn."""
    cosine = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], cosine)
    if cosine < 1e-9:  # roll and yaw then turn about the same axis
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    roll, yaw = math.atan2(rotation[2, 1], rotation[2, 2]), math.atan2(rotation[1, 0], rotation[0, 0])
    return roll, pitch, yaw


def standard_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of A_i = Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha).

    The constant part of the joint's motion commutes with it and is applied after it, so that the joint
    frame's origin stays p_{i-1}; a prismatic joint's theta turns the frame. [FGL87] Eq. (3.2-5).
    """
    behind = Placement(_about(0, row.alpha), np.array([row.a, 0.0, row.d]))
    turn = _about(2, row.theta)
    if kind == "prismatic":
        return Placement(turn), behind
    return Placement(), Placement(turn @ behind.rotation, turn @ behind.translation)


def modified_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)."""
    before = Placement(_about(0, row.alpha), np.array([row.a, 0.0, 0.0]))
    return before, Placement(_about(2, row.theta), np.array([0.0, 0.0, row.d]))


# The two placements of a row, by convention.
CONVENTIONS = {"standard": standard_placements, "modified": modified_placements}


@dataclass
class RightAngles:
    """Largest changes by link, and doubts; a joint's numbers are listed under its child link."""

    angles: dict[str, float] = field(default_factory=dict)  # rad
    lengths: dict[str, float] = field(default_factory=dict)  # m
    suspects: list[tuple[str, str]] = field(default_factory=list)  # link, sentence

    def angle(self, text: str, link: str, place: object, turn: float = 2 * math.pi) -> str:
        """An angle as written, right angles exact; `turn` is a full turn, `place` the line for a doubt."""
        value, quarter = float(text), turn / 4
        if abs(value) > (1.0 + 1e-4) * turn:
            doubt = (
                f"{place}: an angle of {text} is more than a full turn, {turn:.4g}; is it in another unit?"
            )
            self.suspects.append((link, doubt))
        near = round(value / quarter)
        deviation = abs(value - near * quarter) * 2 * math.pi / turn
        if deviation <= RIGHT:
            # Rounding of the number as written is not a change.
            if deviation > 8 * np.finfo(float).eps * max(1.0, abs(near)):
                _note(self.angles, link, deviation)
            return repr(near * quarter)
        if (
            near
            and deviation <= _SUSPECT_RIGHT_ANGLE
            and deviation * turn / (2 * math.pi) <= 10.0 ** -_decimals(text)
        ):
            doubt = (
                f"{place}: an angle of {text} is {deviation:.1g} rad off a right angle and used as written; "
                f"if {near * quarter:.6g} is meant, give six digits"
            )
            self.suspects.append((link, doubt))
        return text

    def length(self, text: str, link: str) -> str:
        """A coordinate as written; "0" below a nanometre."""
        if not 0 < abs(float(text)) < _NEGLIGIBLE_METRES:
            return text
        _note(self.lengths, link, abs(float(text)))
        return "0"

    def direction(self, numbers: Sequence[float], link: str) -> FloatArray:
        """Unit vector along a direction of any length, with exact zeros."""
        vector = np.array(numbers) / np.abs(numbers).max()  # whose square might overflow
        vector /= np.linalg.norm(vector)
        small = np.abs(vector) <= RIGHT
        self._note_turn(link, float(np.linalg.norm(vector[small])))
        cleaned = np.where(small, 0.0, vector)
        out: FloatArray = cleaned / np.linalg.norm(cleaned)
        return out

    def rotation(self, rotation: FloatArray, words: Sequence[str], link: str, place: object) -> FloatArray:
        """A rotation with exact zeros, made orthonormal; `words` are its numbers as written."""
        cleaned = straight(rotation, RIGHT)
        deviation, digits = float(np.abs(rotation - np.round(rotation)).max()), min(map(_decimals, words))
        if RIGHT < deviation <= min(_SUSPECT_RIGHT_ANGLE, 4 * 10.0**-digits):
            doubt = (
                f"a rotation of {' '.join(words)} is {deviation:.1g} off a right angle and used as written"
            )
            self.suspects.append((link, f"{place}: {doubt}; if a right angle is meant, give six digits"))
        self._note_turn(link, float(np.linalg.norm(cleaned - rotation)) / math.sqrt(2))
        return cleaned

    def _note_turn(self, link: str, change: float) -> None:
        if change > 16 * np.finfo(float).eps:
            _note(self.angles, link, change)

    def assumptions(self, links: Container[str]) -> tuple[str, ...]:
        """Changes made to some links: a sentence for angles and one for lengths, each with the largest."""
        sentences = []
        for changes, sentence, unit in (
            (self.angles, f"Angles within {RIGHT:g} rad of a right angle are made right", "rad"),
            (self.lengths, f"Lengths below {_NEGLIGIBLE_METRES:g} m are set to 0", "m"),
        ):
            of_links = {link: change for link, change in changes.items() if link in links}
            if of_links:
                worst = max(of_links, key=lambda link: of_links[link])
                largest = f"largest change {of_links[worst]:.2g} {unit} ({worst})"
                sentences.append(f"{sentence}: links changed {len(of_links)}, {largest}.")
        return tuple(sentences)


def _note(changes: dict[str, float], link: str, change: float) -> None:
    changes[link] = max(change, changes.get(link, 0.0))


def straight(rotation: FloatArray, tolerance: float = _ROUND_OFF) -> FloatArray:
    """Set entries of a rotation below the tolerance to 0 and make its rows orthonormal again.

    The rows with the most zeros come first, so that no zero is lost to those that follow.
    """
    out = np.where(np.abs(rotation) <= tolerance, 0.0, rotation)
    fixed: list[FloatArray] = []
    for i in np.argsort(np.count_nonzero(out, axis=1), kind="stable"):
        for row in fixed:
            out[i] -= (out[i] @ row) * row
        out[i][np.abs(out[i]) <= tolerance] = 0.0
        out[i] /= np.linalg.norm(out[i])
        fixed.append(out[i])
    return out


def without_round_off(values: FloatArray, scale: float | None = None) -> FloatArray:
    """Set values to 0 that are round-off relative to `scale`, or else to the largest value and 1."""
    scale = max(1.0, float(np.abs(values).max())) if scale is None else scale
    out: FloatArray = np.where(np.abs(values) <= _ROUND_OFF * scale, 0.0, values)
    return out


def _decimals(text: str) -> int:
    """Digits behind the point of a number as written."""
    mantissa, _, exponent = text.lower().partition("e")
    return len(mantissa.partition(".")[2]) - int(exponent or 0)
