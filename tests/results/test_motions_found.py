"""What the main job finds along several motions, and what it says of each."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics import decomposition
from gd_analyze.report.main_report import JSON, main_result
from gd_analyze.results.motion_result import strict_notice, verdict_rows
from gd_analyze.results.run_facts import run_headline, subtitle
from gd_analyze.studies.settings import default_folder
from gd_analyze.studies.study_files import write_findings
from recordings import swung

# Allowed errors and shares of them are quotients, rounded once or twice.
ROUNDED = 1.0 + 4 * float(np.finfo(float).eps)

SLOW, FAST = swung(20.0, "slow"), swung(2.2, "fast")


@pytest.fixture(scope="module")
def together(two_link):
    return gd.analyze(two_link, [SLOW, FAST], budget="20%")


@pytest.fixture(scope="module")
def alone(two_link):
    return {one.name: gd.analyze(two_link, one, budget="20%") for one in (SLOW, FAST)}


def test_along_each_the_verdicts_are_those_of_the_motion_by_itself(together, alone):
    table = together.tables["motions"]
    for k, (name, findings) in enumerate(alone.items()):
        by_itself = findings.dominance.sel(element=table.element.values)
        assert table.motion.values[k] == name
        for what in ("verdict", "dominant", "torque_joint"):
            assert table[what].values[:, k].tolist() == by_itself[what].values.tolist()
        # The same sums over the same blocks of set points.
        np.testing.assert_allclose(table.torque_share.values[:, k], by_itself.torque_share, rtol=1e-12)
        accuracy = findings.model.accuracy
        np.testing.assert_allclose(table.allowed_error.values[k], accuracy.allowed, rtol=1e-14)
        np.testing.assert_array_equal(table.peak_torque.values[k], accuracy.errors.peak_torque)


def test_verdicts_that_change_are_told(together):
    """Run fast, the arm needs Coriolis and centrifugal torque; run slowly, it does not."""
    rows = {row["element"]: row for row in verdict_rows(together)}
    assert rows["h1"]["verdicts"][0] == "negligible"
    assert rows["h1"]["verdicts"][1] != "negligible"
    assert rows["h1"]["changes"]
    # Gravity counts along both.
    assert (rows["c1"]["verdicts"], rows["c1"]["changes"]) == (["gravity", "gravity"], False)
    found = main_result(together, JSON).values()["motions"]
    assert found["changing"] == [name for name in rows if rows[name]["changes"]]
    assert all(row["worst"] <= ROUNDED for row in found["each"])
    assert found["worst_of_allowed"] == max(row["worst"] for row in found["each"])
    assert "slow, fast" in subtitle(together)


def test_it_holds_near_each(together):
    """What is proven there, of all and motion by motion, is within the budget of each."""
    table, model = together.tables["motions"], together.model
    assert model.saves
    share = table.certified / table.allowed_error
    assert 0.2 < float(share.max()) <= ROUNDED
    assert (table.certified >= table.largest_error * (1 - 1e-9)).all()
    np.testing.assert_array_equal(table.certified.max("motion"), together.tables["tube"].tube_certified)
    tube, errors = together.tables["tube"], model.accuracy.errors
    assert (tube.tube_worst_found >= errors.largest).all()
    assert (tube.tube_worst_found <= tube.tube_certified).all()
    assert "(proven)" in run_headline(together)
    found = main_result(together, JSON).values()
    # A share of the peak torque along the motion that uses most of its budget, which is 20 % of it.
    assert found["proven_error"] == pytest.approx(0.2 * float(share.max()))
    assert max(row["proven"] for row in found["motions"]["each"]) == pytest.approx(float(share.max()))


def test_a_strict_motion_is_named(two_link):
    flat = dataclasses.replace(two_link, gravity_vector=np.zeros(3))
    said = strict_notice(gd.analyze(flat, [swung(40.0, "creeping"), FAST], budget="20%"))
    # Without gravity torque goes with the square of the velocity: (40 / 2.2)^2 = 331.
    assert "along creeping" in said
    assert "331 times" in said
    assert strict_notice(gd.analyze(flat, [swung(40.0, "creeping"), FAST], budget="0.5")) == ""


def test_the_order_changes_nothing_but_the_order(two_link, together):
    other_way = gd.analyze(two_link, [FAST, SLOW], budget="20%")
    first, second = together.tables["motions"], other_way.tables["motions"]
    second = second.sel(element=first.element.values, motion=first.motion.values)
    for name in ("verdict", "dominant", "set_points", "peak_torque", "allowed_error"):
        assert second[name].values.tolist() == first[name].values.tolist(), name
    assert other_way.model.operations == together.model.operations
    assert {*other_way.model.terms} == {*together.model.terms}


def test_run_and_folder_are_those_of_all(two_link, together, alone):
    one = gd.analyze(two_link, [SLOW], budget="20%")
    assert "motions" not in one.tables
    assert one.provenance["run"] == alone["slow"].provenance["run"]
    other = gd.analyze(two_link, [SLOW, swung(2.1, "fast")], budget="20%")
    renamed = gd.analyze(two_link, [SLOW, dataclasses.replace(FAST, name="quick")], budget="20%")
    marks = [one.provenance["run"].removeprefix("gd-run:").split("-") for one in (together, other, renamed)]
    assert marks[0][0] == marks[1][0]  # asked for by the same names
    assert len({mark[1] for mark in marks}) == 3
    assert marks[0][0] != marks[2][0]
    folder = default_folder(two_link, together.trajectory, gd.types.Settings())
    assert folder.name == "two_link-slow+fast"


def test_the_ranking_as_csv_has_a_column_per_motion(together, tmp_path):
    import pandas as pd

    write_findings(together, tmp_path, ("csv",))
    table, motions_ = pd.read_csv(tmp_path / "dominance.csv"), together.tables["motions"]
    assert table["element"].tolist() == motions_.element.values.tolist()
    for k, name in enumerate(("slow", "fast")):
        assert table[f"verdict_{name}"].tolist() == motions_.verdict.values[:, k].tolist()
        np.testing.assert_allclose(
            table[f"torque_share_{name}"], motions_.torque_share.values[:, k], rtol=4e-16
        )
    assert table.columns[-1] == "run"


def test_long_motions_are_told_apart_on_demand(two_link, together, monkeypatch):
    monkeypatch.setattr(decomposition, "MOST_KEPT", 20)
    read = gd.analyze(two_link, [SLOW, FAST], budget="20%")
    for name, found in together.tables["motions"].data_vars.items():
        if found.dtype.kind == "f":
            # Blocks begin elsewhere: vectorised arithmetic may round its last entries otherwise.
            np.testing.assert_allclose(read.tables["motions"][name], found, rtol=1e-9, atol=1e-12)
        else:
            np.testing.assert_array_equal(read.tables["motions"][name], found)
