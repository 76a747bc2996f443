"""Corrections in words: signs, zeros, coupled joints and late torques as options.

Words become a `Correction` once the arm is known (`Corrections.of_arm`); `typed` makes words of it again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError, argument
from gd_analyze.motions.correction import Correction, inverse
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, in_python, number_in
from gd_analyze.units import UNITS, Quantity, joint_units

_TERM = re.compile(r"([+-]?)(?:(\d+\.?\d*|\.\d+)\*)?q(\d{1,4})")
_COUPLED = re.compile(rf"q(\d{{1,4}})=({_TERM.pattern}(?:(?=[+-]){_TERM.pattern})*)")
# A torque that lags more is another motion's.
LONGEST_LAG_SECONDS = 10.0
# Condition number beyond which coupled joints cannot be told apart any more; of counts of an encoder, and of
# radians beside them, it is some 1e7.
_LARGEST_CONDITION = 1e9
# Significant digits of factors, of which the last of a double are round-off, and of a value in a small unit.
_DIGITS_OF_FACTORS, _DIGITS_IN_SMALL_UNIT = 12, 9
# Share of a row's largest factor below which one is round-off.
_ROUND_OFF_SHARE = 1e-10


@dataclass(frozen=True)
class Corrections:
    """Corrections of a log as typed, in the order in which they are done; empty ones change nothing.

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
            _signs(position_sign, "position_sign"),
            _signs(torque_sign, "torque_sign"),
            tuple(_offset(str(joint).strip(), value) for joint, value in offsets),
            _lag(lag),
        )

    def __bool__(self) -> bool:
        return self != Corrections()

    def of_arm(self, arm: RobotArm, torque_constant: Sequence[float | None] = ()) -> Correction:
        """Numbers for an arm's joints; torque constants are applied first.

        Raises
        ------
        UsageError
            If a correction, or the torque constants, do not fit the arm.
        """
        n = arm.n_joints
        correction = Correction.none(n)
        if torque_constant:
            if len(torque_constant) != n:
                message, expected = "the torque constants do not fit the arm", f"{n} numbers, N m/A (N/A)"
                step, count = "give one for every joint, with commas", str(len(torque_constant))
                raise _unusable(message, "torque_constant", expected, count, step)
            correction = correction.with_torque(np.diag(np.array(torque_constant, dtype=float)))
        for word in self.couple:
            correction = correction.with_joints(_coupling(word, arm))
        if not np.linalg.cond(correction.position) < _LARGEST_CONDITION:
            message = "these sums couple joints so that one variable follows from the others"
            expected = "sums of which the variables as logged can be found again"
            step = "check the factors; a single joint needs one sum: `couple='q3=q3-q2'`"
            raise _unusable(message, "couple", expected, ", ".join(self.couple), step)
        correction = correction.with_joints(_for_joints(self.position_sign, "position_sign", n))
        correction = correction.with_torque(_for_joints(self.torque_sign, "torque_sign", n))
        for word, quantity in self.offset:
            joint = _joint(word, arm)
            correction = correction.with_offset(joint, _of_kind(quantity, word, arm.is_revolute[joint]))
        return replace(correction, lag=self.lag)

    def require_torques(self) -> None:
        """Refuse what concerns the torques of a log that has none."""
        if self.torque_sign or self.lag:
            name = "lag" if self.lag else "torque_sign"
            expected = "a log with columns of torque, or currents with `torque_constant`"
            step = f"name them with {argument('map', 'torque=NAME*')}, or omit it"
            raise _unusable("the log has no torques to correct", name, expected, None, step)


def typed(correction: Correction, revolute: Sequence[bool]) -> dict[str, str | list[str]]:
    """Words that make a correction, by keywords of `Reading.of`: the way back from `Corrections.of_arm`."""
    position, n = correction.position, len(revolute)
    turned = np.where((position == -np.eye(n)).all(axis=1), -1.0, 1.0)
    constants, signs = _constants(position, correction.torque)
    typed_constants = ",".join(map(_decimal, constants))
    words: dict[str, str | list[str]] = {
        "torque_constant": typed_constants if {*typed_constants.split(",")} != {"1"} else "",
        "couple": _sums(turned[:, None] * position),
        "position_sign": _typed_signs(turned),
        "torque_sign": _typed_signs(signs),
        "offset": [
            f"{i}={_quantity(x, 'deg' if revolute[i - 1] else 'mm')}"
            for i, x in enumerate(correction.offset.tolist(), start=1)
            if x
        ],
        "lag": _quantity(correction.lag, "ms") if correction.lag else "",
    }
    return {keyword: word for keyword, word in words.items() if word}


