"""Which set points of a motion searches look at: all of them, or those that represent a long motion.

Both ways answer the same questions: what is decomposed, whether models keep their budgets everywhere, and
what tables show.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, chunks, evenly
from gd_analyze.certification.held import Held
from gd_analyze.dynamics.decomposition import (
    MOST_KEPT,
    contributions_program,
    decompose,
    decompose_on_demand,
    decompose_states,
)
from gd_analyze.dynamics.dominance import Extremes, elements
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Batch, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.results.motion_tables import every_set_point_table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.studies.steps.read import RunInputs

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True)
class SetPointSettings:
    """Which set points represent a long motion."""

    evenly_searched: int = 400  # evenly spaced set points of a search besides the extremes
    shown_parts: int = 12  # parts of the motion whose extremes are shown
    # Least set points in tables and figures, several for each column of pixels in a figure.
    least_shown: int = 1500
    # Rounds that add set points at which a model exceeds its budget to those of the search.
    most_rounds: int = 20


SET_POINT_SETTINGS = SetPointSettings()


# Most set points whose decomposition is stored by default, 150 MB for six joints: evaluating one again takes
# less time than writing it.
MOST_STORED = 2**17

_KINDS = ("q", "qd", "qdd")
# Set points, from 0, ascending.
Points = NDArray[np.intp]
# Searches the model by elements and the run's model, from exact dynamics at some set points.
Search: TypeAlias = Callable[[ExactDynamics], tuple[SimplifiedModel, Held]]
# Dynamics at the states of the last search, both models with their errors at all set points, and the set
# points of the largest errors where searches look at some only.
Settled: TypeAlias = tuple[ExactDynamics, SimplifiedModel, Held, Points]


def set_points_of(inputs: RunInputs, progress: Callable[[int], None]) -> KeptMotion | LongMotion:
    """Decompose a motion: all of it, or a long one block by block."""
    motion = inputs.trajectory
    if motion.n_set_points > MOST_KEPT and not motion.motions and motion.recording is None:
        return LongMotion.of(inputs, progress)
    dataset = decompose_on_demand(inputs.arm, motion, **inputs.stored_parts, progress=progress)
    return KeptMotion(inputs, dataset)


@dataclass(frozen=True, eq=False)
class KeptMotion:
    """A motion whose every set point is decomposed, searched and shown."""

    inputs: RunInputs
    dataset: xr.Dataset
    extremes: Extremes | None = None  # of the elements; None where the dataset has them

    def settled(self, exact: ExactDynamics, search: Search) -> Settled:
        """Search once: the models keep their budgets at every set point."""
        return exact, *search(exact), np.empty(0, dtype=np.intp)

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
    accelerations, torques, elements of D, h and c, their parts, and the torque of each.
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

    @classmethod
    def of(cls, inputs: RunInputs, progress: Callable[[int], None]) -> LongMotion:
        """Decompose the motion once, and note its extremes."""
        arm, motion = inputs.arm, inputs.trajectory
        drives = arm.counts_drives(inputs.settings.drives)
        drive_inertia = arm.drive_inertia if drives else np.zeros(arm.n_joints)
        extremes = Extremes(arm.n_joints, elements(arm.n_joints), drive_inertia)
        values, places = [], []
        for chunk in chunks(motion.n_set_points):
            states = States(*(getattr(motion, kind)[chunk] for kind in _KINDS))
            block = decompose_states(
                arm, states, christoffel=False, shares=False, drives=drives, written=True
            )
            extremes.add(block)
            rows = np.hstack([block[kind] for kind in (*_KINDS, "torque")]).T
            at = np.stack([rows.argmin(axis=1), rows.argmax(axis=1)])
            values.append(np.take_along_axis(rows, at.T, axis=1).T)
            places.append(chunk.start + at)
            progress(len(states))
        value, place = np.array(values), np.array(places)
        parts = np.array_split(np.arange(len(value)), min(SET_POINT_SETTINGS.shown_parts, len(value)))
        points = (
            evenly(motion.n_set_points, SET_POINT_SETTINGS.evenly_searched),
            *_reached(value, place, [np.arange(len(value))]),
        )
        searched = np.unique(np.concatenate([*points, extremes.reached.ravel()]))
        shown = np.unique(np.concatenate([searched, *_reached(value, place, parts)]))
        evenly_spaced = evenly(motion.n_set_points, max(SET_POINT_SETTINGS.least_shown - len(shown), 2))
        dataset = decompose(arm, motion.at(searched), drives=drives, christoffel=False)
        return cls(inputs, dataset, extremes, np.union1d(shown, evenly_spaced))

    def states(self, points: Points) -> States:
        """Take some set points."""
        return States(self.motion.q[points], self.motion.qd[points], self.motion.qdd[points])

    def settled(self, exact: ExactDynamics, search: Search) -> Settled:
        """Search until both models keep their budgets at every set point; raise after too many rounds."""
        torques = contributions_program(self.arm, self.arm.counts_drives(self.inputs.settings.drives))
        for _ in range(SET_POINT_SETTINGS.most_rounds):
            element_model, held_model = search(exact)
            (element_model, model), worst, broken = self.stated(
                exact, (element_model, held_model.model), torques
            )
            if not broken.any():
                return exact, element_model, held_model._replace(model=model), worst.ravel()
            states = np.stack(self.states(np.unique(worst[broken])).arrays)
            exact = exact.joined_by(states, np.ones(states.shape[1:]))
        message = "the model misses its budget"
        next_step = "please report this with the arm file and the motion"
        raise GdAnalyzeError(message, where=f"trajectory {self.motion.name}", next_step=next_step)

    def stated(
        self, exact: ExactDynamics, models: Sequence[SimplifiedModel], torques: Program
    ) -> tuple[list[SimplifiedModel], Points, NDArray[np.bool_]]:
        """State the errors of models at all set points, given a program of the exact torques.

        Also returns the set point of each model's largest error at each joint, shape (models, n), and whether
        it exceeds the allowed one. All models form one program, so that they share steps.
        """
        n, count = self.arm.n_joints, self.motion.n_set_points
        trace = Trace()
        programs = {id(model.program): model.program for model in models}
        all_programs = (torques, *programs.values())
        values = [(program.folded(trace, {}), program.outputs) for program in all_programs]
        joint = Program.of(trace, [value(output) for value, outputs in values for output in outputs])
        batch, floor = Batch(joint, min(count, CHUNK)), exact.round_off
        largest, squares = np.zeros((2, len(programs), n))
        worst = np.zeros((len(programs), n), dtype=np.intp)
        arrays = {kind: getattr(self.motion, kind) for kind in _KINDS}
        for chunk in chunks(count):
            # The last block overlaps the one before.
            block = slice(chunk.stop - batch.count, chunk.stop)
            inputs = {
                f"{kind}{i + 1}": x for kind, rows in arrays.items() for i, x in enumerate(rows[block].T)
            }
            torque = batch.at(inputs)[:, chunk.start - block.start :].reshape(len(all_programs), n, -1)
            error = torque[1:] - torque[0]
            error[np.abs(error) <= floor] = 0.0
            squares += np.einsum("min,min->mi", error, error)
            np.abs(error, out=error)
            at = error.argmax(axis=2)
            top = np.take_along_axis(error, at[..., None], axis=2)[..., 0]
            worst = np.where(top > largest, chunk.start + at, worst)
            largest = np.maximum(largest, top)
        place = [[*programs].index(id(model.program)) for model in models]
        largest, squares, worst = largest[place], squares[place], worst[place]
        stated_models = []
        fitted_on: dict[str, str | int] = {
            "trajectory": self.motion.name,
            "trajectory_fingerprint": self.motion.fingerprint,
            "set_points": count,
        }
        for model, largest_error, square in zip(models, largest, squares, strict=True):
            errors = ErrorTable(exact.peak_torque, largest_error, np.sqrt(square / count))
            stated_models.append(model.stating(replace(model.accuracy, errors=errors, fitted_on=fitted_on)))
        allowed = np.array([model.accuracy.allowed for model in models])
        return stated_models, worst, largest > allowed

    def path(self, exact: ExactDynamics, models: Sequence[SimplifiedModel]) -> tuple[SimplifiedModel, ...]:
        """State the errors of models for growing budgets.

        A model that exceeds its budget is replaced by the one before, the first one by the exact torque.
        """
        checked_models, _, broken = self.stated(exact, models, exact.form.program)
        result: list[SimplifiedModel] = []
        for model, breaks in zip(checked_models, np.any(broken, axis=1).tolist(), strict=True):
            requested = model.accuracy
            if breaks and result:
                last = result[-1]
                accuracy = replace(last.accuracy, allowed=requested.allowed, budget=requested.budget)
                result.append(last.stating(accuracy))
            else:
                result.append(
                    exactly(exact, model.level, requested.allowed, requested.budget) if breaks else model
                )
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


def _reached(values: NDArray[np.float64], places: Points, groups: Sequence[Points]) -> list[Points]:
    """Set points of the smallest and largest values, shape (blocks, 2, rows), by groups of blocks."""
    points = []
    for group in groups:
        for side, pick in enumerate((np.argmin, np.argmax)):
            best = pick(values[group, side], axis=0)
            points.append(np.take_along_axis(places[group, side], best[None], axis=0)[0])
    return points
