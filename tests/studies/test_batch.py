"""Batches: the same table from one process, from two and from a cluster; restarts, kills, and what fails."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import gd_analyze as gd
from gd_analyze import batch
from gd_analyze.errors import OutputError, UsageError
from gd_analyze.figures.batch import batch_figure
from gd_analyze.result import value_text
from gd_analyze.studies import batch as module
from gd_analyze.studies import batch_rows, many
from gd_analyze.studies.batch import RECORD
from gd_analyze.studies.batch_table import batch_result
from gd_analyze.text import percent
from killed_batches import killed
from told import Told

ROWS = [
    {"arm": "two_link", "trajectory": "two-link-swing", "budget": f"{k}%", "at_set_points": "yes"}
    for k in (1, 20, 30)
]
BAD = {"arm": "two_link", "trajectory": "nowhere.csv"}


def test_the_table_holds_what_the_main_job_finds(two_link, swing, tmp_path):
    table = batch([*ROWS, BAD], tmp_path, to=("csv", "parquet"))
    assert table.state.tolist() == ["done"] * 3 + ["failed"]
    assert "nowhere.csv" in table.error[3]
    alone = gd.analyze(two_link, swing, budget="20%", at_set_points=True)
    row = table.iloc[1]
    assert row.model_operations == alone.model.operations.total
    assert row.exact_operations == alone.model.operations_full.total
    assert [row.peak_torque_1, row.peak_torque_2] == alone.model.accuracy.errors.peak_torque.tolist()
    verdicts = dict(zip(alone.dominance.element.values, alone.dominance.verdict.values, strict=True))
    assert {label: row[label] for label in verdicts} == verdicts
    model = gd.load_model(tmp_path / row.files / "model.json")
    states = swing.q, swing.qd, swing.qdd
    np.testing.assert_allclose(model.torque(*states), alone.model.torque(*states), rtol=1e-12)
    stored = pd.read_csv(tmp_path / "batch.csv", keep_default_na=False)
    assert stored.D11.tolist() == table.D11.fillna("").tolist()
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "batch.parquet"), table)


def test_errors_say_what_they_are_of(tmp_path):
    """Shares of peak torque and of a budget, and torques, stand in one column, each with its reference."""
    budgets = ("20%", "0.3 N m", "20% or 0.3 N m")
    table = batch([{**ROWS[0], "budget": budget} for budget in budgets], tmp_path)
    assert table.sampled_error_of.tolist() == ["peak torque", "N m", "the budget"]
    stored = batch_result(table).values()["table"]
    assert [row["sampled_error_of"] for row in stored] == ["peak torque", "N m", "the budget"]
    (sampled,) = (c for c in batch_result(table).parts[0].columns if c.label == "sampled")
    share, torque, of_budget = table.sampled_error
    assert sampled.values == [
        percent(share),
        value_text(torque, "N m"),
        f"{percent(of_budget)} of budget",
    ]
    model = gd.load_model(tmp_path / table.files[1] / "model.json")
    assert torque == model.accuracy.errors.largest.max()


def test_processes_give_the_same_table_in_any_order(tmp_path):
    rows = [*ROWS[:2], BAD]
    alone = batch(rows, tmp_path / "a")
    pd.testing.assert_frame_equal(batch(rows, tmp_path / "b", jobs=2), alone)
    backwards = batch(rows[::-1], tmp_path / "c")
    same = backwards[::-1].reset_index(drop=True).assign(row=alone.row)
    pd.testing.assert_frame_equal(same, alone)


def test_it_goes_on_where_it_stopped(tmp_path, monkeypatch):
    class Stopping(Told):
        def advance(self, steps: int = 1) -> None:
            super().advance(steps)
            if sum(self.steps[-1]) == 2:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch([*ROWS, BAD], tmp_path, progress=Stopping())
    assert not (tmp_path / "batch.csv").exists()
    record = tmp_path / RECORD
    assert len(record.read_text().splitlines()) == 2
    with record.open("a") as file:
        file.write('{"key": "cut sho')
    analysed, done = module.analysed, []
    monkeypatch.setattr(module, "analysed", lambda task: done.append(task) or analysed(task))
    table = batch([*ROWS, BAD], tmp_path)
    assert [task.row for task in done] == [ROWS[2], BAD]
    assert table.equals(batch([*ROWS, BAD], tmp_path / "whole"))
    # What failed is done again, as it may be mended; nothing else is, and rows may be added and left out.
    done.clear()
    (tmp_path / "nowhere.csv").write_text(
        "time,q1,q2\n" + "".join(f"{k / 4},{k * k / 50},0\n" for k in range(9))
    )
    monkeypatch.chdir(tmp_path)
    more = {"arm": "two_link", "trajectory": "two-link-swing", "budget": "40%", "at_set_points": "yes"}
    table = batch([BAD, more, ROWS[0], ROWS[0]], tmp_path)
    assert [task.row for task in done] == [BAD, more]
    assert table.state.tolist() == ["done"] * 4
    keys = [json.loads(line)["key"] for line in record.read_text().splitlines()]
    assert len(keys) == len(set(keys)) == 6


@pytest.fixture
def done(monkeypatch) -> list[module.BatchTask]:
    """Tasks that were done, as they are done."""
    analysed, tasks = module.analysed, list[module.BatchTask]()
    monkeypatch.setattr(module, "analysed", lambda task: tasks.append(task) or analysed(task))
    return tasks


@pytest.mark.parametrize("spoil", ["empty", "edit", "delete", "record"])
def test_a_row_whose_files_or_record_changed_is_done_again(tmp_path, done, spoil):
    table = batch(ROWS[:2], tmp_path)
    path, record = tmp_path / table.files[1] / "model.json", tmp_path / RECORD
    content = path.read_text()
    if spoil == "delete":
        path.unlink()
    elif spoil == "record":
        first, second = record.read_text().splitlines()
        count = int(table.model_operations[1])
        second = second.replace(f'"model_operations": {count}', f'"model_operations": {count + 1}')
        record.write_text(f"{first}\n{second}\n")
    else:
        path.write_text("" if spoil == "empty" else content.replace("two_link", "two_lint"))
    done.clear()
    pd.testing.assert_frame_equal(batch(ROWS[:2], tmp_path), table)
    assert [task.row for task in done] == [ROWS[1]]
    assert gd.load_model(path).operations.total == table.model_operations[1]
    done.clear()
    pd.testing.assert_frame_equal(batch(ROWS[:2], tmp_path), table)
    assert done == []


DESIGNS = [
    {"arm": "two_link", "trajectory": "two-link-swing", "at_set_points": True, "link2.mass": mass}
    for mass in (0.5, "1500 g", 2)
]


def test_numbers_of_the_arm_vary_by_row(two_link, swing, tmp_path, done):
    table = batch(DESIGNS, tmp_path, formats=(), to=("csv", "svg"))
    assert table.state.tolist() == ["done"] * 3
    assert table["link2.mass"].tolist() == [0.5, 1.5, 2.0]
    link = two_link.links[1]
    for row in table.itertuples():
        changed = replace(link, mass=(0.5, 1.5, 2.0)[row.Index])
        arm = replace(two_link, links=(two_link.links[0], changed))
        dataset = gd.decompose(arm, swing)
        peak = np.abs(dataset.torque.values).max(axis=0)
        np.testing.assert_allclose([row.peak_torque_1, row.peak_torque_2], peak, rtol=1e-12)
        ranking = gd.rank(dataset)
        verdicts = dict(zip(ranking.element.values.tolist(), ranking.verdict.values.tolist(), strict=True))
        assert {label: getattr(row, label) for label in verdicts} == verdicts
        first = {label: table[label][0] for label in verdicts}
        changes = [f"{label} {word}" for label, word in verdicts.items() if word != first[label]]
        assert sorted(row.changed_verdicts.split(", ")) == sorted(changes or [""])
    assert any(table.changed_verdicts)
    assert table.joint_kinds.tolist() == ["RR"] * 3
    assert set(table.budget_kept) <= {"proven", "at set points"}
    stored = pd.read_csv(tmp_path / "batch.csv")
    assert stored["link2.mass"].tolist() == [0.5, 1.5, 2.0]
    assert (tmp_path / "batch.svg").read_text().startswith("<svg")
    # Other numbers are other rows, and the same are known again.
    done.clear()
    other = DESIGNS[0] | {"link2.mass": 0.6}
    again = batch([*DESIGNS[:2], other], tmp_path, formats=())
    assert [task.row for task in done] == [other]
    assert again[:2].peak_torque_1.tolist() == table[:2].peak_torque_1.tolist()


def test_a_number_that_an_arm_cannot_have_fails_its_row(tmp_path):
    wrong = [{"link9.mass": 1}, {"link2.mass": "heavy"}, {"link2.mass": -1}, {"drive1.inertia": 1}]
    table = batch(
        [{"arm": "two_link", "trajectory": "two-link-swing"} | number for number in wrong], tmp_path
    )
    assert table.state.tolist() == ["failed"] * 4
    for error, number in zip(table.error, wrong, strict=True):
        assert error.startswith(next(iter(number)))
    with pytest.raises(UsageError, match=r"rows, row 1: there is no option 'link2.mas'"):
        batch([DESIGNS[0] | {"link2.mas": 1}], tmp_path)


def test_combinations_of_numbers_and_a_payload(tmp_path):
    (tmp_path / "a.yaml").write_text(
        'arm: two_link\ntrajectory: two-link-swing\nat_set_points: true\npayload: "1,0,0,0"\n'
        "link2.mass: [0.5, 500 g]\njoint1.a_mm: [1000, 500]\n"
    )
    table = batch(tmp_path / "a.yaml", tmp_path / "out", formats=())
    assert table["link2.mass"].tolist() == [0.5] * 4
    assert table["joint1.a_mm"].tolist() == [1000, 500] * 2
    assert table.peak_torque_1[:2].tolist() == table.peak_torque_1[2:].tolist()
    arm = gd.load_arm("two_link")
    arm = replace(arm, links=(arm.links[0], replace(arm.links[1], mass=0.5)))
    arm = gd.tables.with_payload(arm, 1.0, [0.0, 0.0, 0.0])
    swing = gd.read_trajectory("two-link-swing", arm)
    peak = np.abs(gd.decompose(arm, swing).torque.values).max(axis=0)
    np.testing.assert_allclose(table.peak_torque_1[0], peak[0], rtol=1e-12)


def test_the_figure_shows_the_finished_rows_over_the_number_or_the_row():
    table = pd.DataFrame({
        "row": [1, 2, 3, 4], "state": ["done", "failed", "done", "done"], "budget": ["1%"] * 4,
        "link2.mass": [2.0, 3.0, 1.0, None],
        "joints": [2, None, 2, 1], "joint_kinds": ["RP", None, "RR", "R"],
        "peak_torque_1": [20.0, None, 10.0, 5.0], "peak_torque_2": [2.0, None, 1.0, None],
        "model_operations": [20, None, 22, 5], "exact_operations": [30, None, 32, 6],
    })  # fmt: skip
    first, second, operations = batch_figure(table, "link2.mass").panels
    assert [panel.y.unit for panel in (first, second)] == ["N m", "N or N m"]
    assert first.x.unit == "kg"
    (curve,) = first.items
    assert (curve.x.tolist(), curve.y.tolist()) == ([1.0, 2.0], [10.0, 20.0])
    assert [curve.y.tolist() for curve in operations.items] == [[32.0, 30.0], [22.0, 20.0]]
    by_row = batch_figure(table, "row").panels[0]
    assert by_row.items[0].x.tolist() == [1.0, 3.0, 4.0]
    assert not by_row.items[0].width
    assert all(place == round(place) for place in by_row.x.ticks)
    assert len(batch_figure(table[1:2], "row").panels) == 1


def test_one_run_writes_in_a_folder_at_a_time(tmp_path, done):
    """The lock ends with the run that holds it, also where that is killed."""
    words = (
        "import sys, time\nfrom pathlib import Path\nfrom gd_analyze.files import appending_alone\n"
        "with appending_alone(Path(sys.argv[1])):\n    print('locked', flush=True)\n    time.sleep(60)"
    )
    command = [sys.executable, "-c", words, str(tmp_path / RECORD)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"locked\n"
        with pytest.raises(OutputError, match="another run"):
            batch(ROWS[:1], tmp_path, formats=())
        other.kill()
    assert done == []
    assert batch(ROWS[:1], tmp_path, formats=()).state.tolist() == ["done"]


def test_too_many_combinations_are_refused_before_they_are_made(tmp_path, monkeypatch):
    numbers = ", ".join(f"{k}%" for k in range(1, 252))
    path = tmp_path / "a.yaml"
    path.write_text("".join(f"{key}: [{numbers}]\n" for key in ("arm", "trajectory", "budget")))
    tracemalloc.start()
    try:
        with pytest.raises(UsageError, match="15813251"):
            batch_rows.rows_in(path)
        # The lists take some 50 kB; a row takes more than 200 bytes.
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
    monkeypatch.setattr(batch_rows, "MOST_ROWS", 2)
    (tmp_path / "a.csv").write_text("arm,trajectory\n" + "two_link,x.csv\n" * 3)
    with pytest.raises(UsageError, match="too many rows"):
        batch_rows.rows_in(tmp_path / "a.csv")


def test_no_cell_is_a_formula(tmp_path):
    names = ['=HYPERLINK("x")', "@SUM(A1)", "+1+1", "-2+3", "plain"]
    rows = [{"arm": name, "trajectory": "two-link-swing", "gravity": "-1"} for name in names]
    table = batch(rows, tmp_path, to=("csv", "parquet"))
    stored = pd.read_csv(tmp_path / "batch.csv", dtype=str)
    assert stored.arm.tolist() == [*(f"'{name}" for name in names[:-1]), "plain"]
    assert not stored.stack().str.startswith(("=", "@", "+")).any()
    # A number is none, and Parquet is not for spreadsheets.
    assert stored.gravity.tolist() == ["-1"] * len(names)
    assert pd.read_parquet(tmp_path / "batch.parquet").arm.tolist() == names == table.arm.tolist()


def test_combinations_tables_and_folders_state_the_same_rows(tmp_path, two_link):
    expected = [
        {"arm": "two_link", "trajectory": motion, "budget": budget}
        for motion in ("two-link-swing", "x.csv")
        for budget in ("1%", "2%")
    ]
    texts = {
        "a.yaml": "arm: two_link\ntrajectory: [two-link-swing, x.csv]\nbudget: [1%, 2%]\n",
        "a.toml": 'arm = "two_link"\ntrajectory = ["two-link-swing", "x.csv"]\nbudget = ["1%", "2%"]\n',
        "b.yaml": "budget: [1%, 2%]\nrows:\n"
        + "".join(f"- {{arm: two_link, trajectory: {x}}}\n" for x in ("two-link-swing", "x.csv")),
        "a.csv": "\ufeffarm,trajectory,budget,level\n"
        + "".join(f"{row['arm']},{row['trajectory']},{row['budget']},\n" for row in expected),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
        assert batch_rows.rows_in(tmp_path / name) == expected, name
    logs = tmp_path / "logs"
    for robot in ("mine", "two_link"):
        (logs / robot).mkdir(parents=True)
        for log in ("a.csv", "b.csv"):
            (logs / robot / log).write_text("time,q1,q2\n")
    gd.save_arm(two_link, logs / "mine" / "arm.toml")
    arms = {"mine": "mine/arm.toml", "two_link": "two_link"}
    assert batch_rows.rows_in(logs) == [
        {"arm": arm, "trajectory": f"{robot}/{log}"}
        for robot, arm in arms.items()
        for log in ("a.csv", "b.csv")
    ]


def test_options_of_text_are_read_as_the_settings_take_them():
    row = {"drives": "No", "dominance": "5%", "budget": 0.2, "at_set_points": True, "arm": "x"}
    read = {"drives": False, "dominance": 0.05, "budget": "0.2", "at_set_points": True}
    assert batch_rows.settings_of(row) == read
    picked = {"lock": "a=1,b=90deg", "limits": "all=10", "tip": "hand", "gravity": "0,0,-1.6"}
    read = {"lock": ["a=1", "b=90deg"], "limits": ["all=10"], "tip": "hand", "gravity": "0,0,-1.6"}
    assert batch_rows.picked_of(picked | {"arm": "x"}) == read
    for key in ("drives", "dominance"):
        with pytest.raises(UsageError, match=key):
            batch_rows.settings_of({key: "perhaps"})
    for cell in ("10mm", "5deg"):
        with pytest.raises(UsageError, match="dominance"):
            batch_rows.settings_of({"dominance": cell})


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("rows.csv", "arm,trajektory\ntwo_link,x.csv\n", "trajectory"),
        ("rows.csv", "arm,trajectory\n", "no rows"),
        ("rows.csv", "arm,budget\ntwo_link,1%\n", "has no trajectory"),
        ("rows.yaml", "- a\n- b\n", "rows"),
        ("rows.toml", "rows = 3\n", "rows"),
        ("none.csv", None, "none.csv"),
        ("rows.csv", "arm,trajectory,limits\ntwo_link,x.csv,joint_limits.yaml\n", "give the values"),
        ("logs/robot/log.csv", "time,q1\n", "robot"),
    ],
)
def test_a_table_that_is_none_is_refused(tmp_path, name, text, says):
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    if text is not None:
        path.write_text(text)
    with pytest.raises(gd.GdAnalyzeError) as caught:
        batch(tmp_path / name.split("/")[0], tmp_path / "out")
    assert says in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_formats_and_records_that_are_none(tmp_path):
    for more in ({"formats": ("exe",)}, {"to": ("zarr",)}):
        with pytest.raises(UsageError, match=r"exe|zarr"):
            batch(ROWS, tmp_path / "out", **more)
    (tmp_path / RECORD).write_text("no json\n")
    with pytest.raises(OutputError, match=RECORD):
        batch(ROWS, tmp_path)


@pytest.mark.parametrize("name", ["budget", "link2.mass"])
def test_a_column_that_stands_twice_is_refused(tmp_path, name):
    table = tmp_path / "rows.csv"
    table.write_text(f"arm,trajectory,{name}, {name},,\ntwo_link,two-link-swing,1,2,,\n")
    with pytest.raises(UsageError, match=f"2 columns {name}") as caught:
        batch(table, tmp_path / "out")
    assert "rows.csv, header" in caught.value.details["where"]


def test_small_inputs_travel_and_others_are_refused_where_they_differ(tmp_path, monkeypatch, two_link):
    gd.save_arm(two_link, tmp_path / "arm.toml")
    log = tmp_path / "log.csv"
    log.write_text("time,q1,q2\n" + "".join(f"{k / 4},{k * k / 50},0\n" for k in range(9)))
    row = {"arm": "arm.toml", "trajectory": "log.csv", "at_set_points": True}

    def task() -> module.BatchTask:
        return module.BatchTask(row, *batch_rows.row_inputs(row, tmp_path), ())

    travels = task()
    # The log is smaller, the arm is not.
    monkeypatch.setattr(batch_rows, "MOST_TRAVELLING_BYTES", 300)
    by_path = task()
    assert by_path.arm.content is None
    assert by_path.trajectory.content == log.read_bytes()
    assert travels.key == by_path.key
    assert module.analysed(by_path)[1] == module.analysed(travels)[1]
    text = (tmp_path / "arm.toml").read_text()
    (tmp_path / "arm.toml").write_text(text.replace("mass = 2.0", "mass = 2.1") + "\n")
    _, found, _ = module.analysed(by_path)
    assert found["state"] == "failed"
    assert "differs" in found["error"]
    assert "arm.toml" in found["error"]
    assert module.analysed(travels)[1]["state"] == "done"
    log.unlink()
    assert module.analysed(travels)[1]["state"] == "done"
    assert str(tmp_path) not in json.dumps(module.analysed(travels)[1])


def test_a_fault_of_ours_is_the_row_s(monkeypatch):
    monkeypatch.setattr(module, "find", lambda *words, **more: 1 / 0)
    _, found, _ = module.analysed(module.BatchTask(ROWS[0], *batch_rows.row_inputs(ROWS[0], Path()), ()))
    assert found["state"] == "failed"
    assert found["error"].startswith("ZeroDivisionError")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is a matter of POSIX")
def test_kills_lose_nothing_and_do_no_row_twice(tmp_path):
    told = killed(tmp_path, kills=2, rows=4, seed=1987)
    assert (told.kills, told.wrong) == (2, [])


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # a worker that dies is told by warnings of the engine
def test_a_cluster_that_loses_a_worker_gives_the_table_of_one_process(tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the extra `distributed`")
    rows = [ROWS[0] | {"budget": f"{k}%"} for k in range(1, 13)]
    alone, lost = batch(rows, tmp_path / "alone"), []
    settings = {"n_workers": 2, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": ":0"}
    with distributed.LocalCluster(**settings) as cluster, distributed.Client(cluster) as client:
        workers = client.run(os.getpid)

        class Killing(gd.types.Progress):
            def advance(self, steps: int = 1) -> None:
                if not lost:
                    lost.append(next(iter(workers.values())))
                    os.kill(lost[0], signal.SIGKILL)

        shared = batch(rows, tmp_path / "shared", scheduler=cluster.scheduler_address, progress=Killing())
        assert lost[0] not in client.run(os.getpid).values()
    pd.testing.assert_frame_equal(shared, alone)


def test_a_scheduler_that_is_not_there(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="needs the extra `distributed`")
    monkeypatch.setattr(many, "ANSWER_SECONDS", 0.5)
    with pytest.raises(UsageError, match="no Dask scheduler"):
        batch(ROWS, tmp_path, scheduler="tcp://127.0.0.1:1")
