"""ROS messages with an arm's motion: in bags, and as printed by `ros2 topic echo --csv`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import ArrayTable, gathered, missing_library, refusing_damage
from gd_analyze.motions.text import is_number
from gd_analyze.motions.vocabulary import VOCABULARY, words_in
from gd_analyze.progress import NO_PROGRESS, Progress

_STATE, _TRAJECTORY = "sensor_msgs/msg/JointState", "trajectory_msgs/msg/JointTrajectory"
_CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
_DYNAMIC = "control_msgs/msg/DynamicJointState"
_KINDS = (_STATE, _TRAJECTORY, _CONTROLLER, _DYNAMIC)
_ECHOED = ("position", "velocity", "effort")
# Fields of states and of points, and the suffixes of their columns' names.
_FIELDS = {word: word for word in _ECHOED} | {
    **{"positions": "position", "velocities": "velocity", "accelerations": "acceleration"}
}
_STAMP, _ARRIVAL = "header/stamp_ns", "received/time_ns"
_SIDES = ("actual", "feedback", "desired", "reference", "command", "output")
_INTEGER = re.compile(r"[0-9]{1,19}")
# Messages of a bag after which progress is reported again.
_MESSAGES_PER_REPORT = 1000


def read_bag(path: Path, topic: str | None = None, progress: Progress = NO_PROGRESS) -> ArrayTable:
    """Read one topic of a rosbag2 (.db3, .mcap or folder, with or without metadata.yaml) or ROS 1 bag."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_library("rosbags", path) from None
    step = "check it with `ros2 bag info`; messages that are not part of ROS need their definitions"
    with (
        refusing_damage(path, "the bag cannot be read", "a whole bag of ROS", step),
        AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader,
    ):
        chosen = _connections(reader.connections, topic, path)
        states = all(connection.msgtype == _STATE for connection in chosen)
        commanded = states and bool({*words_in(chosen[0].topic)} & VOCABULARY["kind"]["target"])
        messages = (
            (reader.deserialize(raw, connection.msgtype), connection.msgtype, received)
            for connection, received, raw in reader.messages(connections=chosen)
        )
        progress.stage("reading", sum(connection.msgcount for connection in chosen))
        return _table_of(path, messages, commanded, progress)


def _connections(connections: Sequence[Any], topic: str | None, path: Path) -> list[Any]:
    """Connections of the topic to read."""
    fitting = [c for c in connections if c.msgtype in _KINDS and c.msgcount]
    topics = list(dict.fromkeys(c.topic for c in fitting))
    candidates = fitting or connections
    listed = (f"{c.topic} ({c.msgtype.rpartition('/')[2]}, {c.msgcount} messages)" for c in candidates)
    if not topics or topic not in (None, *topics):
        message = "the bag contains no joint motion" + ("" if topic is None else f" on topic {topic}")
        expected = ", ".join(topics) or "a topic of JointState, JointTrajectory or a controller's state"
        step = "give one of these as `topic`" if topics else "record /joint_states too"
        raise refusal(message, Location(path), expected, "; ".join(listed) or "no messages", step)
    if topic is None and len(topics) > 1:
        message, step = "several topics of the bag contain joint motions", " or ".join(topics[:6])
        raise refusal(
            message, Location(path), "one topic", "; ".join(listed), f"choose one as `topic`: {step}"
        )
    return [c for c in fitting if c.topic == (topic or topics[0])]


def echoed_names(cells: Sequence[str]) -> tuple[str, ...] | None:
    """Column names of an echoed JointState in CSV, from its first row; None for any other row.

    A row holds seconds, nanoseconds, frame, the joints' names and their values; an empty list is one cell.
    """
    if len(cells) < 5 or not all(_INTEGER.fullmatch(cell) for cell in cells[:2]) or is_number(cells[2]):
        return None
    joints = list(takewhile(lambda cell: cell and not is_number(cell), cells[3:]))
    names = ["header/stamp/sec", "header/stamp/nanosec", "", *([""] * len(joints))]
    for field in _ECHOED if joints else ():
        if len(names) < len(cells):
            names += [f"{joint}/{field}" for joint in joints] if cells[len(names)] else [""]
    return tuple(names) if joints and len(names) == len(cells) else None


def _rows_of(message: Any, kind: str) -> Iterator[tuple[int, dict[str, float]]]:
    """Rows of a message: ns since its stamp, and values of joints by column name."""
    names = message.name if kind == _STATE else message.joint_names
    row: dict[str, float] = {}
    if kind == _TRAJECTORY:
        for point in message.points:
            yield _nanoseconds(point.time_from_start), _values(point, names, "")
    elif kind == _STATE:
        yield 0, _values(message, names, "")
    elif kind == _DYNAMIC:
        for name, interfaces in zip(names, message.interface_values, strict=True):
            for interface, value in zip(interfaces.interface_names, interfaces.values, strict=True):
                row[f"{name}/{interface}"] = float(value)
        yield 0, row
    else:
        for side in _SIDES:
            row |= _values(getattr(message, side, None), names, f"{side}/")
        yield 0, row


def _nanoseconds(stamp: Any) -> int:
    """Instant of a stamp or a duration, ns."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _values(point: Any, names: Sequence[str], prefix: str) -> dict[str, float]:
    row: dict[str, float] = {}
    for key, quantity in _FIELDS.items():
        values = getattr(point, key, None)
        if values is None or len(values) == 0:
            continue
        if len(values) != len(names):
            raise ValueError(f"{len(values)} of {key} for {len(names)} joints")
        row |= {f"{prefix}{name}/{quantity}": float(x) for name, x in zip(names, values, strict=True)}
    return row


def _records(
    messages: Iterable[tuple[Any, str, int]], plans: list[int], progress: Progress
) -> Iterator[dict[str, float]]:
    """Rows of messages, each with its kind and time of arrival, ns; `plans` takes the points of each plan.

    Raises ValueError if a message is inconsistent.
    """
    for number, (message, kind, received) in enumerate(messages, start=1):
        try:
            stamp = _nanoseconds(message.header.stamp)
            rows = list(_rows_of(message, kind))
        except ValueError as error:
            raise ValueError(f"in message {number}, {error}") from None
        if kind == _TRAJECTORY:
            plans.append(len(rows))
        for later, values in rows:
            yield {_STAMP: stamp + later, _ARRIVAL: received + later, **values}
        if number % _MESSAGES_PER_REPORT == 0:
            progress.advance(_MESSAGES_PER_REPORT)


def _table_of(
    path: Path, messages: Iterable[tuple[Any, str, int]], commanded: bool, progress: Progress
) -> ArrayTable:
    """Rows of messages; nan for missing joints."""
    plans: list[int] = []
    columns = gathered(_records(messages, plans, progress))
    if not {*columns} - {_STAMP, _ARRIVAL}:
        expected, step = "messages with names and positions of joints", "check the recording"
        content = f"{len(columns[_STAMP])} messages without numbers" if columns else "no message"
        raise refusal("the log contains no motion", Location(path), expected, content, step)
    lengths = [str(points) for points in plans if points > 1]
    if len(lengths) > 1:
        problem, content = f"the log contains {len(lengths)} trajectories", f"{', '.join(lengths[:6])} points"
        expected, step = "one JointTrajectory, or points in a row", "write each to a file of its own"
        raise refusal(problem, Location(path), expected, content, step)
    return ArrayTable(path, tuple(columns), tuple(columns.values()), commanded or bool(plans) or None)
