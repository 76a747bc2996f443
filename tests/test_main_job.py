"""The main job writes what was chosen, the files hold what was found, and bad input costs nothing."""

from __future__ import annotations

import importlib
import os

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeError, OutputError, TrajectoryError, UsageError
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.element import ELEMENT, parts_of
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.studies.analyze import analyze, find
from gd_analyze.studies.folder import FILES, default_folder, require_folder, write_findings
from gd_analyze.studies.settings_main import Origin, Settings
from strategies import names_in

DATA_FORMATS = ("h5", "json", "csv")
# The functions of the package hide the modules of their names.
ANALYZE, FIND = (importlib.import_module(f"gd_analyze.studies.{name}") for name in ("analyze", "find"))


@pytest.fixture
def nothing_computed(monkeypatch):
    def fail(*args, **options):
        raise AssertionError("computed before the output was known to be writable")

    monkeypatch.setattr(ANALYZE, "find", fail)


@pytest.mark.parametrize(
    "formats",
    [(), ("h5",), ("json",), ("csv",), ("csv", "json"), DATA_FORMATS],
    ids=lambda f: "+".join(f) or "none",
)
def test_exactly_the_chosen_files(two_link, swing, tmp_path, formats):
    folder = tmp_path / "deep" / "results"
    findings = analyze(two_link, swing, folder, formats=formats)
    assert sorted(names_in(folder) if folder.exists() else []) == sorted(FILES[name] for name in formats)
    assert len(findings.element_model.terms) < len(parts_of(2))
    assert findings.model.torques


def test_the_files_hold_what_was_found(puma, pick_and_place, tmp_path):
    findings = find(puma, pick_and_place, origin=Origin("gd-analyze puma560 x.csv"))
    write_findings(findings, tmp_path, DATA_FORMATS)
    tree = gd.load_results(tmp_path / "analysis.h5")
    np.testing.assert_array_equal(tree["decomposition/torque"], findings.decomposition.torque)
    assert tree.attrs["command"] == "gd-analyze puma560 x.csv"
    model = gd.load_model(tmp_path / "model.json")
    assert model.torques == findings.model.torques
    assert model.provenance["command"] == "gd-analyze puma560 x.csv"


def test_the_ranking_as_csv_is_the_dataset(puma_findings, tmp_path):
    import pandas as pd

    write_findings(puma_findings, tmp_path, ("csv",))
    table = pd.read_csv(tmp_path / "dominance.csv")
    dominance = puma_findings.dominance
    assert len(table) == 21 + 6 + 6
    assert table["element"].tolist() == dominance.element.values.tolist()
    for name, array in dominance.data_vars.items():
        columns = [name] if array.dims == ("element",) else [f"{name}_translation", f"{name}_rotation"]
        found = table[columns].to_numpy().reshape(array.shape)
        if array.dtype.kind == "f":
            # Written with every digit; a parser that is fast may miss the last bit.
            np.testing.assert_allclose(found, array.values, rtol=4e-16, atol=0)
        else:
            assert found.tolist() == array.values.tolist()


def test_nothing_is_written_without_a_folder(two_link, swing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    findings = analyze(two_link, swing)
    assert findings.model.operations.total > 0
    assert names_in(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({}, "two_link-two-link-swing"),
        ({"budget": gd.Budget.parse("1%")}, "two_link-two-link-swing"),
        ({"budget": gd.Budget.parse("0.5%")}, "two_link-two-link-swing-budget-0.5pct"),
        ({"budget": gd.Budget.parse("0.5")}, "two_link-two-link-swing-budget-0.5_N_m"),
        ({"budget": gd.Budget.parse("1%,0.2")}, "two_link-two-link-swing-budget-1pct_0.2_N_m"),
        (
            {"level": "energy", "refit": True, "christoffel": False, "operations": 90},
            "two_link-two-link-swing-level-energy-refit-operations-90-no-christoffel",
        ),
    ],
)
def test_the_default_folder_says_the_options(two_link, swing, options, name):
    assert default_folder(two_link, swing, Settings(**options)).name == name


@pytest.mark.usefixtures("nothing_computed")
def test_an_unwritable_folder_is_found_out_first(two_link, swing, blocked_folder):
    with pytest.raises(OutputError, match="cannot write the results there") as caught:
        analyze(two_link, swing, blocked_folder, formats=DATA_FORMATS)
    assert str(blocked_folder) in caught.value.details["where"]
    assert "is not a folder" in caught.value.details["found"]
    assert "--out" in caught.value.details["next"]
    assert not blocked_folder.exists()


