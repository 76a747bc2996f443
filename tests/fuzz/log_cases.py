"""Logs of robots in text files: valid ones, what is done to them, and what must hold of one that is read."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from random import Random
from typing import Any

import numpy as np
from changes import Stage, text_format
from csv_cases import TABLE_CHANGES, Table, other_header, other_name

from gd_analyze import load_arm, read_log

ARM = load_arm("two_link")  # its joints are called shoulder and elbow
NAMES = [
    "actual_q_0", "target_q_1", "q0", "q_2", "joint_1", "theta_2", "shoulder", "elbow_vel", "tau1", "%time",
    "__time", "sec", "nanosec", "header/stamp/sec", "time_ms", "Position1 [deg]", "state.q_d[1]", "sample",
    "field.name0", "points[1].positions[0]", "torque_2 (Nm)", "shoulder/position", "Temp1", "qd1 [rpm]",
]  # fmt: skip


def _log(names: str, stamps: list[Any], delimiter: str = ",", header: bool = True) -> Table:
    columns = names.split(",")
    rows = [
        [str(stamp), *(f"{0.3 * np.sin(0.2 * k + j):.6f}" for j in range(1, len(columns)))]
        for k, stamp in enumerate(stamps)
    ]
    return Table([columns, *rows] if header else rows, delimiter)


STEPS = [0.008 * k for k in range(9)]
EPOCH = [1_700_000_000_000_000_000 + 8_000_000 * k for k in range(9)]
BASES = [
    _log("timestamp,actual_q_0,actual_q_1,actual_qd_0,actual_qd_1,target_q_0,target_q_1", STEPS),
    _log("Time [ms],shoulder [deg],elbow [deg],mode", list(range(0, 90, 10)), ";"),
    _log("header.stamp,q_0,q_1,tau_0,tau_1,sm_torque_0,sm_torque_1", EPOCH),
    _log("__time,/joint_states/elbow/position,/joint_states/shoulder/position", STEPS, "\t"),
    _log("t,theta_1,theta_2,comment", STEPS, " "),
    Table([f"7,{8_000_000 * k},,elbow,shoulder,0.{k},0.5,,1,2".split(",") for k in range(9)]),
]


def _empty_cells(random: Random, table: Table) -> Table:
    rows = [list(row) for row in table.rows]
    for row in rows[1:]:
        for column in range(len(row)):
            if random.random() < 0.2:
                row[column] = random.choice(["", "nan", "NA"])
    return replace(table, rows=rows)


CHANGES = {
    **TABLE_CHANGES,
    "another name": partial(other_name, names=NAMES),
    "other names": partial(other_header, names=NAMES),
    "empty cells": _empty_cells,
}
STAGES = (Stage(CHANGES, lambda table: table.text, weight=2),)


def use(logged: Any) -> None:
    """Time is known and begins at 0; the rest has the arm's joints, is possible, and stands in the table."""
    count = len(logged.time)
    assert count > 0, "no rows"
    assert np.isfinite(logged.time).all(), "an instant that is not finite"
    assert logged.time[0] == 0.0, "time does not begin at 0"
    for name in ("q", "qd", "qdd", "torque"):
        array = getattr(logged, name)
        if array is None:
            assert name != "q", "no positions"
            continue
        assert array.shape == (count, 2), f"{name} of another shape"
        assert not np.isinf(array).any(), f"{name} is infinite"
        of = [use.joint for use in logged.columns if use.role == name]
        assert sorted(of) == ["elbow", "shoulder"], f"{name} of {of}"


FORMAT = text_format(BASES, STAGES, lambda path: read_log(path, ARM), use)
