from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from report_cases import made_findings, resting_findings

from gd_analyze.report.figure_arm import arm_figure, equal_panel
from gd_analyze.report.figure_elements import inertia_figure, vector_figure
from gd_analyze.report.figure_trade_off import trade_off_figure
from gd_analyze.report.figures import motion_figure, torque_figure
from gd_analyze.report.panel import MOST_POINTS, power_of_ten, tick_label, ticks, value_range
from gd_analyze.report.views import upright_frame
from gd_analyze.results import Findings
from gd_analyze.results.words import kind_name
from gd_analyze.robots import RobotArm

coriolis_figure = partial(vector_figure, quantity="coriolis_centrifugal")
gravity_figure = partial(vector_figure, quantity="gravity_loading")

MADE = {
    "one joint": lambda: made_findings(["revolute"]),
    "two kinds": lambda: made_findings(["prismatic", "revolute"]),
    "five joints": lambda: made_findings(["revolute"] * 5),
    "ten joints": lambda: made_findings(["prismatic"] * 10),
}


@pytest.fixture(scope="module", params=MADE)
def made(request: pytest.FixtureRequest) -> Findings:
    """Arms of every size; made once for all figures."""
    return MADE[request.param]()


def curves(figure: Figure) -> dict[str, np.ndarray]:
    """Labelled lines of a figure: what they show over the set points."""
    return {
        str(line.get_label()): np.asarray(line.get_ydata())
        for line in figure.get_children()
        if isinstance(line, Line2D) and line.get_label()
    }


def texts(figure: Figure) -> set[str]:
    return {text.get_text() for text in figure.texts}


def inside(figure: Figure) -> bool:
    """Every artist within the page the figure stands for, give or take a line's width."""
    width, height = figure.get_size_inches() * 72
    for line in figure.get_children():
        if isinstance(line, Line2D):
            x, y = line.get_transform().transform(np.column_stack(line.get_data())).T * (72 / figure.dpi)
            low, high = (limit(np.stack([x, y]), axis=1) for limit in (np.nanmin, np.nanmax))
            if (low < -1).any() or high[0] > width + 1 or high[1] > height + 1:
                return False
    return True


def test_inertia_figure_draws_the_decomposition(puma_findings: Findings) -> None:
    drawn = curves(inertia_figure(puma_findings))
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
                np.testing.assert_allclose(drawn[f"D{i + 1}{j + 1} {name}"], part, rtol=0, atol=2 * noise)


def test_vectors_are_drawn(puma_findings: Findings) -> None:
    dataset = puma_findings.decomposition
    h, c = curves(coriolis_figure(puma_findings)), curves(gravity_figure(puma_findings))
    noise = {
        name: 64 * np.finfo(float).eps * np.abs(dataset[name].values).max()
        for name in ("coriolis_centrifugal", "gravity_loading")
    }
    for i in range(6):
        parts = dataset.coriolis_centrifugal.values[:, :, i]
        for k, name in enumerate(("translation", "rotation")):
            np.testing.assert_allclose(
                h[f"h{i + 1} {name}"], parts[:, k], rtol=0, atol=noise["coriolis_centrifugal"]
            )
        np.testing.assert_allclose(
            c[f"c{i + 1} combined"],
            dataset.gravity_loading.values[:, i],
            rtol=0,
            atol=noise["gravity_loading"],
        )
    assert set(c) == {f"c{i + 1} combined" for i in range(6)}


def test_torque_and_error_are_drawn(puma_findings: Findings) -> None:
    drawn = curves(torque_figure(puma_findings))
    exact, simplified = puma_findings.exact_torque, puma_findings.simplified_torque
    for i in range(6):
        np.testing.assert_array_equal(drawn[f"exact {i + 1}"], exact[:, i])
        np.testing.assert_array_equal(drawn[f"simplified {i + 1}"], simplified[:, i])
        error = simplified[:, i] - exact[:, i]
        np.testing.assert_array_equal(drawn[f"error {i + 1}"], error)


