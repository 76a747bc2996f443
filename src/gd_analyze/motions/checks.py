"""Is this a trajectory of this arm? Errors for what cannot be, warnings for what looks wrong."""

from __future__ import annotations

import math
import warnings

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.limits import ROUNDING, Violation, joint_label, limit_report
from gd_analyze.motions.rate_slips import rate_slips
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

# A joint without limits may turn several times; numbers beyond two turns are rarely radians.
MANY_TURNS = 4 * math.pi
# Motions of more than this, rad or m, do not creep; and rates up to this share of the limits are usual ones.
_MOVES, _USUAL = 0.1, 1.5


def check_against_arm(trajectory: Trajectory, arm: RobotArm) -> None:
    """Check that a trajectory fits an arm.

    Parameters
    ----------
    trajectory
        The set points.
    arm
        The arm that shall follow them.

    Raises
    ------
    TrajectoryError
        If the number of joints differs.

    Warns
    -----
    GdAnalyzeWarning
        For each joint whose positions, rates or accelerations exceed its limits, once when joint angles look
        like degrees (for joints under that suspicion the limits are not reported as well), and for given
        rates that are not the derivatives they should be.
    """
    require_joints(trajectory, arm)
    suspects = degree_suspects(arm, trajectory.q)
    if suspects:
        labels = ", ".join(joint_label(i + 1, arm.joints[i].name) for i in suspects)
        largest = float(np.abs(trajectory.q[:, list(suspects)]).max())
        _warn(
            f"trajectory {trajectory.name}: {labels} read as radians reach up to {largest:.4g} rad "
            f"({math.degrees(largest):.0f} deg), which looks like degrees; if they are, name the columns "
            f"q{suspects[0] + 1}_deg and so on, or say --degrees of a log"
        )
    for violation in limit_report(arm, trajectory).violations:
        if violation.joint - 1 not in suspects:
            _warn(_limit_warning(trajectory, violation))
    for slip in (*_slowness(trajectory, arm), *rate_slips(trajectory)):
        _warn(f"trajectory {trajectory.name}: {slip}")


def _slowness(trajectory: Trajectory, arm: RobotArm) -> list[str]:
    """Say where rates come of positions and instants alone, and would be usual ones if these were ms."""
    moving = np.ptp(trajectory.q, axis=0) > _MOVES
    limits = arm.limits("velocity_limit")[moving]
    if "qd" not in trajectory.derived or not moving.any() or not ((limits > 0) & np.isfinite(limits)).all():
        return []
    share = float((np.abs(trajectory.qd[:, moving]).max(axis=0) / limits).max())
    if not 0.0 < 1000.0 * share <= _USUAL:
        return []
    return [
        f"the arm moves at {100 * share:.2g} % of its rate limits at most, in time read as seconds; "
        "if it is in milliseconds, say --time-unit ms"
    ]


def require_joints(trajectory: Trajectory, arm: RobotArm) -> None:
    """Refuse a trajectory of another number of joints; raises TrajectoryError."""
    if trajectory.n_joints != arm.n_joints:
        raise TrajectoryError(
            f"trajectory {trajectory.name} is not for arm {arm.name}",
            expected=f"{arm.n_joints} joints",
            found=f"{trajectory.n_joints} joints",
            next_step="choose the arm the trajectory was made for; `gd-analyze arms` lists the built-in ones",
        )


def degree_suspects(arm: RobotArm, q: FloatArray) -> tuple[int, ...]:
    """Joints (from 0) whose angles look like degrees taken for radians.

    A revolute joint is under suspicion when it goes beyond a full turn and outside its limits, yet the
    same numbers taken as degrees stay inside; without limits, when it goes beyond two turns.

    Parameters
    ----------
    arm
        The arm.
    q
        Joint variables, rad (m), shape (N, n).
    """
    low, high = q.min(axis=0), q.max(axis=0)
    lower, upper = arm.limits("lower"), arm.limits("upper")
    reach = np.maximum(np.abs(low), np.abs(high))
    looks_wrong = np.where(
        np.isfinite(lower) & np.isfinite(upper),
        (reach > 2 * math.pi)
        & ((low < lower) | (high > upper))
        & (lower <= np.radians(low) + ROUNDING)
        & (np.radians(high) <= upper + ROUNDING),
        reach > MANY_TURNS,
    )
    return tuple(int(i) for i in np.flatnonzero(looks_wrong & np.array(arm.is_revolute)))


def warn_if_radians(name: str, degrees: FloatArray) -> None:
    """Warn when angles that a file calls degrees look like radians.

    Parameters
    ----------
    name
        Name of the trajectory.
    degrees
        All angles from columns marked as degrees, as written there.

    Warns
    -----
    GdAnalyzeWarning
        If they move, and none is farther than 3.15 degrees from zero: few motions stay that close to the
        zero position of every joint, and all of them do in radians within half a turn.
    """
    reach = float(np.abs(degrees).max())
    moves = bool((np.ptp(degrees, axis=0) > 0).any())
    if moves and reach <= 3.15:
        _warn(
            f"trajectory {name}: the _deg columns stay within {reach:.3g} degrees of zero, which looks like "
            "radians; if they are, leave the _deg suffix out"
        )


def _limit_warning(trajectory: Trajectory, violation: Violation) -> str:
    set_point = int(np.searchsorted(trajectory.time, violation.time)) + 1
    message = f"trajectory {trajectory.name}: {violation}, at set point {set_point} ({violation.time:.4g} s)"
    derived = {"rate": "qd", "acceleration": "qdd"}.get(violation.quantity)
    if trajectory.recording is not None and trajectory.recording.measured:
        if derived:
            message += "; it is of smoothed readings: a lower --cutoff smooths more"
    elif derived in trajectory.derived:
        message += (
            f"; {derived} was derived from the file's numbers, which amplifies their noise and rounding: "
            f"smooth them or add {derived} columns if that is the cause"
        )
    return message


def _warn(message: str) -> None:
    warnings.warn(message, GdAnalyzeWarning, stacklevel=4)
