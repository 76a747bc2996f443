"""The numbers of an arm as symbols: lengths, angles, masses, centres of mass, inertias and gravity.

Zeros stay numbers, and so do the ones of rotations and axes: they determine which terms exist.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.harmonics.symbolic_number import SymbolicNumber
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import table_convention
from gd_analyze.robots.frames import exact_cos_sin
from gd_analyze.robots.parts import DHRow, Link, Placement

# Constant angles of a joint: theta and alpha of its Denavit-Hartenberg row, or one of its placement.
ANGLES_PER_JOINT = 2
# The entries of a turn about an axis of the frame are cosine and sine of its angle up to a few roundings.
_TURN_ROUNDING = 8 * float(np.finfo(float).eps)
_TURNS = ("alpha", "beta", "gamma")


@dataclass(frozen=True)
class ArmSymbol:
    """A symbol, and the number of the arm that it stands for."""

    letter: str  # "a", "m", "I", "alpha"
    index: str  # "2", "2xx"
    number: float
    unit: str

    @property
    def name(self) -> str:
        """Letter and index, a name in Python, too: a2, I2xx, alpha3."""
        return self.letter + self.index


class SymbolicArm:
    """The joints i..n of an arm with symbols for numbers: what formulations read of a `RobotArm`.

    The base is joint i's own frame, as no element of D behind joint i depends on what is before it. Hashable
    by identity, so that its kinematics are cached.
    """

    def __init__(self, joints: list[Any], links: list[Any], is_revolute: tuple[bool, ...]) -> None:
        self.joints, self.links, self.is_revolute = joints, links, is_revolute
        self.n_joints = len(joints)
        self.mass = np.array([link.mass for link in links], dtype=object)
        self.com = np.array([link.com for link in links], dtype=object)
        self.inertia_com = np.array([link.inertia_com for link in links], dtype=object)


class ArmSymbols:
    """The symbols of an arm, and its parts in terms of them.

    As variables of a `SymbolicNumber`, the joints' come first, then `ANGLES_PER_JOINT` constant angles of
    every joint, then `lengths_and_masses`.
    """

    def __init__(self, arm: RobotArm) -> None:
        self.arm = arm
        n = arm.n_joints
        # None where there is no such angle or a right one.
        self.angles: list[ArmSymbol | None] = [None] * (ANGLES_PER_JOINT * n)
        self.lengths_and_masses: list[ArmSymbol] = []
        has_table = table_convention(arm) != "placement"
        self._joints: list[Any] = []
        self._links: list[Any] = []
        for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
            if has_table:
                placement, frame = self._of_table(
                    i, arm.dh_table[i], joint.kind, "modified" in arm.convention
                )
                com, inertia = link.com, link.inertia_com
            else:
                inner = Placement() if i == 0 else arm.links[i - 1].frame
                placement = self._placement(_composed(inner, joint.placement), i)
                frame = Placement()
                com, inertia = _in_joint_frame(link)
            axis = self._vector(joint.axis, "e", i, "", ones=True)
            self._joints.append(SimpleNamespace(placement=placement, axis=axis))
            self._links.append(
                SimpleNamespace(
                    frame=frame,
                    mass=self._other(link.mass, "m", str(i + 1), "kg"),
                    com=self._components(com, i),
                    inertia_com=self._inertia(inertia, i),
                )
            )
        self.gravity = self._gravity(arm.gravity_vector)

    @property
    def used(self) -> tuple[ArmSymbol, ...]:
        """All symbols, angles last."""
        return (*self.lengths_and_masses, *(angle for angle in self.angles if angle is not None))

    def behind(self, first: int) -> tuple[Any, Array]:
        """A `SymbolicArm` from a joint on (from 0), and variables, the first at zero: (n - first, 1)."""
        joints = self._joints[first:]
        joints[0] = SimpleNamespace(placement=Placement(), axis=joints[0].axis)
        at_zero = _Variable(0.0, 1.0, 0.0)
        q = [at_zero, *(self._variable(j) for j in range(first + 1, self.arm.n_joints))]
        arm = SymbolicArm(joints, self._links[first:], self.arm.is_revolute[first:])
        return arm, np.array([[variable] for variable in q], dtype=object)

    def whole(self) -> tuple[Any, Array]:
        """The whole `SymbolicArm` on its base, and its variables, shape (n, 1)."""
        q = [[self._variable(j)] for j in range(self.arm.n_joints)]
        return SymbolicArm(self._joints, self._links, self.arm.is_revolute), np.array(q, dtype=object)

    def _variable(self, joint: int) -> _Variable:
        if self.arm.is_revolute[joint]:
            return _Variable(None, SymbolicNumber.cosine(joint), SymbolicNumber.sine(joint))
        # Nothing uses the cosine and sine that are taken of a distance.
        return _Variable(SymbolicNumber.variable(joint), math.nan, math.nan)

    def _other(self, value: float, letter: str, index: str, unit: str) -> SymbolicNumber | float:
        """A symbol for a number that is not zero."""
        if value == 0.0:
            return 0.0
        self.lengths_and_masses.append(ArmSymbol(letter, index, float(value), unit))
        return SymbolicNumber.variable(
            self.arm.n_joints + len(self.angles) + len(self.lengths_and_masses) - 1
        )

    def _components(self, com: FloatArray, i: int) -> Array:
        """A centre of mass: x2, y2, z2."""
        values = zip("xyz", com, strict=True)
        return np.array([self._other(value, x, str(i + 1), "m") for x, value in values], dtype=object)

    def _vector(self, values: FloatArray, letter: str, i: int, unit: str, ones: bool = False) -> Array:
        """A constant vector; `ones` stay numbers in directions."""
        return np.array(
            [
                float(value)
                if ones and abs(value) == 1.0
                else self._other(value, letter, f"{i + 1}{x}", unit)
                for x, value in zip("xyz", values, strict=True)
            ],
            dtype=object,
        )

    def _inertia(self, tensor: FloatArray, i: int) -> Array:
        out = np.full((3, 3), 0.0, dtype=object)
        for a in range(3):
            for b in range(a, 3):
                index = f"{i + 1}{'xyz'[a]}{'xyz'[b]}"
                out[a, b] = out[b, a] = self._other(tensor[a, b], "I", index, "kg m^2")
        return out

    def _gravity(self, gravity: FloatArray) -> Array:
        """Components; g and -g where gravity has the direction of an axis."""
        acting = np.flatnonzero(gravity)
        out = np.full(3, 0.0, dtype=object)
        for a in acting:
            if len(acting) == 1:
                size = self._other(abs(gravity[a]), "g", "", "m/s^2")
                out[a] = size if gravity[a] > 0 else -size
            else:
                out[a] = self._other(gravity[a], "g", "xyz"[a], "m/s^2")
        return out

    def _cos_sin(self, value: float, letter: str, i: int, place: int) -> tuple[Any, Any]:
        """Cosine and sine of a constant angle; numbers where it is right."""
        cosine, sine = exact_cos_sin(value)
        if 0.0 in (cosine, sine):
            return cosine, sine
        number = ANGLES_PER_JOINT * i + place
        self.angles[number] = ArmSymbol(letter, str(i + 1), value, "rad")
        number += self.arm.n_joints
        return SymbolicNumber.cosine(number), SymbolicNumber.sine(number)

    def _of_table(self, i: int, row: DHRow, kind: str, modified: bool) -> tuple[Any, Any]:
        """Joint placement and link frame of a row, as `frames.CONVENTIONS` has them."""
        theta = _turn(2, *self._cos_sin(row.theta, "theta", i, 0))
        alpha = _turn(0, *self._cos_sin(row.alpha, "alpha", i, 1))
        along_x = np.array([self._other(row.a, "a", str(i + 1), "m"), 0.0, 0.0], dtype=object)
        # d3 is the variable of a prismatic joint 3.
        letter: Literal["d", "l"] = "d" if kind == "revolute" else "l"
        along_z = np.array([0.0, 0.0, self._other(row.d, letter, str(i + 1), "m")], dtype=object)
        if modified:
            before, behind = _placed(alpha, along_x), _placed(theta, along_z)
        elif kind == "prismatic":
            before, behind = _placed(theta, np.zeros(3)), _placed(alpha, along_x + along_z)
        else:
            before = _placed(np.eye(3), np.zeros(3))
            behind = _placed(np.dot(theta, alpha), np.dot(theta, along_x + along_z))
        return before, behind

    def _placement(self, placement: Placement, i: int) -> Any:
        """A placement with symbols for its lengths, and for its angle about an axis or else its entries."""
        translation = self._vector(placement.translation, "p", i, "m")
        rotation = placement.rotation
        axis = _turning_axis(rotation)
        if axis is not None:
            j, k = (axis + 1) % 3, (axis + 2) % 3
            value = math.atan2(rotation[k, j], rotation[j, j])
            return _placed(_turn(axis, *self._cos_sin(value, _TURNS[axis], i, 0)), translation)
        out = np.full((3, 3), 0.0, dtype=object)
        for a, b in np.ndindex(3, 3):
            value = float(rotation[a, b])
            index = f"{i + 1}{'xyz'[a]}{'xyz'[b]}"
            out[a, b] = value if abs(value) == 1.0 else self._other(value, "R", index, "")
        return _placed(out, translation)


class _Variable:
    """A joint's variable: the array code takes cosine and sine of one, and multiplies by the value."""

    def __init__(self, value: Any, cosine: Any, sine: Any) -> None:
        self._value, self._cosine, self._sine = value, cosine, sine

    def __mul__(self, other: Any) -> Any:
        return self._value * other

    __rmul__ = __mul__

    def cos(self) -> Any:
        """Cosine, as `numpy.cos` takes it of objects."""
        return self._cosine

    def sin(self) -> Any:
        """Sine, as `numpy.sin` takes it of objects."""
        return self._sine


