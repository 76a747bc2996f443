"""Plots of a notebook are the report's figures."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes

from gd_analyze.report.figure_contributions import contributions_figure
from gd_analyze.report.figures import torque_figure
from gd_analyze.report.plots import Plots

NAMES = [name for name in vars(Plots) if not name.startswith("_") and name != "findings"]


@pytest.fixture(autouse=True)
def figures_closed():
    yield
    pyplot.close("all")


@pytest.mark.parametrize("name", NAMES)
def test_every_plot_gives_axes_that_can_be_drawn(measured_findings, name, tmp_path):
    axes = getattr(measured_findings.plot, name)()
    assert isinstance(axes, Axes)
    assert axes.figure in map(pyplot.figure, pyplot.get_fignums()), "a notebook shows it"
    axes.figure.savefig(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 5000
    assert axes.lines or axes.patches or axes.collections or axes.artists


def test_what_there_is_can_be_seen(swing_findings):
    assert repr(swing_findings.plot) == f"Plots: {', '.join(f'{name}()' for name in NAMES)}"
    assert {"torque", "errors", "trade_off", "arm"} <= set(NAMES)


def test_it_is_the_reports_drawing(swing_findings):
    for name, canvas in (
        ("torque", contributions_figure(swing_findings)),
        ("errors", torque_figure(swing_findings)),
    ):
        axes = getattr(swing_findings.plot, name)()
        drawn = {artist.get_label() for artist in axes.get_children()}
        assert {shape.label for shape in canvas.shapes if shape.label} <= drawn
        assert {text.text for text in canvas.texts} <= {text.get_text() for text in axes.texts}


def test_panels_have_the_coordinates_of_the_numbers(swing_findings):
    """A curve drawn over a panel lies on the report's own."""
    time, torque = swing_findings.trajectory.time, swing_findings.exact_torque
    axes = swing_findings.plot.errors()
    over = [child for child in axes.child_axes if child.get_xlim() == (time[0], time[-1])]
    assert len(over) == len(axes.child_axes) == 2 * swing_findings.arm.n_joints
    axes.figure.canvas.draw()
    (own,) = (line for line in axes.lines if line.get_label() == "exact 1")
    (beside,) = over[0].plot(time, torque[:, 0])
    pixels = [line.get_transform().transform(line.get_xydata()) for line in (own, beside)]
    # Placed in points, and again by matplotlib: some roundings of thousands of pixels.
    np.testing.assert_allclose(*pixels, rtol=0, atol=1e-6)


def test_torque_of_every_joint_has_a_panel(puma_findings):
    axes = puma_findings.plot.torque()
    assert len(axes.child_axes) == 6
    for child, peak in zip(axes.child_axes, np.abs(puma_findings.exact_torque).max(axis=0), strict=True):
        low, high = child.get_ylim()
        assert max(-low, high) >= peak


def test_what_torque_is_made_of_is_named(puma_findings, swing_findings):
    """Drives only where they act; inside the figure, so that a saved one has it."""
    for findings, with_drives in ((puma_findings, True), (swing_findings, False)):
        axes = findings.plot.torque()
        legend = axes.get_legend()
        words = [text.get_text() for text in legend.get_texts()]
        assert words[0] == "gravity"
        assert ("drives" in words) == with_drives
        axes.figure.canvas.draw()
        box, page = legend.get_window_extent(), axes.figure.bbox
        assert page.x0 <= box.x0 < box.x1 <= page.x1
        assert page.y0 <= box.y0 < box.y1 <= page.y1
