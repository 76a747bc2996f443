"""Whether logs and an arm's file can both be right: doubts about an identified arm, none with a cause.

A fit follows torques in another unit, or of an arm that hangs from the ceiling, as far as parameters can.
What it finds is then far from the file, which is seldom off by more than a third.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence

import numpy as np

from gd_analyze.arrays import FloatArray, evenly
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits, warn_of_weight
from gd_analyze.errors import TorqueLimitWarning, UsageError
from gd_analyze.identification.rows import JointRows, Unknowns
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.plausibility import CHECKS
from gd_analyze.text import named_joints, number

# Ratio of identified and stated torque or inertia, or its inverse, beyond which no arm is written: files that
# state no drives are off by up to three, N mm, N cm and currents by ten and more.
_ANOTHER_UNIT = 10.0
# Ratio of gravity torques that calls for a look: masses and torque constants are off by up to a third; and of
# inertias, to which unstated drives add up to twice the links'.
_HEAVIER, _MORE_INERT = 1.5, 5.0
# Cosine between gravity torques below which they share nothing; or less than masses and centres explain.
_CONTRARY, _UNLIKE = 0.5, 0.8
# Share of the largest gravity torque below which a joint's says nothing.
_SMALL = 0.1
# Standard error of torque constants and gear efficiencies, of which nothing is known.
_CONSTANTS = 0.2
# Set points of a log at which models are compared.
_STATES = 300


def require_torque_of_this_size(
    arm: RobotArm, rows: Sequence[JointRows], start: FloatArray, unknowns: Unknowns
) -> None:
    """Refuse torques that are, friction aside, a tenth of the file's or less, or ten times as large."""
    squares = np.zeros(2)
    for i, each in enumerate(rows):
        first = unknowns.of_friction.start + 3 * i
        torques = np.column_stack([each.torque, each.columns @ start])
        friction = each.columns[:, first : first + 2]
        apart = torques - friction @ np.linalg.lstsq(friction, torques, rcond=None)[0]
        squares += np.square(apart).sum(axis=0)
    if not squares[1]:
        return
    ratio = float(np.sqrt(squares[0] / squares[1]))
    if not 1.0 / _ANOTHER_UNIT < ratio < _ANOTHER_UNIT:
        raise _contradiction(arm, f"measured torques, friction aside, are {number(ratio)} times the file's")


def _contradiction(arm: RobotArm, what: str) -> UsageError:
    return UsageError(
        f"log and file contradict each other: {what}",
        where=f"arm {arm.name}",
        expected="an arm and a log of it, torques in N m, or currents with --torque-constant",
        next_step="check the log's units, zeros and order of joints (`gd-analyze columns`), the file's "
        "masses and how the arm is mounted; a short or noisy log needs more motion",
    )


def doubts_of(
    given: RobotArm, made: RobotArm, motions: Sequence[Trajectory], *, physical: bool
) -> tuple[str, ...]:
    """Sentences on what is implausible of an identified arm, beside the file and its logs.

    Bodies of plain least squares may be impossible (`physical` is False), and are not checked.

    Raises
    ------
    UsageError
        If gravity torques of both have nothing in common, or inertias differ by a factor of ten.
    """
    states = _states_of(motions)
    found = list(_beyond_limits(given, made, states))
    if physical:
        found += _newly_implausible(given, made)
    if given.mass.any():
        found = [*_unlike_the_file(given, made, states), *found]
    return tuple(found)


def scale_error(given: RobotArm, made: RobotArm, motions: Sequence[Trajectory]) -> float:
    """Relative standard error of the torques' scale: how far gravity torques are from the file's, as RMS.

    Noise does not show the scale of torque constants. If they and the file's masses are right, both agree.
    """
    if not given.mass.any():
        return _CONSTANTS
    file, own = _gravity_torques(given, made, _states_of(motions))
    along, squares = (file * own).sum(axis=0), np.square(file).sum(axis=0)
    seen = squares > 0.0
    if not seen.any():
        return _CONSTANTS
    apart = along[seen] / squares[seen] - 1.0
    return float(np.sqrt(squares[seen] @ apart**2 / squares.sum()))


