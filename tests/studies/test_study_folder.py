"""The files of a study in a folder: of one run."""

from __future__ import annotations

import pytest

from gd_analyze.errors import OutputError
from gd_analyze.progress import NO_PROGRESS
from gd_analyze.result import Result
from gd_analyze.studies.study_files import StudyFolder

RESULT = Result("Torques of an arm", provenance={"created": "2026-01-01T00:00:00+00:00"})
FORMATS = ("html", "pdf", "json")


def test_a_repeated_study_replaces_its_own_files_and_no_others(tmp_path):
    for _ in range(2):
        StudyFolder(tmp_path, "study", FORMATS, ["arm"], overwrite=False).write(RESULT, NO_PROGRESS)
    assert {path.name for path in tmp_path.iterdir()} == {f"study.{word}" for word in FORMATS}
    with pytest.raises(OutputError, match="another run"):
        StudyFolder(tmp_path, "study", FORMATS, ["other arm"], overwrite=False)
    other = StudyFolder(tmp_path, "study", ("json",), ["other arm"], overwrite=True)
    other.write(RESULT, NO_PROGRESS)
    assert [*tmp_path.iterdir()] == [*other.paths]


def test_without_a_folder_no_file_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = StudyFolder(None, "study", FORMATS, ["arm"], overwrite=False)
    study.write(RESULT, NO_PROGRESS)
    assert (study.paths, [*tmp_path.iterdir()]) == ((), [])
