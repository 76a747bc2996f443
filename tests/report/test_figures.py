from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from report_cases import made_findings, resting_findings

from gd_analyze.report.canvas import Canvas
from gd_analyze.report.colours import ON_PAPER
from gd_analyze.report.figure_arm import arm_figure, equal_panel, views_figure
from gd_analyze.report.figure_contributions import contributions_figure
from gd_analyze.report.figure_elements import inertia_figure, vector_figure
from gd_analyze.report.figure_trade_off import trade_off_figure
from gd_analyze.report.figures import motion_figure, torque_figure
from gd_analyze.report.panel import MOST_POINTS, Panel, Scale, tick_label, ticks, value_range
from gd_analyze.report.views import upright_frame
from gd_analyze.results.findings import Findings
from gd_analyze.results.words import kind_name
from gd_analyze.robots.arm import RobotArm

coriolis_figure = partial(vector_figure, quantity="coriolis_centrifugal")
gravity_figure = partial(vector_figure, quantity="gravity_loading")

MADE = {
    "one joint": lambda: made_findings(["revolute"]),
    "two kinds": lambda: made_findings(["prismatic", "revolute"]),
    "five joints": lambda: made_findings(["revolute"] * 5, level="element"),
    "ten joints": lambda: made_findings(["prismatic"] * 10),
}


