"""Figures of one run for a notebook, as matplotlib axes; the only module that imports matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from gd_analyze.arguments import several
from gd_analyze.arrays import runs
from gd_analyze.errors import UsageError
from gd_analyze.figures import joints
from gd_analyze.figures.arm import arm_figure, views_figure
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.elements import MOST_MARKED_SET_POINTS, Look, inertia_figure, vector_figure
from gd_analyze.figures.figure import CELL_HEIGHT, ON_PAPER, Area, Cells, Figure, FigureWords, Panel
from gd_analyze.figures.run import Elements, Run
from gd_analyze.figures.structure import matrix_figure, shares_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Given: TypeAlias = Axes | Sequence[Axes] | None

_MARKERS = dict(zip(("circle", "square", "triangle", "diamond", "cross", "star"), "os^Dx*", strict=True))
# Heights of the legend and of the space below all panels, pt.
_LEGEND = 16.0
_FOOT = 8.0


@dataclass(frozen=True, repr=False)
class ElementPlots:
    """Figures of the elements of a decomposition.

    Each method draws a new figure of `matplotlib.pyplot`, or on given axes, and returns a list of its axes,
    one per element, row by row, in SI units.
    """

    run: Elements

    def __repr__(self) -> str:
        methods = (f"{name}()" for name in dir(self) if not name.startswith("_") and name != "run")
        return f"{type(self).__name__}: {', '.join(methods)}"

    def inertia(self, elements: str | Sequence[str] = (), *, ax: Given = None, **look: Any) -> list[Axes]:
        """Elements of D by effect.

        Parameters
        ----------
        elements
            A label, such as "D12", or several; by default the whole upper triangle.
        ax
            Axes to draw on, one per element, in place of a new figure.
        look
            `x`, "time" (default) or "set point"; `effects`, of "translation", "rotation" and "combined";
            `marked`, whether set points are marked, by default if there are up to 50.

        Raises
        ------
        UsageError
            If an element or effect is unknown, or the number of axes is wrong.
        """
        return axes_of(inertia_figure(self.run, self._look(elements, look)), ax)

    def coriolis_centrifugal(
        self, elements: str | Sequence[str] = (), *, ax: Given = None, **look: Any
    ) -> list[Axes]:
        """Elements of h by effect; arguments as for `inertia`, effects also "centrifugal" and "coriolis"."""
        return axes_of(vector_figure(self.run, "coriolis_centrifugal", self._look(elements, look)), ax)

    def gravity_loading(
        self, elements: str | Sequence[str] = (), *, ax: Given = None, **look: Any
    ) -> list[Axes]:
        """Elements of c; arguments as for `inertia`."""
        return axes_of(vector_figure(self.run, "gravity_loading", self._look(elements, look)), ax)

    def _look(self, elements: str | Sequence[str], look: Mapping[str, Any]) -> Look:
        is_short = len(self.run.time) <= MOST_MARKED_SET_POINTS
        fields: dict[str, Any] = {"elements": elements, "marked": is_short, **look}
        for name in {"elements", "effects"} & fields.keys():
            fields[name] = several(fields[name])
        return Look(**fields)


@dataclass(frozen=True, repr=False)
class Plots(ElementPlots):
    """Figures of one run.

    Each method draws the report's figure as a new figure of `matplotlib.pyplot` and returns a list of its
    axes, one per panel, row by row, in SI units (angles of the motion in degrees).
    """

    run: Run

    def torque(self) -> list[Axes]:
        """Torque of every joint over time, stacked by contribution."""
        return axes_of(joints.contributions_figure(self.run))

    def errors(self) -> list[Axes]:
        """Exact and simplified torque, and the error with the allowed one; two panels per joint."""
        return axes_of(joints.error_figure(self.run))

    def measured(self) -> list[Axes]:
        """Measured and exact torque, and the difference; two panels per measured joint."""
        if not joints.measured_joints(self.run):
            raise UsageError("no torque was measured along this trajectory", where="measured()")
        return axes_of(joints.measured_figure(self.run))

    def arm(self) -> list[Axes]:
        """Poses of the arm along the motion, in an oblique view, m."""
        return axes_of(arm_figure(self.run))

    def views(self) -> list[Axes]:
        """Poses along the axes of the base frame, m; a panel per view."""
        return axes_of(views_figure(self.run))

    def motion(self) -> list[Axes]:
        """Positions, velocities and accelerations; three panels per joint."""
        return axes_of(joints.motion_figure(self.run))

    def dominance(self, ax: Axes | None = None) -> list[Axes]:
        """Dominant effect of each element at every set point, the largest torque first; one axes."""
        return axes_of(dominance_figure(self.run), ax)

    def structure(self) -> list[Axes]:
        """Elements of D, h and c in their places, by share of the joint's peak torque; one axes each."""
        return axes_of(matrix_figure(self.run))

    def shares(self) -> list[Axes]:
        """What makes each joint's torque, as shares of the sum of RMS; one axes per joint."""
        return axes_of(shares_figure(self.run))


