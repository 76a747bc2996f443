"""Weighted least squares for parameters of which a log tells only some directions.

Unknowns are scaled by their plausible sizes, and rows by the standard deviation of their joint's residuals. A
direction is identifiable if a change of plausible size would show by three standard errors; along all others
the numbers stay unchanged. The result is the solution nearest to the arm's file.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.base_parameters import PARAMETERS, inertial_parameters, parameters_of
from gd_analyze.dynamics.friction import correlation_time, reduced, triangle
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.identification.rows import JointRows, Unknowns
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.parts import of_point_mass

# Standard errors that make a number significant.
SIGMAS = 3.0

_MOST_ROUNDS = 12  # most rounds of weighting joints by the previous residuals
_SETTLED_CHANGE = 1e-3  # relative change of the noise below which the rounds end
_ROWS_AT_ONCE = 4096  # rows in memory at a time
_LEAST_SINGULAR_SHARE = 1e-10  # singular values below this share of the largest are round-off
_ROUND_OFF_SHARE = 1e-12  # share of the largest torque that is round-off

_SHORTEST_SHARE = 0.05  # least plausible size of a link, as a share of the reach
_LIGHTEST_SHARE = 0.1  # least plausible mass of a link, as a share of the mean link's
_ROD_DENSITY = 1500.0  # density of rods that replace links without data in the file, kg/m^3
_ROD_SLENDERNESS = 0.2  # radius of these rods over their length
# A file's masses, centres of mass and inertias are good to about this share of a link's size: a log that
# is not clearly better than that tells nothing new.
_FILE_ERROR_SHARE = 1.0 / 3.0
# Shares of the fastest velocity below which friction may be larger (Stribeck).
_SLOW_SHARES: tuple[float, ...] = (0.07, 0.25)
# Radius of gyration, as a share of the reach, of a link without mass in the file.
_GYRATION_SHARE = 0.2


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of p unknowns from equations and a start, along directions in plausible sizes.

    Parameters
    ----------
    start, sizes
        Numbers to start from, and their plausible sizes, (p,).
    directions
        Orthonormal directions, in units of these sizes, identifiable ones first, (p, p).
    strength
        Singular values: one over the standard error along each identifiable direction, (k,).
    steps
        Distance of the solution from the start along these, (k,).
    noise
        Standard deviation of a row of every joint, N m (N), the larger of fitted and of held-out rows, (n,);
        nan without rows.
    correlated
        Correlated rows per independent one, by joint, likewise, (n,).
    bends
        What the unknowns change by under other assumptions, a row of each, (b, p).
    """

    start: FloatArray
    sizes: FloatArray
    directions: FloatArray
    strength: FloatArray
    steps: FloatArray
    noise: FloatArray
    correlated: FloatArray
    bends: FloatArray

    @property
    def identifiable(self) -> int:
        """Number of identifiable directions."""
        return len(self.strength)

    @property
    def condition(self) -> float:
        """Condition number of the equations along identifiable directions."""
        return float(self.strength[0] / self.strength[-1]) if self.identifiable else np.nan

    @property
    def values(self) -> FloatArray:
        """The solution, (p,)."""
        return self.start + self.sizes * (self.steps @ self.directions[: self.identifiable])

    @property
    def deviations(self) -> FloatArray:
        """One standard error along each identifiable direction, and the bends: D^T D is the covariance."""
        along = self.sizes * self.directions[: self.identifiable] / self.strength[:, None]
        return np.vstack([along, self.bends])

    def bent_by(self, change: FloatArray) -> Estimate:
        """The same with another bend, (p,)."""
        return replace(self, bends=np.vstack([self.bends, change]))

    def judged_by(self, rows: Sequence[JointRows], held_out: Sequence[Array]) -> Estimate:
        """The same with noise and correlation of residuals that were not fitted, where these are larger."""
        noise, correlated = self.noise.copy(), self.correlated.copy()
        for i, (joint_rows, is_held_out) in enumerate(zip(rows, held_out, strict=True)):
            residual = joint_rows.torque - joint_rows.columns @ self.values
            if is_held_out.any():
                noise[i] = np.fmax(noise[i], np.sqrt(np.mean(residual[is_held_out] ** 2)))
                correlated[i] = max(correlated[i], _rows_per_independent_one(residual))
        return replace(self, noise=noise, correlated=correlated)

    @property
    def open(self) -> FloatArray:
        """One plausible size along each unidentifiable direction, (p - k, p)."""
        return self.sizes * self.directions[self.identifiable :]


