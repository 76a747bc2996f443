"""Messages of ROS as `ros2 topic echo` and `rostopic echo` print them, in YAML."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.motions.messages import TRAJECTORY, Gathering, kind_of, require_one_plan, rows_of
from gd_analyze.motions.table import ArrayTable, Progress, no_progress

LARGEST_FILE = 400_000_000
# A message in memory takes 35 times the room of its text.
LARGEST_MESSAGE = 30_000_000

# Messages nest five deep.
_DEEPEST = 50
_BETWEEN = re.compile(r"^---[ \t]*$", re.MULTILINE)


def read_yaml(path: str | Path, data: bytes | None = None, progress: Progress = no_progress) -> ArrayTable:
    """Read messages that stand below each other, with `---` between them.

    Parameters
    ----------
    path
        The file.
    data
        Its bytes, where they are not to be read from it.
    progress
        Told how many signs of how many are read.

    Raises
    ------
    TrajectoryError
        If it is no YAML, or its documents are no messages of joints.
    """
    if data is None:
        data = read_at_most(path, LARGEST_FILE)
    if data is None:
        raise _too_large(Location(path), LARGEST_FILE)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _not_read(Location(path), f"byte 0x{data[error.start]:02x}") from None
    gathering, kinds = Gathering(), []
    for number, message in enumerate(_messages(text, path, progress), 1):
        try:
            kind = kind_of(message)
            if kind is None:
                raise ValueError("a document that is no JointState, JointTrajectory or controller state")
            rows = list(rows_of(message, kind))
        except (ValueError, TypeError, AttributeError, OverflowError) as error:
            raise _not_read(Location(path), f"in document {number}, {error}") from None
        for row in rows:
            gathering.add(row)
        kinds.append((kind, len(rows)))
    require_one_plan(kinds, Location(path))
    return gathering.table(path, any(kind == TRAJECTORY for kind, _ in kinds) or None, lambda: Location(path))


def _messages(text: str, path: str | Path, progress: Progress) -> Iterator[Any]:
    """Documents, one at a time: all of them would take far more room than their text."""
    import yaml

    begin, line = 0, 0
    ends = [(found.start(), found.end()) for found in _BETWEEN.finditer(text)]
    for end, following in [*ends, (len(text), len(text))]:
        document = text[begin:end]
        if len(document) > LARGEST_MESSAGE:
            raise _too_large(Location(path, line + 1), LARGEST_MESSAGE)
        try:
            _require_shallow(document, Location(path, line + 1))
            message = yaml.load(document, Loader=yaml.CSafeLoader)
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            where = Location(path) if mark is None else Location(path, line + mark.line + 1, mark.column + 1)
            raise _not_read(where, error.problem or "no YAML") from None
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            raise _not_read(Location(path, line + 1), str(error).split("\n", 1)[0]) from None
        if message is not None:
            yield message
        line += document.count("\n")
        begin = following
        progress(following, len(text))


def _require_shallow(document: str, where: Location) -> None:
    """Refuse a document that nests deeper than any message; building such a one would exhaust the stack."""
    import yaml

    depth = 0
    for event in yaml.parse(document, Loader=yaml.CSafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            raise _not_read(where, f"lists or maps in each other, more than {_DEEPEST} of them")


def _too_large(where: Location, most: int) -> TrajectoryError:
    return TrajectoryError(
        "the log is too large to be read as YAML",
        where=where,
        expected=f"up to {megabytes(most)}",
        found="more",
        next_step="record a bag, or echo with --csv",
    )


def _not_read(where: Location, found: str) -> TrajectoryError:
    return TrajectoryError(
        "the log cannot be read as messages in YAML",
        where=where,
        expected="what `ros2 topic echo --full-length` prints of JointState or JointTrajectory",
        found=found,
        next_step="echo the topic anew, or record a bag",
    )