def axes_of(figure: Figure, ax: Given = None) -> list[Axes]:
    """Draw a figure with matplotlib, on given or new axes; one per panel, row by row."""
    from matplotlib import pyplot
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=ON_PAPER[key.colour], label=key.label, **_hatched(key.hatching))
        if key.kind == "area"
        else Line2D(
            [],
            [],
            color=ON_PAPER[key.colour],
            linestyle=_style(key.dashes),
            marker=_MARKERS[key.marker] if key.marker else "",
            markersize=3,
            label=key.label,
        )
        for key in figure.legend
    ]
    if ax is not None:
        all_axes = list(np.ravel(np.asarray(ax, dtype=object)))
        if len(all_axes) != len(figure.panels):
            expected, count = f"{len(figure.panels)} axes, one per element", str(len(all_axes))
            raise UsageError("the axes do not fit the figure", where="ax", expected=expected, found=count)
        for axes, panel in zip(all_axes, figure.panels, strict=True):
            _draw(axes, panel)
            axes.set(
                xlabel="time, s" if panel.x.unit == "s" else panel.x.unit,
                ylabel=f"{panel.title}, {panel.y.unit}",
            )
            axes.legend(handles=handles, fontsize=6, frameon=False)
        return all_axes
    head = _LEGEND if figure.legend else 0.0
    wide, high = figure.columns * figure.width, len(figure.rows) * figure.height + head + _FOOT
    drawn = pyplot.figure(figsize=(wide / 72, high / 72))
    all_axes = []
    for r, c, panel in figure.places:
        left, bottom, right, top = panel.margins
        x, y = c * figure.width + left, high - head - (r + 1) * figure.height + bottom
        below = [row[c] for row in figure.rows[r + 1 : r + 2] if c < len(row)]
        room = (figure.width - left - right, figure.height - top - bottom)
        all_axes.append(drawn.add_axes((x / wide, y / high, room[0] / wide, room[1] / high)))
        _draw(all_axes[-1], panel)
        if below in ([], [None]):
            all_axes[-1].set_xlabel(_abscissa(panel), fontsize=panel.text, labelpad=1.0)
    if handles:
        look: dict[str, Any] = {"fontsize": 6, "frameon": False, "handlelength": 1.2, "columnspacing": 1.0}
        drawn.legend(handles=handles, loc="upper left", ncols=len(handles), **look)
    return all_axes


def _abscissa(panel: Panel) -> str:
    return "time, s" if panel.x.unit == "s" else panel.x.unit


def _draw(axes: Axes, panel: Panel) -> None:
    """Axes, title and items of a panel; numbers keep their unit, labels have that of the axis."""
    from matplotlib.colors import to_rgba, to_rgba_array

    for name, axis in (("x", panel.x), ("y", panel.y)):
        scaled = {f"{name}scale": "log"} if axis.is_logarithmic else {}
        axes.set(**{f"{name}lim": (axis.low, axis.high)}, **scaled)
        getattr(axes, f"set_{name}ticks")(axis.ticks, axis.labels, fontsize=panel.text, minor=False)
    axes.minorticks_off()
    axes.tick_params(length=2, pad=1.5)
    if panel.x.dashes:
        axes.set_xticks(panel.x.dashes, minor=True)
        axes.tick_params(axis="x", which="minor", length=1.2)
    axes.spines[["top", "right", "left"]].set_visible(False)
    if panel.is_bare:
        axes.set_axis_off()
    elif not panel.y.names:
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
            # Rows are low: fainter and fewer lines leave their shades to be told apart.
            pale = to_rgba(ON_PAPER["paper"], 0.6)
            for name, slopes in item.hatching.items():
                for row, has_colour in enumerate(item.colours == name):
                    ends = item.x[runs(has_colour)]
                    spans = [(left, right - left) for left, right in ends.tolist()]
                    bars = axes.broken_barh(spans, (row, CELL_HEIGHT), zorder=order, facecolor="none")
                    bars.set(linewidth=0, hatch=2 * slopes, edgecolor=pale)
            continue
        colour = ON_PAPER[item.colour]
        if isinstance(item, Area):
            look = {"facecolor": colour, "lw": 0, **_hatched(item.hatching)}
            axes.fill_between(item.x, item.near, item.far, label=item.label, zorder=order, **look)
        elif isinstance(item, FigureWords):
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
                item.y,
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


def _hatched(slopes: str) -> dict[str, Any]:
    return {"hatch": 3 * slopes, "edgecolor": ON_PAPER["paper"]} if slopes else {}


def _style(dashes: tuple[float, ...]) -> Any:
    return (0, dashes) if dashes else "-"
