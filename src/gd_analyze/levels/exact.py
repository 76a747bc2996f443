"""What simplifications are measured against: an arm's exact dynamics, as a form and at given states."""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.harmonics import AbsoluteRates, Harmonics, harmonics_of
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Energies, Torques
from gd_analyze.levels.budget import Budget
from gd_analyze.levels.promise import ErrorTable
from gd_analyze.operations import OperationCount
from gd_analyze.pinocchio_check import round_off_bounds
from gd_analyze.robots import RobotArm
from gd_analyze.round_off import ROUND_OFF_SHARE, peak_magnitude, round_off_of
from gd_analyze.states import States, states_of
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# States that a search looks at; of a longer trajectory some stand for all, until others turn out to matter.
MOST_STATES = 5000


@dataclass(frozen=True, eq=False)
class ExactForm:
    """An arm's exact dynamics as sums of terms; each is made once, when it is first asked for.

    Parameters
    ----------
    arm, drives
        The arm, and whether drive inertia acts.
    """

    arm: RobotArm
    drives: bool = False

    @property
    def drive_inertia(self) -> FloatArray | None:
        """Drive inertia at the joints, shape (n,); None where it does not act."""
        return self.arm.drive_inertia if self.drives else None

    @cached_property
    def rates(self) -> AbsoluteRates:
        """The arm's absolute rates."""
        return AbsoluteRates.of(self.arm)

    @cached_property
    def harmonics(self) -> Harmonics:
        """The dynamics as sums of basis functions, by effect and link."""
        return harmonics_of(self.arm)

    @cached_property
    def energies(self) -> Energies:
        """Every term of the energies and its coefficient."""
        return energy_terms(self.harmonics, self.drive_inertia)

    @cached_property
    def torques(self) -> Torques:
        """Every torque term and its weight."""
        return torques_of_energies(self.energies, self.rates)

    @cached_property
    def counts(self) -> dict[Hashable, OperationCount]:
        """Operations of its torque by how it was written, kept by whoever counted."""
        return {}


@dataclass(frozen=True, eq=False)
class ExactDynamics:
    """An arm's exact dynamics at given states.

    Parameters
    ----------
    form, states
        The dynamics, and where.
    decomposed
        What `decompose` gave for these states where it is at hand.
    """

    form: ExactForm
    states: States
    decomposed: Mapping[Any, Any] | None = None

    @classmethod
    def of(
        cls, arm: RobotArm, given: States | Trajectory | xr.Dataset, drives: bool = False
    ) -> ExactDynamics:
        """Take states, a trajectory's set points, or a decomposition, which knows whether drives act."""
        if isinstance(given, States):
            return cls(ExactForm(arm, drives), given)
        if isinstance(given, Trajectory):
            return cls(ExactForm(arm, drives), states_of(given))
        described = {
            "trajectory": given.attrs["trajectory"],
            "trajectory_fingerprint": given.attrs["trajectory_fingerprint"],
            "set_points": given.sizes["time"],
        }
        states = States(given["q"].values, given["qd"].values, given["qdd"].values, described)
        return cls(ExactForm(arm, "drive_torque" in given), states, given)

    @property
    def arm(self) -> RobotArm:
        """The arm."""
        return self.form.arm

    def at(self, states: States) -> ExactDynamics:
        """Take the same dynamics at other states."""
        return replace(self, states=states, decomposed=None)

    def thinned(self) -> ExactDynamics:
        """Take the same at `MOST_STATES` states at most: evenly chosen ones, and every extreme."""
        count = len(self.states)
        if count <= MOST_STATES:
            return self
        evenly = np.linspace(0, count - 1, MOST_STATES).astype(int)
        extremes = [np.abs(x).argmax(axis=0) for x in (self.torque, *self.states.arrays)]
        return self.at(self.states.at(np.unique(np.concatenate([evenly, *extremes]))))

    @cached_property
    def quantities(self) -> Mapping[Any, Any]:
        """D, h and c by effect, drive torque and torque at the states, see `decompose_states`."""
        if self.decomposed is not None:
            return self.decomposed
        return decompose_states(self.arm, self.states, coupling=False, drives=self.form.drives)

    @cached_property
    def torque(self) -> FloatArray:
        """Torque, N m, shape (N, n)."""
        return np.asarray(self.quantities["torque"])

    @cached_property
    def peak_torque(self) -> FloatArray:
        """Largest magnitude of every joint's torque, shape (n,)."""
        return peak_magnitude(self.torque, self._explained)

    @cached_property
    def _explained(self) -> float:
        """Torque that round-off explains at these states, N m."""
        return float(round_off_bounds(self.arm, *self.states.arrays)["torque"])

    @property
    def round_off(self) -> float:
        """Torque that is only round-off at these states, N m."""
        return round_off_of(self.torque, self._explained)

    @property
    def needs_torque(self) -> bool:
        """Whether any joint needs torque at these states, beyond round-off."""
        return bool(self.peak_torque.any())

    def errors_of(self, torque: FloatArray) -> ErrorTable:
        """Error of other torques at these states, N m, shape (N, n)."""
        return ErrorTable.of(self.torque, torque, self._explained)

    def allowed(self, budget: Budget) -> FloatArray:
        """Allowed error per joint, N m, shape (n,), and never less than round-off."""
        # Without any torque anywhere nothing is worth keeping, and any positive budget says so.
        floor = self.round_off or ROUND_OFF_SHARE
        return np.maximum(budget.allowed(self.peak_torque), floor)


def warn_without_torque(exact: ExactDynamics) -> None:
    """Warn where no joint needs any torque: whatever is said of shares of torque is then about nothing."""
    if not exact.needs_torque:
        largest = float(np.abs(exact.torque).max())
        warnings.warn(
            f"no joint of {exact.arm.name} needs torque here beyond round-off ({largest:.1e} N m): there is "
            "nothing to rank, and a model of no operations is exact",
            GdAnalyzeWarning,
            stacklevel=3,
        )
