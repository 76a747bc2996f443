"""What the page draws: every figure as plain values that the page's script turns into Plotly calls.

A figure names what its curves are (their role), never how they look: colours follow the page's theme, and
the abscissa, the scale and the curves shown follow its switches.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.elements import elements
from gd_analyze.findings import Findings
from gd_analyze.formulations.generalized_dalembert import EFFECTS
from gd_analyze.report.motion import motion
from gd_analyze.report.thinning import thinned
from gd_analyze.formatting import inertia_unit, pretty
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array, FloatArray

if TYPE_CHECKING:
    import xarray as xr

# A panel is some hundred pixels wide, so more points than this cannot be told apart.
MOST_POINTS = 1500
MOST_FRAMES = 240
# Six digits are more than a reading of a curve can use, and round-off on a constant does not show as a curve.
DIGITS = 6
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
    dataset = findings.decomposition
    drawing = _Drawing(findings.trajectory.time)
    _add_elements(drawing, findings)
    _add_motion(drawing, findings.arm, dataset)
    _add_torques(drawing, findings)
    figures = {**drawing.figures, "trade-off": _trade_off(findings)}
    return {"axes": drawing.axes, "figures": figures, "viewer": _viewer(findings)}


class _Drawing:
    """Collects figures and the abscissas they share."""

    def __init__(self, time: FloatArray) -> None:
        self.time = time
        self.axes: dict[str, dict[str, list[float]]] = {}
        self.figures: dict[str, dict[str, Any]] = {}

    def add(self, identifier: str, unit: str, curves: dict[str, Array], **more: Any) -> None:
        """Add one figure; `curves` by role, or by "role: label"."""
        values = np.array(list(curves.values()))
        chosen = thinned(values, MOST_POINTS)
        axis = "all" if len(chosen) == len(self.time) else identifier
        if axis not in self.axes:
            self.axes[axis] = {"point": (chosen + 1).tolist(), "time": _rounded(self.time[chosen])}
        traces = []
        for role, curve in zip(curves, values, strict=True):
            kind, _, label = role.partition(": ")
            traces.append({"role": kind, "label": label or kind, "y": _rounded(curve[chosen])})
        self.figures[identifier] = {"axis": axis, "unit": pretty(unit), "traces": traces, **more}


def _add_elements(drawing: _Drawing, findings: Findings) -> None:
    dataset, arm = findings.decomposition, findings.arm
    zero = _zero_parts(findings)
    for element in elements(arm.n_joints):
        parts = np.where(zero[element.label][:, None], 0.0, element.parts(dataset))
        i, j = element.i, element.j
        unit = arm.joints[i].effort_unit if j is None else inertia_unit(arm, i, j)
        curves = {"combined": parts.sum(axis=0)}
        if element.quantity != "gravity_loading":
            curves |= dict(zip(EFFECTS, parts, strict=True))
        if element.quantity == "coriolis_centrifugal":
            for share in ("centrifugal", "coriolis"):
                values = dataset[share].values[:, :, element.i].T
                curves[share] = np.where(zero[element.label][:, None], 0.0, values).sum(axis=0)
        # From zero, so that the parts can be weighed against each other by eye.
        drawing.add(element.label, unit, curves, scale=f"{element.quantity}, {unit}", zero=True)


def _zero_parts(findings: Findings) -> dict[str, Array]:
    """Which parts the ranking found to be zero but for round-off, shape (2,) per element."""
    ranking = findings.dominance
    labels = (str(label) for label in ranking.element.values)
    return dict(zip(labels, ranking.part_peak.values == 0.0, strict=True))


def _add_motion(drawing: _Drawing, arm: RobotArm, dataset: xr.Dataset) -> None:
    for kind, unit in (("revolute", "rad"), ("prismatic", "m")):
        joints = [i for i, joint in enumerate(arm.joints) if joint.kind == kind]
        if not joints:
            continue
        for variable, suffix in (("q", ""), ("qd", "/s"), ("qdd", "/s^2")):
            curves = {
                f"joint-{i + 1}: {i + 1} {arm.joints[i].name}": dataset[variable].values[:, i] for i in joints
            }
            drawing.add(f"{variable}-{kind}", unit + suffix, curves)


def _add_torques(drawing: _Drawing, findings: Findings) -> None:
    exact, simplified = findings.evaluation.exact, findings.evaluation.simplified
    for i, joint in enumerate(findings.arm.joints):
        curves = {"exact": exact[:, i], "simplified": simplified[:, i]}
        drawing.add(f"torque-{i + 1}", joint.effort_unit, curves)
        drawing.add(
            f"error-{i + 1}",
            joint.effort_unit,
            {"error": simplified[:, i] - exact[:, i]},
            band=float(findings.model.promise.allowed[i]),
            zero=True,
        )


def _trade_off(findings: Findings) -> dict[str, Any]:
    """Operations against error in percent: a curve for every kind, this report's model, the exact ones."""
    model, elements_only = findings.model, findings.element_model
    traces = []
    for level, refit in dict.fromkeys((point.level.name, point.refit) for point in findings.trade_off):
        points = [point for point in findings.trade_off if (point.level.name, point.refit) == (level, refit)]
        traces.append(
            {
                "role": f"{level}-refit" if refit else level,
                "label": f"{level}, refitted" if refit else level,
                "x": _rounded(np.array([100 * point.error_share for point in points])),
                "y": [point.operations.total for point in points],
                "budget": [point.budget for point in points],
            }
        )
    shares = model.promise.errors.largest_share
    exact = [{"label": "exact, by elements", "y": elements_only.operations_full.total}]
    if model is not elements_only:
        exact.append({"label": "exact, in harmonic terms", "y": model.operations_full.total})
    return {
        "kind": "trade-off",
        "unit": "operations",
        "traces": traces,
        "exact": exact,
        "model": {
            "label": f"this report: {model.level}{', refitted' if model.refitted else ''}",
            # A joint that needs no torque at all has no peak to take a share of.
            "x": max(_rounded(100 * shares[np.isfinite(shares)]), default=0.0),
            "y": model.operations.total,
            "budget": model.promise.budget,
        },
    }


