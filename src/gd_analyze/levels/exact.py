"""What simplifications are measured against: an arm's exact dynamics, as a form and at given states."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.decomposition import decompose_states, torque_of
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.formulations import newton_euler_regrouped
from gd_analyze.harmonics import AbsoluteRates, Harmonics, harmonics_of
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Energies, Torques
from gd_analyze.levels.budget import Budget
from gd_analyze.levels.effort import ROUGH, Effort
from gd_analyze.levels.kept_programs import Task, inputs_of, kept_programs, some_states
from gd_analyze.levels.promise import AlongMotion, ErrorTable, Promise
from gd_analyze.levels.torque_program import torque_program
from gd_analyze.levels.uncertainty import torque_uncertainty
from gd_analyze.levels.yardsticks import Yardsticks
from gd_analyze.mass_matrix import require_positive_definite
from gd_analyze.operations import OperationCount, Program, Trace
from gd_analyze.operations.rewriting import rewritten
from gd_analyze.pinocchio_check import round_off_bounds
from gd_analyze.robots import RobotArm, arm_of, describe_in_full
from gd_analyze.round_off import ROUND_OFF_SHARE, peak_magnitude, round_off_of
from gd_analyze.states import States, motions_in, require_dataset, states_for, states_of
from gd_analyze.trajectories import GivenMotions, Motion, Trajectory, trajectory_of
from gd_analyze.trajectories.motions import listed
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# States that a search looks at; of a longer trajectory some stand for all, until others turn out to matter.
MOST_STATES = 5000
# Joints up to which sums of terms may take fewer operations than the recursion: terms grow with the fourth
# power of the joints and more, the recursion's operations with the first.
_FEW_JOINTS = 4
# Of so many terms at most it is looked for what they share: half a second.
_SHARED = Effort(250)
# Rewriting adds roundings: a program may differ by so many times what those of a formulation explain.
_REWRITTEN = 8


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

    def __repr__(self) -> str:
        return f"ExactForm({self.arm!r}, drives={self.drives})"

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
    def program(self) -> Program:
        """Its torque in the fewest operations known; a second or two, and kept for the next run."""
        key = ["exact", describe_in_full(self.arm), self.drives]

        def are_right(programs: Sequence[Program]) -> bool:
            return len(programs) == 1 and _is_exact(self, *programs)

        return kept_programs(Task.of(key, self.arm.n_joints, lambda: [_shortest(self)], are_right))[0]

    @property
    def operations(self) -> OperationCount:
        """What the exact torque costs: every saving is stated against this."""
        return self.program.count


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

    def __repr__(self) -> str:
        return f"ExactDynamics({self.form!r}, {self.states!r})"

    @classmethod
    def of(
        cls,
        arm: RobotArm | str | Path,
        given: States | GivenMotions | xr.Dataset,
        drives: bool | None = None,
    ) -> ExactDynamics:
        """Take states, the set points of a trajectory or of several, or a decomposition.

        Drives act where asked for; by default where the decomposition, or else the arm, has them. Arm and
        trajectories may be shipped names, or paths of files. An ArmError says where D is not positive
        definite.
        """
        exact = cls._of(arm_of(arm), given, drives)
        require_positive_definite(exact.arm, exact.states, exact.form.drives)
        return exact

    @classmethod
    def _of(
        cls, arm: RobotArm, given: States | GivenMotions | xr.Dataset, drives: bool | None
    ) -> ExactDynamics:
        if isinstance(given, States):
            return cls(ExactForm(arm, arm.counts_drives(drives)), states_for(arm, given))
        if isinstance(given, Trajectory | str | Path | Sequence):
            states = states_for(arm, states_of(trajectory_of(given, arm)))
            return cls(ExactForm(arm, arm.counts_drives(drives)), states)
        require_dataset(given)
        described = {
            "trajectory": given.attrs["trajectory"],
            "trajectory_fingerprint": given.attrs["trajectory_fingerprint"],
            "set_points": given.sizes["time"],
        }
        motions = motions_in(given)
        if motions:
            described["motions"] = listed(motions)
        q, qd, qdd = (given[name].values for name in ("q", "qd", "qdd"))
        states = states_for(arm, States(q, qd, qdd, described, motions))
        has_drives = "drive_torque" in given
        if drives not in (None, has_drives):
            return cls(ExactForm(arm, bool(drives)), states)
        return cls(ExactForm(arm, has_drives), states, given)

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
        if self.decomposed is not None:
            return np.asarray(self.decomposed["torque"])
        return torque_of(self.arm, self.states, drives=self.form.drives)

    @cached_property
    def peak_torque(self) -> FloatArray:
        """Largest magnitude of every joint's torque, shape (n,)."""
        return peak_magnitude(self.torque, self._explained)

    @cached_property
    def uncertainty(self) -> FloatArray | None:
        """Largest standard uncertainty of each joint's torque, N m, (n,); None where none is stated."""
        spread = torque_uncertainty(self.arm, self.states, self.form.drives)
        return None if spread is None else spread.max(axis=0)

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

    @cached_property
    def effects(self) -> dict[str, FloatArray]:
        """Torque of all terms by the level's name, N m, shape (K, n, N), as far as it was worked out."""
        return {}

    def errors_of(self, torque: FloatArray) -> ErrorTable:
        """Error of other torques at these states, N m, shape (N, n)."""
        return ErrorTable.of(self.torque, torque, self._explained, self.states.weights)

    def allowed(self, budget: Budget | str | None) -> FloatArray:
        """Allowed error per joint, N m, shape (n,), and never less than round-off."""
        by = Yardsticks(self.arm, self.peak_torque, self.uncertainty)
        return allowed_by(Budget.of(budget), by, self.round_off)

    def under(self, budget: Budget | str | None) -> ExactDynamics:
        """Let an error count on each of several motions as a budget measured by that motion asks.

        Where it allows half of what it does over all of them, an error counts twice. One motion is as it is,
        and so is what another budget was set before.
        """
        states, budget = self.states, Budget.of(budget)
        if not states.motions or states.weights is not None:
            return self
        weights, most = np.ones_like(states.q), self.allowed(budget)
        for motion, alone in self.by_motion.items():
            needs = alone.peak_torque > 0.0
            weights[motion.rows] = np.where(needs, np.maximum(most / alone.allowed(budget), 1.0), 1.0)
        return self._weighed(weights)

    @property
    def all_alike(self) -> ExactDynamics:
        """The same, every error counting alike."""
        return self if self.states.weights is None else self._weighed(None)

    def _weighed(self, weights: FloatArray | None) -> ExactDynamics:
        """Weigh the states otherwise, and keep what is known of them."""
        other = replace(self, states=replace(self.states, weights=weights))
        vars(other).update({name: value for name, value in vars(self).items() if name not in vars(other)})
        return other

    @cached_property
    def by_motion(self) -> dict[Motion, ExactDynamics]:
        """The same dynamics at the states of each of several motions alone, all counting alike."""
        parts = {}
        for motion in self.states.motions:
            part = self.at(replace(self.states.at(motion.rows), weights=None))
            vars(part)["torque"] = self.torque[motion.rows]
            parts[motion] = part
        return parts

    def held(self, promise: Promise, torque: FloatArray) -> Promise:
        """Promise what a model of this torque errs by, N m, shape (N, n), over all and along each motion."""
        weights = self.states.weights
        motions = tuple(
            AlongMotion(
                motion.name,
                motion.fingerprint,
                motion.n_set_points,
                promise.allowed / (1.0 if weights is None else weights[motion.first]),
                alone.errors_of(torque[motion.rows]),
                alone.uncertainty,
            )
            for motion, alone in self.by_motion.items()
        )
        return replace(promise, errors=self.errors_of(torque), uncertainty=self.uncertainty, motions=motions)


