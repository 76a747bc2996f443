"""Dominant effect of each element at every set point.

A part is needed at a set point if leaving it out changes the element by more than the threshold of its peak
over the motion. A verdict thus keeps its meaning where parts cancel or the element passes through zero, and
the verdict over the motion is the union of those at its set points.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.dominance import elements, rank
from gd_analyze.schema import table

if TYPE_CHECKING:
    import xarray as xr

# Indexed by the parts needed: translation counts 1, rotation 2.
VERDICTS = np.array(["neither", "translation", "rotation", "both"])


def dominance_over_time(dataset: xr.Dataset, ranking: xr.Dataset | None = None) -> xr.Dataset:
    """Find the share of each part, and the parts needed, of every element at every set point.

    Parameters
    ----------
    dataset
        The result of `decompose`, or some of its set points.
    ranking
        The result of `rank` for the whole motion: elements, their order and peaks, threshold and budget. By
        default that of `dataset`, with default threshold and budget, without h_ijk.

    Returns
    -------
    xarray.Dataset
        `dominance` (time, element, effect), the part over the element's peak, with its sign; `share`, the
        part over the element's value at the set point, nan where that is zero; `needed`, whether the element
        changes by more than the threshold of its peak without the part; `torque` (time, element), the
        element's torque at joint `torque_joint`; `budget_share`, its magnitude over the torque error allowed
        there. Gravity loading has one part, translation.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> over_time = gd.dominance_over_time(gd.decompose("puma560", "pick-and-place"))
    >>> over_time.dominance.sel(element="D15").dims
    ('time', 'effect')
    >>> gd.verdicts(over_time).sel(element="D15").values[:2].tolist()
    ['translation', 'translation']
    """
    ranking = rank(dataset) if ranking is None else ranking
    labels, joints, peaks = (ranking[name].values for name in ("element", "torque_joint", "peak"))
    n, threshold = dataset.sizes["joint"], float(ranking.attrs["threshold"])
    by_label = {element.label: element for element in elements(n, christoffel="k" in ranking)}
    ranked = [by_label[label] for label in labels]
    is_there = ranking.part_peak.values.T[:, :, None] > 0.0
    parts = np.where(is_there, np.stack([element.parts(dataset) for element in ranked], axis=1), 0.0)
    whole = parts.sum(axis=0)
    factors = [one.torque_factors(dataset)[joint - 1] for one, joint in zip(ranked, joints, strict=True)]
    torque = whole * np.stack(factors)
    allowed = np.asarray(ranking.attrs["floor"])[joints - 1] * (n + 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        of_peak = np.where(is_there, parts / peaks[:, None], 0.0)
        # Where parts cancel, their sum is round-off of the peak of either.
        is_zero = np.abs(whole) <= 64 * np.finfo(float).eps * ranking.part_peak.values.max(axis=1)[:, None]
        of_value = np.where(is_zero, np.nan, parts / whole + 0.0)
        budget_share = np.where(torque == 0.0, 0.0, np.abs(torque) / allowed[:, None])
    revolute = (dataset.joint_kind.values == "revolute").tolist()
    return table(
        "dominance_over_time",
        {
            "dominance": of_peak.T,
            "share": of_value.T,
            "needed": np.abs(of_peak.T) > threshold,
            "torque": torque.T,
            "budget_share": budget_share.T,
        },
        revolute,
        {
            "time": dataset.time,
            "element": labels,
            "effect": dataset.effect.values,
            "torque_joint": ("element", joints),
            "torque_unit": ("element", ranking.torque_unit.values),
        },
        {"threshold": threshold, "arm": dataset.attrs["arm"], "trajectory": dataset.attrs["trajectory"]},
    )


def verdicts(over_time: xr.Dataset) -> xr.DataArray:
    """Give the verdict at every set point: translation, rotation, both or neither.

    Parameters
    ----------
    over_time
        The result of `dominance_over_time`.

    Returns
    -------
    xarray.DataArray
        Verdicts as words, (time, element).
    """
    needed = over_time.needed.transpose("time", "element", "effect")
    return needed.isel(effect=0, drop=True).copy(data=VERDICTS[needed.values @ [1, 2]])


def stretches(over_time: xr.Dataset) -> dict[str, list[dict[str, Any]]]:
    """Successive verdicts on every element: `verdict`, and its `begin` and `end` in s."""
    time, found = over_time.time.values, {}
    for label, words in zip(over_time.element.values.tolist(), verdicts(over_time).values.T, strict=True):
        first = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist(), len(words)]
        found[label] = [
            {"verdict": str(words[a]), "begin": float(time[a]), "end": float(time[b - 1])}
            for a, b in pairwise(first)
        ]
    return found
