"""A long motion block by block: set points that represent it, and models checked at every set point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, evenly
from gd_analyze.certification.held import Held
from gd_analyze.dynamics.decomposition import contributions_program, decompose_states
from gd_analyze.dynamics.dominance import Extremes, elements
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.spool import blocks, gathered
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Batch, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly

# Evenly spaced set points of a search besides the extremes.
_SEARCHED = 400
# Parts of the motion whose extremes are shown.
_PARTS = 12
# Least set points in tables and figures, several for each column of pixels in a figure.
_SHOWN = 1500
# Rounds that add set points at which a model exceeds its budget to those of the search.
_ROUNDS = 20

_KINDS = ("q", "qd", "qdd")
# Set points, from 0, ascending.
Points = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class LongMotion:
    """A motion of more set points than are kept, and the set points that represent it.

    The set points `searched` include the extremes over the whole motion of positions, velocities,
    accelerations, torques, elements of D, h and c, their parts, and the torque of each.
    """

    arm: RobotArm
    drives: bool
    motion: Trajectory
    extremes: Extremes  # of the elements, at all set points
    searched: Points  # set points used by searches
    shown: Points  # these and others for tables and figures

    @classmethod
    def of(
        cls, arm: RobotArm, motion: Trajectory, drives: bool | None, progress: Callable[[int], None]
    ) -> LongMotion:
        """Decompose the motion once, and note its extremes."""
        drives = arm.counts_drives(drives)
        drive_inertia = arm.drive_inertia if drives else np.zeros(arm.n_joints)
        extremes = Extremes(arm.n_joints, elements(arm.n_joints), drive_inertia)
        values, places = [], []
        for chunk in blocks(*(getattr(motion, kind) for kind in _KINDS)):
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
        parts = np.array_split(np.arange(len(value)), min(_PARTS, len(value)))
        points = evenly(motion.n_set_points, _SEARCHED), *_reached(value, place, [np.arange(len(value))])
        searched = np.unique(np.concatenate([*points, extremes.reached.ravel()]))
        shown = np.unique(np.concatenate([searched, *_reached(value, place, parts)]))
        evenly_spaced = evenly(motion.n_set_points, max(_SHOWN - len(shown), 2))
        return cls(arm, drives, motion, extremes, searched, np.union1d(shown, evenly_spaced))

    def states(self, points: Points) -> States:
        """Take some set points."""
        q, qd, qdd = (gathered(getattr(self.motion, kind), points) for kind in _KINDS)
        return States(q, qd, qdd)

    def settled(
        self, exact: ExactDynamics, search: Callable[[ExactDynamics], tuple[SimplifiedModel, Held]]
    ) -> tuple[ExactDynamics, SimplifiedModel, Held, Points]:
        """Search until both models keep their budgets at every set point.

        Returns the dynamics at the states of the last search, the models with their errors at all set points,
        and the places of the largest errors. Raises a GdAnalyzeError after too many rounds.
        """
        for _ in range(_ROUNDS):
            element_model, held_model = search(exact)
            torques = contributions_program(self.arm, self.drives)
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
        for chunk in blocks(*arrays.values()):
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
        for model, largest_error, square in zip(models, largest, squares, strict=True):
            errors = ErrorTable(exact.peak_torque, largest_error, np.sqrt(square / count))
            stated_models.append(model.stating(replace(model.accuracy, errors=errors)))
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


def _reached(values: NDArray[np.float64], places: Points, groups: Sequence[Points]) -> list[Points]:
    """Set points of the smallest and largest values, shape (blocks, 2, rows), by groups of blocks."""
    points = []
    for group in groups:
        for side, pick in enumerate((np.argmin, np.argmax)):
            best = pick(values[group, side], axis=0)
            points.append(np.take_along_axis(places[group, side], best[None], axis=0)[0])
    return points
