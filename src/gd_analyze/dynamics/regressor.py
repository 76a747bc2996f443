"""The torque per unit of every base parameter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arguments import strict
from gd_analyze.arrays import FloatArray, chunks, set_points_last
from gd_analyze.dynamics.base_parameters import base_parameters, link_regressor
from gd_analyze.motions.states import broadcast_states
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of


@strict
def regressor(
    arm: RobotArm | str | Path, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, drives: bool | None = None
) -> FloatArray:
    """Regressor Y: the torque is its product with the numbers of `base_parameters`.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    q, qd, qdd
        Joint variables, velocities and accelerations, rad (m) and per s, s^2, shape (..., n); leading axes
        are broadcast.
    drives
        Include the drives' inertia; by default if the arm describes drives.

    Returns
    -------
    numpy.ndarray
        N m (N) per unit of each of the k base parameters, shape (..., n, k).

    Raises
    ------
    UsageError
        If a shape does not fit, or a value is not a number, not finite or too large.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> q, qd, qdd = [0.1, 0.2], [0.3, 0.4], [0.5, 0.6]
    >>> numbers = [parameter.number for parameter in gd.base_parameters("two_link")]
    >>> (gd.regressor("two_link", q, qd, qdd) @ numbers).round(3)
    array([26.143,  5.305])
    >>> gd.types.ArmDynamics("two_link").torque(q, qd, qdd).round(3)
    array([26.143,  5.305])
    """
    arm = arm_of(arm)
    base = base_parameters(arm, drives)
    arrays = broadcast_states(arm, q=q, qd=qd, qdd=qdd)
    columns = [set_points_last(array) for array in arrays]
    n, k = arm.n_joints, len(base)
    of_drives = np.zeros((k, n))
    for row, parameter in enumerate(base):
        for share in parameter.combination:
            if share.kind == "J":
                of_drives[row, share.link - 1] = share.coefficient
    # Per unit of the links' and drives' own parameters; base parameters are as many independent sums of them.
    sums = np.concatenate([base.matrix, of_drives[:, :, None]], axis=2).reshape(k, -1)
    into_base = np.linalg.pinv(sums)
    out = np.empty((columns[0].shape[1], n, k))
    for chunk in chunks(len(out)):
        states = [column[:, chunk] for column in columns]
        per_link = link_regressor(arm, *states)
        per_drive = np.eye(n)[:, :, None, None] * states[2][None, :, None]
        per_unit = np.concatenate([per_link, per_drive], axis=2)
        out[chunk] = np.moveaxis(per_unit.reshape(n, 11 * n, -1), -1, 0) @ into_base
    return out.reshape(*arrays[0].shape[:-1], n, k)
