"""What an array of a result, its labels or an attribute may hold: one kind of values, or some words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.errors import StoreError
from gd_analyze.level_names import LEVEL_NAMES

# Quantities of joints have units by the number of turning joints among those they are about.
UNITS: dict[str, tuple[str, ...]] = {
    "position": ("m", "rad"),
    "rate": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
    "effort": ("N", "N m"),
    "viscous": ("N s/m", "N m s"),
    "effort per mass": ("N/kg", "N m/kg"),
    "inertia": ("kg", "kg m", "kg m^2"),
    "christoffel": ("kg/m", "kg", "kg m", "kg m^2"),
}

# NumPy's types by what they are called in a declaration; text is of any length.
_TYPES = {"number": "float64", "whole": "int64", "flag": "bool", "byte": "uint8", "text": "str"}

# What numbers of a sign are not.
_SIGNS = {"nonnegative": np.less, "positive": np.less_equal}


@dataclass(frozen=True)
class Values:
    """Declaration of what is held.

    Parameters
    ----------
    kind
        "number", "whole", "flag" (true or false), "byte" or "text".
    among
        "nonnegative" or "positive" of numbers, which nan passes; or the values there may be, with "|"
        between, of which "1..n" stands for all joints, "units" and "levels" for the names of these. "" for
        all of the kind.
    """

    kind: str
    among: str = ""

    def require_kind(self, dtype: np.dtype[Any], what: str) -> None:
        """Raise a StoreError where values are of another kind."""
        is_text = self.kind == "text" and dtype.kind == "U"
        if not is_text and dtype != _TYPES[self.kind]:
            raise StoreError(f"{what} is of another kind", expected=_TYPES[self.kind], found=str(dtype))

    def require(self, values: Any, what: str, n_joints: int) -> None:
        """Raise a StoreError where values are of another kind, or one is not among those there may be."""
        held = np.asarray(values)
        self.require_kind(held.dtype, what)
        if self.among in _SIGNS and _SIGNS[self.among](held, 0).any():
            raise StoreError(f"{what} is not {self.among}", found=str(held.min()))
        words = self.words(n_joints)
        for value in np.unique(held.astype(str)).tolist() if words else ():
            if value not in words:
                raise StoreError(f"{what} cannot be {value!r}", expected=", ".join(words), found=value)

    def words(self, n_joints: int) -> list[str]:
        """List the values there may be, in order; none where they are not declared one by one."""
        if not self.among or self.among in _SIGNS:
            return []
        named = {
            "1..n": map(str, range(1, n_joints + 1)),
            "units": [unit for units in UNITS.values() for unit in units],
            "levels": LEVEL_NAMES,
        }
        return [word for part in self.among.split("|") for word in named.get(part, [part])]
