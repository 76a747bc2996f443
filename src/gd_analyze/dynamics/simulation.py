"""Motions that torques cause, integrated over time with their energy balance. [FGL87] problem 3.11."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.forward_dynamics import DEFAULT_METHOD, solve_accelerations
from gd_analyze.dynamics.kinematics import kinetic_energy, potential_energy
from gd_analyze.dynamics.methods import known_method
from gd_analyze.errors import GdAnalyzeError, UsageError, require_type
from gd_analyze.motions.states import broadcast_states
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of

Integrator = Literal["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"]
# A function (t, q, qd) -> (n,), or a history (time, values) of shapes (N,) and (N, n).
TorqueFunction: TypeAlias = Callable[[float, FloatArray, FloatArray], ArrayLike]
TorqueHistory: TypeAlias = tuple[ArrayLike, ArrayLike]

# Tightest tolerance of SciPy's Runge-Kutta methods.
TIGHTEST_RTOL = 100 * float(np.finfo(float).eps)


def _require(holds: Any, where: str, expected: str, found: object) -> None:
    if not holds:
        message = f"{where} does not fit the simulation"
        raise UsageError(message, where=where, expected=expected, found=str(found))


@dataclass(frozen=True)
class Integration:
    """Options for integrating a motion."""

    set_points: int = 201  # number of set points reported, evenly spaced from 0 to the duration
    # Formulation that gives D, h and c, of `gd_analyze.dynamics.methods.METHODS`
    method: str = DEFAULT_METHOD
    # Method of `scipy.integrate.solve_ivp`. An arm nearly held by friction is stiff: "LSODA" or "BDF"
    integrator: Integrator = "DOP853"
    # Tolerances per step for every joint variable and velocity, work and dissipation
    rtol: float = 1e-9
    atol: float = 1e-9

    def __post_init__(self) -> None:
        known_method(self.method)
        integrators = get_args(Integrator)
        is_count = int(self.set_points) == self.set_points and self.set_points >= 2
        _require(self.integrator in integrators, "integrator", ", ".join(integrators), self.integrator)
        _require(is_count, "set_points", "a whole number of 2 or more", self.set_points)
        _require(TIGHTEST_RTOL <= self.rtol < np.inf, "rtol", f"{TIGHTEST_RTOL:.1e} or more", self.rtol)
        _require(0 < self.atol < np.inf, "atol", "a positive number", self.atol)

    def __str__(self) -> str:
        return f"{self.method}, {self.integrator}, rtol {self.rtol:g}, atol {self.atol:g}"


USUAL_INTEGRATION = Integration()


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated motion and its energy balance; N set points of n joints."""

    time: FloatArray  # s, shape (N,)
    # Joint variables, velocities and accelerations, shape (N, n)
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    torque: FloatArray  # the actuators' torques, N m (N for a prismatic joint), shape (N, n)
    # Energies, J, shape (N,); kinetic with that of drives, if included
    kinetic: FloatArray
    potential: FloatArray
    work: FloatArray  # done by the actuators since the start, J, shape (N,)
    dissipated: FloatArray  # by friction and damping since the start, J, shape (N,)
    steps: int  # steps of the integrator
    integration: Integration

    @property
    def energy(self) -> FloatArray:
        """Kinetic and potential energy together, J, shape (N,)."""
        return self.kinetic + self.potential

    @property
    def energy_residual(self) -> FloatArray:
        """Energy gained, less work, plus dissipation, J, shape (N,): zero up to integration errors.

        The integrator's tolerance holds per step for q, qd, work and dissipation; the residual accumulates.
        """
        return self.energy - self.energy[0] - self.work + self.dissipated

    def as_trajectory(self, name: str = "simulation") -> Trajectory:
        """Convert the motion to a Trajectory."""
        return Trajectory(self.time, self.q, self.qd, self.qdd, name, f"simulated: {self.integration}")


