"""Operations against error for every level and several budgets."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np

from gd_analyze.figures.figure import (
    WIDTH,
    Axis,
    Curve,
    Figure,
    Item,
    Marker,
    Panel,
    Words,
    decades_axis,
    ends_named,
    joint_label,
)
from gd_analyze.figures.run import Run
from gd_analyze.text import LEVEL_NAMES

# Errors below this share of the largest are drawn at the axis, as they would leave no room for the others.
_DECADES = 4
# Colour and mark of every level.
_COLOURS = ("series-6", "series-3", "series-2", "series-4")
_MARKERS: tuple[Marker, ...] = ("square", "circle", "triangle", "diamond")
_OF_LEVEL = dict(zip(LEVEL_NAMES, cycle(zip(_COLOURS, _MARKERS, strict=True))))


def trade_off_figure(run: Run) -> Figure:
    """Operations against largest error: a line per level and refit, and one through budgets."""
    assert run.model is not None  # callers draw a run of the main job
    model, table, path = run.model, run.tables["trade_off"], run.tables["budgets"]
    errors, operations = 100 * table.largest_share.values, table.operations.values.astype(float)
    exact, counts = float(model.operations_full.total), path.operations.values.astype(float)
    along, whole = path.largest_error.values, model.accuracy.whole
    along = 100 * np.divide(along, whole, out=np.zeros_like(along), where=whole > 0).max(axis=1)
    shares = model.accuracy.shares
    own = 100 * float(shares[np.isfinite(shares)].max(initial=0.0))
    x = _axis(np.concatenate([[own], errors.ravel(), along]), "%")
    y = _axis(np.concatenate([[model.operations.total, exact], operations.ravel(), counts]), "")
    items: list[Item] = [
        Curve(np.array([x.low, x.high]), np.full(2, max(exact, y.low)), "ink", 0.8, (1.0, 1.6)),
        Curve(np.maximum(along, x.low), counts, "accent", 1.0, (4.0, 2.0)),
    ]
    names = [(exact, f"exact: {exact:.0f}", "ink")]
    kinds = zip(table.level.values, table.refit.values, errors, operations, strict=True)
    for level, refit, error, count in kinds:
        (colour, marker), name = _OF_LEVEL[level], kind_name(level, refit)
        tips = tuple(
            f"{name}\nbudget {budget}\nerror {share:.2g} %\n{number:.0f} operations"
            for budget, share, number in zip(table.budget.values.tolist(), error, count, strict=True)
        )
        dashes = (3.2, 1.6) if refit else ()
        shown = np.clip(error, x.low, x.high), np.maximum(count, y.low)
        items.append(
            Curve(*shown, colour, 1.3, dashes, marker=marker, size=3.6, hollow=bool(refit), tips=tips)
        )
        names.append((float(count[-1]), name, colour))
    count = model.operations.total
    tip = f"this report: {kind_name(model.level.name, model.refitted)}\nerror {own:.2g} %\n{count} operations"
    at = np.array([max(own, x.low)]), np.array([max(float(count), y.low)])
    items.append(Curve(*at, "accent", 0.0, marker="star", size=11.0, tips=(tip,)))
    title, margins = "operations (multiplications and additions)", (34.0, 26.0, 96.0, 16.0)
    panel = Panel("trade-off", title, x, y, tuple(items), margins=margins)
    below = f"largest error along the trajectory, % of the {model.accuracy.asked.shares_of}"
    return ends_named("Operations against largest torque error", panel, names, below, 190.0)


def kind_name(level: str, refit: bool) -> str:
    """Name of a way to simplify."""
    return f"{level}, refitted" if refit else level


def _axis(values: np.ndarray, unit: str) -> Axis:
    """Logarithmic axis around positive values, from 0 if there are none."""
    positive = values[(values > 0) & np.isfinite(values)]
    if not positive.size:
        return Axis(0.0, 1.0, (0.0,), unit, grid=True)
    high = float(positive.max())
    low = float(positive[positive >= high / 10**_DECADES].min())
    room = max((high / low) ** 0.07, 1.15)
    return decades_axis(low / room, high * room, unit)


def reach_figure(run: Run) -> Figure:
    """Errors of every joint as multiples of the allowed one: sampled, proven, drawn from the limits."""
    arm, beyond = run.arm, run.tables["beyond"]
    allowed = run.tables["simplified_model"].allowed_error.values
    looks: tuple[tuple[str, np.ndarray, str, Any], ...] = (
        ("at the set points", run.tables["simplified_model"].largest_error.values, "accent", "circle"),
        ("found in the box", beyond.worst_found.values, "inertia", "triangle"),
        ("proven in the box", beyond.certified.values, "inertia", "square"),
        ("within the arm's limits", beyond.within_limits.values, "rotation", "diamond"),
        ("uncertainty of parameters", beyond.uncertainty.values, "ink", "cross"),
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = {label: values / allowed for label, values, *_ in looks}
    every = np.concatenate([*ratios.values(), [0.1, 10.0]])
    known = every[np.isfinite(every) & (every > 0)]
    low, high = max(known.min(), 1e-3) / 1.3, min(known.max(), 1e5) * 1.3
    n = arm.n_joints
    names = tuple(joint_label(arm.joints, i, 80.0) for i in range(n))
    y = Axis(-n - 0.5, -0.5, tuple(-float(i) for i in range(1, n + 1)), names=names, grid=True)
    items: list[Item] = [Curve(np.ones(2), np.array([y.low, y.high]), "ink", 1.0)]
    right = -60.0
    for label, _, colour, marker in looks:
        shown = np.isfinite(ratios[label])
        if shown.any():
            told = ratios[label][shown]
            tips = tuple(f"{label}: {ratio:.3g} times the allowed error" for ratio in told)
            at = np.clip(told, low, high), -np.arange(1.0, n + 1)[shown]
            items.append(Curve(*at, colour, 0.0, marker=marker, size=5.0, tips=tips))
            key = f"{_SIGNS[marker]} {label}"
            items.append(Words(low, y.low, key, colour, size=7.0, right=right, up=-24.0))
            right += 84.0
    margins = (84.0, 30.0, 12.0, 6.0)
    panel = Panel("reach", "", decades_axis(low, high, "×"), y, tuple(items), margins=margins)
    return Figure("Errors as multiples of the allowed error", ((panel,),), WIDTH, 40.0 + 13.0 * n)


_SIGNS = {"circle": "●", "triangle": "▲", "square": "■", "diamond": "◆", "cross": "×"}
