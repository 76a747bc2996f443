"""An arm's exact dynamics: as sums of terms, as the cheapest program known, and at given states."""

from __future__ import annotations

import json
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray, peak_magnitude, round_off_of
from gd_analyze.dynamics import newton_euler_regrouped
from gd_analyze.dynamics.decomposition import decompose_states, torque_of
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.torque_uncertainty import torque_uncertainty
from gd_analyze.errors import GdAnalyzeWarning, require_type
from gd_analyze.files import shipped
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import DYNAMICS_QUANTITIES, Energies, Torques
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.states import States, motions_in, require_dataset, states_for, states_of
from gd_analyze.motions.trajectory import Motion, Trajectory, listed
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.description import describe_in_full
from gd_analyze.simplification.accuracy import (
    USUAL_STATES,
    Accuracy,
    AlongMotion,
    ErrorTable,
    NormShare,
    norm_shares,
    share_at,
)
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.effort import ROUGH, Effort, Task, kept_program, program_name
from gd_analyze.simplification.functions import Functions, functions_of
from gd_analyze.simplification.identity import largest_difference
from gd_analyze.simplification.torque_program import functions_of_terms, torque_program

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True)
class _ExactSettings:
    """Which exact programs are tried, and for how many joints and terms."""

    quick_joints: int = 6  # most joints of an arm whose terms are all counted at once
    # Outer joints of a longer arm whose terms are counted first, which takes tens of milliseconds.
    outer_joints: int = 4
    identified_joints: int = 8  # most joints for which identifying the exact form takes a second
    # Most joints for which sums of terms may take fewer operations than the recursion: the number of terms
    # grows with the fourth power of the number of joints, the operations of the recursion with the first.
    joints_of_sums: int = 4
    # Terms per operation known from which on their sums take more: of Panda and Gen3, a term takes 0.4 or
    # more.
    terms_per_operation: int = 5
    # Sums of terms with this multiple of the operations known may take fewer with shared parts.
    nearly_known: float = 1.2


_SETTINGS = _ExactSettings()
# Effort of sharing parts of sums: half a second.
_SHARING = Effort(250)

# Most torque terms that are written out to choose from: a second, for a general seven-joint arm of 30 000.
MOST_TERMS = 60_000
# Rewriting changes rounding: by 1e-15 of a joint's torque for up to eight joints.
REWRITTEN = 1e-11


