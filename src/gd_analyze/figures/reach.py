"""Errors of every joint, sampled and proven, against the allowed one."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.figures.figure import (
    FIGURE_WIDTH,
    Axis,
    Curve,
    Figure,
    FigureWords,
    Item,
    Panel,
    decades_axis,
    short_joint_label,
)
from gd_analyze.figures.run import Run
from gd_analyze.text import number


def reach_figure(run: Run) -> Figure:
    """Errors of every joint as multiples of the allowed one: sampled, proven, drawn from the limits."""
    arm, beyond = run.arm, run.tables["beyond"]
    allowed = run.tables["simplified_model"].allowed_error.values
    looks: tuple[tuple[str, np.ndarray, str, Any], ...] = (
        ("at the set points", run.tables["simplified_model"].largest_error.values, "accent", "circle"),
        ("found in the box", beyond.worst_found.values, "bound", "triangle"),
        (f"{run.proof} in the box", beyond.certified.values, "bound", "square"),
        ("within the arm's limits", beyond.within_limits.values, "series-4", "diamond"),
        ("uncertainty of parameters", beyond.uncertainty.values, "ink", "cross"),
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = {label: values / allowed for label, values, *_ in looks}
    all_ratios = np.concatenate([*ratios.values(), [0.1, 10.0]])
    positive = all_ratios[np.isfinite(all_ratios) & (all_ratios > 0)]
    low, high = max(positive.min(), 1e-3) / 1.3, min(positive.max(), 1e5) * 1.3
    n = arm.n_joints
    names = tuple(short_joint_label(arm.joints, i, 80.0) for i in range(n))
    y = Axis(-n - 0.5, -0.5, tuple(-float(i) for i in range(1, n + 1)), names=names, grid=True)
    items: list[Item] = [Curve(np.ones(2), np.array([y.low, y.high]), "ink", 1.0)]
    margins, right = (84.0, 30.0, 12.0, 6.0), -84.0
    for label, _, colour, marker in looks:
        is_finite = np.isfinite(ratios[label])
        if is_finite.any():
            finite_ratios = ratios[label][is_finite]
            tips = tuple(f"{label}: {number(ratio)} times the allowed error" for ratio in finite_ratios)
            at = np.clip(finite_ratios, low, high), -np.arange(1.0, n + 1)[is_finite]
            items.append(Curve(*at, colour, 0.0, marker=marker, size=5.0, tips=tips))
            key = f"{_SIGNS[marker]} {label}"
            items.append(FigureWords(low, y.low, key, colour, size=7.0, right=right, up=-24.0))
            right += 3.8 * len(key) + 11.0
    panel = Panel("reach", "", decades_axis(low, high, "×"), y, tuple(items), margins=margins)
    return Figure("Errors as multiples of the allowed error", ((panel,),), FIGURE_WIDTH, 40.0 + 17.0 * n)


_SIGNS = {"circle": "●", "triangle": "▲", "square": "■", "diamond": "◆", "cross": "×"}
