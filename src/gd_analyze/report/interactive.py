"""What the page draws: every figure as plain values that the page's script turns into lines and areas.

A figure names what its curves are (their role), never how they look: colours follow the page's theme, and
the abscissa, the scale and the curves shown follow its switches.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.dominance import elements
from gd_analyze.figures.arm import flat_normal, skeleton, upright_frame
from gd_analyze.figures.colours import OF_LEVEL
from gd_analyze.figures.elements import _rank as rank_of
from gd_analyze.figures.elements import element_curves
from gd_analyze.figures.motion import Readings as ReadingCurves
from gd_analyze.figures.motion import degrees, motion_unit
from gd_analyze.figures.torques import CONTRIBUTIONS, Contributions, measured_joints, torque_curves
from gd_analyze.figures.trade_off import kind_name
from gd_analyze.report.thinning import breaks, evenly, thinned
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.recording_words import is_recorded
from gd_analyze.text import pretty

# A panel is some hundred pixels wide, so more points than this cannot be told apart.
MOST_POINTS = 1500
MOST_FRAMES = 240
MOST_PATH = 600
# Six digits are more than a reading of a curve can use, and round-off on a constant does not show as a curve.
DIGITS = 6
# A torque limit is drawn where it lies below so many times the peak; farther out it would flatten the curves.
NEAR = 1.6
# Torques this far below the largest are what is left of sums that cancel.
ROUND_OFF = 1e-14


def page_data(findings: Findings) -> dict[str, Any]:
    """Collect all figures of a report.

    Returns
    -------
    dict
        `axes`: set point numbers (from 1) and times in s by name; `figures`: by identifier, each with its
        axis, unit and traces, and "trade-off" with its own abscissas; `viewer`: the arm's motion. Only JSON
        values.
    """
    drawing = _Drawing(findings.trajectory.time, findings.trajectory.gaps)
    _add_elements(drawing, findings)
    _add_motion(drawing, findings)
    _add_torques(drawing, findings)
    _add_piles(drawing, findings)
    if is_recorded(findings):
        _add_readings(drawing, findings)
    _add_measured(drawing, findings)
    figures = drawing.figures
    if not summary.nothing_to_trade(findings):
        figures["trade-off"] = _trade_off(findings)
    return {"axes": drawing.axes, "figures": figures, "viewer": _viewer(findings)}


class _Drawing:
    """Collects figures and the abscissas they share."""

    def __init__(self, time: FloatArray, gaps: tuple[int, ...]) -> None:
        self.time, self.gaps = time, gaps
        self.axes: dict[str, dict[str, list[float]]] = {}
        self.figures: dict[str, dict[str, Any]] = {}

    def add(
        self,
        identifier: str,
        unit: str,
        curves: dict[str, Array],
        points: NDArray[np.intp] | None = None,
        **more: Any,
    ) -> None:
        """Add one figure; `curves` by role, or by "role: label", over all set points or those given."""
        values = np.array(list(curves.values()))
        chosen = thinned(values, MOST_POINTS)
        axis = "all" if len(chosen) == len(self.time) else identifier
        at = chosen if points is None else points[chosen]
        if cuts := breaks(at, self.gaps).tolist():
            more["breaks"] = cuts
        if axis not in self.axes:
            self.axes[axis] = {"point": (at + 1).tolist(), "time": _rounded(self.time[at])}
        traces = []
        for role, curve in zip(curves, values, strict=True):
            kind, _, label = role.partition(": ")
            traces.append({"role": kind, "label": label or kind, "y": _rounded(curve[chosen])})
        self.figures[identifier] = {"axis": axis, "unit": pretty(unit), "traces": traces, **more}


def _add_elements(drawing: _Drawing, findings: Findings) -> None:
    for element in elements(findings.arm.n_joints):
        unit = str(findings.dominance.unit.values[rank_of(findings, element)])
        # From zero, so that the parts can be weighed against each other by eye.
        curves = element_curves(findings, element)
        scale = f"{element.quantity}, {unit}"
        drawing.add(element.label, unit, curves, findings.drawn[0], scale=scale, zero=True)


def _add_motion(drawing: _Drawing, findings: Findings) -> None:
    arm, trajectory = findings.arm, findings.trajectory
    for kind in dict.fromkeys(joint.kind for joint in arm.joints):
        joints = [(i, joint) for i, joint in enumerate(arm.joints) if joint.kind == kind]
        for name in ("q", "qd", "qdd"):
            curves = {
                f"joint-{i + 1}: {i + 1} {joint.name}": degrees(getattr(trajectory, name)[:, i], joint)
                for i, joint in joints
            }
            drawing.add(f"{name}-{kind}", motion_unit(joints[0][1], name), curves)


def _add_torques(drawing: _Drawing, findings: Findings) -> None:
    table = findings.tables["simplified_model"]
    for i, joint in enumerate(findings.arm.joints):
        curves = {"exact": findings.exact_torque[:, i], "simplified": findings.simplified_torque[:, i]}
        drawing.add(f"torque-{i + 1}", joint.effort_unit, curves)
        error, band = table.torque_error.values[:, i], float(table.allowed_error[i])
        drawing.add(f"error-{i + 1}", joint.effort_unit, {"error": error}, band=band, zero=True)


def _add_piles(drawing: _Drawing, findings: Findings) -> None:
    """Torque by what makes it, a panel per joint."""
    made = Contributions.of(findings)
    for i, joint in enumerate(findings.arm.joints):
        curves = {f"{name}: {CONTRIBUTIONS[name]}": part[:, i] for name, part in made.parts.items()}
        near = made.limit[i] < NEAR * np.abs(made.total[:, i]).max(initial=0.0)
        drawing.add(
            f"pile-{i + 1}",
            joint.effort_unit,
            curves | {"total: torque": made.total[:, i]},
            findings.drawn[0],
            kind="pile",
            limit=float(made.limit[i]) if near else None,
            zero=True,
        )


def _add_readings(drawing: _Drawing, findings: Findings) -> None:
    for i, joint in enumerate(findings.arm.joints):
        drawn, unit = ReadingCurves.of(findings, i), motion_unit(joint, "q")
        both = {"reading: readings": drawn.read, "smooth: smoothed": drawn.smooth}
        drawing.add(f"reading-{i + 1}", unit, both)
        drawing.add(f"residue-{i + 1}", unit, {"residue": drawn.difference}, drawn.near, zero=True)


def _add_measured(drawing: _Drawing, findings: Findings) -> None:
    """Measured and exact torque of every joint that was measured, and what is between them."""
    for i in measured_joints(findings):
        made, unit = torque_curves(findings, i), findings.arm.joints[i].effort_unit
        torque = {"read: as read": made.read, "measured": made.measured, "model: exact": made.exact}
        between = {"measured: measured − exact": made.difference}
        if made.friction is not None:
            torque["friction: exact and friction"] = made.exact + made.friction
            between["friction: friction and offset"] = made.friction
        drawing.add(f"measured-{i + 1}", unit, torque, made.points)
        drawing.add(f"difference-{i + 1}", unit, between, made.points, zero=True)


def _trade_off(findings: Findings) -> dict[str, Any]:
    """Operations against error in percent: a curve for every kind, this report's model, the exact one."""
    model, table = findings.model, findings.tables["trade_off"]
    traces = []
    for k, (level, refit) in enumerate(zip(table.level.values, table.refit.values, strict=True)):
        colour, mark = OF_LEVEL[level]
        traces.append(
            {
                "role": f"{level}-refit" if refit else str(level),
                "label": kind_name(level, refit),
                "colour": colour,
                "mark": mark,
                "refit": bool(refit),
                "x": _rounded(100 * table.largest_share.values[k]),
                "y": table.operations.values[k].tolist(),
                "budget": table.budget.values.tolist(),
            }
        )
    shares, whole = model.accuracy.shares, model.accuracy.whole
    path = findings.tables["budgets"]
    errors = path.largest_error.values
    errors = np.divide(errors, whole, out=np.zeros_like(errors), where=whole > 0)
    return {
        "kind": "trade-off",
        "unit": "operations",
        "shares_of": model.accuracy.asked.shares_of,
        "traces": traces,
        "exact": model.operations_full.total,
        "path": {"x": _rounded(100 * errors.max(axis=1)), "y": path.operations.values.tolist()},
        "model": {
            "label": f"this report: {kind_name(model.level.name, model.refitted)}",
            # A joint that needs no torque at all has no peak to take a share of.
            "x": max(_rounded(100 * shares[np.isfinite(shares)]), default=0.0),
            "y": model.operations.total,
            "budget": model.accuracy.budget,
        },
    }