@dataclass(frozen=True, eq=False)
class ExactForm:
    """An arm's exact dynamics, with or without drive inertia; each form is computed on first use."""

    arm: RobotArm
    drives: bool = False

    def __repr__(self) -> str:
        return f"ExactForm({self.arm!r}, drives={self.drives})"

    @property
    def drive_inertia(self) -> FloatArray | None:
        """Drive inertia at the joints, shape (n,); None if not included."""
        return self.arm.drive_inertia if self.drives else None

    @cached_property
    def velocities(self) -> AbsoluteVelocities:
        """Velocities and accelerations in which parallel axes are summed."""
        return AbsoluteVelocities.of(self.arm)

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
        return torques_of_energies(self.energies, self.velocities)

    @cached_property
    def upper_torques(self) -> Torques:
        """Those of h', of c' and of the upper triangle of D', as D' is symmetric."""
        return {term: weight for term, weight in self.torques.items() if term.is_upper}

    @cached_property
    def program(self) -> Program:
        """Its torque in the fewest operations known: shipped, or found in a second or two and then cached."""

        def shortest() -> Program:
            programs = [self.recursion]
            if self.arm.n_joints <= _SETTINGS.joints_of_sums:
                programs += [
                    torque_program(self.velocities, self.torques, effort) for effort in (ROUGH, _SHARING)
                ]
            return rewritten(min(programs, key=lambda program: program.count.total))

        key = ["exact", describe_in_full(self.arm), self.drives]
        path = shipped("programs", ".json").get(shipped_name(self))
        values = None if path is None else json.loads(path.read_bytes())
        return kept_program(
            Task(program_name(key), self.arm.n_joints, shortest, self._is_short_torque, values)
        )

    @cached_property
    def functions(self) -> Functions:
        """D, h and c as functions of their own, each in the fewest operations known."""
        functions = functions_of(self.program, self.arm.n_joints, symmetric=True)
        if self.arm.n_joints > _SETTINGS.identified_joints:
            return functions
        least = dict(zip(DYNAMICS_QUANTITIES, (program.count.total for program in functions), strict=True))
        numbers = Counter(term.quantity for term in self.torques)
        few = {
            quantity
            for quantity in least
            if numbers[quantity] < _SETTINGS.terms_per_operation * least[quantity]
        }
        nested = functions_of_terms(self.velocities, self._torques_of(few), ROUGH)
        # Shared parts take time to find: only where nested sums come close.
        counts = dict(zip(DYNAMICS_QUANTITIES, (program.count.total for program in nested), strict=True))
        close = {quantity for quantity in few if counts[quantity] < _SETTINGS.nearly_known * least[quantity]}
        shared = functions_of_terms(self.velocities, self._torques_of(close), _SHARING)
        return Functions(
            *(
                min(programs, key=lambda program: program.count.total) if quantity in close else programs[0]
                for quantity, *programs in zip(DYNAMICS_QUANTITIES, functions, nested, shared, strict=True)
            )
        )

    def _torques_of(self, quantities: Set[str]) -> Torques:
        return {term: weight for term, weight in self.torques.items() if term.quantity in quantities}

    def _is_short_torque(self, program: Program) -> bool:
        """Whether a program computes the torque, in no more operations than the recursion."""
        recursion = self.recursion
        if program.count.total > recursion.count.total:
            return False
        difference, size = largest_difference(program, recursion, self.arm.is_revolute, REWRITTEN)
        return bool((difference <= REWRITTEN * size).all())

    @cached_property
    def recursion(self) -> Program:
        """Its torque by the cheapest formulation, folded, step by step, with drives."""
        trace, n = Trace(), self.arm.n_joints
        states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
        torque = newton_euler_regrouped.torque(self.arm, *states)[:, 0]
        if self.drive_inertia is not None:
            torque = torque + self.drive_inertia * states[2][:, 0]
        return Program.of(trace, list(torque))

    @property
    def operations(self) -> OperationCount:
        """Operations of the exact torque: every saving is stated against them."""
        return self.program.count


def shipped_name(form: ExactForm) -> str:
    """Name of the file with an arm's exact program, if one is shipped: "puma560-drives"."""
    return f"{form.arm.name}-drives" if form.drives else form.arm.name


def too_many_terms(form: ExactForm) -> str:
    """Reason why exact equations are too long to choose terms from: "9 joints"; "" if they are not."""
    n = form.arm.n_joints
    if n > _SETTINGS.identified_joints:
        return f"{n} joints"
    return f"more than {MOST_TERMS} torque terms" if has_more_terms(form, MOST_TERMS) else ""


def has_more_terms(form: ExactForm, most: int) -> bool:
    """Whether the exact torque has more than `most` terms; those of the outer joints are counted first."""
    if "torques" in vars(form) or form.arm.n_joints <= _SETTINGS.quick_joints:
        return len(form.torques) > most
    arm = replace(form.arm, gravity=np.zeros(3), drives=(), dh_table=(), convention="", spread=None)
    outer = (
        ExactForm(replace(arm, joints=arm.joints[-count:], links=arm.links[-count:]))
        for count in range(_SETTINGS.outer_joints, arm.n_joints, 2)
    )
    return any(len(outer_form.torques) > most for outer_form in outer) or len(form.torques) > most


def require_exact(value: object) -> None:
    """Raise a UsageError unless an argument is exact dynamics at states."""
    require_type(
        value, ExactDynamics, "exact", "an ExactDynamics, as `ExactDynamics.of(arm, states)` makes it"
    )


# States of a search; a longer trajectory is represented by some, joined by others that turn out to matter.
MOST_STATES = 5000


