"""Trajectory files: valid ones, what is done to them, and what must hold of one that is read."""

from __future__ import annotations

import csv
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from changes import Stage, text_format
from hostile_values import RAW, number, text

from gd_analyze import Trajectory, load_arm, read_trajectory, write_trajectory
from gd_analyze.arrays import FloatArray

ARM = load_arm("two_link")
# Digits, a point and an exponent in ASCII: whatever else Python's float takes is no number in a CSV file.
NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", re.ASCII)
HEADERS = ["time", "q0", "q3", "q1_deg", "q2_DEG", "QD1", "qd2_deg", "qdd1_deg", "t", "time_ms", "joint_1"]
LOGS = ["actual_q_0", "joint_pos_1", "shoulder velocity", "Timestamp [s]", "tau1", "wrist_3_joint", "acc_02"]

# A line of its own where the motion between the set points above and below is unknown.
GAP = "# gap"


@dataclass(frozen=True)
class Table:
    """Rows of cells, the header first, and how they are written; with a gap before a row, or without."""

    rows: list[list[str]]
    delimiter: str = ","
    comment: str = "# made for a test"
    gap: int = 0

    def place(self, random: Random) -> tuple[list[list[str]], int, int]:
        """A copy of the rows, and the place of a cell in it."""
        rows = [list(row) for row in self.rows]
        row = random.randrange(len(rows))
        return rows, row, random.randrange(len(rows[row]))

    @property
    def text(self) -> str:
        lines = [self.delimiter.join(row) for row in self.rows]
        if self.gap:
            lines.insert(self.gap, GAP)
        return "\n".join([self.comment, *lines]) + "\n"


def _base(columns: str, count: int) -> Table:
    """A swing of the two-link arm within its limits."""
    names = columns.split(",")
    time = np.linspace(0.0, 1.5, count)
    values = {"time": time}
    for joint, rate in ((1, 0.8), (2, 1.1)):
        values |= {
            f"q{joint}": 0.5 * np.sin(rate * time),
            f"qd{joint}": 0.5 * rate * np.cos(rate * time),
            f"qdd{joint}": -0.5 * rate**2 * np.sin(rate * time),
        }
    degrees = [np.degrees(values[n.removesuffix("_deg")]) if n.endswith("_deg") else values[n] for n in names]
    return Table([names, *([repr(float(x)) for x in row] for row in zip(*degrees, strict=True))])


BASES = [
    _base("time,q1,q2,qd1,qd2,qdd1,qdd2", 5),
    _base("time,q1,q2", 7),
    _base("time,q1_deg,q2_deg", 7),
    _base("q2,q1,qd2,qd1,time", 8),
    replace(_base("time,q1,q2", 14), gap=8),
]


def _cell(random: Random) -> str:
    x = number(random)
    kind = random.randrange(4)
    if kind == 0:
        return random.choice([text(random), random.choice(RAW)])
    return repr(x) if kind == 1 else f" {x:.3e}" if isinstance(x, float) else f"{x}.0"


def _other_cell(random: Random, table: Table) -> Table:
    rows, row, column = table.place(random)
    rows[row][column] = _cell(random)
    return replace(table, rows=rows)


def _other_column(random: Random, table: Table) -> Table:
    """A column of one value, or of another unit."""
    rows, _, column = table.place(random)
    scale, value = random.choice([None, 0.0, -1.0, 1e3, 1e-3, 57.29577951308232, 1e200]), _cell(random)
    for cells in rows[1:]:
        if column < len(cells):
            number = cells[column] if NUMBER.fullmatch(cells[column]) else "1"
            cells[column] = value if scale is None else repr(float(number) * scale)
    return replace(table, rows=rows)


def other_name(random: Random, table: Table, names: Sequence[str] = (*HEADERS, *LOGS)) -> Table:
    rows, _, column = table.place(random)
    rows[0][column % len(rows[0])] = random.choice([*names, text(random)])
    return replace(table, rows=rows)


def other_header(random: Random, table: Table, names: Sequence[str] = LOGS) -> Table:
    return replace(table, rows=[[random.choice(names) for _ in table.rows[0]], *table.rows[1:]])


