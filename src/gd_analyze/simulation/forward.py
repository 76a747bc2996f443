"""Joint accelerations from torque, by any formulation that gives D, h and c.

M. W. Walker and D. E. Orin (1982), methods 1 to 3, which differ only in how they come by D: given D, h and c,
D qdd = tau - h - c is a linear system. [FGL87] problem 3.11.
"""

from __future__ import annotations

import difflib

import numpy as np

from gd_analyze.authority import round_off_bounds
from gd_analyze.comparison.methods import METHODS, Method
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.simulation.resistance import REST_RATE, Resistance
from gd_analyze.simulation.states import checked_states
from gd_analyze.vectors import FloatArray, set_points_first, set_points_last

DEFAULT_METHOD = "composite_moments"


def joint_accelerations(
    arm: RobotArm,
    q: FloatArray,
    qd: FloatArray,
    torque: FloatArray,
    method: str = DEFAULT_METHOD,
    *,
    drives: bool = False,
    friction: bool = False,
    damping: FloatArray | None = None,
    rest_rate: float = REST_RATE,
) -> FloatArray:
    """Accelerations that torques cause: (D + J) qdd = tau - h - c - resistance.

    Parameters
    ----------
    arm
        The arm.
    q, qd, torque
        Joint variables, rates and the actuators' torques, shape (..., n).
    method
        One of `gd_analyze.comparison.methods.METHODS`.
    drives
        Add the drives' inertia J to the diagonal of D.
    friction, damping, rest_rate
        What opposes the motion, as for `Resistance`.

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
    leading, (q, qd, torque) = checked_states(arm, q=q, qd=qd, torque=torque)
    resistance = Resistance(arm, friction, damping, rest_rate)
    added = arm.drive_inertia if drives else np.zeros(arm.n_joints)
    driving = set_points_last(torque - resistance.torque(qd))
    states = set_points_last(q)
    return set_points_first(
        solve_accelerations(arm, known_method(method), states, set_points_last(qd), driving, added), leading
    )


def known_method(name: str) -> Method:
    """Look a formulation up by its name.

    Raises
    ------
    UsageError
        If there is none of this name.
    """
    if name not in METHODS:
        near = difflib.get_close_matches(str(name), METHODS, n=1)
        raise UsageError(
            f"there is no formulation {name!r}",
            where="method",
            expected=", ".join(METHODS),
            next_step=f"did you mean {near[0]!r}?" if near else None,
        )
    return METHODS[name]


def solve_accelerations(
    arm: RobotArm, method: Method, q: FloatArray, qd: FloatArray, driving: FloatArray, added: FloatArray
) -> FloatArray:
    """Do `joint_accelerations` for checked states, set points last.

    Parameters
    ----------
    arm, method
        The arm and the formulation.
    q, qd, driving
        Joint variables, rates, and torque less resistance, shape (n, N).
    added
        What goes onto D's diagonal, shape (n,).

    Returns
    -------
    ndarray
        qdd, shape (n, N).

    Raises
    ------
    GdAnalyzeError
        If D is singular.
    """
    dynamics = method.dynamics(arm, q, qd)
    inertia = np.moveaxis(dynamics.inertia, -1, 0) + np.diag(added)
    accelerating = (driving - dynamics.coriolis_centrifugal - dynamics.gravity_loading).T[..., None]
    # An effective inertia (a pivot) no larger than what round-off leaves of a zero is a zero.
    still = np.zeros_like(q.T)
    floor = round_off_bounds(arm, q.T, still, still)["inertia"]
    try:
        pivots = np.diagonal(np.linalg.cholesky(inertia), axis1=-2, axis2=-1) ** 2
    except np.linalg.LinAlgError:
        raise _singular(arm, inertia, floor) from None
    if not (pivots > floor).all():
        raise _singular(arm, inertia, floor)
    solution: FloatArray = np.linalg.solve(inertia, accelerating)[..., 0].T
    return solution


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
                "inertia of the drives (drives=True)",
            )
        column = left[:, i:, i]
        left[:, i:, i:] -= np.einsum("na,nb,n->nab", column, column, 1.0 / pivots)
    return GdAnalyzeError(
        "D is singular",
        where=f"arm {arm.name}",
        expected="a positive definite D",
        next_step="give every link mass and inertia about its joint's axis, or add the drives' inertia",
    )