@pytest.fixture(scope="module", params=MADE)
def made(request: pytest.FixtureRequest) -> Findings:
    """Arms of every size; made once for all figures."""
    return MADE[request.param]()


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Values that the panels of figures made since have put on paper, by the label of the curve."""
    placed: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    curves: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    place, line = Panel.place, Canvas.line

    def noted(panel: Panel, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        points = place(panel, x, y)
        placed[id(points)] = (x, y)
        kept.append(points)
        return points

    def labelled(canvas: Canvas, points: np.ndarray, *look: object, label: str = "", **more: object) -> None:
        if label:
            curves[label] = placed[id(points)]
        line(canvas, points, *look, label=label, **more)

    kept: list[np.ndarray] = []
    monkeypatch.setattr(Panel, "place", noted)
    monkeypatch.setattr(Canvas, "line", labelled)
    return curves


def texts(figure: Canvas) -> set[str]:
    return {text.text for text in figure.texts}


def inside(figure: Canvas) -> bool:
    """Whether every shape, give or take a line's width, and every text's place are within the figure."""
    every = np.concatenate([shape.points for shape in figure.shapes])
    places = np.array([[text.x, text.y] for text in figure.texts]).reshape(-1, 2)
    return all(
        ((points >= -1).all() and (points <= (figure.width + 1, figure.height + 1)).all())
        for points in (every, places)
    )


Drawn = dict[str, tuple[np.ndarray, np.ndarray]]


def test_inertia_figure_draws_the_decomposition_over_time(puma_findings: Findings, drawn: Drawn) -> None:
    inertia_figure(puma_findings)
    inertia = puma_findings.decomposition.inertia.values
    # What the ranking calls zero is drawn as zero.
    noise = 64 * np.finfo(float).eps * np.abs(inertia).max()
    assert len(drawn) == 3 * 21
    for i in range(6):
        for j in range(i, 6):
            translation, rotation = inertia[:, 0, i, j], inertia[:, 1, i, j]
            for name, part in (
                ("translation", translation),
                ("rotation", rotation),
                ("combined", translation + rotation),
            ):
                time, values = drawn[f"D{i + 1}{j + 1} {name}"]
                np.testing.assert_array_equal(time, puma_findings.trajectory.time)
                np.testing.assert_allclose(values, part, rtol=0, atol=2 * noise)


def test_vectors_are_drawn(puma_findings: Findings, drawn: Drawn) -> None:
    dataset = puma_findings.decomposition
    coriolis_figure(puma_findings)
    gravity_figure(puma_findings)
    noise = {
        name: 64 * np.finfo(float).eps * np.abs(dataset[name].values).max()
        for name in ("coriolis_centrifugal", "gravity_loading")
    }
    for i in range(6):
        parts = dataset.coriolis_centrifugal.values[:, :, i]
        for k, name in enumerate(("translation", "rotation")):
            np.testing.assert_allclose(
                drawn[f"h{i + 1} {name}"][1], parts[:, k], rtol=0, atol=noise["coriolis_centrifugal"]
            )
        np.testing.assert_allclose(
            drawn[f"c{i + 1} combined"][1],
            dataset.gravity_loading.values[:, i],
            rtol=0,
            atol=noise["gravity_loading"],
        )
    assert {name for name in drawn if name[0] == "c"} == {f"c{i + 1} combined" for i in range(6)}


def test_torque_and_error_are_drawn(puma_findings: Findings, drawn: Drawn) -> None:
    torque_figure(puma_findings)
    exact, simplified = puma_findings.exact_torque, puma_findings.simplified_torque
    for i in range(6):
        np.testing.assert_array_equal(drawn[f"exact {i + 1}"][1], exact[:, i])
        np.testing.assert_array_equal(drawn[f"simplified {i + 1}"][1], simplified[:, i])
        error = simplified[:, i] - exact[:, i]
        np.testing.assert_array_equal(drawn[f"error {i + 1}"][1], error)


def test_motion_is_drawn_in_degrees_and_metres(drawn: Drawn) -> None:
    findings = made_findings(["revolute", "prismatic"])
    motion_figure(findings)
    np.testing.assert_array_equal(drawn["qd1"][1], np.degrees(findings.trajectory.qd[:, 0]))
    np.testing.assert_array_equal(drawn["qd2"][1], findings.trajectory.qd[:, 1])


def test_names_above_a_panel_do_not_meet_its_letters() -> None:
    """Columns of a force and an angle have long units: they are written as small as the room is."""
    figure = inertia_figure(made_findings(["revolute", "revolute", "prismatic"] * 2, level="element"))
    letters = {text.y: text for text in figure.texts if text.text == "T+R" and text.anchor == "end"}
    assert letters
    for text in figure.texts:
        if "kg" in text.text or text.text.startswith(("g", "mg")):
            ends = [one for one in figure.texts if one.y == text.y and one.anchor == "end" and one.x > text.x]
            nearest = min(ends, key=lambda one: one.x)
            # Half an em for each sign of the unit, two thirds for the capitals.
            begins = nearest.x - 0.67 * nearest.size * len(nearest.text)
            assert text.x + 0.5 * text.size * len(text.text) <= begins


def test_panels_name_element_and_verdict(puma_findings: Findings) -> None:
    figure = inertia_figure(puma_findings)
    shown = texts(figure)
    assert {"D₁₁", "D₃₆", "D₆₆"} <= shown
    verdicts = {str(v) for v in puma_findings.dominance.dominant.values}
    short = {"translation": "T", "rotation": "R", "both": "T+R", "neither": "0"}
    assert {short[v] for v in verdicts} <= shown


@pytest.mark.parametrize(
    "make",
    [
        arm_figure,
        views_figure,
        motion_figure,
        inertia_figure,
        coriolis_figure,
        gravity_figure,
        torque_figure,
        trade_off_figure,
    ],
)
def test_nothing_is_drawn_off_the_page(make: Callable[[Findings], Canvas], made: Findings) -> None:
    assert inside(make(made))


def marks(figure: Canvas) -> dict[str, np.ndarray]:
    """Places of the labelled shapes of a figure, by label, pt."""
    return {shape.label: shape.points for shape in figure.shapes if shape.label}


def test_trade_off_has_one_line_per_kind_and_the_own_model(puma_findings: Findings) -> None:
    shown = marks(trade_off_figure(puma_findings))
    table = puma_findings.tables["trade_off"]
    names = {
        kind_name(level, refit) for level, refit in zip(table.level.values, table.refit.values, strict=True)
    }
    assert set(shown) == names | {"this report's model"}
    # More operations stand higher, whichever scale is chosen.
    order = np.argsort(table.operations.sel(kind="term").values, kind="stable")
    assert (np.diff(shown["term"][order, 1]) >= 0).all()
    assert (np.diff(shown["term"][:, 0]) >= 0).all()  # budgets grow, and errors with them


def test_trade_off_names_the_exact_operations(puma_findings: Findings) -> None:
    shown = texts(trade_off_figure(puma_findings))
    assert f"exact: {puma_findings.model.operations_full.total}" in shown


def test_names_of_lines_do_not_cover_each_other() -> None:
    figure = trade_off_figure(made_findings(["revolute"]))
    right = max(text.x for text in figure.texts)
    heights = sorted(text.y for text in figure.texts if text.x == right)
    assert len(heights) >= 6
    # Names are 9 pt apart; a sum may be a rounding less.
    assert np.diff(heights).min() >= 9 - 1e-9


def test_without_any_error_the_own_model_stands_at_the_axis(puma: RobotArm) -> None:
    figure = trade_off_figure(resting_findings(puma))
    (own,) = marks(figure)["this report's model"]
    left, bottom = next(shape.points.min(axis=0) for shape in figure.shapes if shape.order == 1.0)
    assert own.tolist() == [left, bottom]


def test_nothing_moves_and_nothing_weighs(puma: RobotArm) -> None:
    findings = resting_findings(puma)
    for make in (arm_figure, views_figure, motion_figure, coriolis_figure, torque_figure, trade_off_figure):
        assert inside(make(findings))


def test_one_set_point_is_drawn_as_a_dot() -> None:
    figure = coriolis_figure(made_findings(["revolute"] * 2, set_points=1))
    marked = [shape for shape in figure.shapes if shape.label]
    assert len(marked) == 2 * 3
    assert {shape.kind for shape in marked} == {"marks"}


def test_a_drawing_is_text_and_colours_as_given() -> None:
    canvas = Canvas(10.0, 10.0)
    canvas.line(np.array([[0.0, 0.0], [1.0, 2.0]]), "accent")
    canvas.text(1.0, 1.0, "a < b & c $d$")
    svg = canvas.svg()
    assert f"stroke: {ON_PAPER['accent'].lower()}" in svg
    assert "M 0 10 \nL 1 8 \n" in svg  # SVG counts downward
    assert ">a &lt; b &amp; c $d$</text>" in svg
    assert "Libertinus" in svg
    assert "clip-path" not in svg


def test_a_drawing_fills_axes_of_its_size() -> None:
    canvas = Canvas(72.0, 36.0)
    canvas.mark(np.array([[4.0, 7.0]]), "ink", 2.0, label="here")
    axes = canvas.axes()
    figure = axes.get_figure()
    assert figure is not None
    assert figure.get_size_inches().tolist() == [1.0, 0.5]
    (mark,) = [line for line in axes.lines if line.get_label() == "here"]
    np.testing.assert_allclose(axes.transData.transform(mark.get_xydata()), [[4.0, 7.0]], rtol=1e-12)


def test_planar_arm_is_drawn_head_on(two_link: RobotArm, swing_findings: Findings) -> None:
    # Gravity of this arm is along -y: up on paper is y.
    np.testing.assert_array_equal(upright_frame(two_link)[2], [0.0, 1.0, 0.0])
    assert "from the front" in texts(views_figure(swing_findings))
    assert "from above" not in texts(views_figure(swing_findings))


@given(arrays(float, (7, 2), elements=st.floats(-5, 5)))
def test_lengths_are_to_scale(points: np.ndarray) -> None:
    panel = equal_panel(points, (10.0, 20.0, 200.0, 80.0))
    scales = (200.0 / (panel.x[1] - panel.x[0]), 80.0 / (panel.y[1] - panel.y[0]))
    # The range is a middle plus and minus a half, of magnitudes up to 5: cancellation leaves eps * 5 over
    # a range of at least 1e-9 * 80 / 200.
    assert scales[0] == pytest.approx(scales[1], rel=1e-5)
    assert panel.x[0] <= points[:, 0].min()
    assert points[:, 1].max() <= panel.y[1]


def test_long_curves_are_thinned() -> None:
    findings = made_findings(["revolute"], set_points=20_000)
    assert len(marks(inertia_figure(findings))["D11 combined"]) <= MOST_POINTS


@given(arrays(float, 5, elements=st.floats(-1e12, 1e12)))
def test_ranges_hold_their_values_and_ticks_are_inside(values: np.ndarray) -> None:
    low, high = value_range(values)
    assert low < high
    assert low <= min(0.0, values.min())
    assert max(0.0, values.max()) <= high
    # Ticks may stand on the end itself, which is computed with another rounding.
    slack = 1e-9 * (high - low)
    assert all(low - slack <= tick <= high + slack for tick in ticks((low, high)))
    assert len(ticks((low, high))) <= 5


def test_labels_of_ticks_stay_short() -> None:
    assert Scale.of((-2e-5, 1e-5), "N m") == Scale(1e-6, "µN m")
    assert Scale.of((-2e-5, 1e-5), "N m").label(-1e-5) == "−10"
    assert Scale.of((0.0, 40.0), "kg m^2") == Scale(1.0, "kg m²")
    assert tick_label(-0.30000000000000004) == "−0.3"


def test_warnings_on_the_first_page_leave_less_room_for_the_torques(puma_findings: Findings) -> None:
    warned = replace(puma_findings, warnings=("A warning of some length. " * 8,) * 2)
    assert contributions_figure(warned).height < contributions_figure(puma_findings).height
    many = replace(puma_findings, warnings=("A warning of some length. " * 8,) * 40)
    assert contributions_figure(many).height > 100.0
