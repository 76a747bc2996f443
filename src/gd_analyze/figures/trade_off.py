"""Operations against error: what every level gives for smaller and larger budgets."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.figures.colours import OF_LEVEL
from gd_analyze.figures.figure import (
    WIDTH,
    Axis,
    Curve,
    Figure,
    Item,
    Panel,
    Words,
    apart,
    decades_axis,
    shortened,
    with_grid,
)

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings

_HEIGHT, _PITCH = 190.0, 9.0
# Errors below this share of the largest stand at the axis: they would leave no room for the others.
_DECADES = 4


def trade_off_figure(findings: Findings) -> Figure:
    """Operations against largest error: a line per level and refit, and one through budgets."""
    model, table, path = findings.model, findings.tables["trade_off"], findings.tables["budgets"]
    errors, operations = 100 * table.largest_share.values, table.operations.values.astype(float)
    exact, counts = float(model.operations_full.total), path.operations.values.astype(float)
    whole = model.accuracy.whole
    along = path.largest_error.values
    along = 100 * np.divide(along, whole, out=np.zeros_like(along), where=whole > 0).max(axis=1)
    shares = model.accuracy.shares
    own = 100 * float(shares[np.isfinite(shares)].max(initial=0.0))
    x = _axis(np.concatenate([[own], errors.ravel(), along]), "%")
    y = _axis(np.concatenate([[model.operations.total, exact], operations.ravel(), counts]), "")
    left, right = x.low, x.high
    items: list[Item] = [
        Curve(np.array([left, right]), np.full(2, max(exact, y.low)), "ink", 0.8, (1.0, 1.6)),
        Curve(np.maximum(along, left), counts, "accent", 1.0, (4.0, 2.0), role="path"),
    ]
    names = [(_height(y, exact), f"exact: {exact:.0f}", "ink")]
    kinds = zip(table.level.values, table.refit.values, errors, operations, strict=True)
    for level, refit, error, count in kinds:
        (colour, marker), name = OF_LEVEL[level], kind_name(level, refit)
        tips = tuple(
            f"{name}\nbudget {budget}\nerror {share:.2g} %\n{number:.0f} operations"
            for budget, share, number in zip(table.budget.values.tolist(), error, count, strict=True)
        )
        dashes = (3.2, 1.6) if refit else ()
        shown = np.clip(error, left, right), np.maximum(count, y.low)
        items.append(
            Curve(*shown, colour, 1.3, dashes, marker=marker, size=3.6, hollow=bool(refit), tips=tips)
        )
        names.append((_height(y, float(count[-1])), name, colour))
    name, count = kind_name(model.level.name, model.refitted), model.operations.total
    tip = f"this report: {name}\nerror {own:.2g} %\n{count} operations"
    at = np.array([max(own, left)]), np.array([max(float(model.operations.total), y.low)])
    items.append(Curve(*at, "accent", 0.0, marker="star", size=11.0, tips=(tip,)))
    items.append(Curve(*at, "rotation", 0.0, marker="circle", size=5.0, role="at-budget", hidden=True))
    margins = (34.0, 26.0, 96.0, 16.0)
    pt = _HEIGHT - margins[1] - margins[3]
    names = [(pt * height, name, colour) for height, name, colour in names]
    items += [
        Words(right, y.low, name, colour, size=7.0, right=6.0, up=height - 2.5)
        for height, name, colour in apart(names, _PITCH, pt)
    ]
    told = f"largest error along the trajectory, % of the {model.accuracy.asked.shares_of}"
    items.append(Words(right, y.low, told, "ink", "end", 7.0, up=-22.0))
    panel = Panel(
        "trade-off", "operations (multiplications and additions)", x, y, tuple(items), margins=margins
    )
    return Figure("Operations against largest torque error", ((panel,),), WIDTH, _HEIGHT)


def kind_name(level: str, refit: bool) -> str:
    """Name of a way to simplify."""
    return f"{level}, refitted" if refit else level


def _axis(values: np.ndarray, unit: str) -> Axis:
    """Logarithmic axis around positive values, from 0 where there are none."""
    positive = values[(values > 0) & np.isfinite(values)]
    if not positive.size:
        return with_grid(Axis(0.0, 1.0, (0.0,), unit))
    high = float(positive.max())
    low = float(positive[positive >= high / 10**_DECADES].min())
    room = max((high / low) ** 0.07, 1.15)
    return decades_axis(low / room, high * room, unit)


def _height(axis: Axis, value: float) -> float:
    return float(np.clip(axis.place(np.array(value)), 0.0, 1.0))


def reach_figure(findings: Findings) -> Figure:
    """Errors of every joint as multiples of the allowed one: sampled, proven, drawn from the limits."""
    arm, beyond = findings.arm, findings.tables["beyond"]
    allowed = findings.tables["simplified_model"].allowed_error.values
    looks: tuple[tuple[str, np.ndarray, str, Any], ...] = (
        ("at the set points", findings.tables["simplified_model"].largest_error.values, "accent", "circle"),
        ("found in the box", beyond.worst_found.values, "inertia", "triangle"),
        ("proven in the box", beyond.certified.values, "inertia", "square"),
        ("within the arm's limits", beyond.within_limits.values, "rotation", "diamond"),
        ("uncertainty of parameters", beyond.uncertainty.values, "ink", "cross"),
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = {label: values / allowed for label, values, *_ in looks}
    known = [
        *(r for values in ratios.values() for r in values[np.isfinite(values) & (values > 0)]),
        0.1,
        10.0,
    ]
    low, high = max(min(known), 1e-3) / 1.3, min(max(known), 1e5) * 1.3
    n = arm.n_joints
    names = tuple(f"{i + 1} {shortened(joint.name, 74.0)}" for i, joint in enumerate(arm.joints))
    y = Axis(-n - 0.5, -0.5, tuple(-float(i) for i in range(1, n + 1)), names=names, grid=True)
    items: list[Item] = [Curve(np.ones(2), np.array([y.low, y.high]), "ink", 1.0)]
    keys = []
    for label, _, colour, marker in looks:
        x = np.clip(ratios[label], low, high)
        shown = np.isfinite(ratios[label])
        if shown.any():
            at = -np.arange(1.0, n + 1)[shown]
            tips = tuple(f"{label}: {ratio:.3g} times the allowed error" for ratio in ratios[label][shown])
            items.append(Curve(x[shown], at, colour, 0.0, marker=marker, size=5.0, tips=tips))
            keys.append(Words(low, y.low, f"{_SIGNS[marker]} {label}", colour, size=7.0, up=-24.0))
    for k, word in enumerate(keys):
        items.append(replace(word, right=k * 84.0 - 60.0))
    margins = (84.0, 30.0, 12.0, 6.0)
    panel = Panel("reach", "", decades_axis(low, high, "×"), y, tuple(items), margins=margins)
    return Figure("Errors as multiples of the allowed error", ((panel,),), WIDTH, 40.0 + 17.0 * n)


_SIGNS = {"circle": "●", "triangle": "▲", "square": "■", "diamond": "◆", "cross": "×"}