def allowed_by(budget: Budget, by: Yardsticks, round_off: float = 0.0) -> FloatArray:
    """Allowed error per joint, N m, shape (n,), and never less than round-off."""
    # Without any torque anywhere nothing is worth keeping, and any positive budget says so.
    floor = ROUND_OFF_SHARE * float(by.peak.max()) or round_off or ROUND_OFF_SHARE
    return np.maximum(budget.allowed(by), floor)


def _shortest(form: ExactForm) -> Program:
    ways = [_recursion(form)]
    if form.arm.n_joints <= _FEW_JOINTS:
        ways += [torque_program(form.rates, form.torques, effort) for effort in (ROUGH, _SHARED)]
    return rewritten(min(ways, key=lambda way: way.count.total))


def _is_exact(form: ExactForm, program: Program) -> bool:
    """Whether a program gives the torque at some states, within what roundings explain."""
    states = some_states(form.arm.n_joints)
    exact = torque_of(form.arm, states, drives=form.drives)
    bound = _REWRITTEN * round_off_bounds(form.arm, *states.arrays)["torque"]
    error = np.abs(program.run(inputs_of(states)).T - exact).max()
    return bool(error <= bound + ROUND_OFF_SHARE * np.abs(exact).max())


def _recursion(form: ExactForm) -> Program:
    """The cheapest formulation as it folds, drives added."""
    trace, n = Trace(), form.arm.n_joints
    states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
    torque = newton_euler_regrouped.torque(form.arm, *states)[:, 0]
    if form.drive_inertia is not None:
        torque = torque + form.drive_inertia * states[2][:, 0]
    return Program.of(trace, list(torque))


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
