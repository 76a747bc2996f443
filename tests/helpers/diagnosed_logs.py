"""Logs written for `gd-analyze diagnose`, and what it says of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
from click.testing import CliRunner

from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.cli.app import app
from recordings import readings

Arrays = tuple[FloatArray, FloatArray, FloatArray]


def log_of(time: FloatArray, q: FloatArray, torque: FloatArray) -> Trajectory:
    """Readings as a motion."""
    return Trajectory.from_log(readings(time, q, torque=torque))


def written(
    folder: Path, time: FloatArray, q: FloatArray, torque: FloatArray, qd: FloatArray | None = None
) -> str:
    """The path of a CSV file of readings whose columns state no units."""
    path, joints = folder / "log.csv", range(1, q.shape[1] + 1)
    arrays = {"q": q, "qd": qd, "torque": torque}
    columns = {name: values for name, values in arrays.items() if values is not None}
    head = ",".join(["time", *(f"{name}{i}" for name in columns for i in joints)])
    np.savetxt(path, np.column_stack([time, *columns.values()]), delimiter=",", header=head, comments="")
    return str(path)


def said(*words: str, arm: str = "two_link") -> dict:
    """What the verb says, from its JSON."""
    done = CliRunner().invoke(app, ["diagnose", arm, *words, "--measured", "--json", "--quiet"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def late(time: FloatArray, torque: FloatArray, lag: float) -> FloatArray:
    """Torques that lag."""
    return np.column_stack([np.interp(time - lag, time, column) for column in torque.T])


def told_numbers(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard errors that a sentence states."""
    pairs = re.findall(r"([\d.]+) ± ([\d.]+)", text)
    values, errors = np.array(pairs, dtype=float).T
    return values, errors
