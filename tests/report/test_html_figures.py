"""What the page draws: every figure's data are the results."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from page_reader import Page
from report_arms import swing

from gd_analyze.dynamics.dominance import elements
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.beyond_chart import beyond_chart
from gd_analyze.report.document import document
from gd_analyze.report.figures import motion_figure
from gd_analyze.report.html import render_html
from gd_analyze.report.interactive import DIGITS, MOST_FRAMES, MOST_POINTS, NEAR, page_data
from gd_analyze.results.contributions import Contributions
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import dropped_parts, joint_rows
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.find import find
from gd_analyze.studies.settings_main import Settings

MOTION = ("q", "qd", "qdd")


def test_every_figure_is_placed_and_has_data(puma_findings: Findings, page: Page) -> None:
    placed = Counter(a["data-figure"] for a in page.all("div") if "data-figure" in a)
    figures = page.data["figures"]
    assert placed.keys() == figures.keys()
    n = puma_findings.arm.n_joints
    assert {element.label for element in elements(n)} <= placed.keys()
    assert all(a["aria-label"] for a in page.all("div") if "data-figure" in a)


def test_curves_are_the_decomposition(puma_findings: Findings, page: Page) -> None:
    dataset = puma_findings.decomposition
    # Six significant digits are kept; what the ranking calls zero is drawn as zero.
    tolerance = 0.5 * 10.0 ** (1 - DIGITS)
    for element in elements(puma_findings.arm.n_joints):
        parts = element.parts(dataset)
        traces = {
            trace["role"]: np.array(trace["y"]) for trace in page.data["figures"][element.label]["traces"]
        }
        scale = np.abs(dataset[element.quantity].values).max()
        noise = 64 * np.finfo(float).eps * scale
        np.testing.assert_allclose(traces["combined"], parts.sum(axis=0), rtol=tolerance, atol=2 * noise)
        if element.quantity != "gravity_loading":
            np.testing.assert_allclose(traces["translation"], parts[0], rtol=tolerance, atol=noise)
            np.testing.assert_allclose(traces["rotation"], parts[1], rtol=tolerance, atol=noise)
        if element.quantity == "coriolis_centrifugal":
            whole = traces["centrifugal"] + traces["coriolis"]
            # Two addends, each rounded to six digits of its own size.
            largest = np.abs(traces["centrifugal"]).max() + np.abs(traces["coriolis"]).max()
            np.testing.assert_allclose(whole, traces["combined"], atol=3 * tolerance * largest)


def test_sliding_joints_have_their_units(arms: dict[str, RobotArm]) -> None:
    arm = arms["sliding"]
    page = Page(render_html(find(arm, swing(arm))))
    figures = page.data["figures"]
    units = {label: figures[label]["unit"] for label in ("D11", "D12", "D23", "h1", "h2", "c3", "error-3")}
    assert units == {
        "D11": "kg m²",
        "D12": "kg m",
        "D23": "kg",
        "h1": "N m",
        "h2": "N",
        "c3": "N",
        "error-3": "N",
    }
    assert {"q-revolute", "q-prismatic"} <= figures.keys()
    assert figures["qd-prismatic"]["unit"] == "m/s"
    # A shared scale must not mix units.
    by_scale: dict[str, set[str]] = {}
    for figure in figures.values():
        by_scale.setdefault(figure.get("scale", ""), set()).add(figure["unit"])
    assert all(len(found) == 1 for scale, found in by_scale.items() if scale)


@pytest.mark.parametrize("count", [1, 2, 21])
@pytest.mark.parametrize("which", ["one joint", "sliding", "puma560"])
def test_any_arm_and_length(arms: dict[str, RobotArm], which: str, count: int) -> None:
    arm = arms.get(which) or load_arm(which)
    page = Page(render_html(find(arm, swing(arm, count))))
    assert len(page.data["axes"]["all"]["point"]) == count
    assert page.data["viewer"]["at"][-1] == count
    assert len(page.data["viewer"]["points"][0]) == 2 * arm.n_joints + 1
    assert page.text.count("NaN") == page.text.count("nan ") == 0


def test_an_arm_without_torque(arms: dict[str, RobotArm]) -> None:
    arm = replace(arms["one joint"], gravity=np.zeros(3))
    still = np.zeros((3, 1))
    page = Page(render_html(find(arm, Trajectory(np.arange(3.0), still, still, still))))
    assert all(y == 0 for trace in page.data["figures"]["torque-1"]["traces"] for y in trace["y"])
    assert "∞" not in page.text


def test_more_than_nine_joints() -> None:
    small = load_arm("two_link")
    arm = replace(small, name="chain", joints=small.joints * 5, links=small.links * 5, dh_table=(), drives=())
    findings = find(arm, swing(arm, 3), Settings(level="element"))
    # Terms of ten joints are too many to be told one by one, and it is said so.
    assert "chain has 10 joints: elements are ranked, single terms are not" in findings.warnings
    source = render_html(findings)
    assert "D1,10" in Page(source).data["figures"]
    assert "<mn>1,10</mn>" in source


def test_long_trajectories_are_thinned_and_say_so(arms: dict[str, RobotArm]) -> None:
    arm = arms["one joint"]
    count = 20_000
    findings = find(arm, swing(arm, count))
    page = Page(render_html(findings))
    for name, figure in page.data["figures"].items():
        if name == "trade-off":
            continue
        axis = page.data["axes"][figure["axis"]]
        assert len(axis["point"]) == len(axis["time"]) <= MOST_POINTS
        assert axis["point"][0] == 1
        assert axis["point"][-1] == count
        for trace in figure["traces"]:
            assert len(trace["y"]) == len(axis["point"])
    assert len(page.data["viewer"]["at"]) == MOST_FRAMES
    assert f"thinned to at most {MOST_POINTS}" in page.text
    drawn = np.array(page.data["figures"]["c1"]["traces"][0]["y"])
    exact = findings.decomposition.gravity_loading.values[:, 0]
    # Only rounding to six digits stands between the drawn and the true extremes.
    assert drawn.max() == pytest.approx(exact.max(), rel=10.0 ** (1 - DIGITS))
    assert drawn.min() == pytest.approx(exact.min(), rel=10.0 ** (1 - DIGITS))


def test_the_trade_off_is_drawn_and_tabled(puma_findings: Findings, page: Page) -> None:
    figure = page.data["figures"]["trade-off"]
    table = puma_findings.tables["trade_off"]
    points = {(row["kind"], row["budget"]): row for row in rows_of(table, "kind", "factor")}
    drawn = 0
    for trace in figure["traces"]:
        for x, y, budget in zip(trace["x"], trace["y"], trace["budget"], strict=True):
            point = points[trace["role"].replace("-", " "), budget]
            assert y == point["operations"]
            # Drawn with six digits.
            assert x == pytest.approx(100 * point["largest_share"], rel=10.0 ** (1 - DIGITS))
            drawn += 1
    assert drawn == len(points)
    assert figure["model"]["y"] == puma_findings.model.operations.total
    assert figure["exact"] == puma_findings.model.operations_full.total
    assert len([a for a in page.all("tr") if a.get("class") == "asked"]) == 1


def test_marks_beyond_the_trajectory_are_in_order(puma_findings: Findings) -> None:
    rows = joint_rows(puma_findings, "simplified_model", "beyond")
    chart = beyond_chart(rows)
    for mark, row in zip(chart["marks"], rows, strict=True):
        places = {place: row[name] for name, place in mark.items() if name != "uncertainty"}
        places[chart["budget"]] = row["allowed_error"]
        assert list(dict(sorted(places.items()))) == sorted(places, key=places.__getitem__)
        assert all(0.0 <= place <= 100.0 for place in places)


def test_page_data_is_json(puma_findings: Findings) -> None:
    data = page_data(puma_findings)
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_a_part_is_zero_where_the_ranking_says_so(puma_findings: Findings, source: str, page: Page) -> None:
    """One criterion for headline, figures, page and PDF."""
    dominance, parts = puma_findings.dominance, puma_findings.tables["parts"]
    zero = {
        f"{label} {effect}"
        for label, peaks in zip(dominance.element.values, dominance.part_peak.values, strict=True)
        for effect, peak in zip(dominance.effect.values, peaks, strict=True)
        if peak == 0.0
    }
    dropped = dropped_parts(puma_findings)
    told = {row["part"] if " " in row["part"] else f"{row['part']} translation" for row in dropped.zero}
    # Gravity has no rotational part, so none is dropped; a part that is kept is not told to be zero.
    assert told <= zero
    kept = {label for label, is_kept in zip(parts.part.values, parts.kept.values, strict=True) if is_kept}
    assert {name for name in zero - told if not name.startswith("c")} <= kept
    assert f"{len(dropped.zero)} parts are zero" in page.text
    shown = document(puma_findings)["elements"]
    assert [len(shown[name]) for name in ("costing", "zero", "idle")] == [*map(len, dropped)]
    for name in zero:
        element, _, effect = name.partition(" ")
        traces = {trace["role"]: trace["y"] for trace in page.data["figures"][element]["traces"]}
        assert not any(traces.get(effect, ()))


def test_angles_are_in_degrees_on_every_motion_plot(arms: dict[str, RobotArm]) -> None:
    arm = arms["sliding"]
    findings = find(arm, swing(arm))
    figures = page_data(findings)["figures"]
    units = [figures[f"{name}-{kind}"]["unit"] for kind in ("revolute", "prismatic") for name in MOTION]
    assert units == ["deg", "deg/s", "deg/s²", "m", "m/s", "m/s²"]
    for name in MOTION:
        drawn = figures[f"{name}-revolute"]["traces"][0]["y"]
        exact = np.degrees(getattr(findings.trajectory, name)[:, 0])
        np.testing.assert_allclose(drawn, exact, rtol=10.0 ** (1 - DIGITS))
    said = {text.text for text in motion_figure(findings).texts}
    assert {"position q, deg or m", "rate q̇, deg/s or m/s", "acceleration q̈, deg/s² or m/s²"} <= said


def test_torques_pile_up_from_what_makes_them(puma_findings: Findings, page: Page) -> None:
    made = Contributions.of(puma_findings)
    for i, joint in enumerate(puma_findings.arm.joints):
        figure = page.data["figures"][f"pile-{i + 1}"]
        *parts, total = figure["traces"]
        assert [trace["role"] for trace in parts] == list(made.parts)
        assert total["role"] == "total"
        assert figure["unit"] == joint.effort_unit
        # Each addend and the total have six digits of their own size.
        largest = sum(np.abs(trace["y"]).max() for trace in (*parts, total))
        np.testing.assert_allclose(
            np.sum([trace["y"] for trace in parts], axis=0), total["y"], atol=10.0 ** (1 - DIGITS) * largest
        )
        near = made.limit[i] < NEAR * np.abs(made.total[:, i]).max()
        assert (figure["limit"] is not None) == near


def test_time_is_in_seconds(puma_findings: Findings, page: Page) -> None:
    axis = page.data["axes"]["all"]
    np.testing.assert_allclose(axis["time"], puma_findings.trajectory.time, rtol=10.0 ** (1 - DIGITS))


def test_the_arm_is_drawn_in_axes_that_point_up(puma_findings: Findings, two_link: RobotArm) -> None:
    viewer = page_data(puma_findings)["viewer"]
    assert viewer["flat"] is None
    np.testing.assert_allclose(viewer["axes"], np.eye(3), atol=1e-12)
    planar = page_data(find(two_link, swing(two_link)))["viewer"]
    points = np.array(planar["points"])
    # Gravity acts along -y there: up is y, and the arm never leaves the plane of x and y.
    assert np.array(planar["axes"])[1].tolist() == [0.0, 0.0, 1.0]
    assert np.ptp(points[..., planar["flat"]]) == 0.0
