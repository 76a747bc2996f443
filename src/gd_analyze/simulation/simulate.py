"""Motions integrated over time, with the books of energy kept by the same integrator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.simulation.energy import kinetic_energy, potential_energy
from gd_analyze.simulation.forward import DEFAULT_METHOD, known_method, solve_accelerations
from gd_analyze.simulation.resistance import REST_RATE, Resistance
from gd_analyze.simulation.states import checked_states
from gd_analyze.simulation.torques import TorqueFunction, TorqueHistory, torque_function
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray, set_points_last

Integrator = Literal["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"]

# SciPy's Runge-Kutta methods cannot be asked for more.
TIGHTEST_RTOL = 100 * float(np.finfo(float).eps)


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
    method, integrator
        The formulation, and SciPy's name of the integrator.
    rtol, atol
        Tolerances of the integrator, per step.
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
    method: str
    integrator: str
    rtol: float
    atol: float

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
        return Trajectory(
            self.time,
            self.q,
            self.qd,
            self.qdd,
            name,
            f"simulated: {self.method}, {self.integrator}, rtol {self.rtol:g}, atol {self.atol:g}",
        )


def simulate(
    arm: RobotArm,
    torque: TorqueFunction | TorqueHistory,
    q0: ArrayLike,
    qd0: ArrayLike,
    duration: float,
    *,
    set_points: int = 201,
    drives: bool = False,
    friction: bool = False,
    damping: FloatArray | None = None,
    rest_rate: float = REST_RATE,
    method: str = DEFAULT_METHOD,
    rtol: float = 1e-9,
    atol: float = 1e-9,
    integrator: Integrator = "DOP853",
) -> Simulation:
    """Follow the motion that torques cause.

    Joint limits do not stop it, and neither do torque limits.

    Parameters
    ----------
    arm
        The arm.
    torque
        The actuators' torques: a function (t, q, qd) -> (n,), or a history (time, values) of shapes (N,) and
        (N, n) through which a cubic spline is laid (`gd_analyze.simulation.torques.torque_function`).
    q0, qd0
        State at t = 0, shape (n,).
    duration
        s.
    set_points
        How many, evenly spaced from 0 to the duration, to report.
    drives, friction, damping, rest_rate, method
        As for `joint_accelerations`.
    rtol, atol
        Tolerances per step of the integrator, of every joint variable and rate and of work and dissipation.
    integrator
        `scipy.integrate.solve_ivp`'s. An arm that friction holds nearly at rest is stiff: "LSODA" or "BDF".

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
    >>> from gd_analyze.robots import load_arm
    >>> from gd_analyze.simulation import simulate
    >>> fall = simulate(load_arm("two_link"), lambda t, q, qd: np.zeros(2), [0.0, 0.0], [0.0, 0.0], 0.5)
    >>> bool(abs(fall.energy_residual).max() < 1e-7)
    True
    """
    from scipy.integrate import solve_ivp

    leading, (start, rates) = checked_states(arm, q0=q0, qd0=qd0)
    if leading:
        raise UsageError(
            "a simulation starts from one state",
            where="q0",
            expected=f"shape ({arm.n_joints},)",
            found=str((*leading, arm.n_joints)),
        )
    time = _times(duration, set_points)
    _check_integrator(integrator, rtol, atol)
    formulation = known_method(method)
    resistance = Resistance(arm, friction, damping, rest_rate)
    added = arm.drive_inertia if drives else np.zeros(arm.n_joints)
    actuators = torque_function(arm, torque, float(duration))
    n = arm.n_joints

    def accelerations(q: FloatArray, qd: FloatArray, driving: FloatArray) -> FloatArray:
        """Of one state (n,) or several (N, n)."""
        columns, speeds, torques = (set_points_last(x) for x in (q, qd, driving))
        return solve_accelerations(arm, formulation, columns, speeds, torques, added).T.reshape(q.shape)

    def rate(t: float, state: FloatArray) -> FloatArray:
        q, qd = state[:n], state[n : 2 * n]
        if not np.isfinite(state).all():
            raise GdAnalyzeError(
                "the simulated motion grows without bounds",
                where=f"t = {t:g} s",
                next_step="check the torque function's signs",
            )
        active, resisting = actuators(t, q, qd), resistance.torque(qd)
        return np.concatenate([qd, accelerations(q, qd, active - resisting), [active @ qd, resisting @ qd]])

    solved: Any = solve_ivp(
        rate,
        (0.0, float(duration)),
        np.concatenate([start, rates, [0.0, 0.0]]),
        method=integrator,
        dense_output=True,
        rtol=rtol,
        atol=atol,
    )
    if not solved.success:
        raise GdAnalyzeError(
            f"the integrator {integrator} gives up",
            where=f"t = {solved.t[-1]:g} of {duration:g} s",
            found=solved.message,
            next_step='take integrator="LSODA" or "Radau" for a stiff motion, or larger tolerances',
        )
    states = solved.sol(time).T
    q, qd = states[:, :n].copy(), states[:, n : 2 * n].copy()
    applied = np.array([actuators(float(t), *state) for t, *state in zip(time, q, qd, strict=True)])
    return Simulation(
        time,
        q,
        qd,
        accelerations(q, qd, applied - resistance.torque(qd)),
        applied,
        kinetic_energy(arm, q, qd, drives=drives),
        potential_energy(arm, q),
        states[:, 2 * n].copy(),
        states[:, 2 * n + 1].copy(),
        len(solved.sol.ts) - 1,
        int(solved.nfev),
        method,
        integrator,
        float(rtol),
        float(atol),
    )


def _times(duration: float, set_points: int) -> FloatArray:
    if not (np.isfinite(duration) and duration > 0):
        raise UsageError(
            "the duration is not positive", where="duration", expected="seconds", found=str(duration)
        )
    if int(set_points) != set_points or set_points < 2:
        raise UsageError(
            "a simulation has at least two set points",
            where="set_points",
            expected="a whole number of 2 or more",
            found=str(set_points),
        )
    return np.linspace(0.0, float(duration), int(set_points))


def _check_integrator(integrator: str, rtol: float, atol: float) -> None:
    if integrator not in get_args(Integrator):
        raise UsageError(
            f"there is no integrator {integrator!r}",
            where="integrator",
            expected=", ".join(get_args(Integrator)),
        )
    if not (np.isfinite(rtol) and rtol >= TIGHTEST_RTOL and np.isfinite(atol) and atol > 0):
        raise UsageError(
            "the integrator cannot keep these tolerances",
            where="rtol, atol",
            expected=f"rtol of {TIGHTEST_RTOL:.1e} or more, atol above 0",
            found=f"{rtol:g}, {atol:g}",
        )
