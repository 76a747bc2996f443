"""What the user says is wrong with a log's numbers: signs, zeros, coupled joints, late torques."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python, number_in
from gd_analyze.units import Quantity, joint_units

_COUPLED = re.compile(r"q(\d{1,4})=(.+)")
_TERM = re.compile(r"([+-]?)(?:(\d+\.?\d*|\.\d+)\*)?q(\d{1,4})")
# A torque that lags more is another motion's.
_LONGEST_LAG_SECONDS = 10.0


@dataclass(frozen=True)
class Corrections:
    """Corrections of a log, in the order in which they are done; empty ones change nothing.

    Parameters
    ----------
    couple
        Joint variables as sums of those logged: "q3=q3-q2", counted from 1. Torques go by the transposed
        inverse, so that power stays the same.
    position_sign
        -1 for a joint that counts the other way, (n,), or one for all: positions and torques are reversed.
    torque_sign
        -1 for a joint whose torque alone is reversed, (n,), or one for all.
    offset
        Number of a joint from 1, or its name, and an angle (length) that is added to its positions; without
        a unit rad (m).
    lag
        Time by which torques are late, s; negative if they are early.

    Raises
    ------
    UsageError
        If one cannot be read.
    """

    couple: tuple[str, ...] = ()
    position_sign: tuple[float, ...] = ()
    torque_sign: tuple[float, ...] = ()
    offset: tuple[tuple[str, Quantity], ...] = ()
    lag: float = 0.0

    @classmethod
    def of(
        cls,
        couple: Iterable[str] | str = (),
        position_sign: str | Iterable[float] = (),
        torque_sign: str | Iterable[float] = (),
        offset: Iterable[str] | Mapping[str, float | str] = (),
        lag: str | float = 0.0,
    ) -> Corrections:
        """Parse words as typed: "q3=q3-q2", "1,-1,1", "-1", "3=90deg", "4ms"."""
        offsets = (
            offset.items() if isinstance(offset, Mapping) else (str(w).rpartition("=")[::2] for w in offset)
        )
        return cls(
            (couple,) if isinstance(couple, str) else tuple(couple),
            _signs(position_sign, "--position-sign"),
            _signs(torque_sign, "--torque-sign"),
            tuple(_offset(str(joint).strip(), value) for joint, value in offsets),
            _lag(lag),
        )

    def __bool__(self) -> bool:
        return self != Corrections()

    @property
    def words(self) -> str:
        """The corrections as options."""
        signs = {"--position-sign": self.position_sign, "--torque-sign": self.torque_sign}
        out = [f"--couple {word}" for word in self.couple]
        out += [f"{name} {','.join(f'{x:g}' for x in values)}" for name, values in signs.items() if values]
        out += [f"--offset {joint}={value}" for joint, value in self.offset]
        return " ".join(out + ([f"--lag {self.lag:g}s"] if self.lag else []))

    def applied(
        self, time: FloatArray, arrays: Mapping[str, FloatArray], arm: RobotArm
    ) -> dict[str, FloatArray]:
        """Correct q, qd, qdd and torque, (N, n) each, of those there are.

        Raises
        ------
        UsageError
            If a correction does not fit the arm, or concerns torques that there are not.
        """
        n, out = arm.n_joints, dict(arrays)
        position, torque = np.eye(n), np.eye(n)
        for word in self.couple:
            matrix = _coupling(word, arm)
            position, torque = matrix @ position, np.linalg.inv(matrix).T @ torque
        reverse = _for_joints(self.position_sign, "--position-sign", n)
        position, torque = reverse[:, None] * position, reverse[:, None] * torque
        torque = _for_joints(self.torque_sign, "--torque-sign", n)[:, None] * torque
        offset = np.zeros(n)
        for word, quantity in self.offset:
            joint = _joint(word, arm)
            offset[joint] += _of_kind(quantity, word, arm.is_revolute[joint])
        if "torque" not in out and (self.torque_sign or self.lag):
            raise UsageError(
                "the log has no torques to correct",
                where="--lag" if self.lag else "--torque-sign",
                expected="a log with columns of torque, or currents with --torque-constant",
                next_step="name them with --map 'torque=NAME*', or omit the option",
            )
        for role, matrix in (("q", position), ("qd", position), ("qdd", position), ("torque", torque)):
            # A missing reading of one joint is one of those it is summed with, and of no other.
            if role in out and not np.array_equal(matrix, np.eye(n)):
                out[role] = _multiplied(out[role], matrix)
        out["q"] = out["q"] + offset
        if self.lag:
            out["torque"] = _earlier(time, out["torque"], self.lag)
        return out


def _multiplied(values: FloatArray, matrix: FloatArray) -> FloatArray:
    columns = []
    for row in matrix:
        sources = np.flatnonzero(row)
        columns.append(values[:, sources] @ row[sources])
    return np.column_stack(columns)


def _earlier(time: FloatArray, torque: FloatArray, lag: float) -> FloatArray:
    """Torques as logged so much later; nan where the log has ended, or not begun."""
    out = np.full_like(torque, np.nan)
    for i, column in enumerate(torque.T):
        rows = np.flatnonzero(np.isfinite(column) & np.isfinite(time))
        rows = rows[np.argsort(time[rows], kind="stable")]
        if len(rows):
            out[:, i] = np.interp(time + lag, time[rows], column[rows], left=np.nan, right=np.nan)
    return out


def _signs(signs: str | Iterable[float], option: str) -> tuple[float, ...]:
    values: list[Any] = [number_in(word) for word in signs.split(",")] if isinstance(signs, str) else [*signs]
    if any(value not in (1.0, -1.0) for value in values):
        raise UsageError(
            "these are not signs",
            where=option,
            expected="1 or -1 per joint, with commas, or one for all",
            found=in_python(signs),
            next_step=f"{option} -1 reverses all joints, {option} 1,-1,1 the second of three",
        )
    return tuple(float(value) for value in values)


def _for_joints(values: tuple[float, ...], option: str, n: int) -> FloatArray:
    if len(values) not in (0, 1, n):
        raise UsageError(
            "the signs do not fit the arm",
            where=option,
            expected=f"{n} signs, or one for all",
            found=str(len(values)),
            next_step=f"{option} {','.join(['-1', *['1'] * (n - 1)])} reverses the first joint",
        )
    return np.ones(n) if not values else np.array(values if len(values) == n else values * n)


def _offset(joint: str, value: object) -> tuple[str, Quantity]:
    quantity = Quantity.read(value)
    if not joint or quantity is None or quantity.kind not in ("", "angle", "length"):
        raise UsageError(
            "no joint with an offset",
            where="--offset",
            expected="a joint's number or name and a value in rad or m, or with a unit: 3=90deg, slide=20mm",
            found=in_python(f"{joint}={value}" if joint else value),
            next_step="--offset 3=90deg adds 90 degrees to the positions of joint 3",
        )
    return joint, quantity


def _of_kind(quantity: Quantity, word: str, revolute: bool) -> float:
    """Offset of a joint that turns (slides), rad (m)."""
    value = quantity.of_joint(revolute)
    if value is None:
        unit = "deg" if revolute else "mm"
        step = f"--offset {word}={quantity.si:g}{unit} if it is in {unit}"
        if quantity.kind:
            step = f"check the joint's number; of this one: --offset {word}=5{unit}"
        raise UsageError(
            f"this is no offset of joint {word}, which {'turns' if revolute else 'slides'}",
            where="--offset",
            expected=joint_units(revolute),
            found=f"{word}={quantity}",
            next_step=step,
        )
    return value


def _lag(lag: str | float) -> float:
    # A text needs a unit: a number alone could be rows of the log.
    quantity = Quantity.parse(lag) if isinstance(lag, str) else Quantity(float(lag), "time")
    if quantity is None or quantity.kind != "time" or not abs(quantity.si) <= _LONGEST_LAG_SECONDS:
        raise UsageError(
            "this is no lag",
            where="--lag",
            expected=f"up to {_LONGEST_LAG_SECONDS:g} s, with the unit: 4ms, -0.01s",
            found=in_python(lag),
            next_step="--lag 4ms if torques are 4 ms late, --lag -4ms if they are early",
        )
    return quantity.si


def _joint(word: str, arm: RobotArm) -> int:
    """Place of a joint, from 0, by its name or number from 1."""
    number = arm.joint_number(word)
    if number is None:
        names = [joint.name for joint in arm.joints]
        raise UsageError(
            f"there is no joint {word!r}",
            where="--offset",
            expected=f"a number of 1 to {len(names)}, or a name: {', '.join(names)}",
            found=in_python(word),
            next_step=f"--offset {len(names)}=0.1 is of the last joint",
        )
    return number


def _coupling(word: str, arm: RobotArm) -> FloatArray:
    """Matrix of a joint's variable as a sum."""
    n, match = arm.n_joints, _COUPLED.fullmatch(re.sub(r"\s", "", word))
    terms = list(_TERM.finditer(match[2])) if match else []
    matrix = np.eye(n)
    readable = match is not None and terms and "".join(term[0] for term in terms) == match[2]
    signed = readable and all(term[1] for term in terms[1:])
    joints = [int(term[3]) for term in terms] + ([int(match[1])] if match else [])
    if signed and match is not None and all(1 <= joint <= n for joint in joints):
        row = np.zeros(n)
        for term in terms:
            row[int(term[3]) - 1] += float(term[2] or 1.0) * (-1.0 if term[1] == "-" else 1.0)
        matrix[int(match[1]) - 1] = row
        if row[int(match[1]) - 1] != 0.0 and np.isfinite(row).all():
            return matrix
    raise UsageError(
        "this does not couple joints",
        where="--couple",
        expected=f"a joint's variable as a sum that contains it, joints from 1 to {n}: q3=q3-q2",
        found=in_python(word),
        next_step=f"--couple q{n}=q{n}-q{max(n - 1, 1)} if joint {n} is logged with joint {max(n - 1, 1)}"
        if n > 1
        else "omit --couple: the arm has one joint",
    )
