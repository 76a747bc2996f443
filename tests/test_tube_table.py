"""What the main job finds around the motion, in its table, its file and its sentence."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.certification.box import Box
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.store import load_findings, save_results
from gd_analyze.results.summary import tube_sentence
from gd_analyze.studies.find import find
from gd_analyze.studies.settings_main import Settings


def test_it_holds_what_certify_proves(puma, pick_and_place, puma_findings):
    table, model = puma_findings.tables["tube"], puma_findings.model
    tube = gd.Tube.along(puma, pick_and_place)
    certificate = gd.certify(model, tube, effort=100_000)
    np.testing.assert_array_equal(table.tube_along, certificate.along)
    np.testing.assert_array_equal(table.tube_certified, certificate.certified)
    np.testing.assert_array_equal(table.tube_worst_found, certificate.worst_found)
    np.testing.assert_array_equal(table.segment_from, tube.begin)
    np.testing.assert_array_equal(table.segment_to, tube.end)
    for name, margins in zip(("q", "qd", "qdd"), tube.margins, strict=True):
        np.testing.assert_array_equal(table[f"tube_margin_{name}"], margins)
    peak = model.accuracy.errors.peak_torque
    np.testing.assert_allclose(table.tube_certified_share * peak, certificate.certified)
    np.testing.assert_allclose(table.tube_worst_found_share * peak, certificate.worst_found)
    assert (table.tube_certified >= model.accuracy.errors.largest).all()
    assert (table.attrs["margin"], table.attrs["coarse"]) == ("1deg,1mm,qd=2%,qdd=5%", tube.coarse)
    assert table.attrs["note"] == tube.note


def test_it_is_far_below_the_box_of_extremes(puma_findings):
    tube, beyond = puma_findings.tables["tube"], puma_findings.tables["beyond"]
    assert (tube.tube_certified < beyond.certified).all()


def test_it_survives_its_file(puma_findings, tmp_path):
    save_results(puma_findings, tmp_path / "analysis.h5")
    assert load_findings(tmp_path / "analysis.h5").tables["tube"].identical(puma_findings.tables["tube"])


def test_it_is_said_in_a_sentence(puma_findings):
    said = tube_sentence(puma_findings)
    assert said.startswith(
        "Proven: no state within 1 degree, 2 % of peak velocity and 5 % of peak acceleration"
    )
    assert "between its set points too" in said
    assert said.endswith(puma_findings.tables["tube"].attrs["note"])


@pytest.mark.parametrize("margin", ["3deg,qd=6%", gd.Margin(revolute=np.radians(3.0), velocity=0.06)])
def test_the_margin_is_a_setting(two_link, swing, margin):
    table = find(two_link, swing, Settings(margin=margin, budget="5%")).tables["tube"]
    assert table.attrs["margin"] == "3deg,1mm,qd=6%,qdd=5%"
    np.testing.assert_allclose(table.tube_margin_q, np.radians(3.0))


def test_a_margin_that_is_none_is_refused_before_any_computing():
    with pytest.raises(UsageError, match="the margin is not understood"):
        Settings(margin="3")


def test_another_margin_is_another_run(two_link, swing):
    runs = {find(two_link, swing, Settings(margin=margin)).provenance["run"] for margin in (None, "2deg")}
    assert len(runs) == 2


def test_a_coarse_trajectory_is_told_in_the_table(puma, pick_and_place):
    every = slice(None, None, 6)
    coarse = Trajectory(
        pick_and_place.time[every],
        pick_and_place.q[every],
        pick_and_place.qd[every],
        pick_and_place.qdd[every],
        "coarse",
    )
    findings = find(puma, coarse, Settings(level="energy", budget="5%"))
    table = findings.tables["tube"]
    assert table.attrs["coarse"] == 5
    assert "5 of 5 intervals" in table.attrs["note"]
    assert "5 of 5 intervals" in tube_sentence(findings)
    # It is wider, but proven all the same.
    assert (table.tube_certified >= findings.model.accuracy.errors.largest).all()


def test_set_points_without_a_motion_between_them_have_no_certificate(two_link, tmp_path):
    """What is said of the set points themselves stays."""
    q = np.array([[0.0, 0.0], [1.0, 1.0], [1.1, 1.2]])
    motion = Trajectory(np.array([0.0, 1e-9, 1.0]), q, 0.1 + 0 * q, 1 + 0 * q, "torn")
    findings = find(two_link, motion)
    table = findings.tables["tube"]
    assert table.tube_certified.isnull().all()
    assert table.tube_along.shape == (1, 2)
    assert "no possible motion leads from one set point to the next" in tube_sentence(findings)
    save_results(findings, tmp_path / "analysis.h5")
    assert load_findings(tmp_path / "analysis.h5").tables["tube"].identical(table)


def test_one_set_point_is_a_tube_too(two_link):
    states = np.array([[0.3, 0.4]])
    table = find(two_link, Trajectory(np.zeros(1), states, states, states, "one")).tables["tube"]
    assert table.sizes["segment"] == 1
    assert table.tube_certified.notnull().all()


def test_a_box_says_what_it_is(puma):
    assert Box.of(puma).where == "the arm's limits"
