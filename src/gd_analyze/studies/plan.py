"""Plan a motion, and say where the drives are too weak for it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from gd_analyze.arguments import strict
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.motions.planning import plan_motion
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of


@strict
def plan(
    arm: RobotArm | str | Path,
    start: ArrayLike,
    goal: ArrayLike,
    duration: float,
    *,
    via: Sequence[ArrayLike] = (),
    profile: str = "4-3-4",
    n_set_points: int = 31,
    via_times: ArrayLike | None = None,
    allow_violations: bool = False,
    name: str | None = None,
) -> Trajectory:
    """Plan a motion from rest to rest, within the arm's limits.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    start, goal
        Joint variables at the ends, rad (m), shape (n,).
    duration
        Time from start to goal, s.
    via
        Joint variables to pass in between, in order. For 4-3-4 and 3-5-3: none, or lift-off and set-down.
    profile
        "4-3-4", "3-5-3", "quintic", "cubic" or "trapezoidal".
    n_set_points
        Number of set points, evenly spaced in time, both ends included.
    via_times
        Instants of the vias, s; by default the time of each stretch is proportional to the square root of the
        distance of its slowest joint.
    allow_violations
        Warn, rather than fail, when velocities or accelerations exceed their limits.
    name
        Name of the trajectory; by default arm and profile.

    Returns
    -------
    Trajectory
        Set points with the profile's exact velocities and accelerations. Where an acceleration jumps, its
        value is that after the jump, at the goal that before.

    Raises
    ------
    TrajectoryError
        If an argument is wrong, a position limit is exceeded, or (unless `allow_violations`) a velocity or
        acceleration limit; the message then gives the shortest duration that meets them.
    UsageError
        If the profile is unknown.
    ArmError
        If there is no such arm.

    Warns
    -----
    GdAnalyzeWarning
        If velocities or accelerations exceed their limits and `allow_violations` is set, or the drives are
        too weak for the motion.

    Examples
    --------
    >>> plan("two_link", [0, 0], [1, -1], 2.0, profile="quintic").n_set_points
    31
    """
    arm = arm_of(arm)
    planned = plan_motion(
        arm,
        start,
        goal,
        duration,
        via=via,
        profile=profile,
        n_set_points=n_set_points,
        via_times=via_times,
        allow_violations=allow_violations,
        name=name,
    )
    warn_of_torque_limits(arm, states_of(planned.trajectory))
    return planned.trajectory
