"""From a file to a motion: table (formats), columns, log in SI units (log), trajectory (smoothing)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from types import NoneType

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.errors import Location, TrajectoryError, require_type, warn_caller
from gd_analyze.motions.columns import chosen_columns
from gd_analyze.motions.formats import files_in, log_source, log_table
from gd_analyze.motions.limits import check_against_arm
from gd_analyze.motions.log import Log, log_of
from gd_analyze.motions.reading import Reading, Treatment, refusal
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.trajectory import Trajectory, recorded_command
from gd_analyze.motions.units_by_numbers import look_like_radians
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of, builtin_arms, load_arm
from gd_analyze.text import visible


@strict
def read_trajectory(
    path_or_name: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    treatment: Treatment | None = None,
    *,
    progress: Progress = NO_PROGRESS,
) -> Trajectory:
    """Read a trajectory for an arm, or the log of a motion.

    Parameters
    ----------
    path_or_name
        A file, the folder of a bag, the name of a shipped trajectory, or "-" for standard input.
    arm
        The arm of the motion, its name, or the path of its file.
    reading
        How to read a log; fields left out are inferred from the log.
    treatment
        How to treat readings; by default chosen by rule.
    progress
        Told how much is read, see `Progress`.

    Returns
    -------
    Trajectory
        Named after the file. `Trajectory.derivatives_from` says how missing velocities and accelerations were
        derived; `Trajectory.recording` holds the readings of a measured log.

    Raises
    ------
    TrajectoryError
        If it cannot be read or is ambiguous; the message names line and column.

    Warns
    -----
    GdAnalyzeWarning
        If the arm's limits are exceeded, angles seem to be in another unit than stated, or joints with
        different names are matched.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> read_trajectory("pick-and-place", load_arm("puma560")).n_set_points
    31
    """
    require_type(treatment, (Treatment, NoneType), "treatment", "a Treatment, or None")
    arm = arm_of(arm)
    return motion_of(read_log(path_or_name, arm, reading, progress=progress), path_or_name, arm, treatment)


def motion_of(
    logged: Log, path_or_name: str | Path, arm: RobotArm, treatment: Treatment | None
) -> Trajectory:
    """Make a motion from a log, and check its numbers; see `read_trajectory`."""
    try:
        trajectory = Trajectory.from_log(logged, arm, treatment)
    except TrajectoryError as error:
        if str(path_or_name) in str(error):
            raise
        # The error, raised from numbers alone, does not know the file.
        expected, content, step = (error.details.get(key, "") for key in ("expected", "found", "next"))
        where = Location("standard input" if str(path_or_name) == "-" else path_or_name)
        raise refusal(error.what, where, expected, content, step or None) from None
    names = [joint.name for joint in arm.joints]
    degrees = [names.index(use.joint) for use in logged.columns if use.role == "q" and use.unit == "deg"]
    low, high = (np.degrees(extreme.reduce(logged.q)[degrees]) for extreme in (np.fmin, np.fmax))
    reach = np.maximum(-low, high)
    if look_like_radians(reach) and (high > low).any():
        looks = f"angles in degrees stay within {reach.max():.3g} of zero, which looks like radians"
        message = f"trajectory {trajectory.name}: {looks}; if they are, name the columns without the unit"
        warn_caller(message)
    check_against_arm(trajectory, arm)
    return trajectory


@strict
def read_log(
    path_or_name: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    *,
    progress: Progress = NO_PROGRESS,
) -> Log:
    """Read the motion of an arm from a log or a file of set points, without treating it.

    Parameters
    ----------
    path_or_name
        As for `read_trajectory`.
    arm
        The arm of the motion, its name, or the path of its file.
    reading
        How to read the log; fields left out are inferred from the log.
    progress
        Told how much is read, see `Progress`.

    Returns
    -------
    Log
        The motion in SI units; `Log.columns` states role, joint and unit of every column.

    Raises
    ------
    TrajectoryError
        If it cannot be read or is ambiguous; the message lists the choices.

    Warns
    -----
    GdAnalyzeWarning
        If joints with different names are matched.
    """
    require_type(reading, (Reading, NoneType), "reading", "a Reading, or None")
    arm, reading = arm_of(arm), reading or Reading()
    path, name, origin, data = log_source(path_or_name)
    table = log_table(path, reading, data, progress, arm.n_joints)
    command = recorded_command(table.first_lines[:20]) if isinstance(table, TextTable) else None
    if command:
        _require_kinds(command, arm, name, path)
        origin += f"; made by: {command}"
    choice, columns = chosen_columns(table, arm, reading, progress)
    for remark in choice.remarks:
        warn_caller(f"log {name}: {remark}")
    return log_of(table, arm, reading, choice, columns, visible(name), visible(origin))


def _require_kinds(command: str, arm: RobotArm, name: str, path: Path) -> None:
    """Refuse a motion planned for a built-in arm that turns where this one slides, or the other way round."""
    planned = next((word for word in command.split() if word in builtin_arms()), arm.name)
    joints = () if planned == arm.name else load_arm(planned).joints
    if len(joints) != arm.n_joints:
        return  # another error says so
    for number, (planned_joint, arm_joint) in enumerate(zip(joints, arm.joints, strict=True), start=1):
        if planned_joint.kind != arm_joint.kind:
            kind = f"joint {number} ({arm_joint.name}) is {arm_joint.kind}"
            message = f"trajectory {name} is not for arm {arm.name}: {kind}"
            expected = f"q{number} in {arm_joint.unit}"
            column = f"q{number} in {planned_joint.unit}, planned for {planned}"
            step = f"choose arm {planned}, or plan a motion with `gd-analyze plan`"
            raise refusal(message, Location(path), expected, column, step)


def last_link(path_or_name: str | Path, paths: Mapping[str, Sequence[str]]) -> str | None:
    """Link of the last joint that a log names; None unless all joints it names are on one path.

    `paths` holds the joints on the path to every link. Of a folder it is the first log. Also None if the log
    can be read only once.
    """
    path = Path(path_or_name)
    joints = sorted({joint for chain in paths.values() for joint in chain}, key=len, reverse=True)
    try:
        table = log_table((files_in(path) or [path])[0], Reading(), None, NO_PROGRESS, 1)
    except (TrajectoryError, OSError):
        return None  # reading it for an arm gives a better message
    named = set()
    for name in table.names:
        matches = (joint for joint in joints if re.search(rf"(?<![^\W_]){re.escape(joint)}(?![^\W_])", name))
        named |= {*islice(matches, 1)}
    ends = [link for link, chain in paths.items() if named and chain[-1] in named and named <= {*chain}]
    return ends[0] if len(ends) == 1 else None
