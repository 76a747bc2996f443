"""Bags of ROS: rosbag2 (.db3, .mcap or a folder) and ROS 1 (.bag), by the optional library rosbags."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.messages import KINDS, STATE, Gathering
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.roles import TARGET, words_of
from gd_analyze.motions.table import ArrayTable, Progress, no_progress

_TOLD_EVERY = 1000


def read_bag(path: Path, topic: str | None = None, progress: Progress = no_progress) -> ArrayTable:
    """Read the messages of one topic; a .db3 or .mcap need not have its metadata.yaml beside it.

    TrajectoryError if the library is missing, the bag damaged, or no topic or several fit.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_library("rosbags", path) from None
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            return _gathered(reader, _connections(reader.connections, topic, path), path, progress)
    except TrajectoryError:
        raise
    # A damaged bag makes every part of the library fail in its own way: struct, sqlite, zstd, assertions.
    except Exception as error:
        raise refusal(
            "the bag cannot be read",
            Location(path),
            "a bag of ROS, with the definitions of its messages where they are none of ROS itself",
            str(error).split("\n", 1)[0] or type(error).__name__,
            "`ros2 bag info` or `rosbag info` tells whether it is whole",
        ) from None


def missing_library(library: str, path: str | Path) -> TrajectoryError:
    """Error of a log that needs a library which is not installed."""
    where, step = Location(path), f"pip install {library}"
    return refusal(f"this log needs the library {library}", where, library, "it is not installed", step)


def _connections(connections: Sequence[Any], topic: str | None, path: Path) -> list[Any]:
    """Connections of the topic to read."""
    fitting = [c for c in connections if c.msgtype in KINDS and c.msgcount]
    topics = list(dict.fromkeys(connection.topic for connection in fitting))
    found = "; ".join(
        f"{c.topic} ({c.msgtype.rpartition('/')[2]}, {c.msgcount} messages)" for c in (fitting or connections)
    )
    if topic is not None and topic not in topics:
        raise refusal(
            f"the bag has no motion of joints on topic {topic}",
            Location(path),
            ", ".join(topics) or "a topic of JointState or JointTrajectory",
            found or "no messages",
            "give one of these with --topic" if topics else "check the recording",
        )
    if not topics:
        raise refusal(
            "the bag holds no motion of joints",
            Location(path),
            "messages of JointState, JointTrajectory, DynamicJointState or a controller's state",
            found or "no messages",
            "record /joint_states too",
        )
    if topic is None and len(topics) > 1:
        choices = " or ".join(f"--topic {each}" for each in topics[:6])
        what = "several topics of the bag carry motions of joints"
        raise refusal(what, Location(path), "one topic", found, f"choose: {choices}")
    return [connection for connection in fitting if connection.topic == (topic or topics[0])]


def _gathered(reader: Any, chosen: list[Any], path: Path, progress: Progress) -> ArrayTable:
    gathering, done = Gathering(), 0
    total = sum(connection.msgcount for connection in chosen)
    for connection, received, raw in reader.messages(connections=chosen):
        message = reader.deserialize(raw, connection.msgtype)
        gathering.add(message, KINDS[connection.msgtype], received)
        done += 1
        if not done % _TOLD_EVERY:
            progress(done, total)
    progress(done, done)
    states = all(KINDS[c.msgtype] == STATE for c in chosen)
    return gathering.table(path, commanded=states and bool(set(words_of(chosen[0].topic)) & TARGET))
