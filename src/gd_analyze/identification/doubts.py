"""Whether logs and an arm's file can both be right: doubts about an identified arm, none with a cause.

A fit follows torques in another unit, or of an arm that hangs from the ceiling, as far as parameters can.
What it finds is then far from the file, which is seldom off by more than a third.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

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
from gd_analyze.text import named_joints, number, percent


@dataclass(frozen=True, kw_only=True)
class _DoubtSettings:
    """How far an identified arm may be from its file."""

    # Ratio of identified and stated torque or inertia, or its inverse, beyond which no arm is written: files
    # that state no drives are off by up to three, N mm, N cm and currents by ten and more.
    another_unit_factor: float = 10.0
    # Ratio of gravity torques that calls for a look: masses and torque constants are off by up to a third.
    heavier_factor: float = 1.5
    # The same of inertias, to which unstated drives add up to twice the links'.
    more_inert_factor: float = 5.0
    contrary_cosine: float = 0.5  # cosine between gravity torques below which they share nothing
    # The same of one joint, below which they share less than errors of masses and centres explain.
    unlike_cosine: float = 0.8
    # Share of the largest gravity torque below which a joint's says nothing.
    little_gravity_share: float = 0.1
    # Standard error of torque constants and gear efficiencies, of which nothing is known.
    unknown_scale_error: float = 0.2
    # Change of a torque's gain over the logs, as a share of it, that no warming of drives explains.
    drifting_gain: float = 0.2
    explained_by_drift: float = 0.25  # share of the squared residual that it explains at least
    # Directions of a joint's columns below this share of the strongest tell nothing of it.
    least_strength: float = 1e-3
    compared_states: int = 300  # set points of a log at which models are compared


_SETTINGS = _DoubtSettings()


def require_torque_of_this_size(
    arm: RobotArm, rows: Sequence[JointRows], start: FloatArray, unknowns: Unknowns
) -> None:
    """Refuse torques that are, friction aside, a tenth of the file's or less, or ten times as large."""
    squares = np.zeros(2)
    for i, joint_rows in enumerate(rows):
        first = unknowns.of_friction.start + 3 * i
        torques = np.column_stack([joint_rows.torque, joint_rows.columns @ start])
        friction = joint_rows.columns[:, first : first + 2]
        frictionless = torques - friction @ np.linalg.lstsq(friction, torques, rcond=None)[0]
        squares += np.square(frictionless).sum(axis=0)
    if not squares[1]:
        return
    ratio = float(np.sqrt(squares[0] / squares[1]))
    if not 1.0 / _SETTINGS.another_unit_factor < ratio < _SETTINGS.another_unit_factor:
        raise _contradiction(arm, f"measured torques, friction aside, are {number(ratio)} times the file's")


def _contradiction(arm: RobotArm, difference: str) -> UsageError:
    return UsageError(
        f"log and file contradict each other: {difference}",
        where=f"arm {arm.name}",
        expected="an arm and a log of it, torques in N m, or currents with --torque-constant",
        next_step="`gd-analyze diagnose ROBOT LOG` looks for the cause; a short or noisy log needs more "
        "motion",
    )


def doubts_of(
    file_arm: RobotArm,
    identified_arm: RobotArm,
    motions: Sequence[Trajectory],
    rows: Sequence[JointRows],
    *,
    physical: bool,
) -> tuple[str, ...]:
    """Sentences on what is implausible of an identified arm, beside the file and its logs, or of the logs.

    Bodies of plain least squares may be impossible (`physical` is False), and are not checked.

    Raises
    ------
    UsageError
        If gravity torques of both have nothing in common, or inertias differ by a factor of ten.
    """
    states = _states_of(motions)
    doubts = list(_beyond_limits(file_arm, identified_arm, states))
    if physical:
        doubts += _newly_implausible(file_arm, identified_arm)
    if file_arm.mass.any():
        doubts = [*_unlike_the_file(file_arm, identified_arm, states), *doubts]
    return (*_of_drift(rows), *doubts)


def _of_drift(rows: Sequence[JointRows]) -> Iterator[str]:
    """Joints whose torque grows or shrinks over the logs for the same motion."""
    changes = {i + 1: change for i, joint_rows in enumerate(rows) if (change := _gain_change(joint_rows))}
    if changes:
        joints, sizes = named_joints([*changes], len(rows)), ", ".join(map(percent, changes.values()))
        yield f"the gain of the torque of {joints} changes over the logs, by {sizes}"


