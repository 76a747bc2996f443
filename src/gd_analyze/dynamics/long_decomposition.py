"""Decompositions of long trajectories, evaluated again where they are read instead of kept.

Evaluating D, h and c at a set point takes some microseconds, no longer than reading them from a file would.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics.decomposition import decompose, decompose_states, labelled, torque_of
from gd_analyze.motions.limits import require_joints
from gd_analyze.motions.states import States, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

if TYPE_CHECKING:
    import xarray as xr

# Set points whose decomposition is kept: some 40 MB for six joints, and no fewer than a search looks at.
MOST_KEPT = 8192

# Takes the numbers of some rows, increasing, and gives these rows, shape (rows, ...).
Read = Callable[[NDArray[np.intp]], Array]


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
    """Do `decompose`; of more than `MOST_KEPT` set points all but torque is evaluated when it is read."""
    options: dict[str, Any] = {
        "christoffel": christoffel, "by_link": by_link, "terms": terms, "drives": drives,
    }  # fmt: skip
    if trajectory.n_set_points <= MOST_KEPT:
        return decompose(arm, trajectory, progress=progress, **options)
    require_joints(trajectory, arm)
    states = states_of(trajectory)
    kept = dict(zip(("q", "qd", "qdd"), states.arrays, strict=True))
    kept["torque"] = torque_of(arm, states, drives=drives, progress=progress)
    # What takes long or is large is evaluated only where it is read.
    lean = _Rows(states, partial(decompose_states, arm, christoffel=False, drives=drives))
    full = _Rows(states, partial(decompose_states, arm, **options))
    first = np.arange(1)
    in_lean = set(lean.at(first))
    arrays: dict[str, Any] = {}
    for name, row in full.at(first).items():
        shape = (trajectory.n_set_points, *row.shape[1:])
        read = partial((lean if name in in_lean else full).variable, name)
        arrays[name] = kept[name] if name in kept else on_demand(shape, read)
    return labelled(arm, trajectory, arrays)


class _Rows:
    """Decompositions of some states, the last of them kept: variables of a table are read one by one."""

    def __init__(self, states: States, evaluate: Callable[[States], dict[str, FloatArray]]) -> None:
        self._states, self._evaluate = states, evaluate
        self._rows, self._last = np.empty(0, dtype=np.intp), dict[str, FloatArray]()

    def at(self, rows: NDArray[np.intp]) -> dict[str, FloatArray]:
        if not np.array_equal(rows, self._rows):
            self._last, self._rows = self._evaluate(self._states.at(rows)), rows
        return self._last

    def variable(self, name: str, rows: NDArray[np.intp]) -> FloatArray:
        return self.at(rows)[name]


def on_demand(shape: tuple[int, ...], read: Read) -> Any:
    """Numbers for a variable of xarray that asks for rows whenever it is read; it keeps nothing."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class OnDemand(BackendArray):
        def __init__(self) -> None:
            self.shape, self.dtype = shape, np.dtype(float)

        def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
            outer = indexing.IndexingSupport.OUTER
            return indexing.explicit_indexing_adapter(
                key, shape, outer, lambda key: _chosen(shape, read, key)
            )

    return indexing.LazilyIndexedArray(OnDemand())


def _chosen(shape: tuple[int, ...], read: Read, key: tuple[Any, ...]) -> Array:
    rows, rest = np.arange(shape[0])[key[0]], key[1:]
    every = np.atleast_1d(rows)
    of_a_row = _at(np.empty((1, *shape[1:])), rest).shape[1:]
    out = np.moveaxis(np.empty((*of_a_row, len(every))), -1, 0)  # as formulations lay out what they give
    for chunk in chunks(len(every)):
        out[chunk] = _at(read(every[chunk]), rest)
    return out if np.ndim(rows) else out[0]


def _at(values: Array, rest: tuple[Any, ...]) -> Array:
    """Index every axis but the first on its own, the last one first as some of them vanish."""
    for axis in range(len(rest), 0, -1):
        values = values[(*[slice(None)] * axis, rest[axis - 1])]
    return values
