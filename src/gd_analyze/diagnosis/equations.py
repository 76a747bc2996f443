"""Torque as a linear function of what a file may be off by, friction included: sums of products of samples.

Columns of every joint: the links' numbers in standard deviations of a file's error, what a hypothesis adds,
the joint's own drive inertia, Coulomb and viscous friction and offset; the file's torque; every joint's
measured torque. With their products alone, a fit takes milliseconds, whatever is done to the torques.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.samples import Samples
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.dynamics.base_parameters import PARAMETERS, inertial_parameters, link_regressor, parameters_of
from gd_analyze.dynamics.friction import own_columns
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import of_point_mass

# Numbers of a joint itself: drive inertia, Coulomb and viscous friction, offset. All but the last are not
# negative.
NUMBERS_OF_JOINT = 4

# What a file's links are off by, one standard deviation: shares of a link's mass, of each coordinate of its
# centre of mass (and metres on top of that), and of each moment of inertia.
MASS_ERROR, COM_ERROR, INERTIA_ERROR = 0.15, 0.15, 0.20
COM_ERROR_M = 0.008

# Radius of gyration, as a share of the reach, below which a file's inertia is not known either.
_LEAST_GYRATION_SHARE = 0.02
# Share of a column's sum of squares added to equations of columns that vanish.
_REGULARIZING_SHARE = 1e-9
_DRAWN_STATES = 40  # states drawn to find which errors of a file have any effect
_NO_EFFECT_SHARE = 1e-3  # share of the largest effect that is none


@dataclass(frozen=True, eq=False)
class Eliminated:
    """A joint's equations after its own numbers are eliminated: these are constant - follows @ shared."""

    normal: FloatArray  # (shared, shared)
    inverse: FloatArray  # of the products of its own free columns, (4, 4), 0 for those held at 0
    follows: FloatArray  # (4, shared)


@dataclass(frozen=True, eq=False)
class TorqueSums:
    """Sums of products of the columns, over samples fitted and scored, (n, c, c) each."""

    fitted: FloatArray
    scored: FloatArray
    counts: FloatArray  # samples fitted and scored, (2, n)
    shared: int  # columns that all joints share
    is_revolute: Array  # (n,)
    # Fitted equations without a joint's own numbers, by joint and which of these are free
    eliminated: dict[tuple[int, tuple[bool, ...]], Eliminated] = field(default_factory=dict)

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.is_revolute)

    @property
    def total(self) -> FloatArray:
        """Over all samples."""
        return self.fitted + self.scored

    def without_own(self, joint: int, free: tuple[bool, ...]) -> Eliminated:
        """Eliminate a joint's own numbers, of which some are held at 0."""
        key = (joint, free)
        if key not in self.eliminated:
            sums, shared = self.fitted[joint], self.shared
            places = shared + np.flatnonzero(free)
            products = sums[np.ix_(places, places)]
            scale = np.sqrt(np.diag(products))
            scale[scale == 0.0] = 1.0
            outer = np.outer(scale, scale)
            inverse = np.zeros((NUMBERS_OF_JOINT, NUMBERS_OF_JOINT))
            free_block = np.ix_(np.flatnonzero(free), np.flatnonzero(free))
            regular = products / outer + _REGULARIZING_SHARE * np.eye(len(places))
            inverse[free_block] = np.linalg.inv(regular) / outer
            across = sums[shared : shared + NUMBERS_OF_JOINT, :shared]
            follows = inverse @ across
            self.eliminated[key] = Eliminated(sums[:shared, :shared] - across.T @ follows, inverse, follows)
        return self.eliminated[key]


@lru_cache(maxsize=16)
def errors_that_act(arm: RobotArm) -> FloatArray:
    """Independent errors of a file, each a standard deviation, that change any torque, (n, 10, k)."""
    n, count, rng = arm.n_joints, _DRAWN_STATES, np.random.default_rng(0)
    errors, parts = file_errors(arm), []
    size = float(np.linalg.norm(arm.gravity_vector)) or 1.0
    for axis in np.eye(3):  # the arm may be mounted in any way
        q, qd, qdd = rng.uniform(-np.pi, np.pi, (n, count)), *rng.normal(0.0, 2.0, (2, n, count))
        per_unit = link_regressor(replace(arm, gravity_vector=size * axis), q, qd, qdd)
        parts.append(np.einsum("ispt,spk->itsk", per_unit, errors, optimize=True).reshape(n, count, -1))
    columns = np.concatenate(parts, axis=1)
    columns /= np.sqrt(np.square(columns).sum(axis=(1, 2), keepdims=True)) + np.finfo(float).tiny
    _, sizes, rows = np.linalg.svd(columns.reshape(-1, columns.shape[2]), full_matrices=False)
    act = rows[sizes > _NO_EFFECT_SHARE * sizes[0]]
    return np.einsum("spk,ask->spa", errors, act.reshape(-1, n, errors.shape[2]))


