"""Options and edits as a user types them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray

if TYPE_CHECKING:
    from gd_analyze.diagnosis.hypothesis import Problem

# Where an option begins in what is typed.
_OPTION_BEGINS = re.compile(r" (?=--)")


def comma_separated(values: Sequence[float]) -> str:
    """Numbers of an option, with commas."""
    return ",".join(f"{value:.4g}" for value in values)


def seconds(value: float) -> str:
    """A time with its unit: "4 ms"."""
    return f"{1e3 * value:.3g} ms" if abs(value) < 1.0 else f"{value:.3g} s"


def degrees(angle: float) -> str:
    """An angle as options take it, between -180deg and 180deg."""
    value = (np.degrees(angle) + 180.0) % 360.0 - 180.0
    return f"{180.0 if np.isclose(value, -180.0) else value:.4g}deg"


def vector(values: FloatArray) -> str:
    """A vector of an option."""
    return ",".join(f"{value + 0.0:.4g}" for value in np.round(values, 4))


def couple(joint: int, neighbour: int, factor: float) -> str:
    """The option that adds another joint's variable, joints from 0."""
    sign = "+" if factor > 0 else "-"
    size = "" if abs(factor) == 1.0 else f"{abs(factor):g}*"
    return f"--couple q{joint + 1}=q{joint + 1}{sign}{size}q{neighbour + 1}"


def scaled_positions(factors: FloatArray, torques: FloatArray) -> str:
    """Options that multiply joint variables and torques, each joint's by its own factors."""
    # --couple keeps power, so that it divides torques by the factors of positions.
    options = [
        f"--couple q{i + 1}={typed_number(x)}*q{i + 1}" for i, x in enumerate(factors.tolist()) if x != 1.0
    ]
    constants = [float(f"{x:.10g}") for x in factors * torques]
    if constants != [1.0] * len(constants):
        options.insert(0, f"--torque-constant {','.join(map(typed_number, constants))}")
    return " ".join(options)


def typed_number(value: float) -> str:
    """A number without an exponent."""
    return np.format_float_positional(value, precision=9, fractional=False, trim="-")


def map_of_torques(problem: Problem, source: Sequence[int]) -> str:
    """Options that take the torque of a joint from the column of another, joints from 0."""
    return _mapped(problem, source, ("torque",))


def map_of_positions(problem: Problem, source: Sequence[int]) -> str:
    """Options that take the motion of a joint from the columns of another, joints from 0."""
    return _mapped(problem, source, ("q", "qd", "qdd"))


def map_of_joints(problem: Problem, source: Sequence[int]) -> str:
    """Options that take all of a joint from the columns of another, joints from 0."""
    return _mapped(problem, source, ("q", "qd", "qdd", "torque"))


def typed_together(remedies: Sequence[str]) -> str:
    """Remedies of several causes: options as they are typed together, or one after the other."""
    if not all(remedy.startswith("--") for remedy in remedies):
        return "; ".join(remedies)
    options: dict[object, str] = {}
    for k, option in enumerate(option for remedy in remedies for option in _OPTION_BEGINS.split(remedy)):
        # A later cause's map says where the column is after the earlier ones.
        options[option.partition("=")[0] if option.startswith("--map ") else k] = option
    return " ".join(options.values())


def _mapped(problem: Problem, source: Sequence[int], roles: Sequence[str]) -> str:
    recording, correction = problem.samples.logs[0].recording, problem.correction
    names = [joint.name for joint in problem.arm.joints]
    uses = () if recording is None else recording.columns
    columns_by_role = {(str(use.role), use.joint): use.column for use in uses}
    options = []
    for role in roles:
        # Columns that are exchanged already are taken from where they are in the log.
        logged = _logged_at(correction.torque if role == "torque" else correction.position)
        options += [
            f"--map {shlex.quote(f'{role}:{names[i]}={columns_by_role[role, names[logged[k]]]}')}"
            for i, k in enumerate(source)
            if i != k and (role, names[logged[k]]) in columns_by_role
        ]
    if options:
        return " ".join(options)
    pairs = ", ".join(f"{i + 1} from {k + 1}" for i, k in enumerate(source) if i != k)
    return f"exchange the columns: joint {pairs}"


def _logged_at(matrix: FloatArray) -> list[int]:
    """Joint, from 0, whose column a joint's values come from; its own where they are made of several."""
    if (np.count_nonzero(matrix, axis=1) == 1).all():
        return np.abs(matrix).argmax(axis=1).tolist()
    return list(range(len(matrix)))
