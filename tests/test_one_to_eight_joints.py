"""Arms of one to eight joints of every make go through the main job to all its files, and back."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import load_model, save_model
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.files import RESULT_FILES
from gd_analyze.studies.study_files import write_findings
from gd_analyze.types import ExactDynamics, RobotArm
from long_cases import long_but
from parallel_axes import arm_of, scara
from recordings import swinging
from strategies import random_states

# How each joint stands to the one before; "askew" eight times over is an arm of a million terms and more.
MAKES = {
    "a pendulum": ["askew"],
    "a lift": ["slides"],
    "a gantry": ["slides", "slides", "slides"],
    "a plane of three": ["same", "same", "opposite"],
    "two turns and slides between": ["askew", "slides across", "slides along", "opposite"],
    "a scara": [],
    "seven of general make": ["askew"] * 3 + ["slides"] + ["askew"] * 3,
}


def assert_goes_through(arm: RobotArm, folder: Path) -> None:
    motion = swinging(arm, 25)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        findings = gd.analyze(arm, motion)
        write_findings(findings, folder, tuple(RESULT_FILES))
        stored = gd.load_findings(folder / RESULT_FILES["h5"])
        model = load_model(folder / RESULT_FILES["json"])
    assert all((folder / name).stat().st_size for name in RESULT_FILES.values())
    exact = ExactDynamics.of(arm, motion)
    off = np.abs(model.torque(*exact.states.arrays) - exact.torque).max(axis=0)
    assert (off <= model.accuracy.allowed).all()
    assert stored.model.operations == model.operations
    # Nothing takes more operations than the exact torque.
    assert model.operations.total <= exact.form.operations.total


@pytest.mark.parametrize("make", long_but(("a pendulum", "a lift"), MAKES))
def test_it_goes_through_the_main_job(make, tmp_path):
    made = scara() if make == "a scara" else arm_of(MAKES[make], np.random.default_rng(3))
    assert_goes_through(made, tmp_path / "results")


@pytest.mark.slow
@pytest.mark.parametrize("level", ["term", "energy"])
def test_a_million_terms_are_refused_with_what_to_do_instead(level):
    arm = arm_of(["askew"] * 8, np.random.default_rng(4))
    with pytest.raises(UsageError, match="too many terms") as caught:
        gd.simplify(arm, random_states(8, 50, 1), "0.01%", level=level)
    assert "`gd-analyze export ROBOT --to c`" in str(caught.value)


@pytest.mark.slow
def test_an_exact_model_of_a_million_terms_is_kept_and_read(tmp_path):
    """By its parts: a list of its terms would take gigabytes, and its program cannot be written out."""
    arm = arm_of(["askew"] * 8, np.random.default_rng(4))
    model = gd.simplify(arm, random_states(8, 50, 1), level="element")
    assert not model.saves
    save_model(model, tmp_path / "model.json")
    assert (tmp_path / "model.json").stat().st_size < 1_000_000
    assert load_model(tmp_path / "model.json").program.count == model.program.count


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
def test_dominant_parts_too_long_to_be_written_out_are_not_proven():
    """Of seven general joints, single terms are ranked, but the parts of elements have no sum of terms."""
    arm = arm_of(["askew"] * 7, np.random.default_rng(4))
    findings = gd.analyze(arm, swinging(arm, 25), level="element", dominance=0.4)
    assert not findings.model.is_exact
    assert findings.tables["tube"].tube_certified.isnull().all()
    assert "too long" in findings.tables["tube"].attrs["note"]
    assert findings.tables["beyond"].certified.isnull().all()
