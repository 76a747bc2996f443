"""Arm and trajectory in, Dataset out: every element of the dynamics by effect at every set point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from threading import get_ident
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gd_analyze.arguments import strict
from gd_analyze.arrays import CHUNK, Array, FloatArray, chunks, round_off_of
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import UsageError, require_type
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.states import States, broadcast_states, states_of
from gd_analyze.motions.states import require_joints as require_states_fit
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.description import fingerprint
from gd_analyze.schema import GROUPS, SCHEMA_VERSION, table
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr

# Most set points whose decomposition is kept: some 40 MB for six joints, and no fewer than a search uses. For
# more it pays to write the arithmetic as a program, which takes some hundredths of a second.
MOST_KEPT = 8192

# Results for every arm and motion.
_LEAN = ("inertia", "coriolis_centrifugal", "gravity_loading", "torque")

# Reads the rows of ascending numbers, shape (rows, ...).
ReadRows = Callable[[NDArray[np.intp]], Array]


@strict
@one_thread()
def decompose(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions | None = None,
    *,
    q: ArrayLike | None = None,
    qd: ArrayLike | None = None,
    qdd: ArrayLike | None = None,
    christoffel: bool = True,
    by_link: bool = False,
    terms: bool = False,
    drives: bool | None = None,
    progress: Progress = NO_PROGRESS,
) -> xr.Dataset:
    """Evaluate D, h, h_ijk and c by effect at every set point.

    Parameters
    ----------
    arm, trajectory
        The arm and its motion, or several motions; or a shipped name, or the path of a file.
    q, qd, qdd
        States in place of a motion: joint variables, velocities and accelerations, rad (m) and per s, s^2,
        shape (N, n) or (n,), which are broadcast; velocities and accelerations left out are zero. The dataset
        numbers them from 0 along `time`.
    christoffel
        Keep h_ijk: 2 n^3 numbers per set point.
    by_link
        Also give what each link adds to D, h and c (slower).
    terms
        Also give FGL87's terms of h separately (slower).
    drives
        Add the torque that accelerates the drives, as `drive_torque` and within `torque`; D, h and c remain
        those of the links. By default if the arm describes drives.
    progress
        Told the set points done.

    Returns
    -------
    xarray.Dataset
        The variables of docs/notation.md, units as attributes; the parts along `effect` sum to the whole.

    Raises
    ------
    TrajectoryError
        If the trajectory has another number of joints.
    UsageError
        If there is neither a motion nor q, or both, or the arrays do not fit.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> gd.decompose("two_link", q=[0.3, 0.1]).gravity_loading.shape
    (1, 2)
    >>> arm = gd.load_arm("two_link")
    >>> dataset = gd.decompose(arm, gd.read_trajectory("two-link-swing", arm))
    >>> dataset.inertia.dims
    ('time', 'effect', 'joint', 'joint_j')
    """
    arm = arm_of(arm)
    trajectory = _motion_of(arm, trajectory, q, qd, qdd)
    require_trajectory_joints(trajectory, arm)
    parts = {"christoffel": christoffel, "by_link": by_link, "terms": terms}
    arrays = decompose_states(arm, states_of(trajectory), **parts, drives=drives, progress=progress)
    return labelled(arm, trajectory, arrays)


def _motion_of(
    arm: RobotArm,
    trajectory: GivenMotions | None,
    q: ArrayLike | None,
    qd: ArrayLike | None,
    qdd: ArrayLike | None,
) -> Trajectory:
    """Take the motion given, or states as set points one second apart."""
    if (trajectory is None) == (q is None):
        message = "there is nothing to decompose" if q is None else "there are a motion and states"
        raise UsageError(message, where="trajectory", expected="either a motion or q")
    if trajectory is not None:
        for name, values in (("qd", qd), ("qdd", qdd)):
            if values is not None:
                message = f"{name} is for states, and a motion is given"
                raise UsageError(message, where=name, expected=f"a motion, or q with {name}")
        return trajectory_of(trajectory, arm)
    still, quantities = np.zeros(arm.n_joints), {"q": q, "qd": qd, "qdd": qdd}
    complete = {name: still if values is None else values for name, values in quantities.items()}
    arrays = broadcast_states(arm, **complete)
    if arrays[0].ndim > 2 or not arrays[0].size:
        expected, shape = f"shape (N, {arm.n_joints}) or ({arm.n_joints},)", str(arrays[0].shape)
        raise UsageError("q does not number its states", where="q", expected=expected, found=shape)
    q, qd, qdd = (array.reshape(-1, arm.n_joints) for array in arrays)
    return Trajectory(np.arange(float(len(q))), q, qd, qdd, "states", "arrays in memory, numbered along time")


def decomposition_coordinates(
    arm: RobotArm, trajectory: Trajectory, arrays: Mapping[str, Any]
) -> dict[str, Any]:
    """Coordinates of a table with these arrays."""
    coords: dict[str, Any] = {
        "time": ("time", trajectory.time, {"units": "s"}),
        "effect": list(dalembert.EFFECTS),
        "joint_name": ("joint", [joint.name for joint in arm.joints]),
        "joint_kind": ("joint", [joint.kind for joint in arm.joints]),
    }
    if "inertia_by_link" in arrays:
        coords["link"] = np.arange(1, arm.n_joints + 1)
    if "coriolis_centrifugal_terms" in arrays:
        coords["term"] = [term.name for term in dalembert.terms_of(arm)]
        coords["term_effect"] = ("term", [term.effect for term in dalembert.terms_of(arm)])
    return coords


def labelled(arm: RobotArm, trajectory: Trajectory, arrays: Mapping[str, Any]) -> xr.Dataset:
    """Make a table of arrays named as in `gd_analyze.schema.GROUPS`, time first."""
    coords = decomposition_coordinates(arm, trajectory, arrays)
    explained = round_off_bounds(arm, trajectory.q, trajectory.qd, trajectory.qdd)["torque"]
    drive_inertia = arm.drive_inertia if "drive_torque" in arrays else np.zeros(arm.n_joints)
    attrs = {
        "schema": SCHEMA_VERSION,
        "arm": arm.name,
        "arm_title": arm.title or arm.name,
        "arm_fingerprint": fingerprint(arm),
        "trajectory": trajectory.name,
        "trajectory_origin": trajectory.origin,
        "trajectory_velocities": trajectory.derivatives_from,
        "trajectory_fingerprint": trajectory.fingerprint,
        "drives": int("drive_torque" in arrays),
        "drive_inertia": drive_inertia.tolist(),
        "torque_round_off": round_off_of(np.asarray(arrays["torque"]), explained),
    }
    if trajectory.whole is not None:
        attrs["set_points"] = trajectory.n_stated
    if trajectory.gaps:
        attrs["gap_times"] = trajectory.time[list(trajectory.gaps)].tolist()
    if motions := trajectory.motions:
        attrs["motions"] = [motion.name for motion in motions]
        attrs["motion_ends"] = [motion.end for motion in motions]
        attrs["motion_fingerprints"] = [motion.fingerprint for motion in motions]
    return table("decomposition", arrays, arm.is_revolute, coords, attrs)


def gaps_in(dataset: xr.Dataset) -> tuple[int, ...]:
    """Set points of a decomposition, or of some of its rows, before which the motion is unknown."""
    before = np.searchsorted(dataset.time.values, np.atleast_1d(dataset.attrs.get("gap_times", [])))
    return tuple(row for row in np.unique(before).tolist() if 0 < row < dataset.sizes["time"])


@strict
@one_thread()
def decompose_states(
    arm: RobotArm,
    states: States,
    *,
    christoffel: bool = True,
    shares: bool = True,
    by_link: bool = False,
    terms: bool = False,
    drives: bool | None = None,
    progress: Progress = NO_PROGRESS,
    written: bool | None = None,
) -> dict[str, FloatArray]:
    """Decompose states of any leading shape: arrays in, arrays out, no labels.

    Parameters
    ----------
    arm
        The arm.
    states
        Joint variables, velocities and accelerations, shape (..., n).
    christoffel, by_link, terms, drives, progress
        As for `decompose`.
    shares
        Also give centrifugal and Coriolis shares of h.
    written
        Run the arithmetic as a program without zeros and repeated steps; by default for more than
        `MOST_KEPT` states. Results are equal up to round-off.

    Returns
    -------
    dict
        Arrays by the names of docs/notation.md, SI units, shape (..., effect, n, n) and so on; in memory the
        set points are contiguous.

    Raises
    ------
    TrajectoryError
        If the states have another number of joints.
    ArmError
        If drives are asked for and the arm describes none.
    """
    require_type(arm, RobotArm, "arm", "a RobotArm, as `load_arm` returns it")
    require_type(states, States, "states", "the States of `states_of` or `states_in_box`")
    require_states_fit(arm, states)
    leading, drives = states.q.shape[:-1], arm.counts_drives(drives)
    q, qd, qdd = states.last
    count = q.shape[1]
    names = [*_LEAN]
    if shares:
        names += ["centrifugal", "coriolis"]
    if christoffel:
        names.append("christoffel")
    if drives:
        names.append("drive_torque")
    if by_link:
        names += ["inertia_by_link", "coriolis_centrifugal_by_link", "gravity_loading_by_link"]
    if terms:
        names.append("coriolis_centrifugal_terms")
    out = _empty(arm, names, count)
    # glibc returns freed memory to the system beyond a threshold, and every page taken again costs a fault:
    # as much time as the arithmetic. Freeing an untouched block just below 32 MiB raises that threshold for
    # good (see mallopt(3), M_MMAP_THRESHOLD); elsewhere it does nothing.
    np.empty(2**25 - 2**16, dtype=np.uint8)
    progress.stage("decomposing", count)
    if count > MOST_KEPT if written is None else written:
        _run(arm, names, (q, qd, qdd), out, progress)
    else:
        for chunk in chunks(count):
            views = {name: array[..., chunk] for name, array in out.items()}
            _fill(arm, q[:, chunk], qd[:, chunk], qdd[:, chunk], views)
            progress.advance(chunk.stop - chunk.start)
    out = {"q": q, "qd": qd, "qdd": qdd} | out
    # Set points first, without copying: the memory keeps them last.
    firsts = {name: np.moveaxis(array, -1, 0) for name, array in out.items()}
    return {name: array.reshape(*leading, *array.shape[1:]) for name, array in firsts.items()}


def _empty(arm: RobotArm, names: Sequence[str], count: int, dtype: type = float) -> dict[str, Array]:
    """Make arrays for the results of a decomposition, set points last."""
    n = arm.n_joints
    sizes = {"effect": 2, "term": len(dalembert.terms_of(arm))}
    dims = {name: GROUPS["decomposition"][name].dims[1:] for name in names}
    return {name: np.empty((*(sizes.get(dim, n) for dim in dims[name]), count), dtype) for name in names}


@lru_cache(maxsize=8)
def _program(arm: RobotArm, names: tuple[str, ...], outputs: tuple[str, ...]) -> Program:
    """Program of `_fill` for the named arrays, with the wanted results one after another."""
    trace, out = Trace(), _empty(arm, names, 1, object)
    q, qd, qdd = (trace.inputs(name, arm.n_joints) for name in ("q", "qd", "qdd"))
    _fill(arm, q, qd, qdd, out)
    return Program.of(trace, [x for name in outputs for x in out[name].ravel().tolist()])


@lru_cache(maxsize=4)
def _runner(program: Program, at_once: int, thread: int) -> Callable[..., FloatArray]:
    """Run a program in memory that is kept; every thread needs its own."""
    return program.runner(at_once)


def _run(
    arm: RobotArm,
    names: Sequence[str],
    states: Sequence[Array],
    out: Mapping[str, Array],
    progress: Progress,
) -> None:
    """Evaluate many states (n, N) by a program, block by block, into the wanted arrays."""
    count, kinds = states[0].shape[-1], ("q", "qd", "qdd")
    rows = [row for array in out.values() for row in array.reshape(-1, count)]
    inputs = {f"{kind}{i + 1}": row for kind, x in zip(kinds, states, strict=True) for i, row in enumerate(x)}
    run = _runner(_program(arm, tuple(names), tuple(out)), min(count, CHUNK), get_ident())
    for chunk in chunks(count):
        run({name: row[chunk] for name, row in inputs.items()}, [row[chunk] for row in rows])
        progress.advance(chunk.stop - chunk.start)


def torque_of(
    arm: RobotArm,
    states: States,
    *,
    drives: bool | None = None,
    progress: Progress = NO_PROGRESS,
) -> FloatArray:
    """Torque at states (..., n), N m, same shape, without keeping its contributions."""
    require_states_fit(arm, states)
    flat = states.in_a_row
    progress.stage("decomposing", len(flat))
    names = [*_LEAN, "drive_torque"] if arm.counts_drives(drives) else [*_LEAN]
    out = np.empty((len(flat), arm.n_joints))
    for chunk in chunks(len(flat)):
        some = flat.at(chunk)
        if len(flat) > MOST_KEPT:
            rows = _empty(arm, ["torque"], len(some))
            _run(arm, names, some.last, rows, progress)
            out[chunk] = rows["torque"].T
        else:
            out[chunk] = decompose_states(arm, some, christoffel=False, drives=drives)["torque"]
            progress.advance(len(some))
    return out.reshape(states.q.shape)


def _fill(arm: RobotArm, q: Array, qd: Array, qdd: Array, out: dict[str, Array]) -> None:
    """Evaluate one chunk of set points into views of the results."""
    kinematics = solve_kinematics(arm, q)
    moments = composite.composite_moments(arm, kinematics)
    inertia = composite.inertia(moments, out["inertia"])
    pairs = composite.brackets(moments)
    if "christoffel" in out:
        composite.christoffel(moments, pairs, out["christoffel"])
    h, centrifugal = composite.coriolis_centrifugal(moments, pairs, qd)
    out["coriolis_centrifugal"][:] = h
    if "coriolis" in out:
        out["centrifugal"][:] = centrifugal
        np.subtract(h, centrifugal, out=out["coriolis"])
    out["gravity_loading"][:] = composite.gravity_loading(arm, moments)
    torque = out["torque"]
    np.einsum("eijn,jn->in", inertia, qdd, out=torque)
    torque += h.sum(axis=0) + out["gravity_loading"]
    if "drive_torque" in out:
        np.multiply(arm.drive_inertia[:, None], qdd, out=out["drive_torque"])
        torque += out["drive_torque"]
    if "inertia_by_link" in out:
        out["inertia_by_link"][:] = dalembert.inertia_by_link(arm, kinematics)
        out["gravity_loading_by_link"][:] = dalembert.gravity_loading_by_link(arm, kinematics)
    if "coriolis_centrifugal_terms" in out or "coriolis_centrifugal_by_link" in out:
        itemised = dalembert.coriolis_centrifugal_by_link(arm, kinematics, qd)
        effects = np.array([term.effect for term in dalembert.terms_of(arm)])
        if "coriolis_centrifugal_terms" in out:
            out["coriolis_centrifugal_terms"][:] = itemised.sum(axis=1)
        if "coriolis_centrifugal_by_link" in out:
            by_effect = [itemised[effects == effect].sum(axis=0) for effect in dalembert.EFFECTS]
            out["coriolis_centrifugal_by_link"][:] = by_effect


def decompose_on_demand(
    arm: RobotArm,
    trajectory: Trajectory,
    *,
    drives: bool | None = None,
    progress: Progress = NO_PROGRESS,
    **parts: Any,
) -> xr.Dataset:
    """Decompose; beyond `MOST_KEPT` set points all but torque is evaluated on access."""
    if trajectory.n_set_points <= MOST_KEPT:
        return decompose(arm, trajectory, drives=drives, progress=progress, **parts)
    require_trajectory_joints(trajectory, arm)
    in_memory = {kind: getattr(trajectory, kind) for kind in ("q", "qd", "qdd")}
    in_memory["torque"] = torque_of(arm, states_of(trajectory), drives=drives, progress=progress)
    return labelled(arm, trajectory, arrays_on_demand(arm, trajectory, drives, **parts) | in_memory)


def arrays_on_demand(
    arm: RobotArm, trajectory: Trajectory, drives: bool | None, **parts: Any
) -> dict[str, Any]:
    """The arrays of `decompose`, evaluated on access."""
    # Slow or large arrays are evaluated only if read themselves.
    lean = _Rows(trajectory, partial(decompose_states, arm, christoffel=False, drives=drives, written=True))
    full = _Rows(trajectory, partial(decompose_states, arm, drives=drives, written=True, **parts))
    first = np.arange(1)
    in_lean = set(lean.at(first))
    arrays: dict[str, Any] = {}
    for name, row in full.at(first).items():
        shape = (trajectory.n_set_points, *row.shape[1:])
        read = partial((lean if name in in_lean else full).variable, name)
        arrays[name] = on_demand(shape, read)
    return arrays


class _Rows:
    """Decompositions of some set points; the last one is kept, as variables are read one by one."""

    def __init__(self, motion: Trajectory, evaluate: Callable[[States], dict[str, FloatArray]]) -> None:
        self._motion, self._evaluate = motion, evaluate
        self._rows, self._last = np.empty(0, dtype=np.intp), dict[str, FloatArray]()

    def at(self, rows: NDArray[np.intp]) -> dict[str, FloatArray]:
        if not np.array_equal(rows, self._rows):
            motion = self._motion
            states = States(motion.q[rows], motion.qd[rows], motion.qdd[rows])
            self._last, self._rows = self._evaluate(states), rows
        return self._last

    def variable(self, name: str, rows: NDArray[np.intp]) -> FloatArray:
        return self.at(rows)[name]


def on_demand(shape: tuple[int, ...], read: ReadRows) -> Any:
    """Values of an xarray variable that are evaluated by rows on access and not kept."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class OnDemand(BackendArray):
        def __init__(self) -> None:
            self.shape, self.dtype = shape, np.dtype(float)

        def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
            outer, chosen = indexing.IndexingSupport.OUTER, partial(_chosen, shape, read)
            return indexing.explicit_indexing_adapter(key, shape, outer, chosen)

    return indexing.LazilyIndexedArray(OnDemand())


def _chosen(shape: tuple[int, ...], read: ReadRows, key: tuple[Any, ...]) -> Array:
    chosen, axis_keys = key[0], key[1:]
    rows = np.arange(*chosen.indices(shape[0])) if isinstance(chosen, slice) else np.asarray(chosen)
    rows = np.where(rows < 0, rows + shape[0], rows)
    row_numbers = np.atleast_1d(rows)
    of_a_row = _at(np.empty((1, *shape[1:])), axis_keys).shape[1:]
    out = np.moveaxis(np.empty((*of_a_row, len(row_numbers))), -1, 0)  # the layout of the formulations
    for chunk in chunks(len(row_numbers)):
        out[chunk] = _at(read(row_numbers[chunk]), axis_keys)
    return out if np.ndim(rows) else out[0]


def _at(values: Array, axis_keys: tuple[Any, ...]) -> Array:
    """Index every axis but the first separately, from the last, as some of them vanish."""
    for axis in range(len(axis_keys), 0, -1):
        values = values[(*[slice(None)] * axis, axis_keys[axis - 1])]
    return values
