"""Messages of ROS as `ros2 topic echo` and `rostopic echo` print them: YAML, or CSV without a header."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.motions.layout import is_number
from gd_analyze.motions.messages import Gathering, kind_of
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import ArrayTable, Progress, no_progress

_LARGEST_FILE = 400_000_000
# A message in memory takes 35 times the room of its text.
_LARGEST_MESSAGE = 30_000_000
# Messages nest five deep.
_DEEPEST = 50
_BETWEEN = re.compile(r"^---[ \t]*$", re.MULTILINE)
_INTEGER = re.compile(r"[0-9]{1,19}")


def echoed_names(cells: Sequence[str]) -> tuple[str, ...] | None:
    """Names of the columns of an echoed JointState, by its first row; None of any other row.

    A row has seconds, nanoseconds, frame, the joints' names, and what is given of each; an empty list in the
    message is an empty cell.

    Examples
    --------
    >>> echoed_names(["0", "8", "", "hip", "0.1", "", "3.5"])
    ('header/stamp/sec', 'header/stamp/nanosec', '', '', 'hip/position', '', 'hip/effort')
    """
    if len(cells) < 5 or not all(_INTEGER.fullmatch(cell) for cell in cells[:2]) or is_number(cells[2]):
        return None
    joints = []
    for cell in cells[3:]:
        if is_number(cell) or not cell:
            break
        joints.append(cell)
    names = ["header/stamp/sec", "header/stamp/nanosec", "", *([""] * len(joints))]
    for field in ("position", "velocity", "effort") if joints else ():
        if len(names) < len(cells):
            names += [f"{joint}/{field}" for joint in joints] if cells[len(names)] else [""]
    return tuple(names) if joints and len(names) == len(cells) else None


def read_yaml(path: str | Path, progress: Progress = no_progress) -> ArrayTable:
    """Read messages with `---` between them; TrajectoryError if it is no YAML, or no messages of joints."""
    data = read_at_most(path, _LARGEST_FILE)
    if data is None:
        raise _too_large(Location(path), _LARGEST_FILE)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _not_read(Location(path), f"byte 0x{data[error.start]:02x}") from None
    gathering = Gathering()
    for number, message in enumerate(_messages(text, path, progress), 1):
        try:
            kind = kind_of(message)
            if kind is None:
                raise ValueError("a document that is no JointState, JointTrajectory or controller state")
            gathering.add(message, kind)
        except (ValueError, TypeError, AttributeError, OverflowError) as error:
            raise _not_read(Location(path), f"in document {number}, {error}") from None
    return gathering.table(path)


def _messages(text: str, path: str | Path, progress: Progress) -> Iterator[Any]:
    """Documents, one at a time: all of them would take far more room than their text."""
    import yaml

    begin, line = 0, 0
    ends = [(found.start(), found.end()) for found in _BETWEEN.finditer(text)]
    for end, following in [*ends, (len(text), len(text))]:
        document = text[begin:end]
        where = Location(path, line + 1)
        if len(document) > _LARGEST_MESSAGE:
            raise _too_large(where, _LARGEST_MESSAGE)
        try:
            depth = 0
            # Building a document that nests deeper than any message would exhaust the stack.
            for event in yaml.parse(document, Loader=yaml.CSafeLoader):
                depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(
                    event, yaml.CollectionEndEvent
                )
                if depth > _DEEPEST:
                    raise ValueError(f"lists or maps in each other, more than {_DEEPEST} of them")
            message = yaml.load(document, Loader=yaml.CSafeLoader)
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            where = Location(path) if mark is None else Location(path, line + mark.line + 1, mark.column + 1)
            raise _not_read(where, error.problem or "no YAML") from None
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            raise _not_read(where, str(error).split("\n", 1)[0]) from None
        if message is not None:
            yield message
        line += document.count("\n")
        begin = following
        progress(following, len(text))


def _too_large(where: Location, most: int) -> TrajectoryError:
    step = "record a bag, or echo with --csv"
    return refusal("the log is too large to be read as YAML", where, f"up to {megabytes(most)}", "more", step)


def _not_read(where: Location, found: str) -> TrajectoryError:
    return refusal(
        "the log cannot be read as messages in YAML",
        where,
        "what `ros2 topic echo --full-length` prints of JointState or JointTrajectory",
        found,
        "echo the topic anew, or record a bag",
    )
