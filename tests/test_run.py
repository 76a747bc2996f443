"""Every file of a run carries its mark, and what is of another run is told."""

from __future__ import annotations

import dataclasses
import shutil
import warnings
from pathlib import Path

import pytest

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeWarning, OutputError
from gd_analyze.files import marks_in
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.store import load_findings, load_results, save_results
from gd_analyze.studies.folder import FILES, require_folder, write_findings
from gd_analyze.studies.settings_main import Origin, Settings

QUICK = ("h5", "json", "csv")


@pytest.fixture(scope="module")
def other_budget(two_link, swing):
    return gd.find(two_link, swing, Settings(budget=gd.Budget.parse("30%")))


@pytest.fixture(scope="module")
def written(swing_findings, other_budget, tmp_path_factory):
    """Folders of two runs."""
    folder = tmp_path_factory.mktemp("runs")
    write_findings(swing_findings, folder / "one", FILES)
    write_findings(other_budget, folder / "other", FILES)
    return folder


@pytest.fixture
def folder(tmp_path, written):
    return Path(shutil.copytree(written / "one", tmp_path / "r"))


def mark(findings) -> str:
    return findings.provenance["run"]


def told(work, *words) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        work(*words)
    return "\n".join(str(warning.message) for warning in caught)


def test_every_file_carries_the_mark(folder, swing_findings):
    import pandas as pd

    for name in FILES.values():
        assert marks_in(folder / name) == {mark(swing_findings)}, name
    assert load_findings(folder / "analysis.h5").provenance["run"] == mark(swing_findings)
    assert gd.load_model(folder / "model.json").provenance["run"] == mark(swing_findings)
    table = pd.read_csv(folder / "dominance.csv")
    assert set(table["run"]) == {mark(swing_findings)}
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert f'<meta name="gd-analyze-run" content="{mark(swing_findings)}">' in page
    assert f"<dt>run</dt><dd>{mark(swing_findings)}</dd>" in page
    assert f"/Keywords({mark(swing_findings)})".encode() in (folder / "report.pdf").read_bytes()


def test_the_mark_is_of_inputs_and_options_alone(two_link, swing, swing_findings):
    """Not of the moment and the words of the command."""
    again = gd.find(two_link, swing, origin=Origin("gd-analyze two_link --json"))
    assert mark(again) == mark(swing_findings)


def test_inputs_and_options_make_another_mark(two_link, swing, swing_findings):
    heavy = dataclasses.replace(two_link, gravity=two_link.gravity * 1.001)
    later = Trajectory(swing.time + 1.0, swing.q, swing.qd, swing.qdd, swing.name, swing.origin)
    named = dataclasses.replace(swing, name="other")
    settings = [
        Settings(budget=gd.Budget.parse("2%")),
        Settings(budget=gd.Budget.parse("0.01")),
        Settings(level="term"),
        Settings(level="element"),
        Settings(refit=True),
        Settings(operations=22),
        Settings(christoffel=False),
        Settings(by_link=True),
        Settings(terms=True),
    ]
    marks = [mark(gd.find(two_link, swing, how)) for how in settings]
    marks += [
        mark(gd.find(arm, motion)) for arm, motion in ((heavy, swing), (two_link, later), (two_link, named))
    ]
    marks.append(mark(swing_findings))
    assert len(set(marks)) == len(marks)
    # The first part is of what was asked for: names and options.
    assert len({found.split("-")[1] for found in marks}) == len(settings) + 2


def test_a_sound_folder_is_read_without_a_word(folder):
    assert told(load_findings, folder / "analysis.h5") == ""
    assert told(gd.load_model, folder / "model.json") == ""


@pytest.mark.parametrize("name", sorted(FILES.values()))
def test_a_file_of_another_run_is_seen(folder, written, name):
    shutil.copy(written / "other" / name, folder)
    for read, load in (
        ("analysis.h5", load_findings),
        ("analysis.h5", load_results),
        ("model.json", gd.load_model),
    ):
        said = told(load, folder / read)
        assert f"the folder {folder} holds files of different runs" in said
        if read != name:
            assert f": {name} is not of the run of {read};" in said
        else:
            others = [other for other in FILES.values() if other != name]
            assert f": {', '.join(others)} are not of the run of {read};" in said


