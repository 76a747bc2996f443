"""Simplification at the text's own level: keep or drop each effect of each element."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.dominance import ROUND_OFF_SHARE, Element, peak_magnitude
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.models.element_level import Part, TracedParts, parts_of, trace_parts
from gd_analyze.models.simplified import ErrorTable, SimplifiedModel
from gd_analyze.operations import Expression
from gd_analyze.robots import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.selection import blocks, select
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# Where no joint feels any torque, a share of it allows nothing: still a number to divide by.
_NO_TORQUE = 1e-200


def simplify(
    arm: RobotArm,
    dataset: xr.Dataset,
    budget: Budget | None = None,
    provenance: Mapping[str, str] | None = None,
) -> SimplifiedModel:
    """Leave out what the budget allows, so that the fewest operations remain.

    Parameters
    ----------
    arm
        The arm.
    dataset
        Its decomposition along the trajectory that matters; drive torque, where it is given, is kept.
    budget
        Allowed torque error per joint; 1 % of each joint's peak torque by default.
    provenance
        Stored with the model.

    Returns
    -------
    SimplifiedModel
        Its largest error at every set point is within the budget, measured on the model itself.

    Raises
    ------
    UsageError
        If the budget does not fit the number of joints.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> dataset = gd.decompose(arm, gd.read_trajectory("two-link-swing", arm))
    >>> model = gd.simplify(arm, dataset, gd.Budget.parse("1%"))
    >>> bool((model.promise.largest_share <= 0.01).all())
    True
    """
    budget = budget or Budget()
    parts = parts_of(arm.n_joints)
    peak_torque = peak_magnitude(dataset.torque.values)
    floor = max(ROUND_OFF_SHARE * float(peak_torque.max()), _NO_TORQUE)
    allowed = np.maximum(budget.allowed(peak_torque), floor)
    traced = trace_parts(arm)
    costs = blocks(traced.trace, [[traced.expression(part)] for part in parts])
    for needing, operations in assembly(traced, parts, "drive_torque" in dataset).items():
        costs[needing] = costs.get(needing, 0) + operations
    selection = select(torque_by_part(dataset, parts), allowed, costs)
    return model_of(
        arm,
        dataset,
        tuple(part.label for part, keep in zip(parts, selection.kept, strict=True) if keep),
        allowed,
        str(budget) if selection.optimal else f"{budget} (search stopped early: not proven cheapest)",
        provenance,
    )


def model_of(
    arm: RobotArm,
    dataset: xr.Dataset,
    kept: tuple[str, ...],
    allowed: FloatArray,
    budget_stated: str,
    provenance: Mapping[str, str] | None = None,
) -> SimplifiedModel:
    """Build the model that keeps the given parts and measure its error on the dataset's set points.

    Raises
    ------
    GdAnalyzeError
        If the measured error is beyond `allowed`.
    """
    drives = "drive_torque" in dataset
    nothing = np.zeros(arm.n_joints)
    states = [dataset[name].values for name in ("q", "qd", "qdd")]
    draft = SimplifiedModel(
        arm, "element", kept, drives, allowed, budget_stated, ErrorTable(nothing, nothing, nothing), {}
    )
    promise = ErrorTable.of(dataset.torque.values, draft.torque(*states))
    if not (promise.largest <= allowed).all():
        raise GdAnalyzeError(
            "the simplified model misses its budget",
            expected=str(allowed.tolist()),
            found=str(promise.largest.tolist()),
            next_step="please report this with the arm file and the trajectory",
        )
    return SimplifiedModel(
        arm=arm,
        level="element",
        kept=kept,
        drives=drives,
        budget=allowed,
        budget_stated=budget_stated,
        promise=promise,
        made_for={
            "trajectory": dataset.attrs["trajectory"],
            "trajectory_fingerprint": dataset.attrs["trajectory_fingerprint"],
            "set_points": dataset.sizes["time"],
        },
        provenance=dict(provenance or {}),
    )


def torque_by_part(dataset: xr.Dataset, parts: tuple[Part, ...]) -> FloatArray:
    """Torque of every part at every joint and set point, N m, shape (P, n, N)."""
    count, n = dataset.torque.shape
    out = np.zeros((len(parts), n, count))
    effects = [str(effect) for effect in dataset.effect.values]
    for p, part in enumerate(parts):
        values = part.element.parts(dataset)[effects.index(part.effect)]
        for joint, factor in part.element.torque_factors(dataset).items():
            out[p, joint] = values * factor
    return out


def assembly(traced: TracedParts, parts: tuple[Part, ...], drives: bool) -> dict[frozenset[int], int]:
    """Operations that put the parts into the torques, by the set of parts that need them.

    One addition per part and joint, less one that every joint saves at its first term; an element of D is
    multiplied by an acceleration once for both of its effects and added to each joint once. Constants are
    summed beforehand. A drive's inertia stands on the diagonal already, product and all.
    """
    costs: dict[frozenset[int], int] = {}
    effects: dict[Element, list[int]] = {}
    for p, part in enumerate(parts):
        if is_zero(traced.expression(part)):
            costs[frozenset([p])] = 1  # nothing is lost without it, so it goes
        else:
            effects.setdefault(part.element, []).append(p)
    for element, live in effects.items():
        varying = any(isinstance(traced.expression(parts[p]), Expression) for p in live)
        if varying or element.j is None:
            costs |= {frozenset([p]): 1 for p in live}
        joints = 1 if element.i == element.j else 2
        if element.j is not None and not (drives and joints == 1):
            either = frozenset(live)
            costs[either] = costs.get(either, 0) + 2 * joints - (1 if varying else 0)
    return costs


def is_zero(expression: object) -> bool:
    """Whether a part is zero in every state."""
    return not isinstance(expression, Expression) and expression == 0.0
