"""Peaks and verdicts along one motion of many arms with the same geometry but different bodies.

Torque is linear in every link's `PARAMETERS`, split by effect as in `robustness`: all arms are one product of
matrices. At s times the speed of the motion h and D qdd grow with s^2; D and c stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.base_parameters import point_masses, regressor
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.robustness import elements_per_unit
from gd_analyze.dynamics.verdicts import negligible_torque
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.varied import Bodies

# Summands of a joint's torque.
CONTRIBUTIONS = (
    "inertia translation", "inertia rotation", "velocity translation", "velocity rotation",
    "gravity", "drives",
)  # fmt: skip
# Verdicts in the numbering of `Peaks.verdicts`.
VERDICT_NAMES = np.array(
    ["translation", "rotation", "both", "drive", "negligible", "zero", "within budget", "beyond budget"]
)
TRANSLATION, ROTATION, BOTH, DRIVE, NEGLIGIBLE, ZERO, WITHIN_BUDGET, BEYOND_BUDGET = range(8)
# Set points at a time that stay in the cache.
SET_POINTS_AT_ONCE = 512
# Set points times arms at a time that stay in the cache.
CELLS_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class Peaks:
    """Largest magnitudes along a motion, of S arms with E elements of D, h and c."""

    parts: FloatArray  # of elements by effect, (2, E, S)
    whole: FloatArray  # of elements, (E, S)
    moved: FloatArray  # torque of an element at a joint, N m (N), (E, n, S); -1 where it does not act
    drive: FloatArray  # drive inertia, kg m^2 (kg), (n, S); 0 without drives
    driven: FloatArray  # torque of D_ii at joint i, the drive's included, N m (N), (n, S)
    torque: FloatArray  # of joints, N m (N), (n, S)
    contributions: FloatArray  # of joints by `CONTRIBUTIONS`, N m (N), (6, n, S)

    def verdicts(self, threshold: float, allowed: FloatArray) -> Array:
        """Verdict on every element as in `rank`, then on every joint's torque without h, (E + n, S).

        Numbers of `VERDICT_NAMES`. `allowed` is the allowed torque error, N m (N), (n, S).
        """
        n = len(self.torque)
        ends = np.array([0, len(self.whole) - 2 * n, len(self.whole) - n])
        largest = np.maximum.reduceat(self.parts.max(axis=0), ends, axis=0)
        noise = 64 * np.finfo(float).eps * np.repeat(largest, np.diff([*ends, len(self.whole)]), axis=0)
        is_there = self.parts > noise
        exists = np.asarray(is_there.any(axis=0))
        translation, rotation = is_there & (self.parts > threshold * self.whole)
        verdict = np.where(rotation, np.where(translation, BOTH, ROTATION), TRANSLATION)
        floor, diagonal = negligible_torque(allowed), np.flatnonzero(np.equal(*np.triu_indices(n)))
        is_small = np.asarray((np.where(exists[:, None], self.moved, 0.0) <= floor).all(axis=1))
        verdict = np.where(exists, np.where(is_small, NEGLIGIBLE, verdict), ZERO)
        with_drive = np.where(self.driven <= floor, NEGLIGIBLE, DRIVE)
        verdict[diagonal] = np.where((self.drive > 0.0) & is_small[diagonal], with_drive, verdict[diagonal])
        without_h = np.where(self.whole[ends[1] : ends[2]] <= allowed, WITHIN_BUDGET, BEYOND_BUDGET)
        return np.vstack([verdict, without_h])


def peaks(arm: RobotArm, bodies: Bodies, q: Array, qd: Array, qdd: Array, speed: FloatArray) -> Peaks:
    """Find the peaks of arms along a motion, each at its own speed.

    Parameters
    ----------
    arm
        The arm that gives geometry and gravity.
    bodies
        Bodies of the S arms.
    q, qd, qdd
        The motion, rad (m) and per s, s^2, shape (n, N).
    speed
        Multiples of the motion's velocity, shape (S,).
    """
    n, count = q.shape
    all_elements, n_arms = elements(n), len(speed)
    points, matter = _parameters(bodies)
    result = Peaks(
        np.zeros((2, len(all_elements), n_arms)),
        np.zeros((len(all_elements), n_arms)),
        np.repeat(_acts(all_elements, n)[..., None] - 1.0, n_arms, axis=-1),
        bodies.drive_inertia.T if bodies.drive_inertia.size else np.zeros((n, n_arms)),
        np.zeros((n, n_arms)),
        np.zeros((n, n_arms)),
        np.zeros((len(CONTRIBUTIONS), n, n_arms)),
    )
    weightless = replace(arm, gravity=np.zeros(3))
    for first in range(0, count, SET_POINTS_AT_ONCE):
        at, v, a = (x[:, first : first + SET_POINTS_AT_ONCE] for x in (q, qd, qdd))
        still, width = np.zeros_like(v), at.shape[1]
        loading, inertial = (
            regressor(*state) for state in ((arm, at, still, still), (weightless, at, still, a))
        )
        of_joints = np.moveaxis(np.concatenate([loading, inertial]), -1, 1).reshape(2 * n, width, -1)
        rows = np.concatenate([elements_per_unit(arm, at, v).reshape(-1, width, 10 * n), of_joints])
        translation, rotation = _Product.of(rows, points), _Product.of(rows, matter)
        step = max(1, CELLS_AT_ONCE // width)
        for block in (slice(start, start + step) for start in range(0, n_arms, step)):
            drives = (
                bodies.drive_inertia[block].T[:, None] * a[..., None] if bodies.drive_inertia.size else 0.0
            )
            _note(result, block, translation.of_arms(block), rotation.of_arms(block), drives, a, speed[block])
    return result


def _acts(all_elements: Sequence[Element], n: int) -> Array:
    """Whether an element acts at a joint, (E, n)."""
    return np.array([[joint in (element.i, element.j) for joint in range(n)] for element in all_elements])


def _note(
    peaks: Peaks, block: slice, translation: Array, rotation: Array, drives: Any, qdd: Array, speed: Array
) -> None:
    """Update the peaks of some arms by their values at some set points, (E + n, set points, arms).

    Rows are the elements of D, h and c, then D qdd. An effect that is equal for all arms has one column.
    """
    n, count = len(qdd), len(peaks.whole)
    square, whole = speed**2, translation + rotation
    h, c = slice(count - 2 * n, count - n), slice(count - n, count)
    grows = np.ones((count, 1)) * square
    grows[: h.start], grows[c] = 1.0, 1.0

    def raise_to(peak: Array, values: Array, times: Array | float = 1.0) -> None:
        np.maximum(peak, np.maximum(values.max(axis=-2), -values.min(axis=-2)) * times, out=peak)

    raise_to(peaks.parts[0, :, block], translation[:count], grows)
    raise_to(peaks.parts[1, :, block], rotation[:count], grows)
    raise_to(peaks.whole[:, block], whole[:count], grows)
    first, second = np.triu_indices(n)
    for joint, accelerated in ((first, second), (second, first)):
        peak = peaks.moved[np.arange(h.start), joint, block]
        raise_to(peak, whole[: h.start] * qdd[accelerated][..., None], square)
        peaks.moved[np.arange(h.start), joint, block] = peak
    joints = np.arange(n)
    for rows in (h, c):
        peaks.moved[rows, :, block][joints, joints] = peaks.whole[rows, block]
    for k, (part, rows) in enumerate(product((translation, rotation), (slice(count, None), h))):
        raise_to(peaks.contributions[2 * (k % 2) + k // 2, :, block], part[rows], square)
    raise_to(peaks.contributions[4, :, block], translation[c])
    if np.ndim(drives):
        raise_to(peaks.contributions[5, :, block], drives, square)
        raise_to(peaks.driven[:, block], whole[: h.start][first == second] * qdd[..., None] + drives, square)
    raise_to(peaks.torque[:, block], (whole[count:] + whole[h] + drives) * square + whole[c])


@dataclass(frozen=True, eq=False)
class _Product:
    """Rows times the parameters of arms; the part common to all arms is summed once."""

    varying: FloatArray  # (rows, set points, V)
    values: FloatArray  # (S, V)
    fixed: FloatArray  # (rows, set points, 1)

    @classmethod
    def of(cls, rows: FloatArray, parameters: FloatArray) -> _Product:
        varies = np.ptp(parameters, axis=0) > 0.0
        return cls(
            rows[..., varies], parameters[:, varies], (rows[..., ~varies] @ parameters[0, ~varies])[..., None]
        )

    def of_arms(self, block: slice) -> FloatArray:
        return self.fixed if not self.values.shape[1] else self.varying @ self.values[block].T + self.fixed


def _parameters(bodies: Bodies) -> tuple[FloatArray, FloatArray]:
    """Parameters of point masses and of the rest, (S, 10 n) each."""
    i, mass = bodies.inertia_com, bodies.mass[..., None]
    body = np.concatenate([mass, mass * bodies.com, np.zeros((*mass.shape[:2], 6))], axis=-1)
    entries = [i[..., a, b] for a, b in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    matter = np.stack([*[np.zeros(mass.shape[:2])] * 4, *entries], axis=-1)
    return point_masses(body).reshape(len(mass), -1), matter.reshape(len(mass), -1)