def _viewer(findings: Findings) -> dict[str, Any]:
    """Skeleton of the arm at evenly spaced set points and the hand's path, in axes whose third points up."""
    arm = findings.arm
    count = findings.trajectory.n_set_points
    frames = evenly(count, MOST_FRAMES)
    q, torque = findings.trajectory.q, findings.exact_torque
    torque = np.where(np.abs(torque) > ROUND_OFF * np.abs(torque).max(), torque, 0.0)
    frame = upright_frame(arm)
    posed = skeleton(arm, q[frames]) @ frame.T
    places = evenly(count, MOST_PATH)
    path = skeleton(arm, q[places])[:, -1] @ frame.T
    return {
        "at": (frames + 1).tolist(),
        "time": _rounded(findings.trajectory.time[frames]),
        "points": np.round(posed, 4).tolist(),
        "path": np.round(path, 4).tolist(),
        "breaks": breaks(places, findings.trajectory.gaps).tolist(),
        "axes": np.round(frame.T, 5).tolist(),
        "flat": flat_normal(np.concatenate([posed.reshape(-1, 3), path])),
        "q": [_rounded(row) for row in q[frames]],
        "torque": [_rounded(row) for row in torque[frames]],
        "joints": [
            {"name": joint.name, "kind": joint.kind, "effort": joint.effort_unit} for joint in arm.joints
        ],
    }


def _rounded(values: Array) -> list[float]:
    """Round to `DIGITS` significant digits."""
    values = np.asarray(values, dtype=float)
    magnitude = np.floor(np.log10(np.abs(values), out=np.zeros_like(values), where=values != 0))
    scale = 10.0 ** np.clip(DIGITS - 1 - magnitude, -300, 300)
    rounded = np.round(values * scale) / scale
    out: list[float] = rounded.tolist()
    return out
