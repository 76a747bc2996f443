"""`gd-analyze batch`: what it prints, its exit codes, and what it refuses."""

from __future__ import annotations

import pandas as pd


def test_a_table_with_a_row_that_fails(run, here, motion):
    (here / "rows.csv").write_text(
        "arm,trajectory,at_set_points\ntwo_link,gentle.csv,yes\ntwo_link,none.csv,yes\n"
    )
    shown = run("batch rows.csv --format none --to csv,parquet")
    assert (shown.code, shown.err) == (1, "")
    assert "1 of 2 rows done" in shown.out
    assert "none.csv" in shown.out
    assert max(map(len, shown.out.splitlines())) <= 80
    assert {path.name for path in (here / "batch").iterdir()} == {"batch.csv", "batch.parquet", "rows.jsonl"}
    assert pd.read_csv(here / "batch" / "batch.csv").state.tolist() == ["done", "failed"]
    (here / "none.csv").write_bytes(motion.read_bytes())
    (here / "rows.csv").write_text((here / "rows.csv").read_text().replace(",", ";"))
    json = run("batch rows.csv --json").json
    assert (json["rows"], json["done"], json["failed"]) == (2, 2, 0)
    assert [row["trajectory"] for row in json["table"]] == ["gentle.csv", "none.csv"]
    folders = pd.read_csv(here / "batch" / "batch.csv").files
    assert all((here / "batch" / name / "model.json").is_file() for name in folders)


def test_varied_numbers_are_printed_and_drawn(run, here, motion):
    (here / "rows.csv").write_text(
        "arm,trajectory,at_set_points,link2.mass\n"
        "two_link,gentle.csv,yes,0.5\ntwo_link,gentle.csv,yes,4000 g\n"
    )
    shown = run("batch rows.csv --format none --to csv,svg")
    assert shown.code == 0
    assert "link2.mass" in shown.out
    assert max(map(len, shown.out.splitlines())) <= 80
    assert {path.name for path in (here / "batch").iterdir()} == {"batch.csv", "batch.svg", "rows.jsonl"}
    table = pd.read_csv(here / "batch" / "batch.csv")
    json = run("batch rows.csv --format none --json").json
    assert [row["link2.mass"] for row in json["varied"]] == [0.5, 4.0]
    assert [row["peak_torque_2"] for row in json["varied"]] == table.peak_torque_2.tolist()


def test_bad_batches_write_nothing(run, here, motion, listing):
    (here / "rows.csv").write_text("arm,trajectory\ntwo_link,gentle.csv\n")
    (here / "wrong.csv").write_text("arm,trajektory\ntwo_link,gentle.csv\n")
    (here / "number.csv").write_text("arm,trajectory,link2.mas\ntwo_link,gentle.csv,1\n")
    (here / "long.csv").write_text("arm,trajectory\ntwo_link,gentle.csv,1%\n")
    (here / "wrong.yaml").write_text("arm: [two_link\n")
    before = listing()
    for line, says in {
        "batch wrong.csv": "'trajectory'",
        "batch number.csv": "number.csv, row 1",
        "batch wrong.yaml": "wrong.yaml, line 2",
        "batch long.csv": "long.csv, row 1",
        "batch nowhere.csv": "nowhere.csv",
        "batch gentle.csv": "'time'",
        "batch rows.csv --format exe": "exe",
        "batch rows.csv --to zarr": "zarr",
        "batch rows.csv --jobs 0": "--jobs",
        "batch rows.csv --out rows.csv": "rows.csv",
    }.items():
        result = run(line)
        assert (result.code, result.out) == (2, ""), line
        assert says in result.err, result.err
        assert "Traceback" not in result.err
    assert listing() == before
