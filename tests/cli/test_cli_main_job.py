from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.cli.analyze import FORMATS
from gd_analyze.cli.report import FORMATS as MADE_AGAIN
from gd_analyze.studies.main_job_files import FILES


def test_the_formats_are_those_of_the_library():
    assert tuple(FILES) == FORMATS
    assert set(MADE_AGAIN) == set(FORMATS) - {"h5"}


def test_everything_is_written_and_said_alike(run, here):
    result = run("puma560", "pick-and-place", "--json")
    assert result.code == 0
    assert result.err == ""
    told = result.json
    folder = Path("reports/puma560-pick-and-place")
    assert {str(folder / name) for name in FILES.values()} == set(told["files"])
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES.values())
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF-")
    assert (folder / "report.html").read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html")

    model = json.loads((folder / "model.json").read_text(encoding="utf-8"))
    assert (told["level"], model["level"]) == ("term", "term")
    assert len(told["terms"]) == told["terms_total"] > len(model["terms"])
    assert len(told["equations"]) == 6
    parts = {*told["elements"]["kept"], *(row["part"] for row in told["elements"]["dropped"])}
    assert len(parts) == 60
    for row, promised in zip(told["beyond"], told["joints"], strict=True):
        # The set points lie between their own extremes: what was sampled there is proven not to be exceeded.
        assert promised["largest_error"] <= row["certified"] * (1 + 1e-9)
        assert row["worst_found"] <= row["certified"]
        # The flange alone does not feel a point mass on its axis.
        assert row["mass_within_budget"] is None or row["mass_within_budget"] >= 0
    tube = told["tube"]
    assert (tube["margin"], tube["coarse"]) == ("1deg,1mm,qd=2%,qdd=5%", 2)
    assert "too far apart" in tube["note"]
    for row, promised in zip(tube["joints"], told["joints"], strict=True):
        assert promised["largest_error"] <= row["tube_certified"]
        assert row["tube_certified"] <= 1.1 * row["tube_worst_found"]
    asked = [point for point in told["trade_off"] if point["budget"] == "1%"]
    assert {(point["level"], point["refit"]) for point in asked} == {
        ("element", False), ("term", False), ("term", True), ("energy", False), ("energy", True),
    }  # fmt: skip
    for row, stored in zip(told["joints"], model["errors"], strict=True):
        assert row["joint_name"] == stored["joint"]
        for name in ("largest_error", "rms_error", "allowed_error"):
            assert row[name] == stored[name]
    assert told["operations"] == model["operations"]
    assert told["search"] == model["search"]

    with (folder / "dominance.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["element"] for row in rows] == [row["element"] for row in told["dominance"]]
    for row, shown in zip(rows, told["dominance"], strict=True):
        assert row["verdict"] == shown["verdict"]
        assert float(row["torque_peak"]) == shown["torque_peak"]

    with h5py.File(folder / "analysis.h5") as file:
        assert file.attrs["command"].decode() == "gd-analyze puma560 pick-and-place --json"
        assert file["decomposition/inertia"].shape == (told["set_points"], 2, 6, 6)
        largest = np.abs(file["simplified_model/torque_error"][:]).max(axis=0)
    # The stored errors are those of the same two arrays, so they agree to the last bit or are round-off.
    allowed = [1e-12 * row["peak_torque"] for row in told["joints"]]
    assert (
        np.abs(largest - [row["largest_error"] for row in told["joints"]]) <= np.maximum(allowed, 1e-9)
    ).all()


def test_the_terminal_shows_the_answer_within_80_columns(run, here):
    result = run("puma560", "pick-and-place", "--format", "csv")
    assert result.code == 0
    assert result.err == ""
    lines = result.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert all(line == line.rstrip() for line in lines)
    assert "\x1b" not in result.out
    assert lines[0] == "Unimation PUMA 560 along pick-and-place, 31 set points, drives included"
    assert lines[-1] == "wrote       reports/puma560-pick-and-place/dominance.csv"
    assert "The founding text's verdicts agree with ours" in result.out


def test_the_terminal_says_how_good_how_proven_how_many_and_whether_drives_act(run, here):
    result = run("puma560", "pick-and-place", "--format", "csv")
    words = " ".join(result.out.split())
    headline, _, rest = words.partition("Largest torque error")
    for said in ("drives included", "cheapest exact program known takes 308", "Near this trajectory, proven"):
        assert said in headline, said
    heads = next(line for line in result.out.splitlines() if line.startswith("joint "))
    assert " ".join(heads.split()) == "joint peak torque allowed sampled share proven share unit"
    assert "Proven: no state within" in rest
    # Where D is not symmetric that is said, and what to use where it must be.
    assert ("D is not symmetric" in rest) == ("`--level energy`" in rest) is True


def test_small_torques_stand_in_small_units(run, here):
    result = run("puma560", "pick-and-place", "--no-drives", "--level", "element", "--format", "csv")
    flange = next(line for line in result.out.splitlines() if line.startswith("6 flange"))
    assert flange.endswith("µN m")
    errors = result.out.partition("Largest torque error")[2].partition("Ranking")[0]
    assert "e-0" not in errors


@pytest.mark.parametrize("formats", [("csv",), ("json",), ("h5", "json"), ("html",), ("pdf",)])
def test_only_the_chosen_files_are_written(run, motion, here, formats):
    assert run("two_link", motion, "--out", "x", "--quiet", "--format", ",".join(formats)).code == 0
    assert {path.name for path in (here / "x").iterdir()} == {FILES[name] for name in formats}


def test_options_may_stand_anywhere(run, motion, here):
    assert run("--out", "a", "--format=json", "two_link", motion).code == 0
    assert run("two_link", "--out", "b", motion, "--format", "JSON").code == 0
    models = [json.loads((here / x / "model.json").read_text(encoding="utf-8")) for x in "ab"]
    assert models[0]["terms"] == models[1]["terms"]


def test_quiet_prints_nothing(run, motion):
    result = run("--quiet", "two_link", motion, "--format", "json", "--out", "x")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_top_chooses_the_rows_of_the_ranking(run, motion):
    def rows(top: int) -> int:
        out = run("two_link", motion, "--format", "csv", "--top", top).out
        return sum(line.split()[0] in labels for line in out.splitlines() if line)

    labels = {"D11", "D12", "D22", "h1", "h2", "c1", "c2"}
    assert [rows(top) for top in (0, 1, 3, 100)] == [0, 1, 3, 7]
    assert "Ranking" not in run("two_link", motion, "--format", "csv", "--top", 0).out


def test_what_is_stored_follows_the_options(run, motion, here):
    def stored(*options: str) -> set[str]:
        words = ("--format", "h5", "--out", "x", "--overwrite", "--quiet", *options)
        assert run("two_link", motion, *words).code == 0
        return set(gd.load_results("x/analysis.h5")["decomposition"].data_vars)

    assert "christoffel" in stored()
    assert "christoffel" not in stored("--no-christoffel")
    assert "inertia_by_link" in stored("--by-link")
    assert "coriolis_centrifugal_terms" in stored("--terms")


def test_drives_count_unless_the_links_alone_are_asked_for(run, here):
    def told(*options: str) -> tuple[float, bool]:
        words = ("puma560", "large-slew", "--level", "element", "--format", "json", "--json")
        document = run(*words, *options).json
        assert ("drives included" in document["headline"]) == document["drives"]
        assert ("links alone" in document["headline"]) != document["drives"]
        return document["joints"][0]["peak_torque"], document["drives"]

    with_drives, alone = told(), told("--no-drives")
    assert with_drives == told("--drives")
    assert (with_drives[1], alone[1]) == (True, False)
    assert with_drives[0] > alone[0]


def test_a_budget_in_newton_metres_per_joint(run, motion):
    told = run("two_link", motion, "--format", "json", "--json", "--budget", "0.3,10%").json
    first, second = told["joints"]
    assert first["allowed_error"] == 0.3
    # One product, so within one rounding.
    assert second["allowed_error"] == pytest.approx(0.1 * second["peak_torque"], rel=2**-52)
    assert all(row["largest_error"] <= row["allowed_error"] for row in told["joints"])


def test_a_trajectory_from_standard_input(process, motion):
    result = process("two_link", "-", "--format", "json", "--json", stdin=motion.read_text())
    assert result.code == 0, result.err
    assert result.json["trajectory"] == "stdin"


def test_a_plan_may_be_piped_into_the_main_job(process):
    planned = process("plan", "two_link", "--from", "0,0", "--to", "60,-45", "--duration", "2")
    assert planned.code == 0
    assert planned.out.startswith("# gd-analyze plan two_link --from 0,0 --to 60,-45 --duration 2\ntime,q1")
    assert process("two_link", "-", "--format", "json", stdin=planned.out).code == 0


def test_an_arm_of_ones_own_with_a_joint_that_slides(run, here):
    (here / "slider.toml").write_text(
        'format = "gd-analyze arm 1"\nname = "slider"\n'
        '[[joints]]\nkind = "prismatic"\n[[joints]]\na = 0.5\n'
        "[[links]]\nmass = 1.0\ncom = [0.0, 0.0, 0.0]\ninertia = { xx = 1.0, yy = 1.0, zz = 1.0 }\n"
        "[[links]]\nmass = 1.0\ncom = [-0.2, 0.1, 0.0]\ninertia = { xx = 0.1, yy = 0.1, zz = 0.1 }\n"
    )
    rows = "".join(f"{0.2 * k},{0.01 * k * k},{0.02 * k * k}\n" for k in range(9))
    (here / "lift.csv").write_text("time,q1,q2\n" + rows)
    result = run("slider.toml", "lift.csv", "--format", "csv")
    assert result.code == 0, result.err
    assert "allows, in the unit of each row" in " ".join(result.out.split())
    assert [
        row["effort_unit"]
        for row in run("slider.toml", "lift.csv", "--format", "csv", "--json").json["joints"]
    ] == [
        "N",
        "N m",
    ]


def test_reports_are_made_again_byte_by_byte(run, here):
    """From the stored analysis alone: same reports, same model, same ranking, same words."""
    told = run("two_link", "two-link-swing", "--out", "first", "--json").json
    result = run("report", "first/analysis.h5", "--out", "second", "--json")
    assert (result.code, result.err) == (0, "")
    for name in MADE_AGAIN:
        first, second = ((here / folder / FILES[name]).read_bytes() for folder in ("first", "second"))
        assert first == second, name
    again = result.json
    assert again.pop("files") == [str(Path("second") / FILES[name]) for name in MADE_AGAIN]
    told.pop("files")
    assert again == told


def test_reports_go_beside_the_analysis_and_replace_what_is_there(run, motion, here):
    said = run("two_link", motion, "--out", "x", "--format", "h5,html").out
    before = (here / "x" / "report.html").read_bytes()
    (here / "x" / "report.html").write_text("old")
    result = run("report", "x/analysis.h5", "--format", "html")
    assert result.code == 0
    assert (here / "x" / "report.html").read_bytes() == before
    assert {path.name for path in (here / "x").iterdir()} == {"analysis.h5", "report.html"}
    assert result.out.splitlines()[:-1] == said.splitlines()[:-2]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.h5", None, "there is no such results file"),
        ("model.json", b"{}", "damaged or not HDF5"),
        ("cut.h5", b"\x89HDF\r\n\x1a\n", "not as gd-analyze wrote it"),
    ],
)
def test_no_report_of_another_file(run, here, name, content, said):
    if content is not None:
        (here / name).write_bytes(content)
    result = run("report", name)
    assert (result.code, result.out) == (2, "")
    assert said in result.err
    assert not [path for path in here.iterdir() if path.suffix in (".html", ".pdf")]


def test_the_terminal_has_the_words_of_the_reports(run, here):
    from gd_analyze.results import summary
    from gd_analyze.results.store import load_findings

    out = run("puma560", "pick-and-place", "--out", "x", "--format", "h5,html", "--top", 33).out
    page = (here / "x" / "report.html").read_text(encoding="utf-8")
    findings = load_findings("x/analysis.h5")
    for words in (summary.headline(findings), "gravity", "negligible"):
        assert words in " ".join(out.split())
        assert words.replace("'", "&#39;") in page
    check = summary.cross_check_row(findings)
    ratios = findings.tables["cross_check"]
    assert check["largest_difference"] / check["round_off_bound"] == pytest.approx(
        float((ratios.largest_difference / ratios.round_off_bound).max())
    )
    assert f"differs by {check['largest_difference']:.2e} {check['unit']}" in out
    for step in findings.model.accuracy.steps:
        assert step.words in page
        assert step.words in findings.model.accuracy.search
