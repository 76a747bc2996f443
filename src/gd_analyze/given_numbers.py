"""Numbers that a user gives: how they are written, and how large one may be."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.visible import in_python

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gd_analyze.vectors import FloatArray

# SI: a billion tonnes, seven times as far as the sun, 32 000 years. What is larger is a slip of the unit or
# a damaged file. It also keeps results finite: torque is of the first power in mass and of the second in
# lengths and in rates, so that its square stays below 1e130; doubles end at 1.8e308.
LARGEST = 1e12

# A term's coefficient is made of a mass and two lengths, 1e36 at most; a program may add them up and divide
# one by another. What is larger was never written, and its products would end beyond the doubles.
LARGEST_COEFFICIENT = 1e100

# float() also takes 1_000, digits of other scripts, "infinity" and "nan", which nobody means in a table.
UNSIGNED = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER = re.compile(rf"[-+]?{UNSIGNED}")


def number_in(text: str) -> float | None:
    """Read a number in decimal digits of ASCII; None where there is none, infinity where it overflows.

    Examples
    --------
    >>> number_in(" -1.5e3 "), number_in("1_000"), number_in("nan")
    (-1500.0, None, None)
    """
    stripped = text.strip()
    return float(stripped) if _NUMBER.fullmatch(stripped) else None


def are_possible(values: ArrayLike) -> bool:
    """Whether all numbers are finite and none is larger than `LARGEST`."""
    import numpy as np

    return bool((np.abs(np.asarray(values, dtype=float)) <= LARGEST).all())


def array_of(values: Any, name: str, error: type[GdAnalyzeError]) -> FloatArray:
    """Take an array, or a list of numbers, as floats; nothing is copied that need not be.

    Raises
    ------
    GdAnalyzeError
        The one that is named, if something is no number, or rows differ in length.
    """
    import numpy as np

    try:
        array = np.asarray(values)
    except ValueError:
        array = np.array(None)
    if array.dtype.kind not in "fiub":
        raise error(
            f"{name} is not made of numbers",
            where=name,
            expected="an array of numbers",
            found=in_python(values),
        )
    return array.astype(float, copy=False)


def require_possible(array: FloatArray, name: str, error: type[GdAnalyzeError]) -> None:
    """Raise an error, the one that is named, where a number is not finite or larger than `LARGEST`."""
    import numpy as np

    wrong = ~(np.abs(array) <= LARGEST)
    if wrong.any():
        raise error(
            f"{name} is {'too large' if np.isfinite(array).all() else 'not finite'}",
            where=f"{name}{list(map(int, np.argwhere(wrong)[0]))}",
            expected=f"finite numbers up to {LARGEST:g}",
            found=str(array[wrong][0]),
        )
