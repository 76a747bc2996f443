"""Numbers that a value is given and keeps: checked, copied, and read-only from then on."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.errors import ArmError, Location
from gd_analyze.vectors import FloatArray


def constant(values: Any, shape: tuple[int, ...], what: str, where: Location | str) -> FloatArray:
    """Copy numbers into a read-only array of the given shape, or say what is wrong with them.

    Raises
    ------
    ArmError
        If the shape differs or a number is not finite.
    """
    array = np.array(values, dtype=float)
    if array.shape != shape:
        raise ArmError(
            f"{what} has the wrong shape", where=where, expected=str(shape), found=str(array.shape)
        )
    if not np.isfinite(array).all():
        raise ArmError(
            f"{what} is not finite",
            where=where,
            expected="finite numbers",
            found=str(array.tolist()),
            next_step="replace nan and inf by measured or estimated values",
        )
    array.flags.writeable = False
    return array