def _composed(inner: Placement, outer: Placement) -> Placement:
    """One placement after another; exact where the inner one is none."""
    if _is_none(inner):
        return outer
    translation = inner.translation + inner.rotation @ outer.translation
    return Placement(_without_round_off(inner.rotation @ outer.rotation), _without_round_off(translation))


def _in_joint_frame(link: Link) -> tuple[FloatArray, FloatArray]:
    """Centre of mass and inertia in the joint's moved frame; exact where the link's frame is that frame."""
    if _is_none(link.frame):
        return link.com, link.inertia_com
    rotation = link.frame.rotation
    inertia = _without_round_off(rotation @ link.inertia_com @ rotation.T)
    return _without_round_off(link.frame.translation + rotation @ link.com), (inertia + inertia.T) / 2


def _is_none(placement: Placement) -> bool:
    return np.array_equal(placement.rotation, np.eye(3)) and not placement.translation.any()


def _without_round_off(values: FloatArray) -> FloatArray:
    """Zero for what a few roundings of the largest value leave of a zero."""
    out: FloatArray = np.where(np.abs(values) <= _TURN_ROUNDING * np.abs(values).max(), 0.0, values)
    return out


def _placed(rotation: Array, translation: Array) -> Any:
    return SimpleNamespace(rotation=rotation, translation=translation)


def _turn(axis: int, cosine: Any, sine: Any) -> Array:
    """Turn about x (0), y (1) or z (2), with exact zeros and ones."""
    out = np.full((3, 3), 0.0, dtype=object)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    out[axis, axis], out[j, j], out[k, k] = 1.0, cosine, cosine
    out[k, j], out[j, k] = sine, -sine
    return out


def _turning_axis(rotation: FloatArray) -> int | None:
    """The axis of the frame that a rotation turns about, unless its angle is right; None if there is none."""
    for axis in range(3):
        j, k = (axis + 1) % 3, (axis + 2) % 3
        angle = math.atan2(rotation[k, j], rotation[j, j])
        turn = _turn(axis, *exact_cos_sin(angle)).astype(float)
        if (
            np.abs(rotation - turn).max() <= _TURN_ROUNDING
            and not np.isin(np.abs(rotation), (0.0, 1.0)).all()
        ):
            return axis
    return None
