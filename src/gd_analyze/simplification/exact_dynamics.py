"""An arm's exact dynamics at given states: torques, allowed errors, and the errors of models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray, peak_magnitude, round_off_of
from gd_analyze.dynamics.decomposition import decompose_states, torque_of
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits, warn_of_weight
from gd_analyze.dynamics.uncertainty import torque_uncertainty
from gd_analyze.errors import require_type, warn_caller
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.states import States, motions_in, require_dataset, states_for, states_of
from gd_analyze.motions.trajectory import Motion, Trajectory, listed
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
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
from gd_analyze.simplification.exact import ExactForm

if TYPE_CHECKING:
    import xarray as xr

# States of a search; a longer trajectory is represented by some, joined by others that turn out to matter.
MOST_STATES = 5000


@dataclass(frozen=True, eq=False)
class ExactDynamics:
    """An arm's exact dynamics at given states; torques in N m (N)."""

    form: ExactForm
    states: States
    decomposed: Mapping[Any, Any] | None = None  # `decompose` of these states, if available
    left_of_log: FloatArray | None = None  # RMS of what a log's torques leave, N m, (n,); None without a log

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
        arm = arm_with_masses(arm)
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

    def allowed(self, budget: Budget | str | float | None) -> FloatArray:
        """Allowed error per joint, N m, shape (n,), and never less than round-off."""
        by = ReferenceTorques(self.arm, self.peak_torque, self.uncertainty, self.left_of_log)
        return allowed_by(Budget.of(budget), by, self.round_off)

    def norms_of(self, torque: FloatArray) -> tuple[NormShare, ...]:
        """Errors of torques (N, n) as shares of the norm, at 95 % and 99.9 % of the states.

        If a share of few states leaves none out, it is all states.
        """
        shares = norm_shares(torque - self.torque, self.torque, self.arm.is_revolute, self.round_off)
        states = {part if len(shares) * (1.0 - part) >= 1.0 else 1.0 for part in USUAL_STATES}
        return tuple(NormShare(share_at(shares, part), part) for part in sorted(states))

    def under(self, budget: Budget | str | float | None) -> ExactDynamics:
        """Weight errors so that the budget of each of several motions becomes that of all."""
        states, budget = self.states, Budget.of(budget)
        if not states.motions or states.weights is not None:
            return self
        weights, allowed = np.ones_like(states.q), self.allowed(budget)
        for motion, of_motion in self.by_motion.items():
            needs = of_motion.peak_torque > 0.0
            weights[motion.rows] = np.where(needs, np.maximum(allowed / of_motion.allowed(budget), 1.0), 1.0)
        return self.weighed(weights)

    def weighed(self, weights: FloatArray | None) -> ExactDynamics:
        """The same with weights (N, n) of errors, see `States.weights`; equal if None."""
        if weights is None and self.states.weights is None:
            return self
        return self._with_computed(replace(self, states=replace(self.states, weights=weights)))

    def with_form(self, form: ExactForm) -> ExactDynamics:
        """The same at the same states, with terms in other velocities."""
        return self if form is self.form else self._with_computed(replace(self, form=form))

    def _with_computed(self, dynamics: ExactDynamics) -> ExactDynamics:
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
        for motion, of_motion in self.by_motion.items():
            allowed = accuracy.allowed / (1.0 if weights is None else weights[motion.first])
            errors = of_motion.errors_of(torque[motion.rows])
            stated = (motion.name, motion.fingerprint, motion.n_set_points)
            motions.append(AlongMotion(*stated, allowed, errors, of_motion.uncertainty))
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


def warn_of_torques(exact: ExactDynamics) -> None:
    """Warn of torques at these states, or of the arm's weight, that the drives do not give, and of none."""
    _warn_without_torque(exact)
    if "trajectory" in exact.states.described:
        warn_of_torque_limits(exact.arm, exact.states, exact.torque)
    else:
        warn_of_weight(exact.arm)


def _warn_without_torque(exact: ExactDynamics) -> None:
    """Warn if no joint needs any torque: shares of torque are then meaningless."""
    if not exact.needs_torque:
        largest = f"{float(np.abs(exact.torque).max()):.1e} N m"
        text = f"no joint of {exact.arm.name} needs torque here beyond round-off ({largest}): there is "
        text += "nothing to rank, and a model without operations is exact"
        warn_caller(text)


def require_exact(value: object) -> None:
    """Raise a UsageError unless an argument is exact dynamics at states."""
    require_type(
        value, ExactDynamics, "exact", "an ExactDynamics, as `ExactDynamics.of(arm, states)` makes it"
    )
