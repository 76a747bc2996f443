"""What simplifications are measured against: an arm's exact dynamics at given states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.decomposition import decompose_states
from gd_analyze.dominance import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.harmonics import Harmonics, harmonics_of
from gd_analyze.harmonics.lagrangian import energy_terms, gathered, torques_of
from gd_analyze.harmonics.terms import Energies, Torques
from gd_analyze.models.element import operations_of_all_parts
from gd_analyze.models.nested_torque import nested_torque
from gd_analyze.models.simplified import Level
from gd_analyze.models.torque_program import shared_torque
from gd_analyze.operations import OperationCount
from gd_analyze.robots import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.states import States, states_of
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# States that a search looks at; of a longer trajectory some stand for all, until others turn out to matter.
MOST_STATES = 5000
# Terms beyond which what the rows share is not looked for: minutes.
_MANY = 600


@dataclass(frozen=True, eq=False)
class ExactDynamics:
    """An arm's exact dynamics at given states; each form of it is made once, when it is first asked for.

    Parameters
    ----------
    arm, states, drives
        Arm, states, and whether drive inertia acts.
    """

    arm: RobotArm
    states: States
    drives: bool = False

    @classmethod
    def of(
        cls, arm: RobotArm, given: States | Trajectory | xr.Dataset, drives: bool = False
    ) -> ExactDynamics:
        """Take states, a trajectory's set points, or a decomposition, which knows whether drives act."""
        states = given if isinstance(given, States) else states_of(given)
        if states.decomposed is not None:
            drives = "drive_torque" in states.decomposed
        return cls(arm, states, drives)

    def at(self, states: States) -> ExactDynamics:
        """Take the same dynamics at other states; what is identified need not be identified again."""
        other = ExactDynamics(self.arm, states, self.drives)
        for name in ("harmonics", "energy", "sources", "torques", "_shared_operations"):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    def joined_by(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> ExactDynamics:
        """Take the same dynamics at these states and more, shape (M, n)."""
        mine = self.states
        return self.at(
            States(
                np.vstack([mine.q, q]), np.vstack([mine.qd, qd]), np.vstack([mine.qdd, qdd]), mine.described
            )
        )

    def thinned(self, most: int = MOST_STATES) -> ExactDynamics:
        """Take the same dynamics at so many states at most: evenly chosen ones, and every extreme."""
        count = len(self.states.q)
        if count <= most:
            return self
        evenly = np.linspace(0, count - 1, most).astype(int)
        extremes = [np.abs(x).argmax(axis=0) for x in (self.torque, *self.states.arrays)]
        chosen = np.unique(np.concatenate([evenly, *extremes]))
        q, qd, qdd = (x[chosen] for x in self.states.arrays)
        return self.at(States(q, qd, qdd, self.states.described))

    @cached_property
    def quantities(self) -> Mapping[Any, Any]:
        """D, h and c by effect, drive torque and torque at the states, see `decompose_states`."""
        if self.states.decomposed is not None:
            return self.states.decomposed
        return decompose_states(
            self.arm, self.states.q, self.states.qd, self.states.qdd, coupling=False, drives=self.drives
        )

    @cached_property
    def torque(self) -> FloatArray:
        """Torque, N m, shape (N, n)."""
        return np.asarray(self.quantities["torque"])

    @cached_property
    def peak_torque(self) -> FloatArray:
        """Largest magnitude of every joint's torque, shape (n,)."""
        return peak_magnitude(self.torque)

    def allowed(self, budget: Budget) -> FloatArray:
        """Allowed error per joint, N m, shape (n,), and never less than round-off."""
        # Without any torque anywhere nothing is worth keeping, and any positive budget says so.
        floor = ROUND_OFF_SHARE * (float(self.peak_torque.max()) or 1.0)
        return np.maximum(budget.allowed(self.peak_torque), floor)

    @cached_property
    def harmonics(self) -> Harmonics:
        """The identified dynamics."""
        return harmonics_of(self.arm)

    @cached_property
    def energy(self) -> Energies:
        """Every term of the energies."""
        return energy_terms(self.harmonics, self.arm.drive_inertia if self.drives else None)

    @cached_property
    def sources(self) -> tuple[Torques, ...]:
        """Torque terms that every energy term makes with a coefficient of 1."""
        return tuple(torques_of(term, self.harmonics.rates) for term in self.energy)

    @cached_property
    def torques(self) -> Torques:
        """Every torque term and its weight."""
        return gathered(zip(self.energy.values(), self.sources, strict=True))

    def operations_full(self, level: Level, *, thorough: bool = True) -> OperationCount:
        """Operations of the exact torque in the form that models of a level have.

        A thorough search for what the rows share takes a second for several hundred harmonic terms; without
        it brackets are nested, some hundredths of a second and some more operations.
        """
        if level == "element":
            return self._element_operations
        return self._shared_operations if thorough else self._nested_operations

    @cached_property
    def _element_operations(self) -> OperationCount:
        return operations_of_all_parts(self.arm, self.drives)

    @cached_property
    def _nested_operations(self) -> OperationCount:
        return nested_torque(self.harmonics.rates, self.torques).count

    @cached_property
    def _shared_operations(self) -> OperationCount:
        if len(self.torques) > _MANY:
            return self._nested_operations
        shared = shared_torque(self.harmonics.rates, self.torques).count
        return min(shared, self._nested_operations, key=lambda count: count.total)
