"""Is this a trajectory of this arm? Errors for what cannot be, warnings for what looks wrong."""

from __future__ import annotations

import math
import warnings

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.limits import ROUNDING, joint_label, limit_report
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import contradictions
from gd_analyze.robots.arm import RobotArm

# A joint without limits may turn several times; numbers beyond two turns are rarely radians.
_MANY_TURNS = 4 * math.pi
# Motions of more than this, rad or m, do not creep; and velocities up to this share of the limits are usual.
_MOVES, _USUAL = 0.1, 1.5


def check_against_arm(trajectory: Trajectory, arm: RobotArm) -> None:
    """Refuse a trajectory of another number of joints; warn of what looks wrong.

    That is each limit that is exceeded, angles that look like degrees (whose limits are not reported as
    well), velocities that time in milliseconds would explain, and given derivatives that are none.
    """
    require_joints(trajectory, arm)
    suspects = _degree_suspects(arm, trajectory.q)
    found = []
    if suspects:
        labels = ", ".join(joint_label(i + 1, arm.joints[i].name) for i in suspects)
        largest = float(np.abs(trajectory.q[:, list(suspects)]).max())
        found.append(
            f"{labels} read as radians reach {largest:.4g} rad ({math.degrees(largest):.0f} deg), which "
            f"looks like degrees; if they are, name the columns q{suspects[0] + 1}_deg and so on, or say "
            "--degrees of a log"
        )
    found += _limits_exceeded(trajectory, arm, suspects)
    found += _slowness(trajectory, arm)
    arrays = (trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd)
    found += contradictions(*arrays, trajectory.gaps, trajectory.derived)
    for message in found:
        warnings.warn(f"trajectory {trajectory.name}: {message}", GdAnalyzeWarning, stacklevel=3)


def require_joints(trajectory: Trajectory, arm: RobotArm) -> None:
    """Refuse a trajectory of another number of joints; raises TrajectoryError."""
    if trajectory.n_joints != arm.n_joints:
        raise TrajectoryError(
            f"trajectory {trajectory.name} is not for arm {arm.name}",
            expected=f"{arm.n_joints} joints",
            found=f"{trajectory.n_joints} joints",
            next_step="choose the arm the trajectory was made for; `gd-analyze arms` lists the built-in ones",
        )


def warn_if_radians(name: str, degrees: FloatArray) -> None:
    """Warn when angles that a file calls degrees, shape (N, k), look like radians.

    Few motions stay within 3.15 degrees of the zero position of every joint, and all of them do in radians
    within half a turn.
    """
    reach = float(np.nanmax(np.abs(degrees), initial=0.0))
    if reach <= 3.15 and bool((np.ptp(degrees, axis=0) > 0).any()):
        warnings.warn(
            f"trajectory {name}: angles in degrees stay within {reach:.3g} of zero, which looks like "
            "radians; if they are, name the columns without the unit",
            GdAnalyzeWarning,
            stacklevel=3,
        )


def _degree_suspects(arm: RobotArm, q: FloatArray) -> tuple[int, ...]:
    """Joints (from 0) whose angles look like degrees taken for radians.

    A revolute joint is under suspicion when it goes beyond a full turn and outside its limits, yet the
    same numbers taken as degrees stay inside; without limits, when it goes beyond two turns.
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
        reach > _MANY_TURNS,
    )
    return tuple(int(i) for i in np.flatnonzero(looks_wrong & np.array(arm.is_revolute)))


def _limits_exceeded(trajectory: Trajectory, arm: RobotArm, suspects: tuple[int, ...]) -> list[str]:
    smooth = trajectory.recording is not None and trajectory.recording.measured
    found = []
    for violation in limit_report(arm, trajectory).violations:
        if violation.joint - 1 in suspects:
            continue
        set_point = int(np.searchsorted(trajectory.time, violation.time)) + 1
        message = f"{violation}, at set point {set_point} ({violation.time:.4g} s)"
        derived = {"velocity": "qd", "acceleration": "qdd"}.get(violation.quantity)
        if smooth and derived:
            message += "; from smoothed readings: a lower --cutoff smooths more"
        elif derived in trajectory.derived:
            message += f"; {derived} is derived, which amplifies rounding: smooth q or add {derived}"
        found.append(message)
    return found


def _slowness(trajectory: Trajectory, arm: RobotArm) -> list[str]:
    """Velocities that come of positions and instants alone, and would be usual if the instants were in ms."""
    moving = np.ptp(trajectory.q, axis=0) > _MOVES
    limits = arm.limits("velocity_limit")[moving]
    if "qd" not in trajectory.derived or not moving.any() or not ((limits > 0) & np.isfinite(limits)).all():
        return []
    share = float((np.abs(trajectory.qd[:, moving]).max(axis=0) / limits).max())
    if not 0.0 < 1000.0 * share <= _USUAL:
        return []
    return [
        f"at most {100 * share:.2g} % of the arm's velocity limits, in time read as seconds; if it is in "
        "milliseconds, say --time-unit ms"
    ]
