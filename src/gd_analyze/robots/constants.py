"""Numbers that a value is given and keeps: checked, copied, and read-only from then on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray, are_possible
from gd_analyze.errors import ArmError, Location
from gd_analyze.text import LARGEST, in_python


def require_possible(values: ArrayLike, what: str, where: Location | str) -> None:
    """Refuse numbers that are not finite, or larger than any of an arm, with an ArmError."""
    array = np.asarray(values, dtype=float)
    if not np.isfinite(array).all():
        raise ArmError(
            f"{what} is not finite",
            where=where,
            expected="finite numbers",
            found=str(array.tolist()),
            next_step="replace nan and inf by measured or estimated values",
        )
    if not are_possible(array):
        raise ArmError(
            f"{what} is too large for any arm",
            where=where,
            expected=f"numbers up to {LARGEST:g} in SI units",
            found=str(array.tolist()),
            next_step="check the unit",
        )


def keep(
    owner: object,
    name: str,
    shape: tuple[int, ...],
    what: str,
    where: Location | str,
    *,
    nonnegative: str | None = None,
) -> FloatArray:
    """Replace what a frozen value was given by a copy that cannot change, a float where the shape is ().

    `nonnegative` is the unit of numbers that must not be negative.

    Raises
    ------
    ArmError
        If something is no number, the shape differs, or a number is not finite, negative or too large for any
        arm.
    """
    given = np.array(getattr(owner, name))
    if given.dtype.kind not in "fiu":
        found = in_python(getattr(owner, name))
        raise ArmError(f"{what} is not made of numbers", where=where, expected="numbers", found=found)
    array = given.astype(float)
    if array.shape != shape:
        raise ArmError(
            f"{what} has the wrong shape", where=where, expected=str(shape), found=str(array.shape)
        )
    require_possible(array, what, where)
    if nonnegative is not None and (array < 0).any():
        found = str(array.tolist()) if shape else f"{array:g}"
        raise ArmError(
            f"{what} is negative", where=where, expected="0 or more", found=f"{found} {nonnegative}"
        )
    array.flags.writeable = False
    object.__setattr__(owner, name, array if shape else float(array))
    return array