def file_errors(arm: RobotArm) -> FloatArray:
    """Errors of a link's numbers by the standard deviation of each independent cause, (n, 10, 10).

    The causes are its mass, three coordinates of its centre of mass and six inertias about it.
    """
    out = np.zeros((arm.n_joints, len(PARAMETERS), len(PARAMETERS)))
    for i, link in enumerate(arm.links):
        mass, com = link.mass, link.com
        zeros = np.zeros((3, 3))
        out[i, :, 0] = MASS_ERROR * inertial_parameters(mass, mass * com, of_point_mass(mass, com))
        for axis in range(3):
            moved = np.zeros(3)
            moved[axis] = COM_ERROR * abs(com[axis]) + COM_ERROR_M
            # Of (com + moved) less that of com, to first order.
            products = np.outer(com, moved) + np.outer(moved, com)
            steiner = mass * (np.trace(products) * np.eye(3) - products)
            out[i, :, 1 + axis] = inertial_parameters(0.0, mass * moved, steiner)
        least = mass * (_LEAST_GYRATION_SHARE * arm.reach) ** 2
        moments = np.maximum(np.diag(link.inertia_com), least)
        for k, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
            tensor = zeros.copy()
            tensor[a, b] = tensor[b, a] = INERTIA_ERROR * np.sqrt(moments[a] * moments[b])
            out[i, :, 4 + k] = inertial_parameters(0.0, np.zeros(3), tensor)
    return out


def with_gravity(arm: RobotArm, gravity: FloatArray | None) -> RobotArm:
    """The arm under another gravity."""
    return arm if gravity is None else replace(arm, gravity_vector=gravity)


def corrected_columns(samples: Samples, correction: Trial) -> tuple[FloatArray, Array, int]:
    """Columns of every joint, (n, N, c), samples that count, (N, n), and the number of shared columns."""
    arm, n = samples.arm, samples.arm.n_joints
    q, qd, qdd, _ = correction.states(samples)
    per_unit = link_regressor(with_gravity(arm, correction.gravity), q.T, qd.T, qdd.T)
    act = errors_that_act(arm)
    # The file's torque is one more column.
    file_numbers = parameters_of(arm)
    if correction.taken_off is not None:
        file_numbers[-1] -= correction.taken_off
    numbers = np.concatenate([act, file_numbers[:, :, None]], axis=2).reshape(-1, act.shape[2] + 1)
    torques = np.swapaxes(per_unit.reshape(n, -1, len(q)), 1, 2) @ numbers
    links, file = torques[:, :, :-1], torques[:, :, -1]
    added = [unknowns.columns * unknowns.sizes for unknowns in correction.added]
    # Drives and friction are those of the motion, though it shows in no other torque.
    driven = correction if np.isfinite(correction.pace) else replace(correction, pace=1.0)
    _, speed, acceleration, direction = driven.states(samples)
    joint_columns = own_columns(acceleration.T, direction.T, speed.T)
    torque = np.broadcast_to(correction.steady(samples.torque), (n, *samples.torque.shape))
    columns = np.concatenate([links, *added, joint_columns, file[:, :, None], torque], axis=2)
    shared = links.shape[2] + sum(block.shape[2] for block in added)
    return columns, correction.counts(samples, direction), shared


def equations_of(samples: Samples, correction: Trial) -> TorqueSums:
    """Equations of the corrected samples."""
    columns, counts, shared = corrected_columns(samples, correction)
    sums = []
    for is_chosen in (~samples.scored, samples.scored):
        weighted = columns[:, is_chosen] * counts[is_chosen].T[:, :, None]
        sums.append(np.swapaxes(weighted, 1, 2) @ weighted)
    counts_by_part = np.array(
        [counts[~samples.scored].sum(axis=0), counts[samples.scored].sum(axis=0)], dtype=float
    )
    return TorqueSums(sums[0], sums[1], counts_by_part, shared, np.array(samples.arm.is_revolute))
