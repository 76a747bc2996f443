"""Writes trajectories as CSV, and finds the command that such a file records."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gd_analyze.files import write_text
from gd_analyze.motions.trajectory import Trajectory

# A line of its own where nothing is known of the motion between the set points above and below.
GAP = "# gap"

_COMMAND = re.compile(r"(?m)^#[ \t]*(gd-analyze plan .*\S)\s*$")


def trajectory_csv(trajectory: Trajectory, comments: Iterable[str] = ()) -> str:
    """Text of a trajectory's CSV file: comments, header, numbers in full precision, gaps as `# gap`."""
    table = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    # Adding 0.0 turns -0.0 into 0.0; repr is the shortest text that reads back as the same number.
    rows = [",".join(map(repr, row)) for row in (table + 0.0).tolist()]
    for gap in reversed(trajectory.gaps):
        rows.insert(gap, GAP)
    joints = range(1, trajectory.n_joints + 1)
    header = ",".join(["time", *(f"{role}{i}" for role in ("q", "qd", "qdd") for i in joints)])
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines()]
    return "\n".join([*lines, header, *rows]) + "\n"


def write_trajectory(trajectory: Trajectory, path: str | Path, comments: Iterable[str] = ()) -> None:
    """Write a trajectory as CSV, atomically; reading it back gives the same numbers.

    `comments` come first, without their `#`: by custom the command that makes the file. Raises OutputError.
    """
    write_text(path, trajectory_csv(trajectory, comments))


def recorded_command(lines: Iterable[str]) -> str | None:
    """Find the `gd-analyze plan` command in the comments of a trajectory file, or None."""
    return next((found[1] for line in lines if (found := _COMMAND.fullmatch(line))), None)
