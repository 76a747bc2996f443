"""Bags of ROS: rosbag2 (.db3, .mcap or a folder) and ROS 1 (.bag), by the extra library rosbags."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.extra import required
from gd_analyze.motions.messages import KINDS, STATE, TRAJECTORY, Gathering, require_one_plan, rows_of
from gd_analyze.motions.roles import says_target
from gd_analyze.motions.table import ArrayTable, Progress, no_progress
from gd_analyze.motions.words import words_of

_TOLD_EVERY = 1000


def read_bag(path: Path, topic: str | None = None, progress: Progress = no_progress) -> ArrayTable:
    """Read the messages of one topic.

    Parameters
    ----------
    path
        A bag's file or folder; a .db3 or .mcap need not have its metadata.yaml beside it.
    topic
        Which topic, where several carry motions of joints.
    progress
        Told how many messages of how many are read.

    Raises
    ------
    TrajectoryError
        If the library is missing, the bag damaged, or no topic or several fit; the message lists them.
    """
    rosbags = required("rosbags.highlevel", "rosbags", path)
    typesys = required("rosbags.typesys", "rosbags", path)
    try:
        store = typesys.get_typestore(typesys.Stores.LATEST)
        with rosbags.AnyReader([path], default_typestore=store) as reader:
            chosen = _connections(reader.connections, topic, path)
            return _gathered(reader, chosen, path, progress)
    except TrajectoryError:
        raise
    # A damaged bag makes every part of the library fail in its own way: struct, sqlite, zstd, assertions.
    except Exception as error:
        text = str(error).split("\n", 1)[0] or type(error).__name__
        raise TrajectoryError(
            "the bag cannot be read",
            where=Location(path),
            expected="a bag of ROS, with the definitions of its messages where they are none of ROS itself",
            found=text,
            next_step="`ros2 bag info` or `rosbag info` tells whether it is whole",
        ) from None


def _connections(connections: Sequence[Any], topic: str | None, path: Path) -> list[Any]:
    """Connections of the topic to read."""
    fitting = [c for c in connections if c.msgtype in KINDS and c.msgcount]
    topics = list(dict.fromkeys(connection.topic for connection in fitting))
    listed = "; ".join(
        f"{c.topic} ({c.msgtype.rpartition('/')[2]}, {c.msgcount} messages)" for c in (fitting or connections)
    )
    if topic is not None and topic not in topics:
        raise TrajectoryError(
            f"the bag has no motion of joints on topic {topic}",
            where=Location(path),
            expected=", ".join(topics) or "a topic of JointState or JointTrajectory",
            found=listed or "no messages",
            next_step="give one of these with --topic" if topics else "check the recording",
        )
    if not topics:
        raise TrajectoryError(
            "the bag holds no motion of joints",
            where=Location(path),
            expected="messages of JointState, JointTrajectory, DynamicJointState or a controller's state",
            found=listed or "no messages",
            next_step="record /joint_states too",
        )
    if topic is None and len(topics) > 1:
        raise TrajectoryError(
            "several topics of the bag carry motions of joints",
            where=Location(path),
            expected="one topic",
            found=listed,
            next_step="choose: " + " or ".join(f"--topic {each}" for each in topics[:6]),
        )
    return [connection for connection in fitting if connection.topic == (topic or topics[0])]


def _gathered(reader: Any, chosen: list[Any], path: Path, progress: Progress) -> ArrayTable:
    gathering, done = Gathering(), 0
    total = sum(connection.msgcount for connection in chosen)
    plans: Counter[int] = Counter()
    for connection, received, raw in reader.messages(connections=chosen):
        kind = KINDS[connection.msgtype]
        rows = list(rows_of(reader.deserialize(raw, connection.msgtype), kind, received))
        for row in rows:
            gathering.add(row)
        if kind == TRAJECTORY:
            plans[len(rows)] += 1
        done += 1
        if not done % _TOLD_EVERY:
            progress(done, total)
    progress(done, done)
    require_one_plan(((TRAJECTORY, count) for count in plans.elements()), Location(path))
    commanded = bool(plans) or (
        all(KINDS[c.msgtype] == STATE for c in chosen) and says_target(words_of(chosen[0].topic))
    )
    return gathering.table(path, commanded or None, lambda: Location(path))
