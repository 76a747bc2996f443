"""Logs that are read where a trajectory is asked for: which files these are, and the motion in them."""

from __future__ import annotations

import csv
from contextlib import suppress
from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.cells import WITH_COMMA
from gd_analyze.motions.measured import motion_of
from gd_analyze.motions.read import read_log
from gd_analyze.motions.reading import Reading
from gd_analyze.motions.roles import is_of_set_points
from gd_analyze.motions.table import Progress, no_progress
from gd_analyze.motions.text_layout import LONGEST_NAME
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.treatment import Treatment
from gd_analyze.robots.arm import RobotArm

# Bytes by which a file is judged.
HEAD = 100_000


def beginning_of(path: Path) -> bytes:
    """Read the first bytes of a file; none of one that cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return file.read(HEAD)
    return b""


def _rows(head: bytes) -> list[list[str]] | None:
    """Cells of the first two lines; None where these are no text, or no table."""
    if b"\0" in head:
        return None
    try:
        text = head.decode("utf-8-sig", errors="ignore")
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")][:2]
        delimiter = max(",;\t", key=rows[0].count) if rows else ","
        return list(csv.reader(rows, delimiter=delimiter, strict=True))
    except csv.Error:
        return None


def keeps_contract(head: bytes) -> bool:
    """Whether a file, by its first bytes, is to be read as set points: by its header, or for its errors."""
    rows = _rows(head)
    if not rows:
        return True
    names = [name.strip() for name in rows[0]]
    if any(len(name) > LONGEST_NAME for name in names):
        return True
    return all(map(is_of_set_points, names)) and not (len(rows) > 1 and any(map(_has_comma, rows[1])))


def _has_comma(cell: str) -> bool:
    return WITH_COMMA.fullmatch(cell.strip()) is not None


def motion_of_log(
    path: str | Path,
    arm: RobotArm,
    reading: Reading,
    treatment: Treatment | None,
    data: bytes | None = None,
    progress: Progress = no_progress,
) -> Trajectory:
    """Read a log and make a motion of it.

    Parameters
    ----------
    path, arm, reading, data, progress
        As `read_log` takes them.
    treatment
        As `motion_of` takes it.

    Raises
    ------
    TrajectoryError
        As these two.
    """
    logged = read_log(path, arm, reading, data=data, progress=progress)
    try:
        return motion_of(logged, arm, treatment)
    except TrajectoryError as error:
        if str(path) in str(error):
            raise
        # Of arrays alone it does not know which file they are from, and what users would change there.
        raise TrajectoryError(
            error.what,
            where=Location(path),
            expected=error.details.get("expected"),
            found=error.details.get("found"),
            next_step="check the unit of its time, and that no two instants are almost the same",
        ) from None
