"""Decompositions of long trajectories, evaluated again where they are read instead of kept.

Evaluating D, h and c at a set point takes some microseconds, no longer than reading them from a file would.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics.decomposition import decompose, decompose_states, labelled, torque_of
from gd_analyze.motions.checks import require_joints
from gd_analyze.motions.states import States, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

if TYPE_CHECKING:
    import xarray as xr

# Set points whose decomposition is kept: some 40 MB for six joints, and no fewer than a search looks at.
MOST_KEPT = 8192


def decompose_on_demand(
    arm: RobotArm,
    trajectory: Trajectory,
    *,
    christoffel: bool = True,
    by_link: bool = False,
    terms: bool = False,
    drives: bool | None = None,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Do `decompose` without keeping what it gives of a long trajectory, but for its torque.

    Parameters and what is raised are those of `decompose`.

    Returns
    -------
    xarray.Dataset
        The same numbers. Of more than `MOST_KEPT` set points, D, h, h_ijk and c are evaluated again for the
        set points in question whenever they are read, and only torque is in memory.
    """
    if trajectory.n_set_points <= MOST_KEPT:
        return decompose(
            arm,
            trajectory,
            christoffel=christoffel,
            by_link=by_link,
            terms=terms,
            drives=drives,
            progress=progress,
        )
    require_joints(trajectory, arm)
    states = states_of(trajectory)
    kept = dict(zip(("q", "qd", "qdd"), states.arrays, strict=True))
    kept["torque"] = torque_of(arm, states, drives=drives, progress=progress)
    # What takes long or is large is evaluated only where it is read.
    lean = _Blocks(states, partial(decompose_states, arm, christoffel=False, drives=drives))
    whole = partial(
        decompose_states, arm, christoffel=christoffel, by_link=by_link, terms=terms, drives=drives
    )
    full = _Blocks(states, whole)
    of_lean = {*lean.at(np.arange(1))}
    arrays: dict[str, Any] = {}
    for name, row in full.at(np.arange(1)).items():
        read = (lean if name in of_lean else full).rows_of(name)
        shape = (trajectory.n_set_points, *row.shape[1:])
        arrays[name] = kept[name] if name in kept else on_demand(shape, read)
    return labelled(arm, trajectory, arrays)


class _Blocks:
    """Decompositions of some states, the last of them kept: variables of a table are read one by one."""

    def __init__(self, states: States, evaluate: Callable[[States], dict[str, FloatArray]]) -> None:
        self._states, self._evaluate = states, evaluate
        self._rows = np.empty(0, dtype=np.intp)
        self._last: dict[str, FloatArray] = {}

    def at(self, rows: NDArray[np.intp]) -> dict[str, FloatArray]:
        """Evaluate them at some of the states."""
        if not np.array_equal(rows, self._rows):
            self._last = self._evaluate(self._states.at(rows))
            self._rows = rows
        return self._last

    def rows_of(self, name: str) -> Callable[[NDArray[np.intp]], FloatArray]:
        """Give one of the variables, by the rows asked for."""
        return lambda rows: self.at(rows)[name]


# Takes the numbers of some rows, increasing, and gives these rows, shape (rows, ...).
Read = Callable[[NDArray[np.intp]], Array]


def on_demand(shape: tuple[int, ...], read: Read) -> indexing.LazilyIndexedArray:
    """Make numbers for a variable of xarray that asks for rows whenever it is read, some thousand at a time.

    `isel` chooses without reading; `values` reads what was chosen, and keeps nothing.
    """
    return indexing.LazilyIndexedArray(_Rows(shape, read))


class _Rows(BackendArray):
    """What xarray indexes and, in the end, reads."""

    def __init__(self, shape: tuple[int, ...], read: Read) -> None:
        self.shape, self.dtype, self._read = shape, np.dtype(float), read

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._chosen
        )

    def _chosen(self, key: tuple[Any, ...]) -> Array:
        rows, rest = np.arange(self.shape[0])[key[0]], key[1:]
        every = np.atleast_1d(rows)
        shape = _at(np.empty((1, *self.shape[1:])), rest).shape[1:]
        out = np.moveaxis(np.empty((*shape, len(every))), -1, 0)  # as formulations lay out what they give
        for chunk in chunks(len(every)):
            out[chunk] = _at(self._read(every[chunk]), rest)
        return out if np.ndim(rows) else out[0]


def _at(values: Array, rest: tuple[Any, ...]) -> Array:
    """Index every axis but the first on its own, the last one first as some of them vanish."""
    for axis in range(len(rest), 0, -1):
        values = values[(*[slice(None)] * axis, rest[axis - 1])]
    return values