@dataclass(frozen=True, eq=False)
class ExactDynamics:
    """An arm's exact dynamics at given states; torques in N m (N)."""

    form: ExactForm
    states: States
    decomposed: Mapping[Any, Any] | None = None  # `decompose` of these states, if available

    def __repr__(self) -> str:
        return f"ExactDynamics({self.form!r}, {self.states!r})"

    @classmethod
    def of(
        cls,
        arm: RobotArm | str | Path,
        motion_or_states: States | GivenMotions | xr.Dataset,
        drives: bool | None = None,
    ) -> ExactDynamics:
        """Take states, the set points of a trajectory or of several, or a decomposition.

        Drives are included as asked for; by default if the decomposition, or else the arm, has them. Arm and
        trajectories may be shipped names, or paths of files. ArmError if D is not positive definite.
        """
        arm = arm_of(arm)
        if isinstance(motion_or_states, Trajectory | str | Path | Sequence):
            motion_or_states = states_of(trajectory_of(motion_or_states, arm))
        if isinstance(motion_or_states, States):
            exact = cls(ExactForm(arm, arm.counts_drives(drives)), states_for(arm, motion_or_states))
        else:
            require_dataset(motion_or_states)
            described = {
                name: motion_or_states.attrs[name] for name in ("trajectory", "trajectory_fingerprint")
            }
            described["set_points"] = motion_or_states.attrs.get("set_points", motion_or_states.sizes["time"])
            motions = motions_in(motion_or_states)
            if motions:
                described["motions"] = listed(motions)
            q, qd, qdd = (motion_or_states[name].values for name in ("q", "qd", "qdd"))
            states = states_for(arm, States(q, qd, qdd, described, motions))
            has_drives = "drive_torque" in motion_or_states
            as_given = drives in (None, has_drives)
            form = ExactForm(arm, has_drives if as_given else bool(drives))
            exact = cls(form, states, motion_or_states if as_given else None)
        require_positive_definite(exact.arm, exact.states, exact.form.drives)
        return exact

    @property
    def arm(self) -> RobotArm:
        """The arm."""
        return self.form.arm

    def at(self, states: States) -> ExactDynamics:
        """Take the same dynamics at other states."""
        return replace(self, states=states, decomposed=None)

    def joined_by(self, states: FloatArray, weights: FloatArray) -> ExactDynamics:
        """Add further unnamed states (3, N, n), with weights relative to those of the present ones."""
        q, qd, qdd = states
        joined = self.at(replace(self.states.joined_by(q, qd, qdd, weights), described={}))
        vars(joined).update(peak_torque=self.peak_torque, uncertainty=self.uncertainty)
        return joined

    def thinned(self, most: int = MOST_STATES) -> ExactDynamics:
        """Take at most some states: evenly spaced ones, and every extreme."""
        count = len(self.states)
        if count <= most:
            return self
        evenly = np.linspace(0, count - 1, most).astype(int)
        extremes = [np.abs(x).argmax(axis=0) for x in (self.torque, *self.states.arrays)]
        return self.at(self.states.at(np.unique(np.concatenate([evenly, *extremes]))))

    @cached_property
    def quantities(self) -> Mapping[Any, Any]:
        """D, h and c by effect, drive torque and torque at the states, see `decompose_states`."""
        if self.decomposed is not None:
            return self.decomposed
        return decompose_states(self.arm, self.states, christoffel=False, drives=self.form.drives)

    @cached_property
    def inertia(self) -> FloatArray:
        """D with both effects and, if included, the drives' inertia, kg m^2, shape (N, n, n)."""
        links = np.asarray(self.quantities["inertia"]).sum(axis=1)
        added = np.zeros(self.arm.n_joints) if self.form.drive_inertia is None else self.form.drive_inertia
        return np.asarray(links + np.diag(added))

    @cached_property
    def torque(self) -> FloatArray:
        """Torque, N m, shape (N, n)."""
        if self.decomposed is not None:
            return np.asarray(self.decomposed["torque"])
        return torque_of(self.arm, self.states, drives=self.form.drives)

    @cached_property
    def peak_torque(self) -> FloatArray:
        """Largest magnitude of every joint's torque, N m, shape (n,)."""
        return peak_magnitude(self.torque, self._explained)

    @cached_property
    def uncertainty(self) -> FloatArray | None:
        """Largest standard uncertainty of each joint's torque, N m, (n,); None if none is stated."""
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

    def errors_of(self, torque: FloatArray) -> ErrorTable:
        """Error of other torques at these states, N m, shape (N, n)."""
        return ErrorTable.of(self.torque, torque, self._explained, self.states.weights)

    def allowed(self, budget: Budget | str | None) -> FloatArray:
        """Allowed error per joint, N m, shape (n,), and never less than round-off."""
        by = ReferenceTorques(self.arm, self.peak_torque, self.uncertainty)
        return allowed_by(Budget.of(budget), by, self.round_off)

    def norms_of(self, torque: FloatArray) -> tuple[NormShare, ...]:
        """Errors of torques (N, n) as shares of the norm, at 95 % and 99.9 % of the states.

        If a share of few states leaves none out, it is all states.
        """
        shares = norm_shares(torque - self.torque, self.torque, self.arm.is_revolute, self.round_off)
        states = {part if len(shares) * (1.0 - part) >= 1.0 else 1.0 for part in USUAL_STATES}
        return tuple(NormShare(share_at(shares, part), part) for part in sorted(states))

    def under(self, budget: Budget | str | None) -> ExactDynamics:
        """Weight errors so that the budget of each of several motions becomes that of all."""
        states, budget = self.states, Budget.of(budget)
        if not states.motions or states.weights is not None:
            return self
        weights, most = np.ones_like(states.q), self.allowed(budget)
        for motion, alone in self.by_motion.items():
            needs = alone.peak_torque > 0.0
            weights[motion.rows] = np.where(needs, np.maximum(most / alone.allowed(budget), 1.0), 1.0)
        return self.weighed(weights)

    def weighed(self, weights: FloatArray | None) -> ExactDynamics:
        """The same with weights (N, n) of errors, see `States.weights`; equal if None."""
        if weights is None and self.states.weights is None:
            return self
        dynamics = replace(self, states=replace(self.states, weights=weights))
        computed = {name: value for name, value in vars(self).items() if name not in vars(dynamics)}
        vars(dynamics).update(computed)
        return dynamics

    @cached_property
    def by_motion(self) -> dict[Motion, ExactDynamics]:
        """The same dynamics at the states of each of several motions, with equal weights."""
        parts = {}
        for motion in self.states.motions:
            part = self.at(replace(self.states.at(motion.rows), weights=None))
            vars(part)["torque"] = self.torque[motion.rows]
            parts[motion] = part
        return parts

    def held(self, accuracy: Accuracy, torque: FloatArray) -> Accuracy:
        """State the error of a model with this torque, N m, shape (N, n), over all and along each motion."""
        weights, motions = self.states.weights, []
        for motion, alone in self.by_motion.items():
            allowed = accuracy.allowed / (1.0 if weights is None else weights[motion.first])
            errors = alone.errors_of(torque[motion.rows])
            stated = (motion.name, motion.fingerprint, motion.n_set_points)
            motions.append(AlongMotion(*stated, allowed, errors, alone.uncertainty))
        return replace(
            accuracy,
            errors=self.errors_of(torque),
            uncertainty=self.uncertainty,
            motions=tuple(motions),
            norms=self.norms_of(torque),
        )


def allowed_by(budget: Budget, by: ReferenceTorques, round_off: float = 0.0) -> FloatArray:
    """Allowed error per joint, N m, shape (n,), and never less than round-off."""
    # Without any torque nothing is worth keeping, which any positive budget expresses.
    floor = ROUND_OFF_SHARE * float(by.peak.max()) or round_off or ROUND_OFF_SHARE
    return np.maximum(budget.allowed(by), floor)


def warn_without_torque(exact: ExactDynamics) -> None:
    """Warn if no joint needs any torque: shares of torque are then meaningless."""
    if not exact.needs_torque:
        largest = f"{float(np.abs(exact.torque).max()):.1e} N m"
        text = f"no joint of {exact.arm.name} needs torque here beyond round-off ({largest}): there is "
        text += "nothing to rank, and a model without operations is exact"
        warnings.warn(text, GdAnalyzeWarning, stacklevel=3)