@pytest.mark.usefixtures("nothing_computed")
def test_a_folder_without_permission_is_found_out_first(two_link, swing, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(OutputError) as caught:
        analyze(two_link, swing, tmp_path / "new", formats=DATA_FORMATS)
    assert "is not writable" in caught.value.details["found"]
    assert names_in(tmp_path) == []


def test_a_folder_that_can_be_made_is_fine(tmp_path):
    assert require_folder(tmp_path / "a" / "b", FILES, "") == ()
    assert require_folder(tmp_path, FILES, "") == ()
    assert names_in(tmp_path) == []


@pytest.mark.usefixtures("nothing_computed")
def test_an_unknown_format(two_link, swing, tmp_path):
    with pytest.raises(UsageError, match="no format 'docx'"):
        analyze(two_link, swing, tmp_path, formats=("h5", "docx"))
    assert names_in(tmp_path) == []


def test_a_trajectory_of_another_arm_writes_nothing(puma, swing, tmp_path):
    with pytest.raises(TrajectoryError):
        analyze(puma, swing, tmp_path / "out", formats=DATA_FORMATS)
    assert not (tmp_path / "out").exists()


def test_a_disagreement_with_the_authority_writes_nothing(two_link, swing, tmp_path, monkeypatch):
    def disagree(*args):
        raise GdAnalyzeError("torque disagrees with Pinocchio")

    monkeypatch.setattr(FIND, "cross_check", disagree)
    with pytest.raises(GdAnalyzeError):
        analyze(two_link, swing, tmp_path / "out", formats=DATA_FORMATS)
    assert not (tmp_path / "out").exists()


def test_warnings_end_up_in_the_findings(two_link, swing, monkeypatch):
    import warnings

    from gd_analyze.errors import GdAnalyzeWarning

    real = FIND.decompose_on_demand

    def suspicious(*args, **options):
        warnings.warn("an odd arm", GdAnalyzeWarning, stacklevel=1)
        return real(*args, **options)

    monkeypatch.setattr(FIND, "decompose_on_demand", suspicious)
    found = find(two_link, swing, origin=Origin(warnings=("an odd file",)))
    assert found.warnings == ("an odd file", "an odd arm")


def test_budget_and_options_reach_what_they_are_for(puma, pick_and_place):
    settings = Settings(budget=gd.Budget.parse("5%"), drives=True, christoffel=False, terms=True)
    found = find(puma, pick_and_place, settings)
    assert found.model.accuracy.budget == "5%"
    assert found.model.drives
    assert "christoffel" not in found.decomposition
    assert "coriolis_centrifugal_terms" in found.decomposition
    peak = np.abs(found.decomposition.torque.values).max(axis=0)
    np.testing.assert_array_equal(found.dominance.attrs["floor"], 0.05 * peak / 8)
    np.testing.assert_array_equal(found.model.accuracy.allowed, 0.05 * peak)


def test_provenance_is_flat(puma_findings):
    source = puma_findings.provenance
    assert source.keys() >= {"gd_analyze", "created", "command", "python", "numpy", "pinocchio"}
    assert all(isinstance(value, str) for value in source.values())
    assert puma_findings.decomposition.attrs["command"] == source["command"]


def test_an_arm_of_many_terms_is_simplified_in_its_recursion(two_link, swing, monkeypatch) -> None:
    monkeypatch.setattr("gd_analyze.simplification.exact_form.MOST_TERMS", 3)
    findings = find(two_link, swing)
    model = findings.model
    assert model.level is RECURSIVE
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    tried = {one.level: one for one in model.accuracy.levels}
    assert tried["recursive"].operations == model.operations.total <= findings.element_model.operations.total
    assert tried["term"].operations is None
    assert "more than 3 torque terms" in tried["term"].why
    assert not findings.is_written_out
    assert any("single terms are not" in warning for warning in findings.warnings)
    assert findings.ranked_terms == {}
    assert set(findings.tables["trade_off"].level.values) == {"element", "recursive"}
    budgets = findings.tables["budgets"]
    assert not {"kept", "kept_parts"} & {*budgets}
    counts = budgets.operations.values
    assert counts[0] >= counts[10] == model.operations.total > counts[-1]
    assert (np.diff(counts) <= 0).all()
    errors = budgets.largest_error.values
    assert (errors <= budgets.factor.values[:, None] * model.accuracy.allowed * (1 + 1e-12)).all()


@pytest.mark.parametrize("level", ["element", "term", "energy"])
def test_the_level_asked_for(puma, pick_and_place, level) -> None:
    findings = gd.find(puma, pick_and_place, Settings(level=level, budget=gd.Budget.parse("5%")))
    model, elements_only = findings.model, level == "element"
    assert model.level.name == level
    # Of elements alone nothing is gained: the exact torque takes fewer operations.
    assert model.saves != elements_only
    assert elements_only == (model.level is ELEMENT)
    assert findings.is_written_out
    assert findings.tables["beyond"].certified.notnull().all()
    assert findings.tables["tube"].tube_certified.notnull().all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    again = gd.evaluate(model, pick_and_place).errors
    assert again.largest == pytest.approx(model.accuracy.errors.largest)


def test_one_number_of_terms(puma, pick_and_place) -> None:
    """Carrying something off the last axis makes more terms than a ranking lists; all are counted."""
    from gd_analyze.report.document import document
    from gd_analyze.results import summary

    arm = with_payload(puma, 2.0, np.array([0.05, 0.0, 0.1]))
    findings = find(arm, pick_and_place, Settings(level="term"))
    total = findings.tables["terms"].attrs["total"]
    assert total > findings.tables["terms"].sizes["rank"]
    assert total == len(findings.model.form.torques)
    assert summary.facts(findings)[3][1].endswith(f" {total}")
    shown = document(findings)
    assert shown["terms"]["total"] == total
    assert sum(cell["of"] for row in shown["harmonic"]["kept"] for cell in row) == total
