"""Messages of ROS that carry an arm's motion, as a table: a column per quantity of each joint."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import Location
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import ArrayTable

# Fields of points and states, and what the columns made of them are called.
_FIELDS = {
    **{word: word for word in ("position", "velocity", "effort")},
    **{"positions": "position", "velocities": "velocity", "accelerations": "acceleration"},
}
STATE, TRAJECTORY, CONTROLLER, DYNAMIC = "JointState", "JointTrajectory", "controller state", "dynamic state"
_SIDES = ("actual", "feedback", "desired", "reference", "command", "output")
KINDS = {
    "sensor_msgs/msg/JointState": STATE,
    "trajectory_msgs/msg/JointTrajectory": TRAJECTORY,
    "control_msgs/msg/JointTrajectoryControllerState": CONTROLLER,
    "control_msgs/msg/DynamicJointState": DYNAMIC,
}
# Stamp and time of reception, ns, and values of joints by name of column.
_Row = tuple[int, int, Mapping[str, float]]


def _field(message: Any, name: str) -> Any:
    """A field of a message, which is a mapping in YAML and an object in a bag; None where it is not there."""
    return message.get(name) if isinstance(message, Mapping) else getattr(message, name, None)


def kind_of(message: Any) -> str | None:
    """Kind of a message by its fields."""
    named = _field(message, "joint_names") is not None
    if _field(message, "points") is not None and named:
        return TRAJECTORY
    if _field(message, "interface_values") is not None:
        return DYNAMIC
    if _field(message, "name") is not None and _field(message, "position") is not None:
        return STATE
    return CONTROLLER if named and any(_field(message, side) is not None for side in _SIDES) else None


def _rows_of(message: Any, kind: str, received: int) -> Iterator[_Row]:
    stamp = nanoseconds(_field(_field(message, "header"), "stamp"))
    names = _field(message, "name" if kind == STATE else "joint_names")
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise ValueError("names of joints that are no list of words")
    if kind == TRAJECTORY:
        for point in _field(message, "points"):
            begin = nanoseconds(_field(point, "time_from_start"))
            yield stamp + begin, received + begin, dict(_values(point, names, ""))
    elif kind == STATE:
        yield stamp, received, dict(_values(message, names, ""))
    elif kind == DYNAMIC:
        found: dict[str, float] = {}
        for name, of in zip(names, _field(message, "interface_values"), strict=True):
            for interface, value in zip(_field(of, "interface_names"), _field(of, "values"), strict=True):
                found[f"{name}/{interface}"] = float(value)
        yield stamp, received, found
    else:
        sides = [(side, point) for side in _SIDES if (point := _field(message, side)) is not None]
        yield (
            stamp,
            received,
            {key: x for side, point in sides for key, x in _values(point, names, f"{side}/")},
        )


def nanoseconds(stamp: Any) -> int:
    """Instant of a stamp or a duration, ns; 0 where there is none, ValueError where it is no stamp."""
    if stamp is None:
        return 0
    whole = []
    for names in (("sec", "secs"), ("nanosec", "nsecs")):
        value = next((x for name in names if (x := _field(stamp, name)) is not None), None)
        if not isinstance(value, int | np.integer) or abs(int(value)) >= 2**40:
            raise ValueError("a stamp without sec and nanosec")
        whole.append(int(value))
    return whole[0] * 1_000_000_000 + whole[1]


def _values(point: Any, names: Sequence[str], before: str) -> Iterator[tuple[str, float]]:
    for key, shown in _FIELDS.items():
        values = _field(point, key)
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
    """Rows of messages gathered into columns; nan of joints that a row does not have."""

    def __init__(self) -> None:
        self._columns: dict[str, list[float]] = {}
        self._stamps: list[int] = []
        self._received: list[int] = []
        self._plans: list[int] = []

    def add(self, message: Any, kind: str, received: int = 0) -> None:
        """Append the rows of a message; ValueError if it contradicts itself, or something is no number."""
        rows = list(_rows_of(message, kind, received))
        if kind == TRAJECTORY:
            self._plans.append(len(rows))
        for stamp, known, values in rows:
            count = len(self._stamps)
            self._stamps.append(stamp)
            self._received.append(known)
            for key, value in values.items():
                column = self._columns.setdefault(key, [])
                column.extend([np.nan] * (count - len(column)))
                column.append(value)

    def table(self, path: str | Path, *, commanded: bool = False) -> ArrayTable:
        """All rows; TrajectoryError if there are none, or several trajectories of several points."""
        count = len(self._stamps)
        if not count or not self._columns:
            expected = "messages with names and positions of joints"
            found = f"{count} messages without numbers" if count else "no message"
            raise refusal("the log holds no motion", Location(path), expected, found, "check the recording")
        several = [points for points in self._plans if points > 1]
        if len(several) > 1:
            raise refusal(
                f"the log holds {len(several)} trajectories",
                Location(path),
                "one JointTrajectory, or points that follow each other",
                f"trajectories of {', '.join(map(str, several[:6]))} points",
                "write each to a file of its own",
            )
        columns = [np.array(column + [np.nan] * (count - len(column))) for column in self._columns.values()]
        times = (np.array(self._stamps, dtype=np.int64), np.array(self._received, dtype=np.int64))
        names = ("header/stamp_ns", "received/time_ns", *self._columns)
        return ArrayTable(path, names, (*times, *columns), commanded or bool(self._plans) or None)
