"""Motions integrated over time, with the books of energy kept by the same integrator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.accelerations import solve_accelerations
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.dynamics.integration import USUAL, Integration
from gd_analyze.dynamics.interface import Method
from gd_analyze.dynamics.methods import known_method
from gd_analyze.dynamics.torques import TorqueFunction, TorqueHistory, torque_function
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.motions.states import checked_states
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated motion and its books of energy; N set points of n joints.

    Parameters
    ----------
    time
        s, shape (N,).
    q, qd, qdd
        Joint variables, rates and accelerations, shape (N, n).
    torque
        The actuators' torques, N m (N where the joint slides), shape (N, n).
    kinetic, potential
        Energies, J, shape (N,); kinetic with the drives' where they take part.
    work
        Done by the actuators since the start, J, shape (N,).
    dissipated
        By friction and damping since the start, J, shape (N,).
    steps, evaluations
        Steps the integrator took, and times it asked for accelerations.
    integration
        How it was integrated.
    """

    time: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    torque: FloatArray
    kinetic: FloatArray
    potential: FloatArray
    work: FloatArray
    dissipated: FloatArray
    steps: int
    evaluations: int
    integration: Integration

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def energy(self) -> FloatArray:
        """Kinetic and potential energy together, J, shape (N,)."""
        return self.kinetic + self.potential

    @property
    def energy_residual(self) -> FloatArray:
        """Energy gained, less work, plus what was dissipated, J, shape (N,): zero but for the integrator.

        The integrator's tolerance holds per step, for q, qd, work and dissipation alike; the residual is what
        all steps together make of it.
        """
        return self.energy - self.energy[0] - self.work + self.dissipated

    def as_trajectory(self, name: str = "simulation") -> Trajectory:
        """Give the motion as set points for everything that takes a trajectory."""
        origin = f"simulated: {self.integration}"
        return Trajectory(self.time, self.q, self.qd, self.qdd, name, origin)


def simulate(
    arm: RobotArm,
    torque: TorqueFunction | TorqueHistory,
    q0: ArrayLike,
    qd0: ArrayLike,
    duration: float,
    drivetrain: Drivetrain = NO_DRIVES,
    integration: Integration = USUAL,
) -> Simulation:
    """Follow the motion that torques cause.

    Joint limits do not stop it, and neither do torque limits.

    Parameters
    ----------
    arm
        The arm.
    torque
        The actuators' torques: a function (t, q, qd) -> (n,), or a history (time, values) of shapes (N,) and
        (N, n) through which a cubic spline is laid (`gd_analyze.dynamics.torques.torque_function`).
    q0, qd0
        State at t = 0, shape (n,).
    duration
        s.
    drivetrain
        What the drives add to D, and what opposes the motion.
    integration
        Formulation, integrator, tolerances, and how many set points to report.

    Returns
    -------
    Simulation
        The motion and its energies.

    Raises
    ------
    UsageError
        If an argument does not fit.
    ArmError
        If drives or friction are asked for and the arm describes no drives.
    GdAnalyzeError
        If D is singular, the torque function misbehaves or the integrator gives up.

    Examples
    --------
    >>> import numpy as np
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> from gd_analyze.dynamics.simulate import simulate
    >>> fall = simulate(load_arm("two_link"), lambda t, q, qd: np.zeros(2), [0.0, 0.0], [0.0, 0.0], 0.5)
    >>> bool(abs(fall.energy_residual).max() < 1e-7)
    True
    """
    leading, (start, rates) = checked_states(arm, q0=q0, qd0=qd0)
    if leading:
        raise UsageError(
            "a simulation starts from one state",
            where="q0",
            expected=f"shape ({arm.n_joints},)",
            found=str((*leading, arm.n_joints)),
        )
    if not (np.isfinite(duration) and duration > 0):
        raise UsageError(
            "the duration is not positive", where="duration", expected="seconds", found=str(duration)
        )
    time = np.linspace(0.0, float(duration), int(integration.set_points))
    system = _System(
        arm,
        known_method(integration.method),
        torque_function(arm, torque, float(duration)),
        drivetrain.resistance_of(arm),
        drivetrain.inertia_of(arm),
    )
    solved = _solve(system, np.concatenate([start, rates, [0.0, 0.0]]), float(duration), integration)
    states = solved.sol(time).T
    n = arm.n_joints
    q, qd, work, dissipated = (part.copy() for part in np.split(states, [n, 2 * n, 2 * n + 1], axis=1))
    applied = np.array([system.torque(float(t), *state) for t, *state in zip(time, q, qd, strict=True)])
    return Simulation(
        time,
        q,
        qd,
        system.accelerations(q, qd, applied - system.resistance(qd)),
        applied,
        kinetic_energy(arm, q, qd, drives=drivetrain.inertia),
        potential_energy(arm, q),
        work[:, 0],
        dissipated[:, 0],
        len(solved.sol.ts) - 1,
        int(solved.nfev),
        integration,
    )


@dataclass(frozen=True, eq=False)
class _System:
    """The arm as a differential equation of q, qd, work and dissipation."""

    arm: RobotArm
    formulation: Method
    torque: Callable[[float, FloatArray, FloatArray], FloatArray]
    resistance: Callable[[FloatArray], FloatArray]
    added: FloatArray

    def accelerations(self, q: FloatArray, qd: FloatArray, driving: FloatArray) -> FloatArray:
        """Of one state (n,) or several (N, n)."""
        return solve_accelerations(self.arm, self.formulation, self.added, q, qd, driving)

    def rate(self, t: float, state: FloatArray) -> FloatArray:
        """Slope of the state."""
        n = self.arm.n_joints
        q, qd = state[:n], state[n : 2 * n]
        if not np.isfinite(state).all():
            raise GdAnalyzeError(
                "the simulated motion grows without bounds",
                where=f"t = {t:g} s",
                next_step="check the torque function's signs",
            )
        active, resisting = self.torque(t, q, qd), self.resistance(qd)
        qdd = self.accelerations(q, qd, active - resisting)
        return np.concatenate([qd, qdd, [active @ qd, resisting @ qd]])


def _solve(system: _System, start: FloatArray, duration: float, integration: Integration) -> Any:
    from scipy.integrate import solve_ivp

    solved: Any = solve_ivp(
        system.rate,
        (0.0, duration),
        start,
        method=integration.integrator,
        dense_output=True,
        rtol=integration.rtol,
        atol=integration.atol,
    )
    if not solved.success:
        raise GdAnalyzeError(
            f"the integrator {integration.integrator} gives up",
            where=f"t = {solved.t[-1]:g} of {duration:g} s",
            found=solved.message,
            next_step='take integrator="LSODA" or "Radau" for a stiff motion, or larger tolerances',
        )
    return solved
