"""Corrupt rows: all are named, left out if so wanted, and sound logs have none."""

from __future__ import annotations

import time

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from log_arms import arm_of

ARM = arm_of("hip", "knee")
TIME = 0.01 * np.arange(400) + 1.0
Q = np.column_stack([np.sin(TIME), 0.5 * np.cos(3.0 * TIME)])


def text(changed=(), time=TIME, q=Q):
    cells = [[repr(t), *map(repr, row)] for t, row in zip(time.tolist(), q.tolist(), strict=True)]
    for row, column, cell in changed:
        cells[row][column] = cell
    return "time,pos1,pos2\n" + "".join(",".join(row) + "\n" for row in cells)


CHANGES = [
    *((40, 1, "7" * 290), (90, 0, "0"), (140, 0, "253"), (141, 0, "253.5"), (200, 2, "x"), (260, 1, "55.5")),
    (399, 0, "0"),
]
LINES = "lines 42, 92, 142, 143, 202, 262, 401"


def test_all_are_named_and_left_out(read, refused, warned):
    refused(LINES, text(CHANGES), ARM)
    with warned() as texts:
        logged = read(text(CHANGES), ARM, drop_rows=True)
    (warning,) = texts
    assert "7 corrupt" in warning
    assert warning.endswith(LINES)
    sound = np.delete(np.arange(400), [row for row, _, _ in CHANGES])
    np.testing.assert_array_equal(logged.q, Q[sound])
    # Differences of instants of up to 5 s.
    np.testing.assert_allclose(logged.time, TIME[sound] - 1.0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("change", CHANGES)
def test_each_alone(change, refused):
    refused(f"line {change[0] + 2}", text([change]), ARM)


def test_rows_of_a_plan_are_dropped_as_well(read, refused, warned):
    plan = text([(3, 1, "x"), (9, 2, "1e99")]).replace("pos", "q")
    refused("lines 5, 11", plan, ARM)
    with warned():
        assert len(read(plan, ARM, drop_rows=True).time) == 398


def test_what_sound_logs_have_is_not_corrupt(read, warned):
    """Late rows, restarts of the clock, gaps, repeated rows, wrapped angles and noise."""
    late, restart, gap = np.insert(np.delete(TIME, 50), 70, TIME[50]), TIME.copy(), TIME.copy()
    restart[200:] -= TIME[200]
    gap[200:] += 3.0
    with warned() as texts:
        for time in (late, restart, gap):
            assert len(read(text(time=time), ARM).time) == 400
        turned = text([(k, 1, repr(float(Q[k, 0] + 2 * np.pi))) for k in (60, 61, 80)])
        assert len(read(turned, ARM).time) == 400
    assert not texts


@pytest.mark.parametrize(("jump", "is_corrupt"), [(0.25, False), (0.35, True)])
def test_a_reading_jumps_where_it_would_be_faster_than_any_arm(jump, is_corrupt, read, refused):
    """30 rad/s, 0.3 rad in 10 ms, in a motion so slow that thirty of its steps are a tenth of that."""
    slow = 0.1 * Q
    content = text([(60, 1, repr(float(slow[60, 0] + jump)))], q=slow)
    if is_corrupt:
        refused("line 62", content, ARM)
    else:
        np.testing.assert_array_equal(read(content, ARM).q[60, 0], slow[60, 0] + jump)


@pytest.mark.parametrize("cell", ["inf", "-Infinity", "1e999", "1e13", "#NUM!", "1.#INF"])
@pytest.mark.parametrize("names", ["time,pos1,pos2", "time,q1,q2"])
@pytest.mark.parametrize("column", [1, 2])
def test_a_column_of_no_number_is_named_at_once(cell, names, column, refused):
    content = text([(row, column, cell) for row in range(400)]).replace("time,pos1,pos2", names)
    name = names.split(",")[column]
    refused(f"line 2, column {column + 1}: {name} is", content, ARM)
    torques = content.replace(names, f"time,{'hip,tau1' if column == 2 else 'tau1,hip'}")
    if not cell.startswith(("#", "1.#")):  # else text, of a column that is not needed
        refused(f"line 2, column {column + 1}: tau1 is", torques, arm_of("hip"))


def test_a_table_of_very_many_columns_is_refused_in_about_a_second(read):
    """A second on an ordinary machine; five to ten where names are compared in pairs."""
    count = 32_000
    header = ",".join(["time", *(f"q{k}" for k in range(1, count))])
    content = f"{header}\n{','.join(['0.1'] * count)}\n"
    began = time.process_time()
    with pytest.raises(TrajectoryError) as caught:
        read(content, ARM)
    assert time.process_time() - began < 3.5
    assert "line 1, column 4" in caught.value.details["where"]


def test_another_format_is_no_corrupt_row(read):
    with pytest.raises(TrajectoryError) as caught:
        read("time,pos1,pos2\n" + "0,1,2\n" + "0.1,x,2\n" * 1500, ARM)
    assert "drop_rows" not in caught.value.details["next"]
