"""Joint accelerations from torque, by any formulation that gives D, h and c.

M. W. Walker and D. E. Orin (1982), methods 1 to 3, which differ only in how they come by D: given D, h and c,
D qdd = tau - h - c is a linear system. [FGL87] problem 3.11.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray, set_points_last
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.interface import Method
from gd_analyze.dynamics.mass_matrix import refusal
from gd_analyze.dynamics.methods import known_method
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.motions.states import checked_states
from gd_analyze.robots.arm import RobotArm

DEFAULT_METHOD = "composite_moments"


def joint_accelerations(
    arm: RobotArm,
    q: FloatArray,
    qd: FloatArray,
    torque: FloatArray,
    method: str = DEFAULT_METHOD,
    drivetrain: Drivetrain = NO_DRIVES,
) -> FloatArray:
    """Accelerations that torques cause: (D + J) qdd = tau - h - c - resistance.

    Parameters
    ----------
    arm
        The arm.
    q, qd, torque
        Joint variables, rates and the actuators' torques, shape (..., n).
    method
        One of `gd_analyze.dynamics.methods.METHODS`.
    drivetrain
        What the drives add to D, and what opposes the motion.

    Returns
    -------
    ndarray
        qdd, shape (..., n).

    Raises
    ------
    UsageError
        If the method is unknown, shapes do not fit the arm or a number is not finite.
    ArmError
        If drives or friction are asked for and the arm describes no drives. If D is singular: then a joint
        moves nothing that has mass, and its acceleration can be anything. If D has a negative eigenvalue.
    """
    _, (q, qd, torque) = checked_states(arm, q=q, qd=qd, torque=torque)
    formulation = known_method(method)
    driving = torque - drivetrain.resistance_of(arm)(qd)
    return solve_accelerations(arm, formulation, drivetrain.inertia_of(arm), q, qd, driving)


def solve_accelerations(
    arm: RobotArm, method: Method, added: FloatArray, q: FloatArray, qd: FloatArray, driving: FloatArray
) -> FloatArray:
    """Do `joint_accelerations` for checked states.

    `added`, shape (n,), goes onto D's diagonal, and `driving` is the torque less the resistance.
    """
    dynamics = method.dynamics(arm, set_points_last(q), set_points_last(qd))
    inertia = np.moveaxis(dynamics.inertia, -1, 0) + np.diag(added)
    accelerating = (set_points_last(driving) - dynamics.coriolis_centrifugal - dynamics.gravity_loading).T
    # An effective inertia (a pivot) no larger than what round-off leaves of a zero is a zero.
    still = np.zeros_like(q)
    floor = round_off_bounds(arm, q, still, still)["inertia"]
    try:
        pivots = np.diagonal(np.linalg.cholesky(inertia), axis1=-2, axis2=-1) ** 2
        is_sound = bool((pivots > floor).all())
    except np.linalg.LinAlgError:
        is_sound = False
    if not is_sound:
        worst = int(np.linalg.eigvalsh(inertia)[:, 0].argmin())
        raise refusal(
            arm,
            q.reshape(-1, arm.n_joints)[worst],
            inertia[worst],
            np.full(arm.n_joints, floor),
            f"set point {worst + 1}",
        )
    solution: FloatArray = np.linalg.solve(inertia, accelerating[..., None])
    return solution.reshape(q.shape)
