"""Reads what is given for a trajectory: a file of set points or, whatever else a robot writes, a log."""

from __future__ import annotations

import difflib
import sys
from dataclasses import replace
from os import PathLike
from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most, shipped
from gd_analyze.motions.checks import check_against_arm, warn_if_radians
from gd_analyze.motions.log_file import HEAD, beginning_of, keeps_contract, motion_of_log
from gd_analyze.motions.open_log import format_by_name
from gd_analyze.motions.reading import Reading
from gd_analyze.motions.set_points import set_points_in
from gd_analyze.motions.table import Progress, no_progress
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.treatment import Treatment
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.text import in_python, visible

# A million set points of a seven-joint arm, every number with all its digits, are 0.45 GB.
LARGEST_FILE = 1_000_000_000


def shipped_trajectories() -> dict[str, Path]:
    """Shipped trajectory files by name, in alphabetical order."""
    return shipped("trajectories", ".csv")


def read_trajectory(
    path_or_name: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    treatment: Treatment | None = None,
    *,
    progress: Progress = no_progress,
) -> Trajectory:
    """Read a trajectory for an arm, or the log of a motion.

    Parameters
    ----------
    path_or_name
        A file, the folder of a bag, the name of a shipped trajectory, or "-" for standard input.
    arm
        The arm that shall follow it, or did, or its name or the path of its file.
    reading
        What a log does not tell itself of its columns.
    treatment
        What is done to a measured one; by default rules decide.
    progress
        Told how much of a log is read.

    Returns
    -------
    Trajectory
        Named after the file; missing rates are derived, and `Trajectory.rates_from` says how. Of a measured
        log, `Trajectory.recording` holds what it was made of.

    Raises
    ------
    TrajectoryError
        If there is no such file, it breaks the contract of trajectories, or a log is not understood; the
        message names line and column.

    Warns
    -----
    GdAnalyzeWarning
        If the arm's limits are exceeded, angles seem to be in another unit than stated, or joints are matched
        although their names differ.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> read_trajectory("pick-and-place", load_arm("puma560")).n_set_points
    31
    """
    if not isinstance(path_or_name, str | PathLike):
        raise TrajectoryError(
            "this is no trajectory",
            where="trajectory",
            expected="the name of a shipped one, or the path of a file",
            found=in_python(path_or_name),
        )
    arm = arm_of(arm)
    log = _log_in(path_or_name, arm, reading or Reading(), treatment, progress)
    trajectory, degrees = (log, None) if isinstance(log, Trajectory) else set_points_in(*log, arm)
    if degrees is not None:
        warn_if_radians(trajectory.name, degrees)
    check_against_arm(trajectory, arm)
    return trajectory


def _log_in(
    path_or_name: str | Path,
    arm: RobotArm,
    reading: Reading,
    treatment: Treatment | None,
    progress: Progress,
) -> Trajectory | tuple[str | Path, str, str, bytes]:
    """Read the motion of a log; of a file of set points, fetch path for messages, name, origin and bytes."""
    given = Path(path_or_name)
    is_file = str(path_or_name) not in ("-", *shipped_trajectories()) and _is_regular(given)
    if is_file and (format_by_name(given) or reading.asked or not keeps_contract(beginning_of(given))):
        return motion_of_log(given, arm, reading, treatment, progress=progress)
    path, name, source, data = _fetch(path_or_name)
    if reading.asked or not keeps_contract(data[:HEAD]):
        motion = motion_of_log(path, arm, reading, treatment, data, progress)
        return replace(motion, name=visible(name), origin=visible(source))
    return path, name, source, data


def _is_regular(path: Path) -> bool:
    """Whether a path is that of a file that may be read twice, or of a bag's folder."""
    try:
        return path.is_file() or format_by_name(path) is not None
    except (OSError, ValueError):
        return False


def _fetch(path_or_name: str | Path) -> tuple[str | Path, str, str, bytes]:
    """Path for messages, name, origin and bytes of a trajectory."""
    given = str(path_or_name)
    if given == "-":
        return "standard input", "stdin", "read from standard input", _standard_input()
    known = shipped_trajectories()
    path = known.get(given, Path(path_or_name))
    source = f"shipped trajectory {given}" if given in known else f"read from {given}"
    try:
        return path, path.stem, source, _limited(read_at_most(path, LARGEST_FILE), path)
    except FileNotFoundError:
        near = difflib.get_close_matches(Path(given).stem, known, n=1)
        raise TrajectoryError(
            f"there is no trajectory {given!r}",
            where=Location(path),
            expected=f"a CSV file or a shipped trajectory ({', '.join(known)})",
            found="neither an existing file nor a known name",
            next_step=f"did you mean the shipped {near[0]!r}?"
            if near
            else "check the path, or make a trajectory with `gd-analyze plan`",
        ) from None
    except OSError as error:
        raise TrajectoryError(
            "cannot read the trajectory file",
            where=Location(path),
            found=error.strerror or str(error),
            next_step="give the path of a CSV file you may read",
        ) from None


def _limited(data: bytes | None, path: str | Path) -> bytes:
    if data is None:
        raise TrajectoryError(
            "the trajectory is too large to be read",
            where=Location(path),
            expected=f"up to {megabytes(LARGEST_FILE)}",
            found="more",
            next_step="write fewer digits or fewer set points, or split the motion",
        )
    return data


def _standard_input() -> bytes:
    try:
        data = read_at_most(sys.stdin.buffer, LARGEST_FILE)
    except OSError as error:
        raise TrajectoryError(
            "cannot read the trajectory from standard input",
            where="standard input",
            found=error.strerror or str(error),
            next_step="pipe a CSV file in, or give its path",
        ) from None
    return _limited(data, "standard input")
