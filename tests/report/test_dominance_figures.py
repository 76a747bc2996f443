"""Elements by effect as figures and files: what they show are the numbers of the run."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.svg import panel_svg
from gd_analyze.report.main_report import JSON, main_result
from gd_analyze.results.rows import changes_text, dominance_note, element_rows
from gd_analyze.results.verdict_lists import LISTS
from recordings import swung


def test_cells_are_the_verdicts_and_tell_the_numbers(puma_findings):
    figure = dominance_figure(puma_findings)
    (panel,) = figure.panels
    cells, over_time = panel.items[0], puma_findings.tables["dominance_over_time"]
    labels = [words.split(":")[0] for words in cells.words]
    zero = ("D45", "D56")
    assert labels == [e for e in over_time.element.values if e[0] != "c" and e not in zero]
    verdicts = gd.tables.verdicts(over_time).sel(element=labels).values.T
    assert np.array_equal(np.where(cells.colours == "", "negligible", cells.colours), verdicts)
    # Beside them the verdict over the motion, as in the table of elements and the lists.
    marks = {words.y: words.text for words in panel.items[1:] if words.right == 6.0}
    rows = {row["element"]: row["verdict"] for row in element_rows(puma_findings)}
    assert [marks[k + 0.75] for k in range(len(labels))] == [LETTERS[rows[label]] for label in labels]
    listed = main_result(puma_findings, JSON).values()["verdicts"]
    assert {label: name for name in LISTS for label in listed[name]} == rows
    shares = over_time.dominance.sel(element=labels).values.swapaxes(0, 1)
    assert np.array_equal(cells.numbers[..., :2], np.rint(100 * shares))
    # By its links D66 makes 0.02 % of its torque: where its drive counts, the torque told is the drive's, in
    # three digits, which are within 0.5 %.
    (row,) = (k for k, label in enumerate(labels) if label == "D66")
    drive = np.abs(over_time.drive_torque.sel(element="D66").values)
    is_drive = cells.colours[row] == "drive"
    assert is_drive.any()
    np.testing.assert_allclose(np.abs(cells.numbers[row, is_drive, 2]), drive[is_drive], rtol=6e-3)
    drawn = ElementTree.fromstring(panel_svg(panel, figure))
    told = next(json.loads(g.get("data-cells")) for g in drawn.iter("g") if g.get("data-cells"))
    assert np.array_equal(told["numbers"], cells.numbers)
    # Cells of one look side by side are one rectangle.
    areas = "".join(path.get("d") for path in drawn.iter("path") if path.get("opacity"))
    assert len(labels) <= areas.count("M") < cells.colours.size


def test_axes_of_ones_own(puma_findings):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    _, axes = pyplot.subplots(1, 2)
    drawn = puma_findings.plot.inertia(["D12", "D15"], x="set point", effects=["combined"], ax=axes)
    assert [*drawn] == [*axes]
    assert drawn[0].get_xlabel() == "set point"
    assert drawn[0].get_ylabel().endswith("kg m²")
    assert drawn[0].get_legend() is not None
    (line,) = drawn[1].lines
    whole = puma_findings.decomposition.inertia.sum("effect").sel(joint=1, joint_j=5)
    assert np.array_equal(line.get_xydata().T, [np.arange(1, 32), whole])
    for words in ({"ax": axes[0]}, {"effects": ["drag"]}, {"x": "turns"}):
        with pytest.raises(gd.GdAnalyzeError):
            puma_findings.plot.inertia(["D12", "D15"], **words)
    assert len(puma_findings.plot.dominance()) == 1
    pyplot.close("all")


def test_the_report_says_when_and_how_surely(puma_findings):
    rows = {row["element"]: row for row in element_rows(puma_findings)}
    assert " s, drive until " in changes_text(rows["D55"])
    assert changes_text(rows["c4"]).startswith("gravity until ")
    assert changes_text(rows["D24"]) == ""
    found = gd.tables.robustness(puma_findings.arm, puma_findings.trajectory)
    assert rows["D15"]["probability"] == found.over_motion.sel(element="D15", verdict="both").item()
    assert rows["c2"]["probability"] is None
    assert "robustness" not in gd.analyze("two_link", "two-link-swing").tables
    uncertain = gd.analyze("two_link", "two-link-swing", uncertainty="mass=5%", dominance=0.2)
    assert uncertain.tables["robustness"].attrs["threshold"] == uncertain.dominance.attrs["threshold"] == 0.2


def test_gaps_between_motions_are_empty(two_link):
    motions = [swung(4.0, "slow"), swung(2.2, "fast"), swung(3.0, "last")]  # within the arm's limits
    findings = gd.analyze(two_link, motions)
    (panel,) = dominance_figure(findings).panels
    cells = panel.items[0]
    time, gaps = findings.trajectory.time, list(findings.trajectory.gaps)
    assert len(gaps) == 2
    for before, after in zip(time[np.array(gaps) - 1], time[gaps], strict=True):
        column = int(np.flatnonzero(cells.x == before)[0])
        assert cells.x[column + 1] == after
        assert (cells.colours[:, column] == "").all()
        assert (cells.colours[:, [column - 1, column + 1]] != "").any()
    assert cells.colours.shape == cells.opacity.shape == cells.numbers.shape[:2]
    assert cells.colours.shape[1] == len(cells.x) - 1
    note = dominance_note(findings)
    assert note.index("slow from 0 s") < note.index("fast from")
