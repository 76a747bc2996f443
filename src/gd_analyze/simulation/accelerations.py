"""Joint accelerations from torque, by any formulation that gives D, h and c.

M. W. Walker and D. E. Orin (1982), methods 1 to 3, which differ only in how they come by D: given D, h and c,
D qdd = tau - h - c is a linear system. [FGL87] problem 3.11.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.formulations.interface import Method
from gd_analyze.formulations.methods import known_method
from gd_analyze.pinocchio_check import round_off_bounds
from gd_analyze.robots import RobotArm
from gd_analyze.simulation.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.states import checked_states
from gd_analyze.vectors import FloatArray, set_points_last

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
        One of `gd_analyze.formulations.methods.METHODS`.
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
        If drives or friction are asked for and the arm describes no drives.
    GdAnalyzeError
        If D is singular: then a joint moves nothing that has mass, and its acceleration can be anything.
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
    except np.linalg.LinAlgError:
        raise _singular(arm, inertia, floor) from None
    if not (pivots > floor).all():
        raise _singular(arm, inertia, floor)
    solution: FloatArray = np.linalg.solve(inertia, accelerating[..., None])
    return solution.reshape(q.shape)


def _singular(arm: RobotArm, inertia: FloatArray, floor: float) -> GdAnalyzeError:
    """Say which joint of which set point moves nothing, by elimination from the first joint on."""
    left = inertia.copy()
    for i, joint in enumerate(arm.joints):
        pivots = left[:, i, i]
        if not (pivots > floor).all():
            worst = int(np.argmin(pivots))
            return GdAnalyzeError(
                f"D is singular: joint {i + 1} ({joint.name}) has no effective inertia",
                where=f"arm {arm.name}, set point {worst + 1}",
                expected=f"more than {floor:.1e} (what round-off can explain) with the joints before it free",
                found=f"{pivots[worst]:.1e}",
                next_step="give the links behind that joint mass and inertia about its axis, or add the "
                "inertia of the drives (Drivetrain(inertia=True))",
            )
        column = left[:, i:, i]
        left[:, i:, i:] -= np.einsum("na,nb,n->nab", column, column, 1.0 / pivots)
    return GdAnalyzeError(
        "D is singular",
        where=f"arm {arm.name}",
        expected="a positive definite D",
        next_step="give every link mass and inertia about its joint's axis, or add the drives' inertia",
    )