def _states_of(motions: Sequence[Trajectory]) -> States:
    """Some set points of logs."""
    few = [(motion, evenly(motion.n_set_points, _STATES)) for motion in motions]
    q, qd, qdd = (np.concatenate([getattr(log, x)[at] for log, at in few]) for x in ("q", "qd", "qdd"))
    return States(q, qd, qdd)


def _gravity_torques(given: RobotArm, made: RobotArm, states: States) -> tuple[FloatArray, FloatArray]:
    resting = States(states.q, np.zeros_like(states.q), np.zeros_like(states.q))
    file, own = (torque_of(arm, resting, drives=False) for arm in (given, made))
    return file, own


def _unlike_the_file(given: RobotArm, made: RobotArm, states: States) -> Iterator[str]:
    """Gravity torque and inertia beside the file's, in the positions of the logs."""
    n = given.n_joints
    file, own = _gravity_torques(given, made, states)
    sizes, others = (np.sqrt(np.square(torque).mean(axis=0)) for torque in (file, own))
    if file.any():
        if _cosine(file, own) < _CONTRARY:
            raise _contradiction(
                given,
                f"the gravity torques that fit are not the file's (cosine {number(_cosine(file, own))})",
            )
        counts = np.maximum(sizes, others) > _SMALL * max(sizes.max(), others.max())
        unlike = [i for i in range(n) if counts[i] and _cosine(file[:, i], own[:, i]) < _UNLIKE]
        if unlike:
            joints = named_joints([i + 1 for i in unlike], n)
            yield f"the gravity torque identified at {joints} does not follow the file's"
        for i in np.flatnonzero(counts).tolist():
            ratio = float(others[i] / sizes[i]) if sizes[i] else np.inf
            if i not in unlike and not 1.0 / _HEAVIER < ratio < _HEAVIER:
                yield f"the gravity torque identified at joint {i + 1} is {number(ratio)} times the file's"
    if not all(given.is_revolute):  # kg and kg m^2 have no common largest
        return
    file, own = (_inertias(arm, states.q) for arm in (given, made))
    # Geared drives of a wrist may have many times its links' inertia, but not that of the whole arm.
    largest = int(file.argmax())
    joint = int(own.argmax()) if own.max() > file[largest] else largest
    ratio = float(own[joint] / file[largest]) if file[largest] else 1.0
    whose = "the file's" if joint == largest else f"the file's at joint {largest + 1}"
    what = f"the inertia identified at joint {joint + 1} is {number(ratio)} times {whose}"
    if not 1.0 / _ANOTHER_UNIT < ratio < _ANOTHER_UNIT:
        raise _contradiction(given, what)
    if not 1.0 / _MORE_INERT < ratio < _MORE_INERT:
        yield what


def _cosine(one: FloatArray, other: FloatArray) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.sum(one * other)) / size if size else 0.0


def _inertias(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Mean of D_ii over positions, drives included, (n,)."""
    still = np.zeros_like(q)
    at_rest = torque_of(arm, States(q, still, still))
    units = np.eye(arm.n_joints)
    return np.array(
        [
            (torque_of(arm, States(q, still, still + units[i])) - at_rest)[:, i].mean()
            for i in range(len(units))
        ]
    )


def _beyond_limits(given: RobotArm, made: RobotArm, states: States) -> Iterator[str]:
    """Torque along the logs, and weight, beyond the drives' limits, as of any arm, but not of the file."""
    for check in (lambda arm: warn_of_torque_limits(arm, states), warn_of_weight):
        texts = []
        for arm in (made, given):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                check(arm)
            texts.append([str(each.message) for each in caught if each.category is TorqueLimitWarning])
        if not texts[1]:
            yield from texts[0]


def _newly_implausible(given: RobotArm, made: RobotArm) -> Iterator[str]:
    """Findings of the checks of any arm's file, at places where the file has none."""
    for check in CHECKS:
        before = {place for place, _ in check(given)}
        yield from (f"{place}: {text}" for place, text in check(made) if place not in before)