def simulate(
    arm: RobotArm | str | Path,
    torque: TorqueFunction | TorqueHistory,
    q0: ArrayLike,
    qd0: ArrayLike,
    duration: float,
    drivetrain: Drivetrain = NO_DRIVES,
    integration: Integration = USUAL_INTEGRATION,
) -> Simulation:
    """Simulate the motion that torques cause; limits are ignored.

    Parameters
    ----------
    arm
        The arm, its name, or the path of its file.
    torque
        The actuators' torques, N m (N): a function (t, q, qd) -> (n,), or a history (time, values) of shapes
        (N,) and (N, n) that a cubic spline interpolates; it overshoots near jumps, which need a function.
    q0, qd0
        Joint variables and velocities at the start, shape (n,).
    duration
        Seconds from the start.
    drivetrain
        Effects of the drives; by default none.
    integration
        Integrator, tolerances and set points reported.

    Returns
    -------
    Simulation
        The motion and its energy balance.

    Raises
    ------
    UsageError
        If a state, a duration or a history does not fit.
    GdAnalyzeError
        If D is singular, the torque function misbehaves or the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    arm = arm_of(arm)
    start, velocity = broadcast_states(arm, q0=q0, qd0=qd0)
    n = arm.n_joints
    _require(start.ndim == 1, "q0", f"one state, shape ({n},)", start.shape)
    require_type(duration, (int, float, np.number), "duration", "a positive number of seconds")
    require_type(drivetrain, Drivetrain, "drivetrain", "a Drivetrain")
    require_type(integration, Integration, "integration", "an Integration")
    _require(np.isfinite(duration) and duration > 0, "duration", "a positive number of seconds", duration)
    method, added = known_method(integration.method), drivetrain.inertia_of(arm)
    torque_at, resistance = _torque_function(arm, torque, float(duration)), drivetrain.resistance_of(arm)

    def slope(t: float, state: FloatArray) -> FloatArray:
        q, qd = state[:n], state[n : 2 * n]
        if not np.isfinite(state).all():
            message, hint = "the simulated motion grows without bounds", "check the torque function's signs"
            raise GdAnalyzeError(message, where=f"t = {t:g} s", next_step=hint)
        active, resisting = torque_at(t, q, qd), resistance(qd)
        qdd = solve_accelerations(arm, method, added, q, qd, active - resisting)
        return np.concatenate([qd, qdd, [active @ qd, resisting @ qd]])

    solved: Any = solve_ivp(
        slope,
        (0.0, float(duration)),
        np.concatenate([start, velocity, [0.0, 0.0]]),
        method=integration.integrator,
        dense_output=True,
        rtol=integration.rtol,
        atol=integration.atol,
    )
    if not solved.success:
        raise GdAnalyzeError(
            f"the integrator {integration.integrator} failed",
            where=f"t = {solved.t[-1]:g} of {duration:g} s",
            found=solved.message,
            next_step='take integrator="LSODA" or "Radau" for a stiff motion, or larger tolerances',
        )
    time = np.linspace(0.0, float(duration), int(integration.set_points))
    parts = np.split(solved.sol(time).T, [n, 2 * n, 2 * n + 1], axis=1)
    q, qd, work, dissipated = (part.copy() for part in parts)
    applied = np.array([torque_at(float(t), *state) for t, *state in zip(time, q, qd, strict=True)])
    qdd = solve_accelerations(arm, method, added, q, qd, applied - resistance(qd))
    kinetic, potential = kinetic_energy(arm, q, qd, drives=drivetrain.inertia), potential_energy(arm, q)
    energies, steps = (kinetic, potential, work[:, 0], dissipated[:, 0]), len(solved.sol.ts) - 1
    return Simulation(time, q, qd, qdd, applied, *energies, steps, integration)


def _torque_function(
    arm: RobotArm, torque: TorqueFunction | TorqueHistory, duration: float
) -> Callable[[float, FloatArray, FloatArray], FloatArray]:
    """Turn either form of torque into a checked function of t, q and qd."""
    inner, n = torque if callable(torque) else _spline(torque, arm.n_joints, duration), arm.n_joints

    def checked(t: float, q: FloatArray, qd: FloatArray) -> FloatArray:
        value = np.asarray(inner(t, q, qd), dtype=float)
        if value.shape != (n,) or not np.isfinite(value).all():
            message = "the torque function does not give one finite torque per joint"
            value_text = f"shape {value.shape}" if value.shape != (n,) else str(value.tolist())
            raise GdAnalyzeError(
                message, where=f"t = {t:g} s", expected=f"{n} finite numbers", found=value_text
            )
        return value

    return checked


def _spline(history: TorqueHistory, n: int, duration: float) -> TorqueFunction:
    """SciPy's cubic spline; its two continuous derivatives let a high-order integrator keep its order."""
    from scipy.interpolate import CubicSpline

    try:
        time, values = (np.asarray(part, dtype=float) for part in history)
    except (TypeError, ValueError):
        _require(False, "torque", "a function of t, q and qd, or (time, values)", type(history).__name__)
    fits = time.ndim == 1 and len(time) >= 2 and values.shape == (len(time), n)
    shapes = f"time of shape (N,) with N of 2 or more, and values of shape (N, {n})"
    _require(fits, "torque", shapes, f"time {time.shape}, values {values.shape}")
    is_sound = np.isfinite(time).all() and np.isfinite(values).all() and (np.diff(time) > 0).all()
    _require(is_sound, "torque", "finite numbers, time strictly increasing", "others")
    covered = f"{time[0]:g} to {time[-1]:g} s"
    _require(time[0] <= 0 and time[-1] >= duration, "torque", f"0 to {duration:g} s", covered)
    spline = CubicSpline(time, values)
    return lambda t, q, qd: spline(t)
