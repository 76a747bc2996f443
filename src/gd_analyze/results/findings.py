"""Everything one run of the main job found; files, reports and terminal are views of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import elements
from gd_analyze.dynamics.long_decomposition import MOST_KEPT
from gd_analyze.harmonics.terms import Torques
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.model_facts import headline, joint_errors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import html_of

if TYPE_CHECKING:
    import xarray as xr

    from gd_analyze.figures.axes import Plots


_DRAWN = ("inertia", "coriolis_centrifugal", "centrifugal", "coriolis", "gravity_loading")
# Equal stretches of a long trajectory in each of which every curve keeps its extremes: twice as many as a
# page can show, as each figure may thin its curves further.
STRETCHES = 500


@dataclass(frozen=True, eq=False)
class Findings:
    """One arm along one trajectory.

    Parameters
    ----------
    arm, trajectory
        What was analysed.
    tables
        All numbers found, labelled, by the groups of `gd_analyze.schema.GROUPS`.
    model
        The simplified model.
    element_model
        The model by the founding text's own method, keeping or dropping effects of elements; the same as
        `model` where that is its level.
    ranked_terms
        The exact torque terms and their weights, in the order of the table "terms"; none for an arm whose
        equations are too many to write out.
    warnings
        What is suspicious about the input, in sentences.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    trajectory: Trajectory
    tables: Mapping[str, xr.Dataset]
    model: SimplifiedModel
    element_model: SimplifiedModel
    ranked_terms: Torques
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]

    def __repr__(self) -> str:
        return f"Findings({self.arm!r}, {self.trajectory!r}, {self.model!r})"

    def _repr_html_(self) -> str:
        """Operations and errors of the model, sampled and proven, for a notebook."""
        proven = np.asarray(self.tables["tube"].tube_certified.values)
        shown = joint_errors(self.model, proven).shown()
        headings = [f"{column.label}, {unit}" if unit else column.label for column, unit, _ in shown]
        rows = [list(row) for row in zip(*(cells for _, _, cells in shown), strict=True)]
        title = f"{self.arm.title or self.arm.name} along {self.trajectory.name}"
        note = " ".join([headline(self.model), *(f"Warning: {warning}." for warning in self.warnings)])
        return html_of(title, headings, rows, note)

    @property
    def plot(self) -> Plots:
        """The report's figures as lists of matplotlib axes: `plot.torque()`, `plot.errors()`, and more."""
        from gd_analyze.figures.axes import Plots

        return Plots(self)

    @property
    def decomposition(self) -> xr.Dataset:
        """Dataset of `decompose`; of a long trajectory, elements are evaluated, or read, when asked for."""
        return self.tables["decomposition"]

    @property
    def dominance(self) -> xr.Dataset:
        """Dataset of `rank`."""
        return self.tables["dominance"]

    @cached_property
    def drawn(self) -> tuple[NDArray[np.intp], xr.Dataset]:
        """Set points at which elements are drawn, and the decomposition there; all of a short trajectory."""
        return drawn(self.decomposition)

    @cached_property
    def exact_torque(self) -> FloatArray:
        """Exact torque at the set points, N m, shape (N, n)."""
        return np.asarray(self.decomposition.torque.values)

    @cached_property
    def simplified_torque(self) -> FloatArray:
        """Torque of the model at the set points, N m, shape (N, n)."""
        return np.asarray(self.tables["simplified_model"].torque.values)

    @property
    def is_written_out(self) -> bool:
        """Whether the exact equations are few enough to be ranked and shown term by term."""
        return bool(self.tables["terms"].attrs["written_out"])

    @property
    def round_off(self) -> float:
        """Torque that round-off alone may explain, N m: the bound of the cross-check."""
        check = self.tables["cross_check"]
        return float(check.round_off_bound.values[check.quantity.values == "torque"].max())


def drawn(dataset: xr.Dataset) -> tuple[NDArray[np.intp], xr.Dataset]:
    """Numbers of the set points at which the elements are drawn, and D, h, its shares and c there.

    All of up to `MOST_KEPT` set points; else every element, each of its parts and their sum has the extremes
    of each stretch among them.
    """
    count = dataset.sizes["time"]
    names = [*_DRAWN]
    if count <= MOST_KEPT:
        return np.arange(count), dataset[names].load()
    chosen = [np.array([0, count - 1])]
    length = -(-count // STRETCHES)
    for start in range(0, count, length):
        block = dataset[names].isel(time=slice(start, start + length)).load()
        curves = np.hstack([*_curves(block)])
        chosen += [start + curves.argmin(axis=0), start + curves.argmax(axis=0)]
    points = np.unique(np.concatenate(chosen))
    return points, dataset[names].isel(time=points).load()


def _curves(block: xr.Dataset) -> Iterator[FloatArray]:
    """Whatever is drawn of every element, shape (N, curves)."""
    for element in elements(block.sizes["joint"]):
        parts = element.parts(block).T
        yield parts
        if element.quantity != "gravity_loading":
            yield parts.sum(axis=1, keepdims=True)
    for share in ("centrifugal", "coriolis"):
        yield block[share].values.sum(axis=1)
