"""Messages of ROS as `ros2 topic echo` and `rostopic echo` print them, in YAML."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.logs.messages import TRAJECTORY, Gathering, kind_of, require_one_plan, rows_of
from gd_analyze.logs.table import ArrayTable

LARGEST_FILE = 200_000_000


def read_yaml(path: str | Path, data: bytes | None = None) -> ArrayTable:
    """Read messages that stand below each other, with `---` between them.

    Parameters
    ----------
    path
        The file.
    data
        Its bytes, where they are not to be read from it.

    Raises
    ------
    TrajectoryError
        If it is no YAML, or its documents are no messages of joints.
    """
    import yaml

    if data is None:
        data = read_at_most(path, LARGEST_FILE)
    if data is None:
        raise TrajectoryError(
            "the log is too large to be read as YAML",
            where=Location(path),
            expected=f"up to {megabytes(LARGEST_FILE)}",
            next_step="record a bag, or echo with --csv",
        )
    gathering, kinds, number = Gathering(), [], 0
    try:
        text = data.decode("utf-8-sig")
        for message in yaml.load_all(text, Loader=yaml.CSafeLoader):
            number += 1
            if message is None:
                continue
            kind = kind_of(message)
            if kind is None:
                raise ValueError("a document that is no JointState, JointTrajectory or controller state")
            rows = list(rows_of(message, kind))
            for row in rows:
                gathering.add(row)
            kinds.append((kind, len(rows)))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = Location(path) if mark is None else Location(path, mark.line + 1, mark.column + 1)
        raise _not_read(where, error.problem or "no YAML") from None
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise _not_read(Location(path), str(error).split("\n", 1)[0]) from None
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise _not_read(Location(path), f"in document {number}, {error}") from None
    require_one_plan(kinds, Location(path))
    return gathering.table(path, any(kind == TRAJECTORY for kind, _ in kinds) or None, lambda: Location(path))


def _not_read(where: Location, found: str) -> TrajectoryError:
    return TrajectoryError(
        "the log cannot be read as messages in YAML",
        where=where,
        expected="what `ros2 topic echo --full-length` prints of JointState or JointTrajectory",
        found=found,
        next_step="echo the topic anew, or record a bag",
    )
