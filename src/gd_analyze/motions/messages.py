"""Messages of ROS that carry an arm's motion, as a table: a column per quantity of each joint."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.table import ArrayTable

# Fields of points and states, and how the columns made of them are called.
_FIELDS = {word: word for word in ("position", "velocity", "effort")} | {
    "positions": "position",
    "velocities": "velocity",
    "accelerations": "acceleration",
}
STATE, TRAJECTORY, CONTROLLER, DYNAMIC = "JointState", "JointTrajectory", "controller state", "dynamic state"
_SIDES = ("actual", "feedback", "desired", "reference", "command", "output")
KINDS = {
    "sensor_msgs/msg/JointState": STATE,
    "trajectory_msgs/msg/JointTrajectory": TRAJECTORY,
    "control_msgs/msg/JointTrajectoryControllerState": CONTROLLER,
    "control_msgs/msg/DynamicJointState": DYNAMIC,
}


@dataclass(frozen=True)
class Row:
    """What is known at one instant, ns: values of joints by name of column."""

    stamp: int
    received: int
    values: Mapping[str, float]


def field(message: Any, name: str) -> Any:
    """A field of a message, which is a mapping in YAML and an object in a bag; None where it is not there."""
    return message.get(name) if isinstance(message, Mapping) else getattr(message, name, None)


def kind_of(message: Any) -> str | None:
    """Kind of a message by its fields."""
    if field(message, "points") is not None and field(message, "joint_names") is not None:
        return TRAJECTORY
    if field(message, "interface_values") is not None:
        return DYNAMIC
    if field(message, "name") is not None and field(message, "position") is not None:
        return STATE
    if field(message, "joint_names") is not None and any(field(message, side) is not None for side in _SIDES):
        return CONTROLLER
    return None


def rows_of(message: Any, kind: str, received: int = 0) -> Iterator[Row]:
    """What a message says, in rows.

    Raises
    ------
    ValueError
        If it contradicts itself, or something in it is no number.
    """
    stamp = nanoseconds(field(field(message, "header"), "stamp"))
    if kind == TRAJECTORY:
        names = _names(field(message, "joint_names"))
        for point in field(message, "points"):
            begin = nanoseconds(field(point, "time_from_start"))
            yield Row(stamp + begin, received + begin, dict(_values(point, names, "")))
    elif kind == STATE:
        yield Row(stamp, received, dict(_values(message, _names(field(message, "name")), "")))
    elif kind == DYNAMIC:
        found: dict[str, float] = {}
        for name, of in zip(
            _names(field(message, "joint_names")), field(message, "interface_values"), strict=True
        ):
            for interface, value in zip(field(of, "interface_names"), field(of, "values"), strict=True):
                found[f"{name}/{interface}"] = float(value)
        yield Row(stamp, received, found)
    else:
        names = _names(field(message, "joint_names"))
        sides = [(side, field(message, side)) for side in _SIDES]
        yield Row(
            stamp,
            received,
            {
                key: x
                for side, point in sides
                if point is not None
                for key, x in _values(point, names, f"{side}/")
            },
        )


def nanoseconds(stamp: Any) -> int:
    """Instant of a stamp or a duration, ns; 0 where there is none.

    Raises
    ------
    ValueError
        If it is no stamp.
    """
    if stamp is None:
        return 0
    seconds = next((x for x in (field(stamp, "sec"), field(stamp, "secs")) if x is not None), None)
    nano = next((x for x in (field(stamp, "nanosec"), field(stamp, "nsecs")) if x is not None), None)
    whole = [int(x) for x in (seconds, nano) if isinstance(x, int | np.integer) and abs(int(x)) < 2**40]
    if len(whole) < 2:
        raise ValueError("a stamp without sec and nanosec")
    return whole[0] * 1_000_000_000 + whole[1]


def _names(names: Any) -> list[str]:
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise ValueError("names of joints that are no list of words")
    return list(names)


def _values(point: Any, names: Sequence[str], before: str) -> Iterator[tuple[str, float]]:
    for key, shown in _FIELDS.items():
        values = field(point, key)
        if values is None or len(values) == 0:
            continue
        if isinstance(values, str) or any(isinstance(x, str) and "..." in x for x in values):
            raise ValueError("numbers cut short by ...: echo with --full-length")
        if len(values) != len(names):
            raise ValueError(f"{len(values)} of {key} for {len(names)} joints")
        for name, value in zip(names, values, strict=True):
            if isinstance(value, bool) or not isinstance(value, int | float | np.number):
                raise ValueError(f"a {key} that is no number")
            yield f"{before}{name}/{shown}", float(value)


class Gathering:
    """Rows gathered into columns; of joints that a row does not tell, nan."""

    def __init__(self) -> None:
        self._columns: dict[str, list[float]] = {}
        self._stamps: list[int] = []
        self._received: list[int] = []

    def add(self, row: Row) -> None:
        """Append a row."""
        count = len(self._stamps)
        columns = self._columns
        self._stamps.append(row.stamp)
        self._received.append(row.received)
        for key, value in row.values.items():
            column = columns.setdefault(key, [])
            if len(column) < count:
                column.extend([np.nan] * (count - len(column)))
            column.append(value)

    def table(self, path: str | Path, planned: bool | None, where: Callable[[], Location]) -> ArrayTable:
        """All of it.

        Raises
        ------
        TrajectoryError
            If there is nothing.
        """
        count = len(self._stamps)
        if not count or not self._columns:
            raise TrajectoryError(
                "the log holds no motion",
                where=where(),
                expected="messages with names and positions of joints",
                found=f"{count} messages without numbers" if count else "no message",
                next_step="check the recording",
            )
        columns = []
        for column in self._columns.values():
            column.extend([np.nan] * (count - len(column)))
            columns.append(np.array(column))
        names = ("header/stamp", "received/time", *self._columns)
        times = (np.array(self._stamps, dtype=np.int64), np.array(self._received, dtype=np.int64))
        return ArrayTable(
            path, tuple(f"{n}_ns" if k < 2 else n for k, n in enumerate(names)), (*times, *columns), planned
        )


def require_one_plan(kinds: Iterable[tuple[str, int]], where: Location) -> None:
    """Refuse several trajectories of several points; kinds and numbers of rows of the messages."""
    plans = [count for kind, count in kinds if kind == TRAJECTORY and count > 1]
    if len(plans) > 1:
        raise TrajectoryError(
            f"the log holds {len(plans)} trajectories",
            where=where,
            expected="one JointTrajectory, or points that follow each other",
            found=f"trajectories of {', '.join(map(str, plans[:6]))} points",
            next_step="write each to a file of its own",
        )
