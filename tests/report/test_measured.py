"""Measured torques in the reports: figures, tables and sentences where there are any, nothing elsewhere."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_reader import Page
from pdf_reader import read
from report_arms import SLIDING

from gd_analyze.errors import UsageError
from gd_analyze.report.document import document
from gd_analyze.report.figures import measured_figure
from gd_analyze.report.html import render_html
from gd_analyze.report.numbering import numbering
from gd_analyze.report.pdf import prepare_pdf, report_figures
from gd_analyze.results.findings import Findings
from gd_analyze.results.torque_curves import torque_curves
from gd_analyze.results.torque_words import torque_sentence
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.studies.find import find
from gd_analyze.studies.settings_main import Settings
from recorded_logs import recorded, with_torques


@pytest.fixture(scope="module")
def measured_page(measured_findings: Findings) -> Page:
    return Page(render_html(measured_findings))


@pytest.fixture(scope="module")
def silent(two_link: RobotArm) -> Findings:
    """A log of which the second joint's torque was not measured and lacks readings in the first's."""
    log = recorded(two_link, noise=0.1, gaps=(300,))
    assert log.recording is not None
    assert log.recording.torque is not None
    torque = log.recording.torque.copy()
    torque[:, 1], torque[200:220, 0] = 0.0, np.nan
    return find(two_link, with_torques(log, torque))


def test_the_page_shows_every_joint(measured_findings: Findings, measured_page: Page) -> None:
    table = measured_findings.tables["measured_torque"]
    assert "measured" in measured_page.identifiers
    assert torque_sentence(table) in measured_page.text
    figures = measured_page.data["figures"]
    for joint in (1, 2):
        assert figures[f"measured-{joint}"]["unit"] == "N m"
        roles = [trace["role"] for trace in figures[f"measured-{joint}"]["traces"]]
        assert roles == ["read", "measured", "model", "friction"]
        assert [trace["role"] for trace in figures[f"difference-{joint}"]["traces"]] == [
            "measured",
            "friction",
        ]
        drawn = [a["data-figure"] for a in measured_page.of_class("div", "plot")]
        assert {f"measured-{joint}", f"difference-{joint}"} <= {*drawn}
    curve = figures["measured-2"]["traces"][1]["y"]
    # Six digits are written.
    np.testing.assert_allclose(curve, table.filtered.values[:, 1], rtol=1e-5, atol=1e-9)


def test_tables_have_the_numbers(measured_findings: Findings, measured_page: Page) -> None:
    shown = document(measured_findings)["measured"]
    assert shown["fitted"]
    assert not shown["described"]
    assert (shown["compared"], shown["filtered"]) == (484, True)
    first, second = shown["rows"]
    assert (first["told"], second["told"]) == ("follows", "too light by a factor 2")
    assert (first["correlation"], second["slope"]) == ("1.000", "2.00")
    assert (first["explained"], second["explained"]) == ("100 %", "75 %")
    for row in shown["rows"]:
        for name in ("told", "bias", "rms_difference", "peak_measured", "coulomb", "offset"):
            assert row[name] in measured_page.text, name


def test_a_model_that_was_not_measured_is_warned_of_first(
    measured_findings: Findings, measured_page: Page, tmp_path: Path
) -> None:
    (warning,) = [one for one in measured_findings.warnings if "measured torques" in one]
    assert measured_page.text.index(warning) < measured_page.text.index("What the budget buys")
    first = read(prepare_pdf(measured_findings)(), tmp_path, "-l", "1")
    assert " ".join(warning.split()) in " ".join(first.split())


def test_the_pdf_has_an_appendix(measured_findings: Findings, tmp_path: Path) -> None:
    text = " ".join(read(prepare_pdf(measured_findings)(), tmp_path).split())
    numbers = numbering(measured_findings)
    assert numbers["titles"]["measured"] in text.replace("’", "'")
    for kind, name in (("figures", "measured"), ("tables", "measured"), ("tables", "friction")):
        assert f"{numbers[kind][name]}." in text
    assert torque_sentence(measured_findings.tables["measured_torque"]) in text
    assert "too light by a factor 2" in text


def test_a_plan_shows_nothing_of_it(puma_findings: Findings, page: Page) -> None:
    assert "measured" not in numbering(puma_findings)["appendices"]
    assert "measured" not in page.identifiers
    assert "measured-1" not in page.data["figures"]
    assert "measured" not in report_figures(puma_findings)
    assert document(puma_findings)["measured"] is None
    with pytest.raises(UsageError, match="no torque was measured"):
        puma_findings.plot.measured()


def test_what_was_not_measured_is_named_and_not_drawn(silent: Findings, tmp_path: Path) -> None:
    shown = Page(render_html(silent))
    assert "no torque was measured at joint 2" in shown.text
    assert "measured-1" in shown.data["figures"]
    assert "measured-2" not in shown.data["figures"]
    assert "friction" not in numbering(silent)["tables"]
    assert "no torque was measured at joint 2" in " ".join(read(prepare_pdf(silent)(), tmp_path).split())
    curves = torque_curves(silent, 0)
    assert curves.friction is None
    assert len(curves.points) == 480
    assert np.isfinite(curves.measured).all()
    # Points of the page count from 1.
    axis = shown.data["axes"][shown.data["figures"]["measured-1"]["axis"]]
    assert axis["point"] == (curves.points + 1).tolist()


def test_curves_break_at_gaps(silent: Findings) -> None:
    """There is a gap before set point 300; of the first joint 20 readings before it are missing."""
    figure = Page(render_html(silent)).data["figures"]["measured-1"]
    assert figure["breaks"] == [280]
    drawn = [shape.points for shape in measured_figure(silent).shapes if shape.label == "measured 1"]
    (points,) = drawn
    assert np.flatnonzero(np.isnan(points).all(axis=1)).tolist() == [280]


def test_none_measured_at_all(two_link: RobotArm) -> None:
    found = find(two_link, with_torques(recorded(two_link), np.zeros((500, 2))))
    assert set(found.tables["measured_torque"].verdict.values) == {"not measured"}
    assert not [one for one in found.warnings if "measured" in one]
    assert "measured" not in numbering(found)["appendices"]
    assert Page(render_html(found)).text


def test_forces_of_joints_that_slide(tmp_path: Path) -> None:
    path = tmp_path / "gantry.toml"
    path.write_text(SLIDING, encoding="utf-8")
    arm = read_arm(path)
    found = find(arm, recorded(arm, friction=(0.3, 0.2, 0.1), noise=0.01), Settings(fit_friction=True))
    rows = document(found)["measured"]["rows"]
    assert [row["viscous"].split(" ")[-1] for row in rows] == ["s", "s/m", "s/m"]
    assert [row["rms_difference"].split(" ", 1)[1][-1] for row in rows] == ["m", "N", "N"]
    assert found.tables["measured_torque"].viscous_unit.values.tolist() == ["N m s", "N s/m", "N s/m"]


def test_the_figure_has_two_panels_for_every_joint(measured_findings: Findings) -> None:
    canvas = measured_figure(measured_findings)
    assert len(canvas.frames) == 4
    labels = {shape.label for shape in canvas.shapes}
    for joint in (1, 2):
        assert {f"{what} {joint}" for what in ("read", "measured", "exact", "difference")} <= labels
        assert {f"{what} {joint}" for what in ("with friction", "friction")} <= labels


def test_friction_of_a_plan_is_refused_before_any_computing(puma: RobotArm, pick_and_place) -> None:
    with pytest.raises(UsageError, match="no measured torques") as caught:
        find(puma, pick_and_place, Settings(fit_friction=True))
    assert "a log that has columns" in caught.value.details["next"]
    assert Settings(fit_friction=True).unusual() == ["fit-friction"]


def test_other_numbers_do_not_depend_on_measured_torques(two_link: RobotArm) -> None:
    log = recorded(two_link, gain=3.0)
    found, plain = find(two_link, log), find(two_link, replace(log, recording=None))
    assert found.model.torques == plain.model.torques
    np.testing.assert_array_equal(found.exact_torque, plain.exact_torque)
