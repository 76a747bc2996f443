"""Which set points of a motion searches look at: all of them, or those that represent a long motion.

Both ways answer the same questions: what is decomposed, whether models keep their budgets everywhere, and
what tables show.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, FloatArray, chunks, evenly
from gd_analyze.dynamics.decomposition import (
    MOST_KEPT,
    decompose,
    decompose_on_demand,
    decompose_states,
    torque_of,
)
from gd_analyze.dynamics.dominance import Extremes, elements
from gd_analyze.figures.joints import most_accelerated
from gd_analyze.motions.measured import filtered_torque
from gd_analyze.motions.states import States, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.progress import Progress
from gd_analyze.results.motion_tables import every_set_point_table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.simplification.simplify import Check, Excess
from gd_analyze.studies.steps.read import RunInputs

if TYPE_CHECKING:
    import xarray as xr


# Evenly spaced set points of a search besides the extremes.
EVENLY_SEARCHED = 400
# Parts of a long motion whose extremes are shown.
_SHOWN_PARTS = 12
# Least set points of a long motion in tables and figures, several for each column of pixels in a figure.
_LEAST_SHOWN = 1500
# Most set points of an enlarged part of it that are shown.
_ENLARGED_SHOWN = 120
# Most set points whose decomposition is stored by default, 150 MB for six joints: evaluating one again takes
# less time than writing it.
MOST_STORED = 2**17

_KINDS = ("q", "qd", "qdd")
# Set points, from 0, ascending.
Points = NDArray[np.intp]


def set_points_of(inputs: RunInputs, progress: Progress) -> KeptMotion | LongMotion:
    """Decompose a motion: all of it, or a long one block by block."""
    motion = inputs.trajectory
    if motion.n_set_points > MOST_KEPT and not motion.motions:
        return LongMotion.of(inputs, progress)
    dataset = decompose_on_demand(inputs.arm, motion, **inputs.stored_parts, progress=progress)
    return KeptMotion(inputs, dataset)


@dataclass(frozen=True, eq=False)
class KeptMotion:
    """A motion whose every set point is decomposed, searched and shown."""

    inputs: RunInputs
    dataset: xr.Dataset
    extremes: Extremes | None = None  # of the elements; None where the dataset has them

    @property
    def torque(self) -> FloatArray:
        """Exact torque at every set point, N m, shape (N, n)."""
        return np.asarray(self.dataset.torque.values)

    @property
    def everywhere(self) -> tuple[Check, ...]:
        """No further checks: a search keeps the budget at every set point."""
        return ()

    def stated(
        self, exact: ExactDynamics, models: Sequence[SimplifiedModel]
    ) -> tuple[list[SimplifiedModel], Points]:
        """Models with their errors at every set point, as searches state them; no set points stand out."""
        return list(models), np.empty(0, dtype=np.intp)

    def path(self, exact: ExactDynamics, models: Sequence[SimplifiedModel]) -> tuple[SimplifiedModel, ...]:
        """State the errors of models for growing budgets."""
        return tuple(measured(exact, model) for model in models)

    def shown(self, worst: Points) -> tuple[Trajectory, xr.Dataset]:
        """Return the motion and its decomposition for tables and figures."""
        return self.inputs.trajectory, self.dataset

    def every_set_point(self, model: SimplifiedModel) -> xr.Dataset | None:
        """There is no further table: the others hold every set point."""
        return None


@dataclass(frozen=True, eq=False)
class LongMotion:
    """A motion of more set points than are kept, and the set points that represent it.

    The set points of `dataset` include the extremes over the whole motion of positions, velocities,
    accelerations, torques, elements of D, h and c, their parts, and the torque of each. Those of
    `represented_by` also include, by part of the motion, where readings differ most from the smoothed motion
    and from the exact torque.
    """

    inputs: RunInputs
    dataset: xr.Dataset  # decomposition at the set points that searches look at
    extremes: Extremes  # of the elements, at all set points
    represented_by: Points  # these and others for tables and figures

    @property
    def arm(self) -> RobotArm:
        """The arm."""
        return self.inputs.arm

    @property
    def motion(self) -> Trajectory:
        """The whole motion."""
        return self.inputs.trajectory

    @property
    def torque(self) -> FloatArray:
        """Exact torque at every set point, N m, shape (N, n); evaluated on access."""
        return torque_of(self.arm, states_of(self.motion), drives=self.inputs.settings.drives)

    @classmethod
    def of(cls, inputs: RunInputs, progress: Progress) -> LongMotion:
        """Decompose the motion once, and note its extremes."""
        arm, motion = inputs.arm, inputs.trajectory
        drives = arm.counts_drives(inputs.settings.drives)
        drive_inertia = arm.drive_inertia if drives else np.zeros(arm.n_joints)
        extremes = Extremes(arm.n_joints, elements(arm.n_joints), drive_inertia)
        values, places = [], []
        progress.stage("decomposing", motion.n_set_points)
        for chunk in chunks(motion.n_set_points):
            states = States(*(getattr(motion, kind)[chunk] for kind in _KINDS))
            block = decompose_states(
                arm, states, christoffel=False, shares=False, drives=drives, written=True
            )
            extremes.add(block)
            of_motion = [block[kind] for kind in (*_KINDS, "torque")]
            rows = np.hstack([*of_motion, *_of_readings(motion, chunk, block)]).T
            at = np.stack([rows.argmin(axis=1), rows.argmax(axis=1)])
            values.append(np.take_along_axis(rows, at.T, axis=1).T)
            places.append(chunk.start + at)
            progress.advance(len(states))
        value, place = np.array(values), np.array(places)
        everywhere, n_of_motion = np.arange(len(value)), 4 * arm.n_joints
        parts = np.array_split(everywhere, min(_SHOWN_PARTS, len(value)))
        points = (
            evenly(motion.n_set_points, EVENLY_SEARCHED),
            *_reached(value[..., :n_of_motion], place[..., :n_of_motion], [everywhere]),
        )
        searched = np.unique(np.concatenate([*points, extremes.reached.ravel()]))
        shown = np.unique(np.concatenate([searched, *_reached(value, place, parts)]))
        evenly_spaced = evenly(motion.n_set_points, max(_LEAST_SHOWN - len(shown), 2))
        dataset = decompose(arm, motion.at(searched), drives=drives, christoffel=False)
        represented_by = np.unique(np.concatenate([shown, evenly_spaced, *_enlarged(motion)]))
        return cls(inputs, dataset, extremes, represented_by)

    @cached_property
    def round_off(self) -> float:
        """Torque that is only round-off, N m."""
        return ExactDynamics.of(self.arm, self.dataset).round_off

    def states(self, points: Points) -> States:
        """Take some set points."""
        return States(self.motion.q[points], self.motion.qd[points], self.motion.qdd[points])

    @property
    def everywhere(self) -> tuple[Check, ...]:
        """A check at every set point of the motion: the worst of every joint joins the search."""
        return (self._exceeding,)

    def _exceeding(self, model: SimplifiedModel, turn: int) -> Excess:
        """Look where a model exceeds its budget at the motion's set points."""
        (largest,), _, (worst,) = self._errors(model.form, [model])
        states = np.stack(self.states(np.unique(worst[largest > model.accuracy.allowed])).arrays)
        return Excess(states, np.ones(states.shape[1:]), largest)

    def stated(
        self, exact: ExactDynamics, models: Sequence[SimplifiedModel]
    ) -> tuple[list[SimplifiedModel], Points]:
        """Models with their errors at every set point, and the set points of the largest errors."""
        largest, squares, worst = self._errors(exact.form, models)
        count = self.motion.n_set_points
        fitted_on: dict[str, str | int] = {
            "trajectory": self.motion.name,
            "trajectory_fingerprint": self.motion.fingerprint,
            "set_points": count,
        }
        stated_models = []
        for model, largest_error, square in zip(models, largest, squares, strict=True):
            errors = ErrorTable(exact.peak_torque, largest_error, np.sqrt(square / count))
            stated_models.append(model.stating(replace(model.accuracy, errors=errors, fitted_on=fitted_on)))
        return stated_models, worst.ravel()

    def _errors(
        self, form: ExactForm, models: Sequence[SimplifiedModel]
    ) -> tuple[FloatArray, FloatArray, Points]:
        """Largest error, sum of squared errors, and set point of the largest error, shape (models, n) each.

        All models form one program with the exact torque, so that they share steps.
        """
        n, count = self.arm.n_joints, self.motion.n_set_points
        trace = Trace()
        programs = {id(model.program): model.program for model in models}
        all_programs = (form.program, *programs.values())
        values = [(program.folded(trace, {}), program.outputs) for program in all_programs]
        joint = Program.of(trace, [value(output) for value, outputs in values for output in outputs])
        run = joint.runner(min(count, CHUNK))
        largest, squares = np.zeros((2, len(programs), n))
        worst = np.zeros((len(programs), n), dtype=np.intp)
        arrays = {kind: getattr(self.motion, kind) for kind in _KINDS}
        for chunk in chunks(count):
            inputs = {
                f"{kind}{i + 1}": x for kind, rows in arrays.items() for i, x in enumerate(rows[chunk].T)
            }
            torque = run(inputs).reshape(len(all_programs), n, -1)
            error = torque[1:] - torque[0]
            error[np.abs(error) <= self.round_off] = 0.0
            squares += np.einsum("min,min->mi", error, error)
            np.abs(error, out=error)
            at = error.argmax(axis=2)
            top = np.take_along_axis(error, at[..., None], axis=2)[..., 0]
            worst = np.where(top > largest, chunk.start + at, worst)
            largest = np.maximum(largest, top)
        place = [[*programs].index(id(model.program)) for model in models]
        return largest[place], squares[place], worst[place]

    def path(self, exact: ExactDynamics, models: Sequence[SimplifiedModel]) -> tuple[SimplifiedModel, ...]:
        """State the errors of models for growing budgets.

        A model that exceeds its budget is replaced by the one before, the first one by the exact torque.
        """
        result: list[SimplifiedModel] = []
        for model, requested in zip(self.stated(exact, models)[0], models, strict=True):
            allowed, budget = requested.accuracy.allowed, requested.accuracy.budget
            if not (model.accuracy.errors.largest > allowed).any():
                result.append(model)
            elif result:
                last = result[-1]
                result.append(last.stating(replace(last.accuracy, allowed=allowed, budget=budget)))
            else:
                result.append(exactly(exact, model.level, allowed, budget))
        return tuple(result)

    def shown(self, worst: Points) -> tuple[Trajectory, xr.Dataset]:
        """Return set points for tables and figures, the worst of them included, and their decomposition."""
        motion = self.motion.at(np.union1d(self.represented_by, worst))
        dataset = decompose(self.arm, motion, **self.inputs.stored_parts)
        dataset.attrs |= self.inputs.source
        return motion, dataset

    def every_set_point(self, model: SimplifiedModel) -> xr.Dataset | None:
        """Tabulate the decomposition at every set point where it is to be stored; evaluated on access."""
        is_stored = self.inputs.settings.every_set_point
        if is_stored is None:
            is_stored = self.motion.n_set_points <= MOST_STORED
        if not is_stored:
            return None
        return every_set_point_table(self.arm, self.motion, model, **self.inputs.stored_parts)


