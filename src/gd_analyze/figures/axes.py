"""Figures of one run for a notebook, as matplotlib axes; the only module that imports matplotlib."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.figures import joints
from gd_analyze.figures.arm import arm_figure, views_figure
from gd_analyze.figures.elements import inertia_figure, vector_figure
from gd_analyze.figures.figure import ON_PAPER, Area, Cells, Figure, Panel, Words
from gd_analyze.figures.run import Run
from gd_analyze.figures.trade_off import trade_off_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_MARKERS = dict(
    zip(("circle", "square", "triangle", "down", "diamond", "cross", "star"), "os^vDx*", strict=True)
)
_LEGEND = 16.0


@dataclass(frozen=True)
class Plots:
    """Figures of what one run found.

    Each method draws the report's figure as a new figure of `matplotlib.pyplot` and gives a list of its axes,
    one per panel, row by row, in SI units (angles of the motion in degrees).
    """

    run: Run

    def __repr__(self) -> str:
        names = (name for name in vars(Plots) if not name.startswith("_") and name != "run")
        return f"Plots: {', '.join(f'{name}()' for name in names)}"

    def torque(self) -> list[Axes]:
        """Torque of every joint over time, stacked by contribution."""
        return axes_of(joints.contributions_figure(self.run))

    def errors(self) -> list[Axes]:
        """Exact and simplified torque, and the error beside the allowed one; two panels per joint."""
        return axes_of(joints.error_figure(self.run))

    def measured(self) -> list[Axes]:
        """Measured and exact torque, and the difference; two panels per measured joint."""
        if not joints.measured_joints(self.run):
            raise UsageError("no torque was measured along this trajectory", where="measured()")
        return axes_of(joints.measured_figure(self.run))

    def trade_off(self) -> list[Axes]:
        """Operations against largest error."""
        return axes_of(trade_off_figure(self.run))

    def arm(self) -> list[Axes]:
        """Poses of the arm along the motion, in an oblique view, m."""
        return axes_of(arm_figure(self.run))

    def views(self) -> list[Axes]:
        """The same along the axes of the base frame, m; a panel per view."""
        return axes_of(views_figure(self.run))

    def motion(self) -> list[Axes]:
        """Positions, velocities and accelerations; three panels per joint."""
        return axes_of(joints.motion_figure(self.run))

    def inertia(self) -> list[Axes]:
        """Elements of D by effect."""
        return axes_of(inertia_figure(self.run))

    def coriolis_centrifugal(self) -> list[Axes]:
        """Elements of h by effect."""
        return axes_of(vector_figure(self.run, "coriolis_centrifugal"))

    def gravity_loading(self) -> list[Axes]:
        """Elements of c."""
        return axes_of(vector_figure(self.run, "gravity_loading"))


def axes_of(figure: Figure) -> list[Axes]:
    """Draw a figure with matplotlib; one axes per panel, row by row."""
    from matplotlib import pyplot
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    head = _LEGEND if figure.legend else 0.0
    wide, high = figure.columns * figure.width, len(figure.rows) * figure.height + head
    drawn = pyplot.figure(figsize=(wide / 72, high / 72))
    found = []
    for r, c, panel in figure.places:
        left, bottom, right, top = panel.margins
        x, y = c * figure.width + left, high - head - (r + 1) * figure.height + bottom
        room = (figure.width - left - right, figure.height - top - bottom)
        found.append(drawn.add_axes((x / wide, y / high, room[0] / wide, room[1] / high)))
        _draw(found[-1], panel)
    handles = [
        Patch(color=ON_PAPER[key.colour], label=key.label)
        if key.kind == "area"
        else Line2D([], [], color=ON_PAPER[key.colour], linestyle=_style(key.dashes), label=key.label)
        for key in figure.legend
    ]
    if handles:
        look: dict[str, Any] = {"fontsize": 6, "frameon": False, "handlelength": 1.2, "columnspacing": 1.0}
        drawn.legend(handles=handles, loc="upper left", ncols=len(handles), **look)
    return found


def _draw(axes: Axes, panel: Panel) -> None:
    """Axes, title and items of a panel; numbers keep their own unit, labels have that of the axis."""
    from matplotlib.colors import to_rgba_array

    for name, axis in (("x", panel.x), ("y", panel.y)):
        scaled = {f"{name}scale": "log"} if axis.is_logarithmic else {}
        axes.set(**{f"{name}lim": (axis.low, axis.high)}, **scaled)
        getattr(axes, f"set_{name}ticks")(axis.ticks, axis.labels, fontsize=panel.text, minor=False)
    axes.minorticks_off()
    axes.tick_params(length=2, pad=1.5)
    axes.spines[["top", "right", "left"]].set_visible(False)
    if panel.is_bare:
        axes.set_axis_off()
    else:
        axes.grid(visible=True, axis="y", color=ON_PAPER["line"], linewidth=0.5)
    unit = f", {panel.y.unit}" if panel.y.unit and not panel.is_bare else ""
    axes.set_title(f"{panel.title}{unit}", loc="left", fontsize=panel.text + 1, pad=3)
    axes.set_title(panel.corner, loc="right", fontsize=panel.text, pad=3)
    for order, item in enumerate(panel.items, start=2):
        if isinstance(item, Cells):
            colours = to_rgba_array([ON_PAPER.get(name, "none") for name in item.colours.ravel()])
            colours[:, 3] *= item.opacity.ravel()
            rows = np.arange(len(item.colours) + 1)
            axes.pcolormesh(item.x, rows, colours.reshape(*item.colours.shape, 4), zorder=order)
            continue
        colour = ON_PAPER[item.colour]
        if isinstance(item, Area):
            axes.fill_between(item.x, item.near, item.far, color=colour, lw=0, label=item.label, zorder=order)
        elif isinstance(item, Words):
            axes.annotate(
                item.text,
                (item.x, item.y),
                (item.right, item.up),
                textcoords="offset points",
                ha={"start": "left", "middle": "center", "end": "right"}[item.anchor],
                color=colour,
                fontsize=item.size,
                annotation_clip=False,
            )
        elif not item.hidden:
            axes.plot(
                item.x,
                np.maximum(item.y, panel.y.low) if panel.y.is_logarithmic else item.y,
                color=colour,
                linewidth=item.width,
                linestyle=_style(item.dashes) if item.width else "none",
                marker=_MARKERS[item.marker] if item.marker else "o" if len(item.x) == 1 else "",
                markersize=item.size,
                markerfacecolor=ON_PAPER["paper"] if item.hollow else colour,
                alpha=item.opacity,
                label=item.label or "_",
                zorder=order,
                clip_on=False,
            )


def _style(dashes: tuple[float, ...]) -> Any:
    return (0, dashes) if dashes else "-"
