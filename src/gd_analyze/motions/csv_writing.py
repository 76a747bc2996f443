"""Writes trajectories as CSV, and finds the command that such a file records."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gd_analyze.files import write_text
from gd_analyze.motions.csv_columns import header_for
from gd_analyze.motions.trajectory import Trajectory

# A line of its own where nothing is known of the motion between the set points above and below.
GAP = "# gap"

_COMMAND = re.compile(r"#\s*(gd-analyze plan .*\S)\s*")


def trajectory_csv(trajectory: Trajectory, comments: Iterable[str] = ()) -> str:
    """Text of a trajectory's CSV file: comments, header and every number in full precision; gaps as `# gap`.

    Parameters
    ----------
    trajectory
        The set points.
    comments
        Lines to put first, without their `#`.
    """
    table = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    # Adding 0.0 turns -0.0 into 0.0; repr is the shortest text that reads back as the same number.
    rows = [",".join(map(repr, row)) for row in (table + 0.0).tolist()]
    for gap in reversed(trajectory.gaps):
        rows.insert(gap, GAP)
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines()]
    return "\n".join([*lines, header_for(trajectory.n_joints), *rows]) + "\n"


def write_trajectory(trajectory: Trajectory, path: str | Path, comments: Iterable[str] = ()) -> None:
    """Write a trajectory as CSV, atomically; reading it back gives the same numbers.

    Parameters
    ----------
    trajectory
        The set points.
    path
        The file.
    comments
        Lines to put first, without their `#`; by custom the command that makes the file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    write_text(path, trajectory_csv(trajectory, comments))


def recorded_command(comments: str) -> str | None:
    """Find the `gd-analyze plan` command that a trajectory file's comments record, or None."""
    matches = (_COMMAND.fullmatch(line) for line in comments.splitlines())
    return next((match[1] for match in matches if match), None)
