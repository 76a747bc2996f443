"""Joint accelerations from torque (forward dynamics).

M. W. Walker and D. E. Orin (1982), methods 1 to 3, which differ only in how they compute D: given D, h and c,
D qdd = tau - h - c is a linear system. [FGL87] problem 3.11.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray, chunks, set_points_last
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.mass_matrix import not_positive_definite
from gd_analyze.dynamics.methods import Method, known_method
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import require_type
from gd_analyze.motions.states import broadcast_states
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of

DEFAULT_METHOD = "composite_moments"


def joint_accelerations(
    arm: RobotArm | str | Path,
    q: FloatArray,
    qd: FloatArray,
    torque: FloatArray,
    method: str = DEFAULT_METHOD,
    drivetrain: Drivetrain = NO_DRIVES,
) -> FloatArray:
    """Accelerations that the actuators' torques cause: (D + J) qdd = tau - h - c - resistance.

    Parameters
    ----------
    arm
        The arm, its name, or the path of its file.
    q, qd, torque
        Joint variables, velocities and the actuators' torques, N m (N), shape (..., n);
        leading axes are broadcast.
    method
        Formulation that gives D, h and c.
    drivetrain
        Effects of the drives; by default none.

    Returns
    -------
    ndarray
        Accelerations, rad/s^2 (m/s^2), shape (..., n).

    Raises
    ------
    ArmError
        If D is singular, as the acceleration of a joint that moves no mass is undefined, or has a negative
        eigenvalue.
    """
    arm = arm_of(arm)
    require_type(drivetrain, Drivetrain, "drivetrain", "a Drivetrain")
    arrays = broadcast_states(arm, q=q, qd=qd, torque=torque)
    rows = [array.reshape(-1, arm.n_joints) for array in arrays]
    resistance, added = drivetrain.resistance_of(arm), drivetrain.inertia_of(arm)
    out, formulation = np.empty(rows[0].shape), known_method(method)
    for chunk in chunks(len(out)):
        positions, velocities, torques = (array[chunk] for array in rows)
        driving = torques - resistance(velocities)
        states = (positions, velocities, driving)
        out[chunk] = solve_accelerations(arm, formulation, added, *states, first=chunk.start)
    return out.reshape(arrays[0].shape)


def solve_accelerations(
    arm: RobotArm,
    method: Method,
    added: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    driving: FloatArray,
    *,
    first: int = 0,
) -> FloatArray:
    """Solve `joint_accelerations` for checked states.

    `added`, shape (n,), is added to D's diagonal, and `driving` is the torque less the resistance. `first` is
    the number, from 0, of the first state, for messages.
    """
    dynamics = method.dynamics(arm, set_points_last(q), set_points_last(qd))
    inertia = np.moveaxis(dynamics.inertia, -1, 0) + np.diag(added)
    accelerating = (set_points_last(driving) - dynamics.coriolis_centrifugal - dynamics.gravity_loading).T
    # An effective inertia (a pivot) no larger than the round-off of a zero is zero.
    still = np.zeros_like(q)
    floor = round_off_bounds(arm, q, still, still)["inertia"]
    try:
        pivots = np.diagonal(np.linalg.cholesky(inertia), axis1=-2, axis2=-1) ** 2
        is_regular = bool((pivots > floor).all())
    except np.linalg.LinAlgError:
        is_regular = False
    if not is_regular:
        worst = int(np.linalg.eigvalsh(inertia)[:, 0].argmin())
        position, floors = q.reshape(-1, arm.n_joints)[worst], np.full(arm.n_joints, floor)
        raise not_positive_definite(arm, position, inertia[worst], floors, f"set point {first + worst + 1}")
    solution: FloatArray = np.linalg.solve(inertia, accelerating[..., None])
    return solution.reshape(q.shape)