def _columns(random: Random, table: Table) -> Table:
    """A column removed, said again, or moved; with its header, or without."""
    rows, _, column = table.place(random)
    kind = random.randrange(3)
    for cells in rows[random.randrange(2) :]:
        if column < len(cells) > 1:
            if kind == 0:
                del cells[column]
            else:
                cells.append(cells[column] if kind == 1 else cells.pop(column))
    return replace(table, rows=rows)


def _rows(random: Random, table: Table) -> Table:
    """A row removed, said again, moved to the end, broken off, or the rest cut off."""
    rows, row, column = table.place(random)
    kind = random.randrange(5)
    if kind == 1:
        rows.insert(row, list(rows[row]))
    elif kind == 2:
        rows.append(rows.pop(row))
    elif kind == 3:
        del rows[row][column + 1 :]
    elif len(rows) > 1:
        del rows[row : None if kind == 4 and row else row + 1]
    return replace(table, rows=rows)


def _delimiter(random: Random, table: Table) -> Table:
    return replace(table, delimiter=random.choice([";", "\t", ", ", " ", "|", ",,"]))


def _quotes(random: Random, table: Table) -> Table:
    return replace(table, rows=[[f'"{cell}"' for cell in row] for row in table.rows])


def _decimal_comma(random: Random, table: Table) -> Table:
    rows = [[cell.replace(".", ",") for cell in row] for row in table.rows]
    return replace(table, rows=rows, delimiter=random.choice([";", ","]))


TABLE_CHANGES = {
    "cell": _other_cell,
    "column": _other_column,
    "name": other_name,
    "log header": other_header,
    "columns": _columns,
    "rows": _rows,
    "delimiter": _delimiter,
    "quotes": _quotes,
    "decimal comma": _decimal_comma,
}
STAGES = (Stage(TABLE_CHANGES, lambda table: table.text, weight=2),)


def read(path: Path) -> tuple[Trajectory, str]:
    return read_trajectory(path, ARM), path.read_text(encoding="utf-8-sig", errors="replace")


def use(read: Any) -> None:
    """What is read is finite, what the file says, and the same when it is written and read again."""
    trajectory, text = read
    arrays = (trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd)
    assert all(np.isfinite(array).all() for array in arrays), "a number that is not finite"
    assert (np.diff(trajectory.time) > 0).all(), "time does not increase"
    if trajectory.recording is not None:
        return  # read as a log, which has other units, names and rows
    for name, stated in _stated(text).items():
        assert np.array_equal(stated, _held(trajectory, name)), f"another {name} than the file says"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "written.csv"
        write_trajectory(trajectory, path)
        written = path.read_text(encoding="utf-8").splitlines()[1:]
    lines = [line for line in written if line != GAP]
    assert len(written) - len(lines) == len(trajectory.gaps), "other gaps when written"
    rewritten = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    assert np.array_equal(rewritten, np.column_stack(arrays)), "another trajectory when written"


def _stated(text: str) -> dict[str, FloatArray]:
    """Columns of a file, read in the plainest way, in SI; an assertion fails where a cell is no number."""
    lines = [x for x in re.split("\r\n|\r|\n", text) if x.strip() and not x.lstrip().startswith("#")]
    delimiter = max(",;\t", key=lines[0].count)
    split = csv.reader(lines, delimiter=delimiter) if delimiter in lines[0] else map(str.split, lines)
    header, *rows = split
    if any("," in cell for row in rows for cell in row):
        return {}  # of decimal commas pandas may miss the last place
    for row in rows:
        for cell in row:
            assert NUMBER.fullmatch(cell.strip()), f"{cell[:40]!r} read as a number"
    columns = {}
    for name, column in zip(header, zip(*rows, strict=True), strict=True):
        values = np.array([float(cell) for cell in column])
        key, degrees, _ = name.strip().lower().partition("_deg")
        columns[key] = np.deg2rad(values) if degrees else values
    return columns


def _held(trajectory: Trajectory, name: str) -> FloatArray:
    if name == "time":
        return trajectory.time
    return np.asarray(getattr(trajectory, name[:-1])[:, int(name[-1]) - 1])


FORMAT = text_format(BASES, STAGES, read, use)