def test_motion_is_drawn_in_degrees_and_metres() -> None:
    findings = made_findings(["revolute", "prismatic"])
    drawn = curves(motion_figure(findings))
    np.testing.assert_array_equal(drawn["qd1"], np.degrees(findings.trajectory.qd[:, 0]))
    np.testing.assert_array_equal(drawn["qd2"], findings.trajectory.qd[:, 1])


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
        motion_figure,
        inertia_figure,
        coriolis_figure,
        gravity_figure,
        torque_figure,
        trade_off_figure,
    ],
)
def test_nothing_is_drawn_off_the_page(make: Callable[[Findings], Figure], made: Findings) -> None:
    assert inside(make(made))


def marks(figure: Figure) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Places of the labelled lines of a figure, by label."""
    return {
        str(line.get_label()): (np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
        for line in figure.get_children()
        if isinstance(line, Line2D) and str(line.get_label())[:1].isalpha()
    }


def test_trade_off_has_one_line_per_kind_and_the_own_model(puma_findings: Findings) -> None:
    shown = marks(trade_off_figure(puma_findings))
    table = puma_findings.tables["trade_off"]
    names = {
        kind_name(level, refit) for level, refit in zip(table.level.values, table.refit.values, strict=True)
    }
    assert set(shown) == names | {"this report's model"}
    # More operations stand higher, whichever scale is chosen.
    order = np.argsort(table.operations.sel(kind="term").values, kind="stable")
    assert (np.diff(shown["term"][1][order]) >= 0).all()
    assert (np.diff(shown["term"][0]) >= 0).all()  # budgets grow, and errors with them


def test_trade_off_names_the_exact_operations(puma_findings: Findings) -> None:
    shown = texts(trade_off_figure(puma_findings))
    assert f"exact: {puma_findings.model.operations_full.total}" in shown


def test_names_of_lines_do_not_cover_each_other() -> None:
    figure = trade_off_figure(made_findings(["revolute"]))
    right = max(text.get_position()[0] for text in figure.texts)
    heights = sorted(text.get_position()[1] for text in figure.texts if text.get_position()[0] == right)
    assert len(heights) >= 6
    assert np.diff(heights).min() * figure.get_figheight() * 72 >= 8.9


def test_without_any_error_the_own_model_stands_at_the_axis(puma: RobotArm) -> None:
    own = marks(trade_off_figure(resting_findings(puma)))["this report's model"]
    assert (own[0][0], own[1][0]) == (0.0, 0.0)


def test_nothing_moves_and_nothing_weighs(puma: RobotArm) -> None:
    findings = resting_findings(puma)
    for make in (arm_figure, motion_figure, coriolis_figure, torque_figure, trade_off_figure):
        assert inside(make(findings))


def test_one_set_point_is_drawn_as_a_dot() -> None:
    figure = coriolis_figure(made_findings(["revolute"] * 2, set_points=1))
    marked = [line for line in figure.get_children() if isinstance(line, Line2D) and line.get_marker() == "o"]
    assert len(marked) == 2 * 3


def test_a_dollar_sign_is_not_mathematics(puma_findings: Findings) -> None:
    assert not any(text.get_parse_math() for text in motion_figure(puma_findings).texts)


def test_planar_arm_is_drawn_head_on(two_link: RobotArm, swing_findings: Findings) -> None:
    # Gravity of this arm is along -y: up on paper is y.
    np.testing.assert_array_equal(upright_frame(two_link)[2], [0.0, 1.0, 0.0])
    assert "from the front" in texts(arm_figure(swing_findings))
    assert "from above" not in texts(arm_figure(swing_findings))


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
    drawn = curves(inertia_figure(findings))["D11 combined"]
    assert len(drawn) <= MOST_POINTS


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
    assert power_of_ten((-2e-5, 1e-5)) == -5
    assert power_of_ten((0.0, 40.0)) == 0
    assert tick_label(-0.30000000000000004) == "−0.3"