def test_a_file_of_no_run_is_seen(folder, two_link, swing):
    gd.save_model(gd.simplify(two_link, swing), folder / "model.json")
    assert "model.json is not of the run of analysis.h5" in told(
        lambda: load_findings(folder / "analysis.h5")
    )
    assert "analysis.h5, dominance.csv" in told(gd.load_model, folder / "model.json")


def test_results_of_other_names_are_no_set(folder, two_link, swing, other_budget):
    """A model kept beside results, or two analyses: nobody takes them for one."""
    gd.save_model(gd.simplify(two_link, swing), folder / "mine.json")
    save_results(other_budget, folder / "before.h5")
    assert told(gd.load_model, folder / "mine.json") == ""
    assert told(load_findings, folder / "before.h5") == ""


def claimed(folder, findings, formats=FILES, *, overwrite=False):
    return require_folder(folder, formats, mark(findings), overwrite=overwrite)


def test_the_same_run_again_replaces_the_files(folder, swing_findings):
    assert claimed(folder, swing_findings) == ()
    assert claimed(folder, swing_findings, QUICK) == ()


@pytest.mark.parametrize("formats", [FILES, QUICK, ("csv",)])
def test_another_run_is_not_replaced(folder, other_budget, puma_findings, formats):
    for findings in (other_budget, puma_findings):
        with pytest.raises(OutputError, match="holds files of another run") as caught:
            claimed(folder, findings, formats)
        assert caught.value.details["found"] == ", ".join(FILES.values())
        assert "--overwrite" in caught.value.details["next"]


def test_overwriting_leaves_files_of_one_run(folder, other_budget):
    strangers = claimed(folder, other_budget, QUICK, overwrite=True)
    assert [path.name for path in strangers] == ["report.html", "report.pdf"]
    write_findings(other_budget, folder, QUICK, strangers)
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES[name] for name in QUICK)
    assert told(load_findings, folder / "analysis.h5") == ""


def test_what_was_asked_for_again_replaces_what_it_gave_before(folder, two_link, swing):
    """Numbers in the arm's file were mended, and the same command is given again."""
    mended = gd.find(dataclasses.replace(two_link, gravity=two_link.gravity * 1.001), swing)
    assert claimed(folder, mended) == ()
    with pytest.raises(OutputError, match="would hold files of two runs") as caught:
        claimed(folder, mended, QUICK)
    assert caught.value.details["found"] == "report.html, report.pdf"
    assert len(claimed(folder, mended, QUICK, overwrite=True)) == 2


@pytest.mark.parametrize("name", sorted(FILES.values()))
def test_a_file_of_no_run_is_not_replaced(tmp_path, swing_findings, name):
    """A report of one's own may be called report.pdf."""
    (tmp_path / name).write_bytes(b"mine")
    with pytest.raises(OutputError, match="another run") as caught:
        claimed(tmp_path, swing_findings)
    assert caught.value.details["found"] == name


def test_a_mixture_is_mended_from_the_analysis(folder, other_budget):
    """What is put in place first is what the others are made from."""
    told(write_findings, other_budget, folder, ("h5",))
    with pytest.warns(GdAnalyzeWarning, match="different runs"):
        findings = load_findings(folder / "analysis.h5")
    assert told(write_findings, findings, folder, ("json", "csv", "html", "pdf")) == ""
    assert told(load_findings, folder / "analysis.h5") == ""
    assert {*marks_in(folder / "model.json")} == {mark(other_budget)}


def test_marks_are_found_wherever_they_stand(tmp_path):
    sign = "gd-run:0123abcd-0123456789abcdef"
    path = tmp_path / "any"
    # Across the border of the blocks that are read, too.
    for before in (0, 1, (1 << 20) - 5, 1 << 20, (1 << 20) + 7):
        path.write_bytes(b"x" * before + sign.encode())
        assert marks_in(path) == {sign}, before
    path.write_bytes(b"gd-run:0123abcd")
    assert marks_in(path) == set()
    assert marks_in(tmp_path) == marks_in(tmp_path / "none") == set()
