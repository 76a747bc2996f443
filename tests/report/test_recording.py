"""A measured motion in results, reports and terminal: what was read, what is left of its noise, and gaps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from page_reader import Page
from pdf_reader import read

from gd_analyze.errors import StoreError
from gd_analyze.motions.logged import ColumnUse, Logged
from gd_analyze.motions.measured import motion_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.document import document
from gd_analyze.report.figures import motion_figure, recording_figure
from gd_analyze.report.html import render_html
from gd_analyze.report.interactive import page_data
from gd_analyze.report.pdf import prepare_pdf
from gd_analyze.report.reading_curves import ReadingCurves
from gd_analyze.results.findings import Findings
from gd_analyze.results.fit import require_tables_fit
from gd_analyze.results.recording_words import noise_rows, recording_told
from gd_analyze.results.store import load_findings, save_results
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.find import find
from recordings import Motion

DEVIATION = 1e-3
COLUMNS = (
    ColumnUse("Time", "time", unit="s", why="by name"),
    ColumnUse("actual_q_0", "q", "1", "rad", "by number"),
    ColumnUse("actual_q_1", "q", "2", "rad", "by number"),
    ColumnUse("<b>temp</b>", "unused", why="no quantity of a joint"),
)


def recording(deviation: float = DEVIATION, still: bool = False) -> Logged:
    """Two stretches of readings at 125 Hz; the second joint at rest where asked for."""
    time = np.concatenate([np.arange(400), np.arange(400) + 600]) / 125
    q = Motion.of(1).at(time)
    if still:
        q[:, 1] = 0.5
    q += deviation * np.random.default_rng(3).normal(size=q.shape)
    return Logged(time, q, None, None, None, measured=True, columns=COLUMNS, name="log", origin="made")


@pytest.fixture(scope="module")
def recorded(two_link: RobotArm) -> Findings:
    return find(two_link, motion_of(recording(), two_link))


@pytest.fixture(scope="module")
def page(recorded: Findings) -> Page:
    return Page(render_html(recorded))


def test_results_give_the_motion_back_with_gaps_and_readings(recorded: Findings, tmp_path: Path) -> None:
    path = tmp_path / "analysis.h5"
    save_results(recorded, path)
    again, motion = load_findings(path), recorded.trajectory
    assert again.trajectory.gaps == motion.gaps == (400,)
    assert again.trajectory.fingerprint == motion.fingerprint
    before, after = motion.recording, again.trajectory.recording
    assert before is not None
    assert after is not None
    np.testing.assert_array_equal(after.q, before.q)
    for name in ("cutoff", "noise_q", "noise_qdd"):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    assert after.columns == COLUMNS
    assert after.treatment == before.treatment
    assert recording_told(again) == recording_told(recorded)
    assert document(again) == document(recorded)


@pytest.mark.parametrize("begins", [[2, 401], [1, 401, 401], [1, 801], [1, 900]])
def test_stretches_that_cannot_be_are_refused(recorded: Findings, begins: list[int]) -> None:
    motion = recorded.tables["trajectory"].drop_vars("stretch_from")
    wrong = motion.assign(stretch_from=("stretch", np.array(begins)))
    with pytest.raises(StoreError, match="stretch_from of trajectory is not where stretches begin"):
        require_tables_fit({**recorded.tables, "trajectory": wrong}, recorded.arm)


def test_torque_noise_is_what_random_noise_makes(recorded: Findings) -> None:
    """Noise drawn for the accelerations, through D at all set points: its RMS is the one stated."""
    table, dataset = recorded.tables["recording"], recorded.decomposition
    noise = np.random.default_rng(4).normal(size=(800, 2)) * table.noise_qdd.values
    torque = np.einsum("tij,tj->ti", dataset.inertia.values.sum(axis=1), noise)
    # 800 draws tell a standard deviation within 4 / sqrt(1600) = 10 %.
    np.testing.assert_allclose(np.sqrt((torque**2).mean(axis=0)), table.torque_noise, rtol=0.1)


def test_noise_is_told_beside_the_budget(recorded: Findings) -> None:
    rows, told = noise_rows(recorded), " ".join(recording_told(recorded))
    worst = max(rows, key=lambda row: row["of_allowed"])
    assert worst["of_allowed"] == worst["torque_noise"] / worst["allowed"]
    assert told.startswith("This is a recording, not a plan: accelerations from the measured positions")
    assert f"of torque at joint {worst['joint']}" in told
    assert ("models for such a budget follow the noise" in told) == (worst["of_allowed"] > 1.0)


def test_elements_of_a_joint_at_rest_are_told_to_be_noise(two_link: RobotArm) -> None:
    findings = find(two_link, motion_of(recording(still=True), two_link))
    table = findings.tables["recording"]
    noisy = table.element.values[table.within_noise.values].tolist()
    # The second joint's acceleration is noise alone, and D22 is with no other.
    assert "D22" in noisy
    assert "D11" not in noisy
    assert not {"c1", "c2", "h1", "h2"} & set(noisy)
    assert any("how they rank is not told by this recording" in told for told in recording_told(findings))


def test_a_plan_has_nothing_of_this(swing_findings: Findings) -> None:
    assert recording_told(swing_findings) == []
    assert document(swing_findings)["recording"] is None
    page = Page(render_html(swing_findings))
    assert "recording" not in page.identifiers
    assert "Readings behind the motion" not in page.text


def test_the_page_shows_readings_and_columns(recorded: Findings, page: Page) -> None:
    assert "recording" in page.identifiers
    for told in recording_told(recorded):
        assert told in page.text
    assert "actual_q_0" in page.text
    # Names in a log are text, not markup.
    assert "<b>temp</b> (no quantity of a joint)" in page.text
    figures = page.data["figures"]
    for joint in (1, 2):
        assert [trace["role"] for trace in figures[f"reading-{joint}"]["traces"]] == ["reading", "smooth"]
        assert figures[f"residue-{joint}"]["unit"] == "deg"


def test_curves_of_the_page_break_at_gaps(recorded: Findings, page: Page) -> None:
    data = page_data(recorded)
    time = data["axes"]["all"]["time"]
    for name in ("q-revolute", "torque-1", "pile-1", "D11", "reading-1"):
        assert data["figures"][name]["breaks"] == [400], name
    assert time[400] - time[399] > 1.0
    viewer = data["viewer"]
    (place,) = viewer["breaks"]
    assert len(viewer["path"]) == 600
    assert place == 300
    plain = find(recorded.arm, replace(recorded.trajectory, gaps=(), recording=None))
    assert "breaks" not in page_data(plain)["figures"]["q-revolute"]


def test_lines_on_paper_break_at_gaps(recorded: Findings) -> None:
    lines = [shape for shape in motion_figure(recorded).shapes if shape.label.startswith("q")]
    assert len(lines) == 6
    for line in lines:
        assert np.isnan(line.points).any(axis=1).sum() == 1


def test_the_figure_shows_every_joint_and_the_paper_the_table(recorded: Findings, tmp_path: Path) -> None:
    labels = {shape.label for shape in recording_figure(recorded).shapes}
    assert {f"{what} {k}" for what in ("readings", "smoothed", "difference") for k in (1, 2)} <= labels
    paper = " ".join(read(prepare_pdf(recorded)(), tmp_path).split())
    assert "Readings behind the motion" in paper
    assert "This is a recording, not a plan" in paper
    assert "actual_q_1" in paper


def test_the_difference_is_the_noise_that_was_added(recorded: Findings) -> None:
    curves = ReadingCurves.of(recorded, 0)
    assert len(curves.near) >= 40
    assert curves.near.max() < 400 or curves.near.min() >= 400
    # Some hundred readings, of which the smoothing took nearly all noise.
    assert np.degrees(DEVIATION) == pytest.approx(curves.difference.std(), rel=0.3)


def test_a_single_set_point_between_gaps_is_drawn(two_link: RobotArm, swing: Trajectory) -> None:
    torn = replace(swing, gaps=(5, 6))
    findings = find(two_link, torn)
    assert render_html(findings)
    assert findings.tables["tube"].attrs["note"].startswith("The motion has 2 gaps")
