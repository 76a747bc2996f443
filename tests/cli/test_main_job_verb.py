"""`gd-analyze ROBOT TRAJECTORY` and `report`: terminal, JSON and files agree, for one motion or several."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.cli.main_job import FORMATS, MADE_AGAIN
from gd_analyze.files import RESULT_FILES
from gd_analyze.motions.trajectory import write_trajectory
from gd_analyze.report.terminal import text_of
from gd_analyze.results.run_result import run_result
from several_motions import swung


def test_the_formats_are_those_of_the_library():
    assert tuple(RESULT_FILES) == FORMATS


def test_everything_is_written_and_agrees(run, here):
    result = run("puma560", "pick-and-place", "--json")
    assert (result.code, result.err) == (0, "")
    found = result.json
    folder = Path("reports/puma560-pick-and-place")
    assert {str(folder / name) for name in RESULT_FILES.values()} == set(found["files"])
    assert sorted(path.name for path in folder.iterdir()) == sorted(RESULT_FILES.values())
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF-")
    assert (folder / "report.html").read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html")

    model = json.loads((folder / "model.json").read_text(encoding="utf-8"))
    assert (found["level"], model["level"]) == ("term", "term")
    assert len(found["terms"]) == found["terms_total"] > len(model["terms"])
    assert len(found["equations"]) == 6
    parts = {*found["elements"]["kept"], *(row["part"] for row in found["elements"]["dropped"])}
    assert len(parts) == 60
    for row, around, stated in zip(found["beyond"], found["tube"]["joints"], found["joints"], strict=True):
        # The set points lie between their own extremes: what was sampled there is proven not to be exceeded.
        assert stated["largest_error"] <= row["certified"] * (1 + 1e-9)
        assert row["worst_found"] <= row["certified"]
        assert stated["largest_error"] <= around["tube_certified"] <= 1.1 * around["tube_worst_found"]
    assert (found["margin"], found["tube"]["coarse"]) == ("1deg,1mm,qd=2%,qdd=5%", 2)
    for row, stored in zip(found["joints"], model["errors"], strict=True):
        for name in ("largest_error", "rms_error", "allowed_error"):
            assert row[name] == stored[name]
    assert model["operations"].items() <= found["operations"].items()

    with (folder / "dominance.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, shown in zip(rows, found["dominance"], strict=True):
        assert (row["element"], row["verdict"]) == (shown["element"], shown["verdict"])
        assert float(row["torque_peak"]) == shown["torque_peak"]
        assert row["torque_unit"] == "N m"
    with h5py.File(folder / "analysis.h5") as file:
        assert file.attrs["command"].decode() == "gd-analyze puma560 pick-and-place --json"
        assert file["decomposition/inertia"].attrs["units"] == b"kg m^2"
        assert file["decomposition/inertia"].shape == (found["set_points"], 2, 6, 6)
        largest = np.abs(file["simplified_model/torque_error"][:]).max(axis=0)
    # The stored errors are those of the same two arrays, so they agree to the last bit or are round-off.
    np.testing.assert_allclose(largest, [row["largest_error"] for row in found["joints"]], atol=1e-9)


def test_the_terminal_shows_the_answer_within_80_columns(run, here):
    result = run("puma560", "pick-and-place", "--format", "csv")
    assert (result.code, result.err) == (0, "")
    lines = result.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert all(line == line.rstrip() for line in lines)
    assert "\x1b" not in result.out
    assert lines[-1] == "wrote reports/puma560-pick-and-place/dominance.csv"
    found = run("puma560", "pick-and-place", "--format", "csv", "--json").json
    assert found["headline"] in " ".join(result.out.split())
    assert f"{found['operations']['multiplications']} mult" in result.out
    assert "proven" in found["headline"]
    # Where D is not symmetric that is said, and what to use where it must be.
    assert any("--level energy" in notice for notice in found["notices"])


@pytest.mark.parametrize("formats", [("json",), ("h5", "json"), ("html",), ("pdf",)])
def test_only_the_chosen_files_are_written(run, motion, here, formats):
    result = run("two_link", motion, "--out", "x", "--quiet", "--format", ",".join(formats))
    assert (result.code, result.out, result.err) == (0, "", "")
    assert {path.name for path in (here / "x").iterdir()} == {RESULT_FILES[name] for name in formats}


def test_options_may_stand_anywhere(run, motion, here):
    assert run("--out", "a", "--format=json", "two_link", motion).code == 0
    assert run("two_link", "--out", "b", motion, "--format", "JSON").code == 0
    models = [json.loads((here / x / "model.json").read_text(encoding="utf-8")) for x in "ab"]
    assert models[0]["terms"] == models[1]["terms"]


def test_top_chooses_the_rows_of_the_ranking(run, motion):
    def rows(top: int) -> int:
        out = run("two_link", motion, "--format", "csv", "--top", top).out
        return sum(line.split()[0] in labels for line in out.splitlines() if line)

    labels = {"D11", "D12", "D22", "h1", "h2", "c1", "c2"}
    assert [rows(top) for top in (0, 3, 100)] == [0, 3, 7]


def test_what_is_stored_follows_the_options(run, motion):
    def stored(*options: str) -> set[str]:
        words = ("--format", "h5", "--out", "x", "--overwrite", "--quiet", *options)
        assert run("two_link", motion, *words).code == 0
        return set(gd.load_results("x/analysis.h5")["decomposition"].data_vars)

    assert "christoffel" in stored()
    assert "christoffel" not in stored("--no-christoffel")
    assert {"inertia_by_link", "coriolis_centrifugal_terms"} <= stored("--by-link", "--terms")


def test_drives_count_unless_the_links_alone_are_asked_for(run):
    def found(*options: str) -> tuple[float, bool]:
        words = ("puma560", "pick-and-place", "--level", "element", "--format", "json", "--json")
        document = run(*words, *options).json
        return document["joints"][0]["peak_torque"], document["drives"]

    with_drives, alone = found(), found("--no-drives")
    assert (with_drives[1], alone[1]) == (True, False)
    assert with_drives[0] > alone[0]


def test_a_budget_in_newton_metres_per_joint(run, motion):
    found = run("two_link", motion, "--format", "json", "--json", "--budget", "0.3,10%").json
    first, second = found["joints"]
    assert first["allowed_error"] == 0.3
    assert second["allowed_error"] == pytest.approx(0.1 * second["peak_torque"], rel=2**-52)
    assert all(row["largest_error"] <= row["allowed_error"] for row in found["joints"])


def test_a_plan_may_be_piped_into_the_main_job(process):
    planned = process("plan", "two_link", "--from", "0,0", "--to", "60,-45", "--duration", "2")
    result = process("two_link", "-", "--format", "json", "--json", stdin=planned.out)
    assert result.code == 0, result.err
    assert result.json["trajectory"] == "stdin"


def test_an_arm_of_ones_own_with_a_prismatic_joint(run, here):
    (here / "slider.toml").write_text(
        'format = "gd-analyze arm 1"\nname = "slider"\n'
        '[[joints]]\nkind = "prismatic"\n[[joints]]\na = 0.5\n'
        "[[links]]\nmass = 1.0\ncom = [0.0, 0.0, 0.0]\ninertia = { xx = 1.0, yy = 1.0, zz = 1.0 }\n"
        "[[links]]\nmass = 1.0\ncom = [-0.2, 0.1, 0.0]\ninertia = { xx = 0.1, yy = 0.1, zz = 0.1 }\n"
    )
    rows = "".join(f"{0.2 * k},{0.01 * k * k},{0.02 * k * k}\n" for k in range(9))
    (here / "lift.csv").write_text("time,q1,q2\n" + rows)
    result = run("slider.toml", "lift.csv", "--format", "csv", "--json")
    assert result.code == 0, result.err
    assert [row["effort_unit"] for row in result.json["joints"]] == ["N", "N m"]
    shown = run("slider.toml", "lift.csv", "--format", "csv").out
    assert " N m" in shown


def test_reports_are_made_again_byte_by_byte(run, here):
    """From the stored analysis alone: same reports, same model, same ranking, same answer."""
    found = run("two_link", "two-link-swing", "--out", "first", "--json").json
    result = run("report", "first/analysis.h5", "--out", "second", "--json")
    assert (result.code, result.err) == (0, "")
    for name in MADE_AGAIN:
        first, second = ((here / folder / RESULT_FILES[name]).read_bytes() for folder in ("first", "second"))
        assert first == second, name
    again = result.json
    assert again.pop("files") == [str(Path("second") / RESULT_FILES[name]) for name in MADE_AGAIN]
    found.pop("files")
    assert again == found


def test_reports_go_beside_the_analysis_and_replace_what_is_there(run, motion, here):
    before = run("two_link", motion, "--out", "x", "--format", "h5,html").out
    page = (here / "x" / "report.html").read_bytes()
    (here / "x" / "report.html").write_text("old")
    result = run("report", "x/analysis.h5", "--format", "html")
    assert result.code == 0
    assert (here / "x" / "report.html").read_bytes() == page
    assert {path.name for path in (here / "x").iterdir()} == {"analysis.h5", "report.html"}
    assert result.out.splitlines()[:-1] == before.splitlines()[:-2]


@pytest.mark.parametrize(
    ("name", "content"), [("none.h5", None), ("model.json", b"{}"), ("c.h5", b"\x89HDF\r\n\x1a\n")]
)
def test_no_report_of_another_file(run, here, name, content):
    if content is not None:
        (here / name).write_bytes(content)
    result = run("report", name)
    assert (result.code, result.out) == (2, "")
    assert name in result.err
    assert not [path for path in here.iterdir() if path.suffix in (".html", ".pdf")]


def test_measured_torques_and_friction(measured_findings):
    result = run_result(measured_findings)
    text, found = text_of(result), result.document()["measured_torque"]
    assert max(map(len, text.splitlines())) <= 80
    assert [row["verdict"] for row in found["joints"]][1] == "too light"
    assert found["joints"][1]["slope_beside_friction"] == pytest.approx(2.0, rel=0.05)
    assert "too light by a factor 2" in text
    assert "Friction and offset" in text
    assert not found["described"]


@pytest.fixture
def folder(here):
    place = here / "moves"
    place.mkdir()
    for name, duration in (("slow", 20.0), ("quick", 4.0)):
        write_trajectory(swung(duration, name), place / f"{name}.csv")
    return place


def test_several_motions(run, here, folder):
    words = (
        "two_link",
        folder / "slow.csv",
        folder / "quick.csv",
        "two-link-swing",
        "--format",
        "h5,json,csv",
    )
    result = run(*words)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    place = here / "reports" / "two_link-slow+quick+two-link-swing"
    model = json.loads((place / "model.json").read_text())
    assert [motion["name"] for motion in model["motions"]] == ["slow", "quick", "two-link-swing"]
    again = run("report", place / "analysis.h5", "--out", "again", "--format", "json,csv")
    assert again.out.splitlines()[:-2] == result.out.splitlines()[:-3]


def test_a_folder_of_motions_as_json(run, folder):
    found = run("two_link", "moves", "--format", "csv", "--json").json
    assert found["trajectory"] == "moves"
    each, verdicts = found["motions"]["each"], found["motions"]["verdicts"]
    assert [(row["motion"], row["set_points"]) for row in each] == [("quick", 41), ("slow", 41)]
    for row in each:
        assert row["used"][row["joint"] - 1] == row["worst"] <= 1.0
    assert [row["element"] for row in verdicts] == [row["element"] for row in found["dominance"]]
    assert all(len(row["verdicts"]) == 2 for row in verdicts)
    for verb, *more in (("simplify",), ("rank",), ("trade-off", "--quick")):
        assert run(verb, "two_link", "moves", *more).code == 0


def test_a_model_of_several_motions_is_judged_by_the_one_it_is_tried_on(run, folder):
    assert run("simplify", "two_link", "moves", "--budget", "20%", "-o", "model.json").code == 0
    found = run("evaluate", "model.json", "moves/slow.csv", "--json").json
    assert found["fitted_on"]["motions"] == "quick, slow"
    assert all(row["within_allowed"] for row in found["joints"])
    assert run("certify", "model.json", "--along", "moves/slow.csv", "--json").code == 0


@pytest.mark.parametrize(
    ("name", "content"), [("b.csv", "time,q1\n0,1\n"), ("b.csv", ""), ("b.txt", "what these are\n")]
)
def test_a_file_that_is_no_trajectory_is_named(run, folder, name, content):
    (folder / name).write_text(content)
    result = run("two_link", "moves")
    assert (result.code, result.out) == (2, "")
    assert f"moves/{name}" in result.err


def test_folders_that_cannot_be_used(run, here, folder):
    (here / "empty").mkdir()
    result = run("two_link", "empty")
    assert (result.code, result.out) == (2, "")
    assert "empty" in result.err
    before = (folder / "slow.csv").read_bytes()
    assert run("simplify", "two_link", "moves", "-o", "moves/slow.csv").code == 2
    assert (folder / "slow.csv").read_bytes() == before
    assert run("two_link", "moves", "--out", "x", "--format", "csv").code == 0
    other = run("two_link", "moves/slow.csv", "moves/quick.csv", "--out", "x", "--format", "csv")
    assert other.code == 2
    assert "the folder x" in other.err