def _viewer(findings: Findings) -> dict[str, Any]:
    """Skeleton of the arm at evenly spaced set points, the hand's path, and a floor below."""
    arm, dataset = findings.arm, findings.decomposition
    count = findings.trajectory.n_set_points
    frames = np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int))
    q, torque = dataset.q.values, findings.evaluation.exact
    torque = np.where(np.abs(torque) > ROUND_OFF * np.abs(torque).max(), torque, 0.0)
    posed = motion(arm, q[frames])
    whole = motion(arm, q[np.unique(np.linspace(0, count - 1, min(count, MOST_POINTS)).round().astype(int))])
    every = np.concatenate([whole.points.reshape(-1, 3), posed.points.reshape(-1, 3)])
    low, high = every.min(axis=0), every.max(axis=0)
    reach = float(max((high - low).max(), 1e-3))
    up = int(np.abs(arm.gravity).argmax()) if arm.gravity.any() else 2
    sign = -1.0 if arm.gravity[up] > 0 else 1.0
    # A flat arm still needs some depth to be looked at, and a base that stands on the floor some height.
    middle, half = (low + high) / 2, np.maximum(high - low, 0.5 * reach) / 2 + 0.08 * reach
    floor = middle[up] - sign * half[up]
    # The view's third axis points up; a cyclic change of axes keeps the arm right-handed.
    axes = [(up + 1) % 3, (up + 2) % 3, up]
    box = np.stack([middle - half, middle + half], axis=1)[axes]
    if sign < 0:
        box[1:] = box[1:, ::-1]
    flat = bool(((high - low) < 0.05 * reach)[axes[:2]].any())
    return {
        "at": (frames + 1).tolist(),
        "time": _rounded(findings.trajectory.time[frames]),
        "points": np.round(posed.points[..., axes], 5).tolist(),
        "path": np.round(whole.hand.T[axes], 5).tolist(),
        "q": [_rounded(row) for row in q[frames]],
        "torque": [_rounded(row) for row in torque[frames]],
        "joints": [
            {"name": joint.name, "kind": joint.kind, "effort": joint.effort_unit} for joint in arm.joints
        ],
        "axes": ["xyz"[axis] for axis in axes],
        "floor": float(floor),
        "range": np.round(box, 5).tolist(),
        "flat": flat,
    }


def _rounded(values: Array) -> list[float]:
    """Round to `DIGITS` significant digits."""
    values = np.asarray(values, dtype=float)
    magnitude = np.floor(np.log10(np.abs(values), out=np.zeros_like(values), where=values != 0))
    scale = 10.0 ** np.clip(DIGITS - 1 - magnitude, -300, 300)
    rounded = np.round(values * scale) / scale
    out: list[float] = rounded.tolist()
    return out
