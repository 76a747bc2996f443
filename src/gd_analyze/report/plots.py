"""The report's figures for a notebook: each as matplotlib Axes, with Axes over every panel to draw on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gd_analyze.errors import UsageError
from gd_analyze.report.figure_arm import arm_figure, views_figure
from gd_analyze.report.figure_contributions import contributions_figure
from gd_analyze.report.figure_elements import inertia_figure, vector_figure
from gd_analyze.report.figure_trade_off import trade_off_figure
from gd_analyze.report.figures import measured_figure, motion_figure, torque_figure
from gd_analyze.results.torque_curves import measured_joints
from gd_analyze.results.words import CONTRIBUTIONS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gd_analyze.report.canvas import Canvas
    from gd_analyze.results.findings import Findings

# Room for a legend, pt.
_LEGEND = 26.0


@dataclass(frozen=True)
class Plots:
    """Figures of what one run found; each method gives Axes in a new figure of `matplotlib.pyplot`.

    The coordinates of these are points of the drawing. Their `child_axes` lie over the panels, row by row,
    and have the coordinates of the numbers in SI units, so that curves of one's own can be drawn beside.
    """

    findings: Findings

    def __repr__(self) -> str:
        names = (name for name in vars(Plots) if not name.startswith("_") and name != "findings")
        return f"Plots: {', '.join(f'{name}()' for name in names)}"

    def torque(self) -> Axes:
        """Torque of every joint over time, stacked by what makes it; a panel per joint."""
        axes = _axes(contributions_figure(self.findings), head=_LEGEND)
        # An area is called by its part and its joint; the report names the parts above its figure.
        areas = {str(patch.get_label()).rpartition(" ")[0]: patch for patch in axes.patches}
        named = [(areas[part], words) for part, words in CONTRIBUTIONS.items() if part in areas]
        handles, words = zip(*named, strict=True) if named else ((), ())
        axes.legend(
            handles,
            words,
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=len(words) or 1,
            fontsize=7,
            frameon=False,
            handlelength=1.2,
            columnspacing=1.2,
        )
        return axes

    def errors(self) -> Axes:
        """Exact and simplified torque and the error beside what is allowed; two panels per joint."""
        return _axes(torque_figure(self.findings))

    def measured(self) -> Axes:
        """Measured and exact torque and the difference; two panels per joint that was measured.

        Raises
        ------
        UsageError
            If no torque was measured.
        """
        if not measured_joints(self.findings):
            raise UsageError("no torque was measured along this trajectory", where="measured()")
        return _axes(measured_figure(self.findings))

    def trade_off(self) -> Axes:
        """Operations against largest error."""
        return _axes(trade_off_figure(self.findings))

    def arm(self) -> Axes:
        """Poses of the arm along the motion."""
        return _axes(arm_figure(self.findings))

    def views(self) -> Axes:
        """The same seen along the axes, m; a panel per view."""
        return _axes(views_figure(self.findings))

    def motion(self) -> Axes:
        """Positions, rates and accelerations; three columns of a panel per joint."""
        return _axes(motion_figure(self.findings))

    def inertia(self) -> Axes:
        """Elements of D by effect; a panel per element."""
        return _axes(inertia_figure(self.findings))

    def coriolis_centrifugal(self) -> Axes:
        """Elements of h by effect; a panel per joint."""
        return _axes(vector_figure(self.findings, "coriolis_centrifugal"))

    def gravity_loading(self) -> Axes:
        """Elements of c; a panel per joint."""
        return _axes(vector_figure(self.findings, "gravity_loading"))


def _axes(canvas: Canvas, head: float = 0.0) -> Axes:
    """Draw on a figure that a notebook shows, with some pt left above, and lay Axes over the panels."""
    from matplotlib import pyplot

    height = canvas.height + head
    axes = canvas.axes(pyplot.figure(figsize=(canvas.width / 72, height / 72)))
    axes.set_position((0.0, 0.0, 1.0, canvas.height / height))
    for frame in canvas.frames:
        over = axes.inset_axes(frame.box, transform=axes.transData, xlim=frame.x, ylim=frame.y)
        over.set_axis_off()
    return axes
