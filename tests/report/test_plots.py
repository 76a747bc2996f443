"""Plots of a notebook have the curves of the report, in the units of the numbers."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import pyplot

from gd_analyze.errors import UsageError
from gd_analyze.figures.axes import Plots

NAMES = [name for name in dir(Plots) if not name.startswith("_") and name != "run"]


@pytest.fixture(autouse=True)
def figures_closed():
    yield
    pyplot.close("all")


@pytest.mark.parametrize("name", NAMES)
def test_every_plot_gives_axes_that_can_be_drawn(measured_findings, name, tmp_path):
    axes = getattr(measured_findings.plot, name)()
    assert f"{name}()" in repr(measured_findings.plot)
    axes[0].figure.savefig(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 5000
    assert all(ax.lines or ax.collections for ax in axes)


def test_axes_have_the_numbers_of_the_run(swing_findings, puma_findings):
    axes = swing_findings.plot.errors()
    assert len(axes) == 2 * swing_findings.arm.n_joints
    (exact,) = (line for line in axes[0].lines if line.get_label() == "exact")
    np.testing.assert_array_equal(exact.get_ydata(), swing_findings.exact_torque[:, 0])
    axes = puma_findings.plot.torque()
    assert len(axes) == puma_findings.arm.n_joints
    for ax, peak in zip(axes, np.abs(puma_findings.exact_torque).max(axis=0), strict=True):
        assert max(np.abs(ax.get_ylim())) >= peak
    words = [text.get_text() for text in axes[0].figure.legends[0].get_texts()]
    assert {"gravity", "drives"} <= {*words}


def test_cells_are_hatched_as_their_legend_says(puma_findings):
    """A verdict is told by its hatching where colours look alike."""
    (axes,) = puma_findings.plot.dominance()
    keys = {text.get_text(): patch.get_hatch() for patch, text in legend_of(axes.figure)}
    in_legend = {name: set(keys[name]) for name in ("rotation", "both", "drive")}
    hatched = [{*collection.get_hatch()} for collection in axes.collections if collection.get_hatch()]
    assert all(signs in hatched for signs in in_legend.values())
    assert keys["translation"] is None


def legend_of(figure):
    legend = figure.legends[0]
    return zip(legend.legend_handles, legend.get_texts(), strict=True)


def test_measured_torque_that_there_is_not(puma_findings):
    with pytest.raises(UsageError, match="measured"):
        puma_findings.plot.measured()