def least_squares(rows: Sequence[JointRows], start: FloatArray, sizes: FloatArray) -> Estimate:
    """Solve the equations of all joints, each weighted by the noise of its residuals.

    Noise is the residual of all directions together: with identifiable ones only, its definition would be
    circular.
    """
    p = len(start)
    joints = [i for i, joint_rows in enumerate(rows) if len(joint_rows.torque)]
    noise, correlated = np.full(len(rows), np.nan), np.ones(len(rows))
    triangles = {i: triangle(_blocks(rows[i], start, sizes), p + 1) for i in joints}
    for i in joints:
        noise[i] = np.linalg.norm(triangles[i][:, p]) / np.sqrt(len(rows[i].torque))

    def weighed() -> FloatArray:
        return reduced(np.vstack([triangles[i] / (noise[i] * np.sqrt(correlated[i])) for i in joints]))

    for _ in range(_MOST_ROUNDS):
        r, before = weighed(), noise.copy()
        steps, _, rank, _ = np.linalg.lstsq(r[:, :p], r[:, p], rcond=_LEAST_SINGULAR_SHARE)
        values = start + sizes * steps
        for i in joints:
            residual = rows[i].torque - rows[i].columns @ values
            correlated[i] = _rows_per_independent_one(residual)
            spare = max(len(residual) - rank / len(joints), 1.0)
            # A residual is never less than the round-off of its operands.
            least = _ROUND_OFF_SHARE * float(np.abs(rows[i].torque).max())
            noise[i] = max(float(np.sqrt(residual @ residual / spare)), least)
        if np.nanmax(np.abs(noise / before - 1.0)) < _SETTLED_CHANGE:
            break
    return _along_directions(weighed(), start, sizes, noise, correlated)


def _rows_per_independent_one(residual: FloatArray) -> float:
    all_rows = np.ones(len(residual), dtype=bool)
    return correlation_time(residual.__getitem__, all_rows, [slice(0, len(residual))])


def solved_again(rows: Sequence[JointRows], start: FloatArray, before: Estimate) -> Estimate:
    """Solve the equations with other torques from another start, weighted as in the estimate before."""
    sizes = before.sizes
    weights = before.noise * np.sqrt(before.correlated)
    blocks = (
        block / weights[i] for i, joint_rows in enumerate(rows) for block in _blocks(joint_rows, start, sizes)
    )
    r = triangle(blocks, len(start) + 1)
    return _along_directions(r, start, sizes, before.noise, before.correlated)


def _along_directions(
    r: FloatArray, start: FloatArray, sizes: FloatArray, noise: FloatArray, correlated: FloatArray
) -> Estimate:
    """Estimate from the triangle of the weighted equations."""
    p = len(start)
    left_vectors, strength, directions = np.linalg.svd(r[:, :p])
    identifiable = int((strength > SIGMAS).sum())
    steps = (left_vectors.T @ r[:, p])[:identifiable] / strength[:identifiable]
    nothing = np.zeros((0, p))
    return Estimate(start, sizes, directions, strength[:identifiable], steps, noise, correlated, nothing)


def change_by_friction(estimate: Estimate, rows: Sequence[JointRows], unknowns: Unknowns) -> FloatArray:
    """Change of the unknowns, (p,), if friction falls as a joint gets faster, and grows with its load.

    Coulomb and viscous friction are a choice: the unknowns are as uncertain as another would change them.
    """
    n, directions = len(rows), estimate.directions[: estimate.identifiable]
    width, load = len(directions), estimate.values.copy()
    # The drive's own inertia and friction do not load its gear.
    load[unknowns.of_drives] = load[unknowns.of_friction] = 0.0
    terms = 1 + len(_SLOW_SHARES)
    blocks = [np.eye(width + terms * n, width + terms * n + 1)]  # none is larger than its plausible size
    for i, joint_rows in enumerate(rows):
        if not len(joint_rows.torque):
            continue
        coulomb, viscous, _ = range(unknowns.count)[unknowns.friction_of(i)]
        sign, velocity = joint_rows.columns[:, coulomb], joint_rows.columns[:, viscous]
        block = np.zeros((len(sign), width + terms * n + 1))
        block[:, :width] = joint_rows.columns * estimate.sizes @ directions.T
        first, fastest = width + terms * i, float(np.abs(velocity).max())
        block[:, first] = sign * np.abs(joint_rows.columns @ load)
        for k, share in enumerate(_SLOW_SHARES, start=1):
            slow = np.exp(-np.square(velocity / (share * fastest)))
            block[:, first + k] = estimate.sizes[coulomb] * sign * slow
        block[:, -1] = joint_rows.torque - joint_rows.columns @ estimate.values
        blocks.append(block / (estimate.noise[i] * np.sqrt(estimate.correlated[i])))
    r = triangle(blocks, width + terms * n + 1)
    change = np.linalg.solve(r[:-1, :-1], r[:-1, -1])[:width]
    return np.asarray(estimate.sizes * (change @ directions))


