"""Checks of what a caller hands in: states that fit the arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.errors import UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray


def checked_states(arm: RobotArm, **given: ArrayLike) -> tuple[tuple[int, ...], list[FloatArray]]:
    """Leading shape and arrays of quantities that each have one finite number per joint.

    Raises
    ------
    UsageError
        If one is not of shape (..., n), is of another shape than the first, or holds nan or infinity.
    """
    arrays: list[FloatArray] = []
    for name, values in given.items():
        try:
            array = np.asarray(values, dtype=float)
        except (TypeError, ValueError) as error:
            raise UsageError(f"{name} is not numbers", where=name, found=str(error)) from None
        first = arrays[0].shape if arrays else (*array.shape[:-1], arm.n_joints)
        if array.shape != first:
            leading = "".join(f"{size}, " for size in first[:-1]) if arrays else "..., "
            raise UsageError(
                f"{name} does not fit arm {arm.name}",
                where=name,
                expected=f"shape ({leading}{arm.n_joints})",
                found=str(array.shape),
            )
        if not np.isfinite(array).all():
            raise UsageError(
                f"{name} is not finite",
                where=f"{name}{list(map(int, np.argwhere(~np.isfinite(array))[0]))}",
                expected="finite numbers",
                found=str(array[~np.isfinite(array)][0]),
            )
        arrays.append(array)
    return arrays[0].shape[:-1], arrays
