"""A model along one motion: errors, what they may be, and where the motion leaves the box."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.evaluation import Evaluation
from gd_analyze.studies.beside_measured import BesideMeasured
from gd_analyze.studies.box_exits import BoxExit
from gd_analyze.text import amount, percent


@dataclass(frozen=True, eq=False)
class ValidatedMotion:
    """What came of a model along one motion; torques are N m (N where the joint slides), shape (n,).

    Parameters
    ----------
    trajectory, evaluation
        The motion, and the model's torque and error along it.
    promise
        What the model promises: along this motion, if it is one of several that it was made for.
    most
        The error above which a joint fails; None where nobody asked for a verdict.
    exits, outside
        Where it leaves the box, see `box_exits`.
    measured
        Both models against measured torques; None where none were recorded.
    """

    trajectory: Trajectory
    evaluation: Evaluation
    accuracy: Accuracy
    most: FloatArray | None
    exits: tuple[BoxExit, ...]
    outside: Array
    measured: BesideMeasured | None

    def __repr__(self) -> str:
        failed = int(self.fails.sum())
        return f"ValidatedMotion({self.name!r}, {f'{failed} joints fail' if failed else 'no joint fails'})"

    @property
    def name(self) -> str:
        """The motion's."""
        return self.trajectory.name

    @property
    def fails(self) -> NDArray[np.bool_]:
        """Whether each joint errs by more than it may; none does where nobody asked."""
        largest = self.evaluation.errors.largest
        return np.zeros(len(largest), dtype=bool) if self.most is None else largest > self.most

    @property
    def allowed(self) -> FloatArray | None:
        """What the model's promise allows each joint; None where its budget is of the norm."""
        return self.accuracy.allowed if self.accuracy.asked.norm is None else None

    @property
    def keeps_promise(self) -> NDArray[np.bool_]:
        """Whether each joint keeps what the model promises, shape (n,).

        A promise of the norm is one of all joints together: then they all do, or none.
        """
        asked, evaluation = self.accuracy.asked.norm, self.evaluation
        if asked is None:
            return np.asarray(evaluation.within(self.accuracy.allowed))
        return np.full(len(evaluation.errors.largest), evaluation.keeps(asked))

    @cached_property
    def at(self) -> FloatArray:
        """Instant of each joint's largest error, s, shape (n,); nan where it has none beyond round-off."""
        error = np.abs(self.evaluation.torque - self.evaluation.dynamics.torque)
        instants = self.trajectory.time[error.argmax(axis=0)]
        return np.where(self.evaluation.errors.largest > 0.0, instants, np.nan)

    def error_told(self, joint: int) -> str:
        """Say how large an error one joint (from 0) has, when, and beside what it may be."""
        errors, unit = self.evaluation.errors, self.evaluation.dynamics.arm.joints[joint].effort_unit
        largest, most = float(errors.largest[joint]), self.most
        if largest == 0.0:
            return "no torque error beyond round-off"
        share = percent(float(errors.largest_share[joint]))
        told = f"largest torque error {amount(largest, unit)} at {self.at[joint]:.6g} s, {share} of its peak"
        if most is None:
            return told
        allowed = float(most[joint])
        return f"{told}, {largest / allowed:.4g} times the {amount(allowed, unit)} it may be"