def _gain_change(rows: JointRows) -> float:
    """Change of a joint's torque from the begin to the end of its logs, over its mean; 0 if there is none.

    All that the joint's torque is linear in is free: the file, and an identified arm, may be wrong.
    """
    sizes = np.linalg.norm(rows.columns, axis=0)
    if len(rows.time) <= 2 * np.count_nonzero(sizes):
        return 0.0
    directions, strength, _ = np.linalg.svd(
        rows.columns[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False
    )
    model = directions[:, strength > _SETTINGS.least_strength * strength[0]]
    place = (rows.time - rows.time.mean()) / np.ptp(rows.time)
    grown, residual = (x - model @ (model.T @ x) for x in (place * rows.torque, rows.torque))
    size = float(grown @ grown)
    change = float(grown @ residual) / size if size else 0.0
    explained = change**2 * size / float(residual @ residual) if residual.any() else 0.0
    is_clear = abs(change) > _SETTINGS.drifting_gain and explained > _SETTINGS.explained_by_drift
    return change if is_clear else 0.0


def scale_error(file_arm: RobotArm, identified_arm: RobotArm, motions: Sequence[Trajectory]) -> float:
    """Relative standard error of the torques' scale: how far gravity torques are from the file's, as RMS.

    Noise does not show the scale of torque constants. If they and the file's masses are right, both agree.
    """
    if not file_arm.mass.any():
        return _SETTINGS.unknown_scale_error
    file_torque, identified_torque = _gravity_torques(file_arm, identified_arm, _states_of(motions))
    along, squares = (file_torque * identified_torque).sum(axis=0), np.square(file_torque).sum(axis=0)
    has_gravity = squares > 0.0
    if not has_gravity.any():
        return _SETTINGS.unknown_scale_error
    deviations = along[has_gravity] / squares[has_gravity] - 1.0
    return float(np.sqrt(squares[has_gravity] @ deviations**2 / squares.sum()))


def _states_of(motions: Sequence[Trajectory]) -> States:
    """Some set points of logs."""
    samples = [(motion, evenly(motion.n_set_points, _SETTINGS.compared_states)) for motion in motions]
    q, qd, qdd = (np.concatenate([getattr(log, x)[at] for log, at in samples]) for x in ("q", "qd", "qdd"))
    return States(q, qd, qdd)


def _gravity_torques(
    file_arm: RobotArm, identified_arm: RobotArm, states: States
) -> tuple[FloatArray, FloatArray]:
    resting = States(states.q, np.zeros_like(states.q), np.zeros_like(states.q))
    return (
        torque_of(file_arm, resting, drives=False),
        torque_of(identified_arm, resting, drives=False),
    )


def _unlike_the_file(file_arm: RobotArm, identified_arm: RobotArm, states: States) -> Iterator[str]:
    """Gravity torque and inertia beside the file's, in the positions of the logs."""
    n = file_arm.n_joints
    file_torque, identified_torque = _gravity_torques(file_arm, identified_arm, states)
    file_rms, identified_rms = (
        np.sqrt(np.square(torque).mean(axis=0)) for torque in (file_torque, identified_torque)
    )
    if file_torque.any():
        cosine = _cosine(file_torque, identified_torque)
        if cosine < _SETTINGS.contrary_cosine:
            raise _contradiction(
                file_arm, f"the gravity torques that fit are not the file's (cosine {number(cosine)})"
            )
        largest_rms = max(file_rms.max(), identified_rms.max())
        counts = np.maximum(file_rms, identified_rms) > _SETTINGS.little_gravity_share * largest_rms
        unlike = [
            i
            for i in range(n)
            if counts[i] and _cosine(file_torque[:, i], identified_torque[:, i]) < _SETTINGS.unlike_cosine
        ]
        if unlike:
            joints = named_joints([i + 1 for i in unlike], n)
            yield f"the gravity torque identified at {joints} does not follow the file's"
        for i in np.flatnonzero(counts).tolist():
            ratio = float(identified_rms[i] / file_rms[i]) if file_rms[i] else np.inf
            if i not in unlike and not 1.0 / _SETTINGS.heavier_factor < ratio < _SETTINGS.heavier_factor:
                yield f"the gravity torque identified at joint {i + 1} is {number(ratio)} times the file's"
    if not all(file_arm.is_revolute):  # kg and kg m^2 have no common largest
        return
    file_inertia, identified_inertia = (_inertias(arm, states.q) for arm in (file_arm, identified_arm))
    # Geared drives of a wrist may have many times its links' inertia, but not that of the whole arm.
    largest = int(file_inertia.argmax())
    joint = int(identified_inertia.argmax()) if identified_inertia.max() > file_inertia[largest] else largest
    ratio = float(identified_inertia[joint] / file_inertia[largest]) if file_inertia[largest] else 1.0
    whose = "the file's" if joint == largest else f"the file's at joint {largest + 1}"
    difference = f"the inertia identified at joint {joint + 1} is {number(ratio)} times {whose}"
    if not 1.0 / _SETTINGS.another_unit_factor < ratio < _SETTINGS.another_unit_factor:
        raise _contradiction(file_arm, difference)
    is_far_from_its_own = bool(
        identified_inertia[joint] > _SETTINGS.another_unit_factor * file_inertia[joint]
        and ratio > _SETTINGS.heavier_factor
    )
    if is_far_from_its_own or not 1.0 / _SETTINGS.more_inert_factor < ratio < _SETTINGS.more_inert_factor:
        yield difference


def _cosine(first: FloatArray, second: FloatArray) -> float:
    size = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(np.sum(first * second)) / size if size else 0.0


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


def _beyond_limits(file_arm: RobotArm, identified_arm: RobotArm, states: States) -> Iterator[str]:
    """Torque along the logs, and weight, beyond the drives' limits, as of any arm, but not of the file."""
    for check in (lambda arm: warn_of_torque_limits(arm, states), warn_of_weight):
        texts = []
        for arm in (identified_arm, file_arm):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                check(arm)
            texts.append(
                [str(warning.message) for warning in caught if warning.category is TorqueLimitWarning]
            )
        if not texts[1]:
            yield from texts[0]


def _newly_implausible(file_arm: RobotArm, identified_arm: RobotArm) -> Iterator[str]:
    """Findings of the checks of any arm's file, at places where the file has none."""
    for check in CHECKS:
        before = {place for place, _ in check(file_arm)}
        yield from (f"{place}: {text}" for place, text in check(identified_arm) if place not in before)
