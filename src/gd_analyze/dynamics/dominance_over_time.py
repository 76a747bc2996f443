"""Dominance, consequence and verdict of each element at every set point.

Parts are measured by the element's peak over the motion (`verdicts.py` has the rule), so that dominance keeps
its meaning where parts cancel or the element passes through zero. The torque at the set point decides whether
the element is negligible there; it is negligible over the motion if it is so at every set point.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.dominance import SOURCES, elements, rank, ratio
from gd_analyze.dynamics.verdicts import (
    DOMINANT,
    effect_words,
    is_round_off,
    least_changes,
    representing_at,
    verdict_words,
)
from gd_analyze.schema import require_table, table

if TYPE_CHECKING:
    import xarray as xr


def dominance_over_time(dataset: xr.Dataset, ranking: xr.Dataset | None = None) -> xr.Dataset:
    """Find the share of each part of every element, the torque it makes, and whether it counts, over time.

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
        changes by more than the threshold of its peak without the part; `torque` (time, element), the links'
        torque at joint `torque_joint`, and `drive_torque` the drive's; `consequence`, the element's torque,
        drive included, over the torque error allowed, at the joint where that is largest, and
        `part_consequence` (time, element, source) the same of each part; `negligible`, whether the element
        is, and `links_negligible`, whether it is without its drive; `dominant` and `over_motion` (element),
        what represents it over the motion, and the verdict there. Gravity loading has one part, translation.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> over_time = gd.tables.dominance_over_time(gd.decompose("puma560", "pick-and-place"))
    >>> over_time.dominance.sel(element="D15").dims
    ('time', 'effect')
    >>> gd.tables.verdicts(over_time).sel(element="D15").values[:2].tolist()
    ['negligible', 'negligible']
    """
    require_table(dataset, "decomposition", "decompose")
    if ranking is None:
        ranking = rank(dataset)
    require_table(ranking, "dominance", "rank", "ranking")
    labels, joints, peaks = (ranking[name].values for name in ("element", "torque_joint", "peak"))
    n, threshold = dataset.sizes["joint"], float(ranking.attrs["threshold"])
    allowed, floor = (np.asarray(ranking.attrs[name]) for name in ("allowed", "floor"))
    by_label = {element.label: element for element in elements(n, christoffel="k" in ranking)}
    ranked = [by_label[label] for label in labels]
    names = {"qd", "qdd", *(element.quantity for element in ranked)} & {*dataset.data_vars}
    quantities = {name: dataset[name].values for name in names}
    part_peaks = ranking.part_peak.values.T  # 0 for round-off
    is_there = part_peaks[:, :, None] > 0.0
    needed_from = least_changes(part_peaks, peaks, 0.0, threshold)[:, :, None]
    parts = np.where(is_there, np.stack([element.parts(quantities) for element in ranked], axis=1), 0.0)
    links, drive = parts.sum(axis=0), ranking.drive.values[:, None]
    # Translation, rotation, drive, both links' parts, and all.
    curves = np.stack([*parts, np.broadcast_to(drive, links.shape), links, links + drive])
    shares, counts = np.zeros(curves.shape), np.zeros(curves.shape, dtype=bool)
    torque = np.zeros((2, *links.shape))
    for k, element in enumerate(ranked):
        for joint, factor in element.torque_factors(quantities).items():
            torques = curves[:, k] * factor
            size = np.where(np.abs(torques) > ranking.attrs["no_torque"], np.abs(torques), 0.0)
            shares[:, k] = np.maximum(shares[:, k], ratio(size, allowed[joint]))
            counts[:, k] |= size > floor[joint]
            if joint == joints[k] - 1:
                torque[:, k] = torques[3], torques[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        of_peak = np.where(is_there, parts / peaks[:, None], 0.0)
        # Where parts cancel, their sum is round-off of the peak of either.
        is_zero = is_round_off(links, part_peaks.max(axis=0)[:, None])
        of_value = np.where(is_zero, np.nan, parts / links + 0.0)
    revolute = (dataset.joint_kind.values == "revolute").tolist()
    return table(
        "dominance_over_time",
        {
            "dominance": of_peak.T,
            "share": of_value.T,
            "needed": (np.abs(parts) > needed_from).T,
            "torque": torque[0].T,
            "drive_torque": torque[1].T,
            "consequence": shares[4].T,
            "part_consequence": shares[:3].T,
            "negligible": ~counts[4].T,
            "links_negligible": ~counts[3].T,
            "dominant": ranking.dominant.values,
            "over_motion": ranking.verdict.values,
        },
        revolute,
        {
            "time": dataset.time,
            "element": labels,
            "effect": dataset.effect.values,
            "source": list(SOURCES),
            "torque_joint": ("element", joints),
            "torque_unit": ("element", ranking.torque_unit.values),
        },
        {"threshold": threshold, "arm": dataset.attrs["arm"], "trajectory": dataset.attrs["trajectory"]},
    )


def verdicts(over_time: xr.Dataset) -> xr.DataArray:
    """Give the verdict at every set point, in the words of `rank`.

    "zero", for an element that is zero along the motion; "negligible", if its torque, drive included, is at
    most its share of the budget there; "drive", if that holds for the links' parts only; "gravity", of any
    other element of c; otherwise the parts that represent it: "translation", "rotation" or "both".

    Parameters
    ----------
    over_time
        The result of `dominance_over_time`.

    Returns
    -------
    xarray.DataArray
        Verdicts as words, (time, element).

    Raises
    ------
    UsageError
        If this is another dataset, such as a decomposition: `dataset.gd.verdicts()` takes that.
    """
    step = "of a decomposition, dataset.gd.verdicts() gives them"
    require_table(over_time, "dominance_over_time", "dominance_over_time", "over_time", step)
    needed = over_time.needed.transpose("effect", "time", "element").values
    is_gravity = np.char.startswith(over_time.element.values.astype(str), "c")
    over_motion = np.stack([np.isin(over_time.dominant, [effect, "both"]) for effect in DOMINANT[1:3]])
    represents = representing_at(needed, over_motion[:, None])
    is_zero = np.broadcast_to(over_time.over_motion == "zero", needed.shape[1:])
    negligible, links = (
        over_time[k].transpose("time", "element") for k in ("negligible", "links_negligible")
    )
    words = verdict_words(
        effect_words(represents),
        is_zero,
        negligible.values,
        links.values,
        np.broadcast_to(is_gravity, is_zero.shape),
    )
    return negligible.copy(data=words).rename("verdict").drop_attrs()


def stretches(over_time: xr.Dataset, starts: Sequence[float] = ()) -> dict[str, list[dict[str, Any]]]:
    """Successive verdicts on every element: `verdict`, and its `begin` and `end` in s.

    None leads from one motion to the next, which begin at `starts`, s.
    """
    time, by_element = over_time.time.values, {}
    rows_of_starts = np.searchsorted(time, starts).tolist()
    for label, words in zip(over_time.element.values.tolist(), verdicts(over_time).values.T, strict=True):
        changes = (np.flatnonzero(words[1:] != words[:-1]) + 1).tolist()
        first = sorted({0, *changes, *rows_of_starts, len(words)})
        by_element[label] = [
            {"verdict": str(words[a]), "begin": float(time[a]), "end": float(time[b - 1])}
            for a, b in pairwise(first)
        ]
    return by_element
