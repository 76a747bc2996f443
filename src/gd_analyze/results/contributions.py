"""Torque over time by what makes it: gravity, inertia by effect, Coriolis and centrifugal, and drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.results.findings import Findings

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Contributions:
    """What the torque of every joint consists of, at the set points that are drawn.

    Parameters
    ----------
    time
        Of these set points, s, shape (N,).
    points
        Their numbers, from 0, shape (N,).
    gaps
        Set points, by their numbers, before which nothing is known of the motion.
    parts
        Torque by the names of `gd_analyze.results.words.CONTRIBUTIONS` and in their order, N m (N where the
        joint slides), shape (N, n) each; "drives" only where they are part of the torque.
    total
        The exact torque, their sum, of the same shape.
    limit
        Largest torque that each joint's drive can give, shape (n,); nan where the arm states none.
    """

    time: FloatArray
    points: NDArray[np.intp]
    gaps: tuple[int, ...]
    parts: Mapping[str, FloatArray]
    total: FloatArray
    limit: FloatArray

    @classmethod
    def of(cls, findings: Findings) -> Contributions:
        """Take them at the set points at which the elements are drawn; all of a short trajectory."""
        points, elements = findings.drawn
        decomposition = findings.decomposition
        names = [name for name in ("qdd", "torque", "drive_torque") if name in decomposition]
        parts = torque_by_cause(elements.assign(decomposition[names].isel(time=points)))
        limits = [drive.torque_limit for drive in findings.arm.drives] or [None] * findings.arm.n_joints
        return cls(
            time=findings.trajectory.time[points],
            points=points,
            gaps=findings.trajectory.gaps,
            parts=parts,
            total=findings.exact_torque[points],
            limit=np.array([np.nan if limit is None else limit for limit in limits]),
        )

    def pile(self, joint: int, *, upward: bool) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Stack the positive parts of a joint's torque from zero upward, or the negative ones downward.

        The ends of both piles sum to the torque, at the set points and on the straight lines between.

        Parameters
        ----------
        joint
            Counts from 0.
        upward
            Which of the two piles.

        Returns
        -------
        dict
            By the part's name the edges of its area, first the one nearer to zero, shape (N,) each; without
            those parts that are never of this sign.
        """
        clipped = np.maximum if upward else np.minimum
        edges, inner = {}, np.zeros(len(self.time))
        for name, part in self.parts.items():
            outer = inner + clipped(part[:, joint], 0.0)
            if np.any(outer != inner):
                edges[name] = inner, outer
            inner = outer
        return edges


def torque_by_cause(dataset: xr.Dataset) -> dict[str, FloatArray]:
    """Split the torque of every joint by what makes it; the parts sum to `torque`, but for round-off.

    Parameters
    ----------
    dataset
        What `decompose` gave, or some of its set points.

    Returns
    -------
    dict
        By the names of `gd_analyze.results.words.CONTRIBUTIONS`, N m (N where the joint slides), shape (N, n)
        each: "gravity"; "translation" and "rotation", what accelerating the links asks for, by effect;
        "velocity", Coriolis and centrifugal of both effects; "drives" where the dataset includes them.
    """
    translation, rotation = np.einsum("teij,tj->eti", dataset.inertia.values, dataset.qdd.values)
    parts = {
        "gravity": dataset.gravity_loading.values,
        "translation": translation,
        "rotation": rotation,
        "velocity": dataset.coriolis_centrifugal.values.sum(axis=1),
    }
    if "drive_torque" in dataset:
        parts["drives"] = dataset.drive_torque.values
    return parts
