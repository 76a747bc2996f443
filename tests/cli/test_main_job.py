"""`gd-analyze ROBOT TRAJECTORY` and `report`: terminal, JSON and files agree, for one motion or several."""

from __future__ import annotations

import csv
import json
import re
import shlex
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import write_trajectory
from gd_analyze.cli.main_job import MADE_AGAIN, RUN_FORMATS
from gd_analyze.files import RESULT_FILES
from gd_analyze.report.document import result_document
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import JSON, main_report, main_result
from gd_analyze.report.pdf import pdf_of
from gd_analyze.report.terminal import text_of
from gd_analyze.simplification.accuracy import STATED
from gd_analyze.types import Drive
from long_cases import long
from recordings import recorded, swung, with_torques


def test_the_formats_are_those_of_the_library():
    assert tuple(RESULT_FILES) == RUN_FORMATS


def test_everything_is_written_and_agrees(run, here):
    result = run("puma560 pick-and-place --level term --json")
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
    for name, stored in (("largest_error", "largest"), ("rms_error", "rms")):
        assert [row[name] for row in found["joints"]] == model["accuracy"]["errors"][stored]
    assert [row["allowed_error"] for row in found["joints"]] == model["accuracy"]["allowed"]
    assert gd.load_model(folder / "model.json").operations.total == found["operations"]["total"]

    with (folder / "dominance.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, shown in zip(rows, found["dominance"], strict=True):
        assert (row["element"], row["verdict"]) == (shown["element"], shown["verdict"])
        assert float(row["torque_peak"]) == shown["torque_peak"]
        assert row["torque_unit"] == "N m"
    with h5py.File(folder / "analysis.h5") as file:
        assert file.attrs["command"].decode() == "gd-analyze puma560 pick-and-place --level term --json"
        assert file["decomposition/inertia"].attrs["units"] == b"kg m^2"
        assert file["decomposition/inertia"].shape == (found["set_points"], 2, 6, 6)
        largest = np.abs(file["simplified_model/torque_error"][:]).max(axis=0)
    # The stored errors are those of the same two arrays, so they agree to the last bit or are round-off.
    np.testing.assert_allclose(largest, [row["largest_error"] for row in found["joints"]], atol=1e-9)
    assert [row["budget"] for row in found["stops"]] == ["1%", "1% or 10% friction", "1% or 0.5% limit"]
    assert found["stops"][0]["terms"] == len(model["terms"])
    assert 0.0 < found["gamma"] < 1.0

    lines = run(f"report {folder}/analysis.h5 --format csv").out.splitlines()
    assert all(line == line.rstrip() and len(line) <= 80 for line in lines)
    assert lines[-1] == f"wrote {folder}: dominance.csv"
    assert found["headline"] in as_proven(" ".join(" ".join(lines).split()))
    assert "proven" in found["headline"]


@pytest.mark.parametrize("level", [long(""), " --level element"], ids=["usual", "element"])
def test_the_answer_fits_one_screen(run, here, level):
    """53 rows: headline, verdicts and the text's, equations, budgets, errors and files."""
    result = run(f"puma560 pick-and-place{level} --format h5,json,csv")
    lines = result.out.splitlines()
    assert len(lines) <= 53
    assert max(map(len, lines)) <= 80
    _, _, files = result.words.partition("wrote ")
    folder = f"reports/puma560-pick-and-place{level.replace(' --', '-').replace(' ', '-')}"
    assert files.split() == [f"{folder}:", "analysis.h5,", "model.json,", "dominance.csv"]
    found = run(f"report {folder}/analysis.h5 --format csv --json").json
    listed = found["verdicts"]
    by_verdict = {row["element"]: row["verdict"] for row in found["dominance"]}
    for name in ("translation", "rotation", "both", "drive", "negligible", "zero"):
        same = [
            label
            for label, verdict in by_verdict.items()
            if verdict == name and label not in listed["gravity"]
        ]
        assert listed[name] == same
    assert listed["negligible_dominance"]["D24"] == "translation"
    assert [row["joint"] for row in listed["drives"]] == [4, 5, 6]


@pytest.mark.parametrize("formats", [("json",), ("h5", "json"), ("html",), ("pdf",)])
def test_only_the_chosen_files_are_written(run, motion, here, formats):
    result = run(f"--out x --quiet two_link --format {','.join(formats).upper()}", motion)
    assert (result.code, result.out, result.err) == (0, "", "")
    assert {path.name for path in (here / "x").iterdir()} == {RESULT_FILES[name] for name in formats}


def test_top_chooses_the_rows_of_the_ranking(run, motion):
    labels = {"D11", "D12", "D22", "h1", "h2", "c1", "c2"}
    for top, count in ((0, 0), (3, 3), (100, 7)):
        lines = run(f"two_link gentle.csv --format csv --top {top}").out.splitlines()
        # An equation begins with an element, too.
        assert sum(line.split()[0] in labels for line in lines if line and " = " not in line) == count


def test_what_is_stored_follows_the_options(run, motion):
    def stored(options: str) -> set[str]:
        assert run(f"two_link gentle.csv --format h5 --out x --overwrite {options}").code == 0
        return set(gd.tables.load_results("x/analysis.h5")["decomposition"].data_vars)

    optional = {"christoffel", "inertia_by_link", "coriolis_centrifugal_terms"}
    assert optional & stored("") == {"christoffel"}
    assert optional & stored("--no-christoffel --by-link --terms") == optional - {"christoffel"}


def test_drives_payloads_and_budgets_per_joint(run, motion):
    driven = replace(gd.load_arm("two_link"), drives=(Drive(0.2), Drive(0.1)))
    gd.save_arm(driven, "driven.toml")
    words = "driven.toml gentle.csv --level element --format json --json"
    with_drives, alone = run(words).json, run(f"{words} --no-drives --out alone").json
    assert (with_drives["drives"], alone["drives"]) == (True, False)
    assert with_drives["joints"][0]["peak_torque"] > alone["joints"][0]["peak_torque"]
    words = "two_link gentle.csv --format json --json --budget 0.3,10%"
    bare, full = run(f"{words} --out a").json, run(f"{words} --out b --payload 1,0,0,0").json
    first, second = bare["joints"]
    assert first["allowed_error"] == 0.3
    assert second["allowed_error"] == pytest.approx(0.1 * second["peak_torque"], rel=2**-52)
    assert full["arm"] == "two_link+1kg"
    # At rest the second rod's weight acts at half its length, the payload's at its end.
    assert full["joints"][1]["peak_torque"] > 1.5 * second["peak_torque"]
    assert gd.load_model("b/model.json").arm.mass[-1] == gd.load_arm("two_link").mass[-1] + 1


def test_an_arm_of_ones_own_with_a_prismatic_joint(run, here):
    (here / "slider.toml").write_text(
        'format = "gd-analyze arm 1"\nname = "slider"\n'
        '[[joints]]\nkind = "prismatic"\n[[joints]]\na = 0.5\n'
        "[[links]]\nmass = 1.0\ncom = [0.0, 0.0, 0.0]\ninertia = { xx = 1.0, yy = 1.0, zz = 1.0 }\n"
        "[[links]]\nmass = 1.0\ncom = [-0.2, 0.1, 0.0]\ninertia = { xx = 0.1, yy = 0.1, zz = 0.1 }\n"
    )
    rows = "".join(f"{0.2 * k},{0.01 * k * k},{0.02 * k * k}\n" for k in range(9))
    (here / "lift.csv").write_text("time,q1,q2\n" + rows)
    result = run("slider.toml lift.csv --format csv --json")
    assert result.code == 0, result.err
    assert [row["effort_unit"] for row in result.json["joints"]] == ["N", "N m"]
    shown = run("slider.toml lift.csv --format csv").out
    assert " N m" in shown
    simplified = run("simplify slider.toml lift.csv").out
    assert all(word in simplified for word in ("revolute", "prismatic"))
    assert max(map(len, shown.splitlines())) <= 80


def as_proven(text: str) -> str:
    """What a verb says of the bounds of a file, as it is said of those that were just proven."""
    text = re.sub(r"Bounds are stated in the file;[^.]*\.json --check`? ?\w* proves? them again\.", "", text)
    return text.replace(STATED, "proven")


def test_reports_are_made_again(run, here):
    """From the stored analysis alone: same model, same ranking, same answer, of which bounds are stated."""
    found = run("two_link two-link-swing --budget 60% --out first --json").json
    result = run("report first/analysis.h5 --out second --json")
    assert (result.code, result.err) == (0, "")
    for name in MADE_AGAIN:
        first, second = ((here / folder / RESULT_FILES[name]).read_bytes() for folder in ("first", "second"))
        assert (first == second) == (name not in ("html", "pdf")), name
    page = (here / "second" / "report.html").read_text(encoding="utf-8")
    assert STATED in page
    assert "proven)" not in page
    again = result.json
    assert again.pop("files") == [str(Path("second") / RESULT_FILES[name]) for name in MADE_AGAIN]
    found.pop("files")
    assert STATED in again["notices"].pop(0)
    assert (found["headline"], STATED in again["headline"]) == (as_proven(again["headline"]), True)
    assert found == again | {"headline": found["headline"]}


def test_measured_torques_and_friction(measured_findings):
    text = text_of(result_document(main_result(measured_findings)))
    values = main_result(measured_findings, JSON).values()
    found = values["measured_torque"]
    assert max(map(len, text.splitlines())) <= 80
    assert found["verdict"] == "does not agree"
    assert values["headline"].startswith("The file ")
    assert found["agreement"].startswith(values["headline"].split(".")[0])
    assert found["diagnosis"]["cause"] is not None
    assert found["diagnosis"]["remedy"] in found["agreement"]
    assert "`gd-analyze diagnose ROBOT LOG`" in found["agreement"]


def test_the_next_command_mends_what_the_log_contradicts(run, here):
    """Typed as printed, with the options that were typed before: the file then describes the robot."""
    log = recorded(gd.load_arm("two_link"), gain=-1.0, noise=0.05)
    table = np.column_stack([log.time, log.q, log.recording.torque])
    np.savetxt("my log.csv", table, delimiter=",", header="t,q1,q2,tau1,tau2", comments="", fmt="%.10g")
    contradicted = run("two_link", "my log.csv", "--level", "element", "--out", "one")
    *_, last = contradicted.out.splitlines()
    assert (
        last
        == "next: gd-analyze two_link 'my log.csv' --level element --out one --overwrite --torque-sign -1"
    )
    mended = run("", *shlex.split(last.removeprefix("next: gd-analyze ")))
    assert mended.code == 0, mended.err
    assert "The file describes this robot" in " ".join(mended.out.split())
    *_, last = mended.out.splitlines()
    assert last == "next: gd-analyze export one/model.json --to c"


def test_of_a_file_that_the_log_contradicts_no_model_is_searched_unless_asked_for(two_link, swing):
    torque = gd.decompose(two_link, swing).torque.values
    log = with_torques(swing, -torque)
    with pytest.warns(gd.GdAnalyzeWarning, match="all torques are reversed"):
        found, asked = gd.analyze(two_link, log), gd.analyze(two_link, log, budget="20%")
    assert found.is_contradicted
    assert found.model.is_exact
    headline = main_result(found, JSON).values()["headline"]
    assert headline.startswith("The file does not fit this log: all torques are reversed. No simplified ")
    assert "`--budget 1%` searches one" in headline
    assert not asked.is_contradicted
    assert asked.model.saves
    page = page_of(main_report(found))
    assert "No simplified model, as the log contradicts the file" in page
    assert pdf_of(main_report(found)).startswith(b"%PDF-")


@pytest.fixture
def folder(here):
    place = here / "moves"
    place.mkdir()
    for name, duration in (("slow", 20.0), ("quick", 4.0)):
        write_trajectory(swung(duration, name), place / f"{name}.csv")
    return place


def test_several_motions(run, here, folder):
    result = run("two_link moves/slow.csv moves/quick.csv two-link-swing --format h5,json,csv")
    assert result.words
    place = here / "reports" / "two_link-slow+quick+two-link-swing"
    model = json.loads((place / "model.json").read_text())
    assert [motion["name"] for motion in model["accuracy"]["motions"]] == ["slow", "quick", "two-link-swing"]
    again = run(f"report {place}/analysis.h5 --out again --format json,csv")
    first, second = (text.out.partition("wrote ")[0].replace("not proven", "") for text in (result, again))
    second = " ".join(second.split())
    assert ("proven" in first, "proven" in second, STATED in second) == (True, False, True)


def test_a_folder_of_motions_as_json(run, folder):
    found = run("two_link moves --format csv --json").json
    assert found["trajectory"] == "moves"
    each, verdicts = found["motions"]["each"], found["motions"]["verdicts"]
    assert [(row["motion"], row["set_points"]) for row in each] == [("quick", 41), ("slow", 41)]
    for row in each:
        assert row["used"][row["joint"] - 1] == row["worst"] <= 1.0
    assert [row["element"] for row in verdicts] == [row["element"] for row in found["dominance"]]
    assert all(len(row["verdicts"]) == 2 for row in verdicts)
    for verb in ("simplify", "rank-terms", "trade-off --quick"):
        assert run(f"{verb} two_link moves").code == 0


def test_a_folder_that_is_written_into(run, folder):
    before = (folder / "slow.csv").read_bytes()
    assert run("simplify two_link moves -o moves/slow.csv").code == 2
    assert (folder / "slow.csv").read_bytes() == before
    assert run("two_link moves --out x --format csv").code == 0
    other = run("two_link moves/slow.csv moves/quick.csv --out x --format csv")
    assert (other.code, "folder x" in other.err, "--overwrite" in other.err) == (2, True, True)
