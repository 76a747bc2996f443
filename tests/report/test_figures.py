"""Figures: what they describe are the numbers of the run, and what is drawn can be read back."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gd_analyze.figures.arm import arm_figure, playable, skeleton, upright_frame, views_figure
from gd_analyze.figures.elements import inertia_figure, vector_figure
from gd_analyze.figures.figure import (
    Area,
    Axis,
    Curve,
    Figure,
    Panel,
    broken,
    hatching,
    short_joint_label,
    ticks,
    value_axis,
)
from gd_analyze.figures.joints import (
    Contributions,
    contributions_figure,
    error_figure,
    measured_figure,
    most_accelerated,
    motion_figure,
    recording_figure,
)
from gd_analyze.figures.reach import reach_figure
from gd_analyze.figures.svg import UNITS_PER_POINT, figure_svg, panel_svg, without_straights
from gd_analyze.types import Findings, Joint


def corners(path: str) -> list[np.ndarray]:
    """Corners of a path of M, L and l, in units of the drawing, run by run."""
    runs: list[list[list[float]]] = []
    how, at, pending = "", [0.0, 0.0], None
    for word in re.findall(r"[a-zA-Z]|-?\d+", path):
        if word.isalpha():
            how = word
        elif pending is None:
            pending = float(word)
        else:
            at = [at[0] + pending, at[1] + float(word)] if how == "l" else [pending, float(word)]
            if how == "M":
                runs.append([])
            runs[-1].append(at)
            pending = None
    return [np.array(run) for run in runs]


def read_back(panel: Panel, figure: Figure, label: str) -> list[np.ndarray]:
    """Points of a curve of a drawing in the numbers of its axes."""
    found = re.search(rf'data-label="{label}"[^>]* d="([^"]*)"', panel_svg(panel, figure))
    assert found
    left, bottom, right, top = panel.margins
    wide, high = figure.width - left - right, figure.height - top - bottom
    out = []
    for run in corners(found[1]):
        x = panel.x.low + (run[:, 0] / UNITS_PER_POINT - left) / wide * (panel.x.high - panel.x.low)
        y = panel.y.high - (run[:, 1] / UNITS_PER_POINT - top) / high * (panel.y.high - panel.y.low)
        out.append(np.stack([x, y], axis=-1))
    return out


def test_drawn_curves_are_the_torques(puma_findings: Findings) -> None:
    figure, time = error_figure(puma_findings), puma_findings.trajectory.time
    assert [panel.key for panel in figure.panels[:2]] == ["torque1", "error1"]
    for i, panel in enumerate(figure.panels[::2]):
        for label, torque in (
            ("exact", puma_findings.exact_torque),
            ("simplified", puma_findings.simplified_torque),
        ):
            (points,) = read_back(panel, figure, label)
            # Coordinates are rounded to 1/20 pt and points within 1/25 pt of a line left out, in six rounds.
            near = 0.3 / (figure.height - 25) * (panel.y.high - panel.y.low)
            drawn = np.interp(time, points[:, 0], points[:, 1])
            np.testing.assert_allclose(drawn, torque[:, i], rtol=0, atol=near)


def test_stacked_parts_end_at_the_torque(puma_findings: Findings) -> None:
    figure, parts = contributions_figure(puma_findings), Contributions.of(puma_findings)
    assert len(figure.panels) == 6
    for i, panel in enumerate(figure.panels):
        areas = [item for item in panel.items if isinstance(item, Area)]
        total = sum(area.far - area.near for area in areas)
        scale = np.abs(parts.total[:, i]).max()
        # Sums of six parts, each as large as the torque or somewhat larger.
        np.testing.assert_allclose(total, parts.total[:, i], atol=1e-12 * scale)
        low, high = panel.y.low, panel.y.high
        assert all(low <= area.far.min() and area.far.max() <= high for area in areas)


def test_elements_are_split_by_effect(puma_findings: Findings) -> None:
    figure = inertia_figure(puma_findings)
    pairs = [(i, j) for i in range(1, 7) for j in range(i, 7)]
    assert [panel.key for panel in figure.panels] == [f"D{i}{j}" for i, j in pairs]
    for panel in (*figure.panels, *vector_figure(puma_findings, "coriolis_centrifugal").panels):
        curves = {item.label: item for item in panel.items if isinstance(item, Curve) and item.label}
        both = curves["translation"].y + curves["rotation"].y
        np.testing.assert_allclose(both, curves["combined"].y, atol=1e-12 * np.abs(both).max())
        if "coriolis" in curves:
            shares = curves["centrifugal"].y + curves["coriolis"].y
            np.testing.assert_allclose(shares, both, atol=1e-9 * max(np.abs(both).max(), 1e-12))
            assert curves["coriolis"].hidden


@pytest.mark.parametrize(
    "make", [arm_figure, views_figure, motion_figure, reach_figure, contributions_figure]
)
def test_a_drawing_is_well_formed_and_of_whole_numbers(
    puma_findings: Findings, make: Callable[[Findings], Figure]
) -> None:
    from xml.etree import ElementTree

    svg = figure_svg(make(puma_findings))
    ElementTree.fromstring(svg)
    assert not re.findall(r' d="[^"]*[.e]', svg)
    assert "nan" not in svg
    assert len(svg) < 60_000


def test_the_arm_that_plays_is_where_the_drawing_has_it(puma_findings: Findings) -> None:
    played, figure = playable(puma_findings), arm_figure(puma_findings)
    arm, motion = puma_findings.arm, puma_findings.trajectory
    last = skeleton(arm, motion.q[-1:])[0] @ upright_frame(arm).T
    np.testing.assert_allclose(played["poses"][-1], last, atol=1e-4)
    a, e = np.radians([played["azimuth"], played["elevation"]])
    right, up = [-np.sin(a), np.cos(a), 0], [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
    (panel,) = figure.panels
    for item in panel.items:
        if isinstance(item, Curve) and item.space is not None:
            np.testing.assert_allclose(item.space @ right, item.x, atol=1e-12, equal_nan=True)
            np.testing.assert_allclose(item.space @ up, item.y, atol=1e-12, equal_nan=True)


def test_lines_break_where_nothing_is_known() -> None:
    time = broken(np.arange(6.0), [2, 4])
    panel = Panel("p", "", Axis(0.0, 5.0), Axis(0.0, 1.0), (Curve(time, time / 5, label="a"),))
    figure = Figure("f", ((panel,),), 200.0, 100.0)
    assert [len(run) for run in read_back(panel, figure, "a")] == [2, 2, 2]


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 50.0), min_size=2, max_size=60))
def test_points_left_out_lie_on_the_line(values: list[float]) -> None:
    points = np.stack([np.arange(len(values), dtype=float), values], axis=-1)
    left = without_straights(points)
    drawn = np.interp(points[:, 0], left[:, 0], left[:, 1])
    # Six rounds of 1/25 pt, along a slope of at most 50.
    distance = np.abs(drawn - points[:, 1]) / np.hypot(1.0, np.gradient(points[:, 1]))
    assert distance.max() <= 6 * 0.04 * 2


def test_long_curves_keep_their_extremes() -> None:
    rng = np.random.default_rng(3)
    y = np.sin(np.linspace(0, 30, 40_000))
    y[rng.integers(0, 40_000, 3)] = [5.0, -4.0, 3.0]
    axis = value_axis("", y)
    panel = Panel("p", "", Axis(0.0, 40_000.0), axis, (Curve(np.arange(40_000.0), y, label="a"),))
    (points,) = read_back(panel, Figure("f", ((panel,),), 400.0, 200.0), "a")
    assert len(points) < 1500
    near = 0.1 / 170 * (axis.high - axis.low)
    np.testing.assert_allclose([points[:, 1].max(), points[:, 1].min()], [5.0, -4.0], atol=near)


@settings(max_examples=60, deadline=None)
@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 6))
def test_ticks_are_few_round_and_inside(low: float, width: float, most: int) -> None:
    found = ticks(low, low + width, most)
    # Two at least, as one tells no scale: of steps 2.5 times apart, the smaller then has five at most.
    assert 2 <= len(found) <= max(most + 1, 5)
    assert all(low - 1e-6 * width <= tick <= low + (1 + 1e-6) * width for tick in found)


def test_readings_are_drawn_where_the_joint_accelerates_most(recorded: Findings) -> None:
    motion = recorded.trajectory
    for joint in range(recorded.arm.n_joints):
        drawn = most_accelerated(motion, joint)
        assert int(np.abs(motion.qdd[:, joint]).argmax()) in drawn
    assert len(recording_figure(recorded).panels) == 2 * recorded.arm.n_joints


def test_measured_torque_is_what_the_table_has(measured_findings: Findings) -> None:
    table = measured_findings.tables["measured_torque"]
    curves = {item.label: item.y for item in measured_figure(measured_findings).panels[0].items}
    known = np.isfinite(table.filtered.values[:, 0])
    for label, torque in (("measured", table.filtered.values), ("exact", measured_findings.exact_torque)):
        drawn = curves[label][np.isfinite(curves[label])]
        np.testing.assert_array_equal(drawn, torque[known, 0])


def test_a_long_name_keeps_the_end_that_tells_the_joint_apart() -> None:
    panda = [Joint(f"panda_joint{k}", "revolute") for k in range(1, 8)]
    assert short_joint_label(panda, 6, 100.0) == "7 joint7"
    assert short_joint_label(panda, 6, 28.0) == "7 joint7"
    ur = [Joint(f"shoulder_{k}_joint", "revolute") for k in ("pan", "lift")]
    ur.append(Joint("elbow_joint", "revolute"))
    assert short_joint_label(ur, 1, 50.0) == "2 …ulder_lift…"
    assert short_joint_label([Joint("1", "revolute")], 0, 50.0) == "1"


def test_hatching_stays_inside_its_area() -> None:
    x = np.linspace(3.0, 90.0, 40)
    near, far = np.sin(x / 7.0), 15.0 + 9.0 * np.cos(x / 11.0)
    for slope, rise in (("/", 1.0), ("-", 0.0), ("\\", -1.0)):
        ends = hatching(x, near, far, slope)
        assert len(ends) > 5
        across, upward = ends[..., 0], ends[..., 1]
        # Coordinates up to 90, lines of a few operations.
        assert np.allclose(np.diff(upward), rise * np.diff(across), rtol=0.0, atol=1e-12)
        assert np.all((upward >= np.interp(across, x, near)) & (upward <= np.interp(across, x, far)))
    upright = hatching(x, near, far, "|")
    assert np.array_equal(upright[:, 0, 0], upright[:, 1, 0])
    assert len(hatching(x, near, far, "/\\")) == sum(len(hatching(x, near, far, one)) for one in "/\\")
    assert hatching(x, near, near, "/").size == 0
