"""Every file of a run carries its mark, and files of another run are noticed."""

from __future__ import annotations

import dataclasses
import shutil
import warnings
from pathlib import Path

import pytest

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeWarning, OutputError
from gd_analyze.files import RESULT_FILES, mark_in, require_one_run
from gd_analyze.studies.study_files import write_findings

EVERY = sorted(RESULT_FILES.values())


@pytest.fixture(scope="module")
def other_budget(two_link, swing):
    return gd.analyze(two_link, swing, budget="30%")


@pytest.fixture(scope="module")
def written(swing_findings, other_budget, tmp_path_factory):
    """Folders of two runs."""
    folder = tmp_path_factory.mktemp("runs")
    write_findings(swing_findings, folder / "one", RESULT_FILES)
    write_findings(other_budget, folder / "other", RESULT_FILES)
    return folder


@pytest.fixture
def folder(tmp_path, written):
    return Path(shutil.copytree(written / "one", tmp_path / "r"))


def mark(findings) -> str:
    return findings.provenance["run"]


def warned(work, *words) -> str:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        work(*words)
    return "\n".join(str(warning.message) for warning in caught)


def test_every_file_carries_the_mark(folder, swing_findings):
    assert {mark_in(folder / name) for name in EVERY} == {mark(swing_findings)}
    assert warned(gd.load_findings, folder / "analysis.h5") == ""
    assert warned(gd.load_model, folder / "model.json") == ""
    assert mark(gd.load_findings(folder / "analysis.h5")) == mark(swing_findings)


def test_the_mark_is_of_inputs_and_options_alone(two_link, swing, swing_findings, other_budget):
    heavy = dataclasses.replace(two_link, gravity_vector=two_link.gravity_vector * 1.001)
    named = dataclasses.replace(swing, name="other")
    by_link = gd.analyze(two_link, swing, by_link=True)
    every = [other_budget, by_link, gd.analyze(two_link, named), swing_findings, gd.analyze(heavy, swing)]
    marks = [mark(findings) for findings in every]
    assert len(set(marks)) == len(marks)
    # The first part is of what was asked for: names and options.
    assert len({found.split("-")[1] for found in marks}) == len(marks) - 1
    assert mark(gd.analyze(two_link, swing)) == mark(swing_findings)


def test_another_file_of_a_robot_of_that_name_is_another_run(two_link, swing, tmp_path):
    """As two URDF files of one robot's name, whose files are named among the sources."""
    first, second = (
        dataclasses.replace(two_link, sources=(f"{name}.urdf: URDF.",)) for name in ("first", "second")
    )
    gd.analyze(first, swing, out=tmp_path, formats="json")
    gd.analyze(first, swing, out=tmp_path, formats="json")
    with pytest.raises(OutputError, match="another run"):
        gd.analyze(second, swing, out=tmp_path, formats="json")


@pytest.mark.parametrize("name", ["analysis.h5", "model.json", "report.pdf"])
def test_a_file_of_another_run_is_noticed(folder, written, name):
    shutil.copy(written / "other" / name, folder)
    for read, load in (("analysis.h5", gd.load_findings), ("model.json", gd.load_model)):
        message = warned(load, folder / read).partition(";")[0]
        assert f"different runs in {folder}" in message
        assert all((other in message) == (name in (read, other)) for other in {*EVERY} - {read})


def test_a_file_of_no_run_is_noticed_and_not_replaced_and_one_of_another_name_is_not(folder, swing_findings):
    gd.save_model(swing_findings.element_model, folder / "mine.json")
    assert warned(gd.load_model, folder / "mine.json") == ""
    (folder / "model.json").write_bytes(b"mine")
    assert "model.json" in warned(gd.load_findings, folder / "analysis.h5")
    with pytest.raises(OutputError, match="another run"):
        require_one_run(folder, RESULT_FILES, RESULT_FILES, mark(swing_findings))


def test_a_mixture_is_mended_from_the_analysis(folder, other_budget):
    """What is put in place first is what the others are made from."""
    warned(write_findings, other_budget, folder, ("h5",))
    with pytest.warns(GdAnalyzeWarning, match="different runs"):
        findings = gd.load_findings(folder / "analysis.h5")
    assert warned(write_findings, findings, folder, ("json", "csv", "html", "pdf")) == ""
    assert warned(gd.load_findings, folder / "analysis.h5") == ""


def test_marks_are_found_wherever_they_stand(tmp_path):
    sign, path = "gd-run:0123abcd-0123456789abcdef", tmp_path / "any"
    for before in (0, (1 << 20) - 5, (1 << 20) + 7):
        path.write_bytes(b"x" * before + sign.encode())
        assert mark_in(path) == sign, before
    assert mark_in(tmp_path) == mark_in(tmp_path / "none") == ""
