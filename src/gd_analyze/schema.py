"""Every variable a result may hold: name, dimensions, unit, equation and meaning, said once in schema.csv.

The same declaration makes a table, validates it, documents it and is stored with it as attributes. A unit
that depends on whether joints turn or slide is given row by row, as a coordinate, where an arm has joints of
both kinds; a unit that depends on what a row is about always is.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import StoreError
from gd_analyze.vectors import Array

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 3

# Units of quantities of joints, by the number of turning joints among those they are about.
UNITS: dict[str, tuple[str, ...]] = {
    "position": ("m", "rad"),
    "rate": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
    "effort": ("N", "N m"),
    "effort per mass": ("N/kg", "N m/kg"),
    "inertia": ("kg", "kg m", "kg m^2"),
    "coupling": ("kg/m", "kg", "kg m", "kg m^2"),
}


def unit_of(kind: str, *turning: bool) -> str:
    """Unit of a quantity of joints, given whether each of them turns.

    Examples
    --------
    >>> unit_of("inertia", True, False)
    'kg m'
    """
    return UNITS[kind][sum(turning)]


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable.

    Parameters
    ----------
    name, dims
        As stored.
    unit
        A unit; a kind of `UNITS`; the name of a coordinate that holds one per row, with "@" before it; or ""
        for what has none.
    besides
        What else than finite numbers it may hold: "nan" where a number is not known, "inf" for a share of
        nothing.
    equation
        Where it is defined, or how.
    meaning
        In words.
    symbol
        In formulas.
    """

    name: str
    dims: tuple[str, ...]
    unit: str
    besides: str
    symbol: str
    equation: str
    meaning: str

    def attributes(self, turning: Sequence[bool]) -> dict[str, str]:
        """Attributes stored with the variable of an arm, given whether its joints turn."""
        out = {"long_name": self.meaning, "equation": self.equation}
        if self.symbol:
            out["symbol"] = self.symbol
        if self.unit.startswith("@"):
            out["units_in"] = self.unit[1:]
        elif self.unit in UNITS and not _uniform(turning):
            out["units_in"] = coordinate_of(self.unit)
        elif self.unit:
            joints = [turning[0]] * self._n_joint_dims
            out["units"] = unit_of(self.unit, *joints) if self.unit in UNITS else self.unit
        return out

    @property
    def _n_joint_dims(self) -> int:
        return sum(dim.startswith("joint") for dim in self.dims)


def coordinate_of(kind: str) -> str:
    """Name of the coordinate that holds the units of a kind, joint by joint."""
    return f"{kind.replace(' ', '_')}_unit"


def _uniform(turning: Sequence[bool]) -> bool:
    return all(turning) or not any(turning)


def _declared() -> dict[str, dict[str, Variable]]:
    """Read the declarations: one line each of schema.csv."""
    groups: dict[str, dict[str, Variable]] = {}
    lines = (Path(__file__).parent / "schema.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        group, dims = row.pop("group"), tuple(row.pop("dims").split())
        groups.setdefault(group, {})[row["name"]] = Variable(dims=dims, **row)
    return groups


GROUPS = _declared()

# Variables that a group may lack.
OPTIONAL = {
    "coupling",
    "drive_torque",
    "inertia_by_link",
    "coriolis_centrifugal_by_link",
    "gravity_loading_by_link",
    "coriolis_centrifugal_terms",
}


def table(
    group: str,
    values: Mapping[str, Any],
    turning: Sequence[bool],
    coords: Mapping[str, Any] | None = None,
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Make the table of a group.

    Parameters
    ----------
    group
        One of `GROUPS`.
    values
        Arrays by the names declared.
    turning
        Whether each joint of the arm turns.
    coords, attrs
        Coordinates beside those of the joints, and attributes.

    Raises
    ------
    StoreError
        If a variable is not declared, has other dimensions or is missing.
    """
    import xarray as xr

    declared = GROUPS[group]
    unknown = sorted(set(values) - set(declared))
    if unknown:
        raise StoreError(f"{unknown[0]} is not a variable of {group}", expected=", ".join(declared))
    variables = {
        name: (declared[name].dims, array, declared[name].attributes(turning))
        for name, array in values.items()
    }
    dims = {dim for name in values for dim in declared[name].dims}
    joints = np.arange(1, len(turning) + 1)
    given = {dim: joints for dim in sorted(dims) if dim.startswith("joint")} | dict(coords or {})
    if not _uniform(turning):
        given |= _unit_coordinates({declared[name].unit: declared[name].dims for name in values}, turning)
    dataset = xr.Dataset(variables, coords=given, attrs=dict(attrs or {}))
    validate(dataset, group)
    return dataset


def _unit_coordinates(kinds: Mapping[str, tuple[str, ...]], turning: Sequence[bool]) -> dict[str, Any]:
    """Units row by row, of the kinds in use."""
    out: dict[str, Any] = {}
    flags = np.array(turning, dtype=int)
    for kind, dims in kinds.items():
        if kind in UNITS:
            over = tuple(dim for dim in dims if dim.startswith("joint"))
            count = sum(np.meshgrid(*[flags] * len(over), indexing="ij")) if len(over) > 1 else flags
            out[coordinate_of(kind)] = (over, np.array(UNITS[kind])[count])
    return out


def validate(dataset: xr.Dataset, group: str) -> None:
    """Check that a table holds what is declared of its group.

    Raises
    ------
    StoreError
        If a variable is missing or unknown, or has other dimensions.
    """
    declared = GROUPS[group]
    for name in declared:
        if name not in dataset and name not in OPTIONAL:
            found = ", ".join(str(known) for known in dataset.data_vars) or "no variables"
            raise StoreError(f"{group} lacks {name}", expected=", ".join(declared), found=found)
    for key, array in dataset.data_vars.items():
        name = str(key)
        if name not in declared:
            raise StoreError(f"{name} is not a variable of {group}", expected=", ".join(declared))
        if tuple(array.dims) != declared[name].dims:
            raise StoreError(
                f"{name} of {group} has other dimensions than declared",
                expected=str(declared[name].dims),
                found=str(tuple(array.dims)),
            )


def require_numbers(values: Array, name: str, group: str) -> None:
    """Check that values of a variable, or of a coordinate, are finite or what else is declared of it.

    Raises
    ------
    StoreError
        If one is nan or infinite where that cannot be.
    """
    if values.dtype.kind != "f" or np.isfinite(values).all():
        return
    besides = GROUPS[group][name].besides.split() if name in GROUPS[group] else []
    for kind, found in (("nan", np.isnan(values)), ("inf", np.isinf(values))):
        if kind not in besides and found.any():
            place = ", ".join(str(index + 1) for index in np.argwhere(found)[0])
            raise StoreError(
                f"{name} of {group} holds what is no finite number",
                expected=" or ".join(["finite numbers", *besides]),
                found=f"{values[found][0]}, entry {place}",
            )