def _blocks(rows: JointRows, start: FloatArray, sizes: FloatArray) -> Iterator[FloatArray]:
    """Columns times plausible sizes, and residual torque of the start; some rows at a time."""
    for first in range(0, len(rows.torque), _ROWS_AT_ONCE):
        block = rows.at(slice(first, first + _ROWS_AT_ONCE))
        yield np.column_stack([block.columns * sizes, block.torque - block.columns @ start])


def plausible_sizes(
    arm: RobotArm, links: FloatArray, rows: Sequence[JointRows], unknowns: Unknowns
) -> FloatArray:
    """Plausible size of every unknown, (p,): of links from their parameters, of others from torque.

    Of links that a file states, it is the size of the file's error.
    """
    sizes, n = np.zeros(unknowns.count), arm.n_joints
    masses = np.maximum(links[:, 0], _LIGHTEST_SHARE * float(links[:, 0].mean()))
    lengths = np.full(n, _SHORTEST_SHARE * (arm.reach or 1.0))
    for i, (link, parameters) in enumerate(zip(arm.links, links, strict=True)):
        ends = [parameters[1:4] / masses[i], link.frame.translation]
        ends += [joint.placement.translation for joint in arm.joints[i + 1 : i + 2]]
        gyration = float(np.sqrt(np.abs(parameters[4:]).max() / masses[i]))
        lengths[i] = max(lengths[i], gyration, *map(np.linalg.norm, ends))
    powers = np.array([kind.count("x") + kind.count("y") + kind.count("z") for kind in PARAMETERS])
    sizes[unknowns.of_links] = (masses[:, None] * lengths[:, None] ** powers).ravel()
    carried = np.where(arm.is_revolute, masses * lengths**2, masses)
    sizes[unknowns.of_drives] = np.cumsum(carried[::-1])[::-1]
    if arm.drives:
        sizes[unknowns.of_drives] = np.maximum(sizes[unknowns.of_drives], arm.drive_inertia)
    if arm.mass.any():
        sizes[unknowns.of_links] *= _FILE_ERROR_SHARE
    first, drive = unknowns.of_friction.start, unknowns.of_drives.start
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # if limits are assumed
        limits = box_limits(arm)
    for i, joint_rows in enumerate(rows):
        torque, acceleration, velocity = (
            float(np.sqrt(np.mean(x**2))) if len(x) and x.any() else 1.0
            for x in (
                joint_rows.torque,
                joint_rows.columns[:, drive + i],
                joint_rows.columns[:, first + 3 * i + 1],
            )
        )
        # Size that alone would take the measured torque at the joint's limits.
        # A log of small motions would make anything plausible.
        acceleration = max(acceleration, float(limits.acceleration[i]))
        velocity = max(velocity, float(limits.velocity[i]))
        sizes[drive + i] = max(sizes[drive + i], torque / acceleration)
        sizes[first + 3 * i : first + 3 * i + 3] = torque, torque / velocity, torque
    if unknowns.payload:  # like a hand with its load
        sizes[unknowns.of_payload] = masses.mean() * lengths.mean() ** powers
    return sizes


def _uniform_bodies(arm: RobotArm) -> FloatArray:
    """Parameters of rods from joint to joint, for an arm whose file states no masses, (n, 10)."""
    out = []
    for i, link in enumerate(arm.links):
        beyond = arm.joints[i + 1].placement.translation if i + 1 < arm.n_joints else np.zeros(3)
        # From the joint's origin to the next joint's, in the link's frame.
        begin = -link.frame.rotation.T @ link.frame.translation
        along = beyond - begin
        length = max(float(np.linalg.norm(along)), _SHORTEST_SHARE * (arm.reach or 1.0))
        mass = _ROD_DENSITY * np.pi * (_ROD_SLENDERNESS * length) ** 2 * length
        com = begin + along / 2.0
        square = along @ along * np.eye(3) - np.outer(along, along)
        inertia = mass * (square / 12.0 + (_ROD_SLENDERNESS * length) ** 2 / 2.0 * np.eye(3))
        out.append(inertial_parameters(mass, mass * com, inertia + of_point_mass(mass, com)))
    return np.array(out)


def start_of(arm: RobotArm) -> str:
    """What `described` describes."""
    return "file" if arm.mass.any() else "rods"


def described(arm: RobotArm) -> FloatArray:
    """The file's parameters, (n, 10); rods if it states none, a ball if only axial inertia is stated."""
    if not arm.mass.any():
        return _uniform_bodies(arm)
    parameters = parameters_of(arm)
    for i, link in enumerate(arm.links):
        if link.axial_only:
            moment = float(np.abs(link.inertia_com).max())
            mass = moment / (_GYRATION_SHARE * (arm.reach or 1.0)) ** 2
            parameters[i] = inertial_parameters(mass, np.zeros(3), moment * np.eye(3))
    return parameters
