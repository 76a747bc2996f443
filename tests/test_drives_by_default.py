"""Where an arm describes drives, they are included unless the links alone are asked for."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.results import summary
from gd_analyze.robots.parts import Drive


@pytest.fixture(scope="module")
def links_alone(puma, pick_and_place):
    return gd.find(puma, pick_and_place, gd.Settings(drives=False))


def test_decompositions_include_them(puma, pick_and_place, pick_and_place_dataset):
    dataset = gd.decompose(puma, pick_and_place)
    inertia = puma.drive_inertia * pick_and_place.qdd
    np.testing.assert_array_equal(dataset.drive_torque, inertia)
    assert dataset.attrs["drives"] == 1
    # D, h and c remain the links' own.
    for name in ("inertia", "coriolis_centrifugal", "gravity_loading"):
        np.testing.assert_array_equal(dataset[name], pick_and_place_dataset[name])
    assert "drive_torque" not in pick_and_place_dataset


def test_models_include_them_however_the_states_are_given(puma, pick_and_place, pick_and_place_dataset):
    states = gd.states_of(pick_and_place)
    peak = np.abs(gd.decompose(puma, pick_and_place).torque.values).max(axis=0)
    for given in (pick_and_place, states, gd.decompose(puma, pick_and_place)):
        model = gd.simplify(puma, given, "10%")
        assert model.drives
        np.testing.assert_allclose(model.accuracy.errors.peak_torque, peak, rtol=1e-14)
    # A decomposition knows whether it has drives; what is asked for counts more.
    assert not gd.simplify(puma, pick_and_place_dataset, "10%").drives
    exact = gd.ExactDynamics.of(puma, pick_and_place_dataset, drives=True)
    np.testing.assert_allclose(exact.peak_torque, peak, rtol=1e-14)
    assert not gd.ExactDynamics.of(puma, gd.decompose(puma, pick_and_place), drives=False).form.drives


def test_the_links_alone_are_taken_where_asked_for(puma, pick_and_place, pick_and_place_dataset):
    model = gd.simplify(puma, pick_and_place, "10%", drives=False)
    assert not model.drives
    peak = np.abs(pick_and_place_dataset.torque.values).max(axis=0)
    np.testing.assert_array_equal(model.accuracy.errors.peak_torque, peak)


def test_rankings_include_them(puma, pick_and_place):
    with_drives = gd.rank_terms(gd.ExactDynamics.of(puma, pick_and_place))
    alone = gd.rank_terms(gd.ExactDynamics.of(puma, pick_and_place, drives=False))
    # Joints 4 to 6 have a term of drive inertia that the links' own D has not in this size.
    assert {term.term for term in alone.terms} < {term.term for term in with_drives.terms}
    assert with_drives.uncertainty > alone.uncertainty


def test_an_arm_without_drives_has_none_to_include(two_link, swing):
    assert not gd.simplify(two_link, swing, "10%").drives
    with pytest.raises(gd.GdAnalyzeError, match="describes no drives"):
        gd.simplify(two_link, swing, "10%", drives=True)
    idle = dataclasses.replace(two_link, drives=(Drive(torque_limit=10.0), Drive(torque_limit=5.0)))
    assert not gd.simplify(idle, swing, "10%").drives  # they state no inertia


def test_the_main_job_says_which(puma_findings, links_alone, swing_findings):
    for findings, told in ((puma_findings, "drives included"), (links_alone, "links alone")):
        assert told in summary.headline(findings)
        assert summary.subtitle(findings).endswith(f", {told}")
        assert dict(summary.provenance_lines(findings))["drives"]
    assert "drives" not in summary.headline(swing_findings) + summary.subtitle(swing_findings)
    assert "links" not in summary.headline(swing_findings) + summary.subtitle(swing_findings)


def test_elements_are_ranked_by_the_links_own_torque_over_the_peak_with_drives(puma_findings, links_alone):
    """What an element moves is the links' own; what it is a share of is the torque that errors count in."""
    own = links_alone.dominance.to_dataframe().torque_peak.groupby("element").max()
    driven = puma_findings.dominance.to_dataframe().torque_peak.groupby("element").max()
    element = "c2"
    assert driven[element] == own[element]
    for findings in (puma_findings, links_alone):
        row = findings.dominance.sel(element=element)
        peak = findings.model.accuracy.errors.peak_torque[int(row.torque_joint) - 1]
        assert float(row.torque_share) == pytest.approx(float(row.torque_peak) / peak, rel=1e-12)


def test_where_nothing_can_be_dropped_the_headline_says_so(puma, pick_and_place):
    findings = gd.find(puma, pick_and_place, gd.Settings(budget="0.0001%", level="term"))
    assert not findings.model.saves
    assert summary.headline(findings) == (
        "Nothing is saved within the budget of 0.0001%: no model found takes fewer operations than the "
        f"{findings.model.operations_full.total} of the exact torque (drives included), which is given."
    )


def test_budgets_in_torque_are_answered_in_torque(puma, pick_and_place):
    findings = gd.find(puma, pick_and_place, gd.Settings(budget="1"))
    largest = findings.model.accuracy.errors.largest.max()
    assert summary.headline(findings).endswith(f" N m; at its set points by {largest:.3g} N m.")
    joint = findings.model.accuracy.errors.largest.argmax() + 1
    assert (f"{largest:.3g} N m", f"largest error at the set points (joint {joint})") in summary.facts(
        findings
    )
    assert findings.tables["trade_off"].attrs["shares_of"] == "allowed error"
    asked = findings.tables["trade_off"].largest_share.sel(factor=1.0).values
    assert (asked <= 1.0).all()
