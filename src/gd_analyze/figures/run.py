"""What figures need: a decomposition with its ranking, or all of one arm along one trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, evenly
from gd_analyze.dynamics.decomposition import MOST_KEPT, decompose_on_demand, gaps_in
from gd_analyze.dynamics.dominance import elements, rank
from gd_analyze.dynamics.dominance_over_time import dominance_over_time
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import PROVEN
from gd_analyze.simplification.model import SimplifiedModel

if TYPE_CHECKING:
    import xarray as xr

_DRAWN = ["inertia", "coriolis_centrifugal", "centrifugal", "coriolis", "gravity_loading"]
# Equal stretches of a long trajectory in which every curve keeps its extremes: twice as many as a page can
# show, as figures may thin curves further.
STRETCHES = 500


@dataclass(frozen=True, eq=False, kw_only=True)
class Elements:
    """Input of figures of elements: a decomposition and its ranking."""

    tables: Mapping[str, xr.Dataset]  # by the groups of `gd_analyze.schema.GROUPS`

    @property
    def decomposition(self) -> xr.Dataset:
        """Dataset of `decompose`; for a long trajectory, elements are evaluated, or read, on access."""
        return self.tables["decomposition"]

    @property
    def dominance(self) -> xr.Dataset:
        """Dataset of `rank`."""
        return self.tables["dominance"]

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return int(self.decomposition.sizes["joint"])

    @property
    def time(self) -> FloatArray:
        """Instants of the set points, s, shape (N,)."""
        return np.asarray(self.decomposition.time.values)

    @property
    def gaps(self) -> tuple[int, ...]:
        """Set points before which the motion is unknown, see `Trajectory`."""
        return gaps_in(self.decomposition)

    @cached_property
    def drawn(self) -> tuple[NDArray[np.intp], xr.Dataset]:
        """Set points at which elements are drawn, and the decomposition there; all of a short trajectory."""
        return drawn(self.decomposition)

    def gaps_among(self, points: NDArray[np.intp]) -> NDArray[np.intp]:
        """Indices of these set points before which the motion is unknown."""
        return np.unique(np.searchsorted(points, self.gaps))


@dataclass(frozen=True, eq=False, kw_only=True)
class Run(Elements):
    """Input of all figures; `gd_analyze.results.findings.Findings` holds all results."""

    arm: RobotArm
    trajectory: Trajectory
    model: SimplifiedModel | None = None  # None if only elements are drawn
    proof: str = PROVEN  # of its bounds; STATED where they were read from a file

    @staticmethod
    def of(arm: RobotArm, trajectory: Trajectory, threshold: float, drives: bool | None = None) -> Run:
        """Decompose and rank, as needed by figures of elements."""
        dataset = decompose_on_demand(arm, trajectory, drives=drives)
        ranking = rank(dataset, threshold=threshold)
        selection = dataset.isel(time=evenly(trajectory.n_set_points, MOST_KEPT))
        over_time = dominance_over_time(selection, ranking)
        tables = {"decomposition": dataset, "dominance": ranking, "dominance_over_time": over_time}
        return Run(arm=arm, trajectory=trajectory, tables=tables)

    @property
    def gaps(self) -> tuple[int, ...]:
        """Set points before which the motion is unknown, see `Trajectory`."""
        return self.trajectory.gaps

    @cached_property
    def exact_torque(self) -> FloatArray:
        """Exact torque at the set points, N m, shape (N, n)."""
        return np.asarray(self.decomposition.torque.values)

    @cached_property
    def simplified_torque(self) -> FloatArray:
        """Torque of the model at the set points, N m, shape (N, n)."""
        return np.asarray(self.tables["simplified_model"].torque.values)

    @property
    def round_off(self) -> float:
        """Torque that round-off alone explains, N m: the bound of the cross-check."""
        check = self.tables["cross_check"]
        return float(check.round_off_bound.values[check.quantity.values == "torque"].max())


def drawn(dataset: xr.Dataset) -> tuple[NDArray[np.intp], xr.Dataset]:
    """Indices of the drawn set points, and D, h, its shares and c there.

    All of up to `MOST_KEPT` set points; otherwise with the extremes of every element and part in each
    stretch.
    """
    count = dataset.sizes["time"]
    if count <= MOST_KEPT:
        return np.arange(count), dataset[_DRAWN].load()
    chosen = [np.array([0, count - 1])]
    length = -(-count // STRETCHES)
    for start in range(0, count, length):
        block = dataset[_DRAWN].isel(time=slice(start, start + length)).load()
        curves = np.hstack([*_curves(block)])
        chosen += [start + curves.argmin(axis=0), start + curves.argmax(axis=0)]
    points = np.unique(np.concatenate(chosen))
    return points, dataset[_DRAWN].isel(time=points).load()


def _curves(block: xr.Dataset) -> Iterator[FloatArray]:
    """Curves drawn for every element, shape (N, curves)."""
    for element in elements(block.sizes["joint"]):
        parts = element.parts(block).T
        yield parts
        if element.quantity != "gravity_loading":
            yield parts.sum(axis=1, keepdims=True)
    for share in ("centrifugal", "coriolis"):
        yield block[share].values.sum(axis=1)
