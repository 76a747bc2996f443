"""Simplification at the text's own level: keep or drop each effect of each element."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.dominance import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.models.element_level import Part, parts_of, trace_parts
from gd_analyze.models.simplified import ErrorTable, SimplifiedModel
from gd_analyze.robots import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.selection import blocks, select
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr


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
    allowed = np.maximum(budget.allowed(peak_torque), ROUND_OFF_SHARE * peak_torque.max())
    traced = trace_parts(arm)
    costs = blocks(traced.trace, [[traced.expression(part)] for part in parts])
    for p, part in enumerate(parts):
        # Adding a part to its joints' torque, and for D the product with the acceleration.
        products, additions = _assembly(part)
        costs[frozenset([p])] = costs.get(frozenset([p]), 0) + additions
        if products:
            pair = frozenset([p, p + 1 if part.effect == "translation" else p - 1])
            costs[pair] = costs.get(pair, 0) + (products if part.effect == "translation" else 0)
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


def _assembly(part: Part) -> tuple[int, int]:
    """Multiplications and additions that put a part into the torques."""
    if part.element.quantity != "inertia":
        return 0, 1
    joints = 1 if part.element.i == part.element.j else 2
    return joints, joints