def _of_readings(motion: Trajectory, chunk: slice, block: Mapping[str, FloatArray]) -> Iterator[FloatArray]:
    """What readings say beyond the motion, (N, n) each: their noise, and torques beside the exact ones."""
    recording = motion.recording
    if recording is not None and recording.measured:
        yield recording.q[chunk] - block["q"]
    if recording is not None and recording.torque is not None:
        for torque in (recording.torque, filtered_torque(motion)):
            yield np.nan_to_num(torque[chunk] - block["torque"])


def _enlarged(motion: Trajectory) -> list[Points]:
    """Set points, by joint, of the enlarged parts in the figure of readings; none of a plan."""
    if motion.recording is None or not motion.recording.measured:
        return []
    parts = [most_accelerated(motion, joint) for joint in range(motion.n_joints)]
    return [part[evenly(len(part), _ENLARGED_SHOWN)] for part in parts]


def _reached(values: NDArray[np.float64], places: Points, groups: Sequence[Points]) -> list[Points]:
    """Set points of the smallest and largest values, shape (blocks, 2, rows), by groups of blocks."""
    points = []
    for group in groups:
        for side, pick in enumerate((np.argmin, np.argmax)):
            best = pick(values[group, side], axis=0)
            points.append(np.take_along_axis(places[group, side], best[None], axis=0)[0])
    return points
