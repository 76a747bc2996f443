"""Exciting motions for identification within limits: optimized Fourier series.

Every joint moves by a_0 + sum_k (a_k cos k w t + b_k sin k w t), whose velocity and acceleration are zero at
both ends. J. Swevers, C. Ganseman, D. Bilgin Tukel, J. De Schutter, H. Van Brussel, Optimal robot excitation
and identification, IEEE Transactions on Robotics and Automation 13, 1997.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray, array_of
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import UsageError, require_whole
from gd_analyze.identification.expected_equations import ExpectedEquations
from gd_analyze.identification.fourier_series import INSTANTS_PER_PERIOD, FourierSeries
from gd_analyze.motions.limits import limit_report
from gd_analyze.motions.planning import Plan, possible_duration, require_set_points
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.states import States, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.limits import box_limits
from gd_analyze.text import LARGEST, number
from gd_analyze.threads import one_thread

# Condition number beyond which logs determine nothing: torques measured to 1 %, averaged over 10 000
# readings, leave an error of ten times a parameter's plausible size.
_MOST_CONDITION_NUMBER = 1e5
_SET_POINTS_PER_SECOND = 100.0  # set points per second by default
_INSTANTS_PER_EQUATION = 5  # equations are evaluated at every fifth of the instants used for limits
_RANDOM_SERIES = 40  # random series to begin with
_DESCENTS = 3  # descents from the best of them
_TRIES_PER_DESCENT = 50  # tries of each descent
_TRIES_OF_BEST = 160  # further tries of the best descent
_DIFFERENCE_STEP = 1e-6  # step of a difference that stands for a derivative
_DRAWN_POSITIONS = 4000  # positions drawn for a box of the end effector
_SIZE_IN_BOX = 0.5  # size of the series around the best of these positions
# Desired and least distance of the end effector from the walls of its box, as shares of the reach.
_CLEARANCE_SHARE = 5e-3
_LEAST_CLEARANCE_SHARE = 5e-4
# Loss of an instant that is outside by the arm's reach; a larger one slows the descent.
_OUTSIDE_PENALTY = 1e3


@dataclass(frozen=True, eq=False)
class Workspace:
    """Box that the end effector must not leave, in the base frame.

    Parameters
    ----------
    lower, upper
        Opposite corners, m, shape (3,) each.

    Raises
    ------
    UsageError
        If these are not corners of a box.
    """

    lower: FloatArray
    upper: FloatArray

    def __init__(self, lower: ArrayLike, upper: ArrayLike) -> None:
        for name, corner in (("lower", lower), ("upper", upper)):
            object.__setattr__(self, name, array_of(corner, name, UsageError))
        corners = self.lower, self.upper
        shapes = all(corner.shape == (3,) and (np.abs(corner) <= LARGEST).all() for corner in corners)
        if not (shapes and (self.lower < self.upper).all()):
            raise UsageError(
                "these are not corners of a box",
                where="within",
                expected="x, y and z of the lower corner, then of the upper one, each larger, m",
                found=", ".join(f"{x:g}" for corner in corners for x in corner.ravel()),
            )


@one_thread()
def exciting_motion(
    arm: RobotArm | str | Path,
    duration: float,
    n_set_points: int | None = None,
    *,
    within: Workspace | None = None,
    seed: int = 0,
    name: str | None = None,
) -> Plan:
    """Plan a motion, from rest to rest, that excites links, drives and friction for `identify`.

    It maximizes the determinant of the equations of `identify`, within the arm's ranges and limits of
    velocity and acceleration, by descents from the best of some random series. If the drives are too weak,
    the motion is made smaller. It ends where it begins; a long one repeats a shorter one.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    duration
        Duration, s.
    n_set_points
        Number of set points, evenly spaced in time; by default 100 per second.
    within
        Box for the end effector, the origin of `tip_frame`.
    seed
        Seed of the random series; the same seed plans the same motion.
    name
        Name of the trajectory; by default from the arm's.

    Returns
    -------
    Plan
        Set points with exact velocities and accelerations. The trajectory's origin states the condition
        number of the equations, for parameters in plausible sizes.

    Raises
    ------
    TrajectoryError
        If the duration is impossible, or the set points are fewer than two per period of the fastest
        harmonic.
    UsageError
        If no motion was found that keeps the end effector in its box, or the duration is so short that logs
        would not determine the parameters.

    Warns
    -----
    GdAnalyzeWarning
        If limits are assumed because the arm states none, or drives are too weak for any motion.

    Examples
    --------
    >>> made = exciting_motion("two_link", 10)
    >>> made.trajectory.n_set_points, made.limits.violations
    (1001, ())
    """
    require_whole(seed, "seed", 0)
    arm = arm_of(arm)
    duration = possible_duration(duration)
    count = n_set_points
    if count is None:
        count = max(2, round(_SET_POINTS_PER_SECOND * duration) + 1)
    require_set_points(count)
    family = FourierSeries(box_limits(arm), duration)
    fewest = 1 + 2 * family.harmonics * round(duration / family.period)
    if n_set_points is None:
        count = max(count, fewest)
    elif count < fewest:
        expected = f"at least {fewest}, two per period of the fastest harmonic"
        raise refusal(
            "too few set points for the motion's harmonics",
            "n_set_points",
            expected,
            str(count),
            f"by default there are {_SET_POINTS_PER_SECOND:g} per second",
        )
    search = _Search(arm, family, within)
    try:
        series = search.best(np.random.default_rng(seed))
        condition = search.equations.condition(family.motion(series)[..., ::_INSTANTS_PER_EQUATION])
    except np.linalg.LinAlgError:  # of equations without any motion
        condition = np.inf
    if condition > _MOST_CONDITION_NUMBER:
        raise UsageError(
            "the duration is too short for a motion that tells links, drives and friction apart",
            where="duration",
            expected=f"equations of a condition number up to {_MOST_CONDITION_NUMBER:g}",
            found=f"{number(condition, 2)} in {duration:g} s",
            next_step="plan a longer motion: 10 s to 30 s are usual",
        )
    origin = (
        f"planned: exciting, {duration:g} s, {family.harmonics} harmonics, seed {seed}, "
        f"condition number {number(condition)}"
    )
    time = np.linspace(0.0, duration, count)
    q, qd, qdd = (values.T for values in family.motion(series, time))
    # Exact at the ends, not just to round-off.
    q[-1], qd[[0, -1]], qdd[[0, -1]] = q[0], 0.0, 0.0
    trajectory = Trajectory(time, q, qd, qdd, name=name or f"{arm.name}-exciting", origin=origin)
    between = Trajectory(search.fine, *(values.T for values in family.motion(series, search.fine)))
    warn_of_torque_limits(arm, states_of(between))
    return Plan(trajectory, limit_report(arm, between), time[[0, -1]], None)


class _Search:
    """Search for the most exciting series of an arm."""

    def __init__(self, arm: RobotArm, family: FourierSeries, within: Workspace | None) -> None:
        self.arm, self.family, self.within = arm, family, within
        self.reach = arm.reach or 1.0
        self.fine = np.linspace(0.0, family.period, 10 * INSTANTS_PER_PERIOD * family.harmonics + 1)
        self.equations = ExpectedEquations(arm, family.limits)
        stated = [drive.torque_limit or np.inf for drive in arm.drives]
        self.torques = np.array(stated or [np.inf] * arm.n_joints)

    def outside(self, q: FloatArray, clearance: float) -> FloatArray:
        """Distance of the end effector outside its box along x, y and z, m, (3, N)."""
        if self.within is None:
            return np.zeros((3, q.shape[1]))
        kinematics = solve_kinematics(self.arm, q)
        tip = np.einsum("abN,b->aN", kinematics.link_rotations[-1], self.arm.tip_frame.translation)
        place, lower, upper = kinematics.link_origins[-1] + tip, self.within.lower, self.within.upper
        clear = np.minimum(clearance * self.reach, (upper - lower) / 20.0)
        low, high = (lower + clear)[:, None] - place, place - (upper - clear)[:, None]
        return np.maximum(np.maximum(low, high), 0.0)

    def loss(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Minus the log of the determinant, and a penalty outside the box; and the derivative by x."""
        n, step, every = self.arm.n_joints, _DIFFERENCE_STEP, _INSTANTS_PER_EQUATION
        near = self.family.motion(self.family.within_limits(np.vstack([x, x + step * np.eye(len(x))])))
        change = (near[:, 1:] - near[:, :1]) / step
        log_determinant, slope = self.equations.log_determinant(near[:, 0, :, ::every])
        value, gradient = -log_determinant, -np.einsum("skiN,siN->k", change[..., ::every], slope)
        if self.within is not None:
            positions = (near[0, 0][:, None] + step * np.eye(n + 1)[1:, :, None]).reshape(n, -1)
            outside = self.outside(positions, _CLEARANCE_SHARE)
            far = np.square(outside / self.reach).sum(axis=0)
            far = _OUTSIDE_PENALTY * far.reshape(n + 1, -1)
            value += float(far[0].sum())
            gradient += np.einsum("kiN,iN->k", change[0], (far[1:] - far[0]) / step)
        return value, gradient

    def starts(self, rng: np.random.Generator) -> FloatArray:
        """Numbers of random series, (starts, count); with a box, small ones about positions within it."""
        x = self.family.random(rng, _RANDOM_SERIES)
        if self.within is not None:
            limits = self.family.limits
            places = rng.uniform(size=(_DRAWN_POSITIONS, self.arm.n_joints))
            drawn = limits.lower + places * (limits.upper - limits.lower)
            far = self.outside(drawn.T, _CLEARANCE_SHARE).max(axis=0)
            nearest = np.argsort(far, kind="stable")[:_RANDOM_SERIES]
            x[..., -2], x[..., -1] = places[nearest], _SIZE_IN_BOX
        return x.reshape(_RANDOM_SERIES, -1)

    def best(self, rng: np.random.Generator) -> FloatArray:
        """Series of the best descent, made smaller if needed for the box or the drives' torques."""
        ranked = sorted(self.starts(rng), key=lambda x: self.loss(x)[0])
        descents = [self.descent(x, _TRIES_PER_DESCENT) for x in ranked[:_DESCENTS]]
        x, _ = self.descent(min(descents, key=lambda descent: descent[1])[0], _TRIES_OF_BEST)
        series = self.family.within_limits(x)
        within = None
        for size in np.linspace(1.0, 0.1, 91):
            smaller = np.hstack([size * series[:, :-1], series[:, -1:]])
            motion = self.family.motion(smaller, self.fine)
            far = self.outside(motion[0], _LEAST_CLEARANCE_SHARE).max()
            if far > 0.0:
                continue
            within = smaller
            if (np.abs(torque_of(self.arm, States(*(x.T for x in motion)))) <= self.torques).all():
                break
        if within is not None:
            return within
        raise UsageError(
            "no exciting motion was found that keeps the end effector in its box",
            where="within",
            found=f"{number(far, 2)} m outside",
            next_step="take a larger box, or another seed",
        )

    def descent(self, x: FloatArray, tries: int) -> tuple[FloatArray, float]:
        """Numbers of a better series, and their loss."""
        from scipy.optimize import minimize

        minimum = minimize(
            self.loss, x, jac=True, method="L-BFGS-B", bounds=self.family.bounds, options={"maxfun": tries}
        )
        return minimum.x, float(minimum.fun)