def as_options(words: Mapping[str, Any]) -> list[str]:
    """Keywords of `Reading.of` as words of the command line; True is a flag."""
    out = []
    for keyword, value in words.items():
        option = f"--{keyword.replace('_', '-')}"
        for word in value if isinstance(value, list) else [value]:
            text = f"{word:g}" if isinstance(word, float) else str(word)
            out += [option] if word is True else [option, text]
    return out


def _constants(position: FloatArray, torque: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Constants before the transposed inverse of positions, and signs after it, (n,) each, of torques."""
    power = _without_round_off(inverse(position).T)
    is_made = power != 0.0
    ratios = np.divide(torque, power, out=np.zeros_like(torque), where=is_made)
    constants, signs = np.zeros(len(power)), np.zeros(len(power))
    while (signs == 0.0).any():
        # A joint whose torque is made of some that are known has no choice of its sign.
        is_known = is_made & (constants != 0.0)
        joint = max(np.flatnonzero(signs == 0.0), key=lambda i: is_known[i].any())
        source = int((is_known if is_known[joint].any() else is_made)[joint].argmax())
        signs[joint] = np.copysign(1.0, ratios[joint, source] * (constants[source] or 1.0))
        constants[is_made[joint]] = signs[joint] * ratios[joint, is_made[joint]]
    return constants, signs


def _sums(position: FloatArray) -> list[str]:
    """Sums, each of one joint's variable and in the order in which they are done, that make a matrix."""
    done, words = np.eye(len(position)), []
    missing = np.flatnonzero((position != done).any(axis=1)).tolist()
    while missing:
        # What each is of the variables that the sums before it make: a sum must contain its own.
        rows = _without_round_off(position[missing] @ inverse(done))
        own = np.abs(rows[range(len(missing)), missing]) / np.abs(rows).max(axis=1)
        if own.any():
            row, joint = rows[own.argmax()], missing.pop(int(own.argmax()))
        else:
            # Joints are exchanged: one that the first is made of takes the first in.
            joint = next(j for j in missing if rows[0, j])
            row = np.eye(len(position))[[joint, missing[0]]].sum(axis=0)
        done[joint] = row @ done
        others = [_term(x, j) for j, x in enumerate(row.tolist()) if x and j != joint]
        words.append(f"q{joint + 1}={''.join([_term(row[joint], joint).removeprefix('+'), *others])}")
    return words


def _term(factor: float, joint: int) -> str:
    size = f"{_decimal(abs(factor))}*".removeprefix("1*")
    return f"{'-' if factor < 0.0 else '+'}{size}q{joint + 1}"


def _without_round_off(factors: FloatArray) -> FloatArray:
    """Factors with 0 for those that inverting a matrix leaves in its place."""
    is_factor = np.abs(factors) > _ROUND_OFF_SHARE * np.abs(factors).max(axis=1, keepdims=True)
    return np.where(is_factor, factors, 0.0)


def _decimal(value: float) -> str:
    """A number without an exponent."""
    return np.format_float_positional(float(f"{value:.{_DIGITS_OF_FACTORS}g}"), trim="-")


def _typed_signs(signs: FloatArray) -> str:
    if (signs == 1.0).all():
        return ""
    return "-1" if (signs == -1.0).all() else ",".join(f"{sign:g}" for sign in signs)


def _quantity(value: float, small: str) -> str:
    """A value with its unit that reads back the same: in a small unit, or else in that of SI."""
    sizes = next(sizes for sizes in UNITS.values() if small in sizes)
    text = f"{value / sizes[small]:.{_DIGITS_IN_SMALL_UNIT}g}{small}"
    quantity = Quantity.parse(text)
    return text if quantity is not None and quantity.si == value else f"{value!r}{next(iter(sizes))}"


def _signs(signs: str | Iterable[float], name: str) -> tuple[float, ...]:
    values: list[Any] = [number_in(word) for word in signs.split(",")] if isinstance(signs, str) else [*signs]
    if any(value not in (1.0, -1.0) for value in values):
        expected = "1 or -1 per joint, with commas, or one for all"
        step = f"{argument(name, '-1')} reverses all joints, {argument(name, '1,-1,1')} the second of three"
        raise _unusable("a sign is 1 or -1", name, expected, in_python(signs), step)
    return tuple(float(value) for value in values)


def _for_joints(values: tuple[float, ...], name: str, n: int) -> FloatArray:
    if len(values) not in (0, 1, n):
        expected = f"{n} signs, or one for all"
        step = f"{argument(name, ','.join(['-1', *['1'] * (n - 1)]))} reverses the first joint"
        raise _unusable("the signs do not fit the arm", name, expected, str(len(values)), step)
    return np.diag(np.broadcast_to(values or 1.0, n))


def _offset(joint: str, value: object) -> tuple[str, Quantity]:
    quantity = Quantity.read(value)
    if not joint or quantity is None or quantity.kind not in ("", "angle", "length"):
        expected = "a joint's number or name and a value in rad or m, or with a unit: 3=90deg, slide=20mm"
        word = in_python(f"{joint}={value}" if joint else value)
        step = "`offset=['3=90deg']` adds 90 degrees to the positions of joint 3"
        raise _unusable("an offset needs a joint and a value", "offset", expected, word, step)
    return joint, quantity


def _of_kind(quantity: Quantity, word: str, revolute: bool) -> float:
    """Offset of a joint that turns (slides), rad (m)."""
    value = quantity.of_joint(revolute)
    if value is None:
        unit = "deg" if revolute else "mm"
        step = f"{argument('offset', [f'{word}={quantity.si:g}{unit}'])} if it is in {unit}"
        if quantity.kind:
            step = f"check the joint's number; of this one: {argument('offset', [f'{word}=5{unit}'])}"
        message = f"this is no offset of joint {word}, which {'turns' if revolute else 'slides'}"
        raise _unusable(message, "offset", joint_units(revolute), f"{word}={quantity}", step)
    return value


def _lag(lag: str | float) -> float:
    # A text needs a unit: a number alone could be rows of the log.
    quantity = Quantity.parse(lag) if isinstance(lag, str) else Quantity(float(lag), "time")
    if quantity is None or quantity.kind != "time" or not abs(quantity.si) <= LONGEST_LAG_SECONDS:
        expected = f"up to {LONGEST_LAG_SECONDS:g} s, with the unit: 4ms, -0.01s"
        step = "`lag='4ms'` if torques are 4 ms late, `lag='-4ms'` if they are early"
        raise _unusable("a lag needs a time with its unit", "lag", expected, in_python(lag), step)
    return quantity.si


def _joint(word: str, arm: RobotArm) -> int:
    """Place of a joint, from 0, by its name or number from 1."""
    number = arm.joint_number(word)
    if number is None:
        n, names = arm.n_joints, ", ".join(joint.name for joint in arm.joints)
        expected, step = (
            f"a number of 1 to {n}, or a name: {names}",
            f"{argument('offset', [f'{n}=0.1'])} is of the last joint",
        )
        raise _unusable(f"there is no joint {word!r}", "offset", expected, in_python(word), step)
    return number


def _coupling(word: str, arm: RobotArm) -> FloatArray:
    """Matrix of a joint's variable as a sum."""
    n, match = arm.n_joints, _COUPLED.fullmatch(re.sub(r"\s", "", word))
    if match is not None:
        joint, matrix = int(match[1]), np.eye(n)
        terms = [(int(term[3]), float(f"{term[1]}{term[2] or 1}")) for term in _TERM.finditer(match[2])]
        if all(1 <= number <= n for number in (joint, *(number for number, _ in terms))):
            row = matrix[joint - 1]
            row[:] = 0.0
            for number, factor in terms:
                row[number - 1] += factor
            if row[joint - 1] != 0.0 and (np.abs(row) <= LARGEST).all():
                return matrix
    expected = f"a joint's variable as a sum that contains it, joints from 1 to {n}: q3=q3-q2"
    step = f"{argument('couple', f'q{n}=q{n}-q{n - 1}')} if joint {n} is logged with joint {n - 1}"
    if n == 1:
        step = "omit it: the arm has one joint"
    raise _unusable(
        "a coupled joint is a sum that contains the joint itself", "couple", expected, in_python(word), step
    )


def _unusable(message: str, name: str, expected: str, found: str | None, next_step: str) -> UsageError:
    return UsageError(message, where=name, expected=expected, found=found, next_step=next_step)
