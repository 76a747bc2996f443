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

from gd_analyze.declared_values import UNITS, Values
from gd_analyze.errors import StoreError
from gd_analyze.schema_labels import require_attributes, require_coordinates
from gd_analyze.vectors import Array

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 4

# Inputs are bounded so that torques stay below 1e65, see `gd_analyze.given_numbers`.
LARGEST_RESULT = 1e150


def unit_of(kind: str, *turning: bool) -> str:
    """Unit of a quantity of joints, given whether each of them turns.

    Examples
    --------
    >>> unit_of("inertia", True, False)
    'kg m'
    """
    return UNITS[kind][sum(turning)]


def units_of(kind: str, turning: Sequence[bool]) -> Array:
    """Unit of every entry of a quantity of an arm's joints: one axis per joint that it is about.

    Examples
    --------
    >>> units_of("inertia", [True, False]).tolist()
    [['kg m^2', 'kg m'], ['kg m', 'kg']]
    """
    flags = np.array(turning, dtype=int)
    axes = np.meshgrid(*[flags] * (len(UNITS[kind]) - 1), indexing="ij")
    return np.array(UNITS[kind])[sum(axes)]


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
    values
        What it may hold.
    """

    name: str
    dims: tuple[str, ...]
    unit: str
    besides: str
    symbol: str
    equation: str
    meaning: str
    values: Values

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
    for row in csv.DictReader(lines, restval=""):
        group, dims = row.pop("group"), tuple(row.pop("dims").split())
        values = Values(row.pop("kind") or "number", row.pop("among"))
        groups.setdefault(group, {})[row["name"]] = Variable(dims=dims, values=values, **row)
    return groups


GROUPS = _declared()

# Variables that a group may lack.
OPTIONAL = {
    "trajectory": {"stretch_from"},
    "decomposition": {
        "christoffel",
        "drive_torque",
        "inertia_by_link",
        "coriolis_centrifugal_by_link",
        "gravity_loading_by_link",
        "coriolis_centrifugal_terms",
    },
    "budgets": {"kept", "kept_parts"},
    "measured_torque": {
        *("coulomb", "coulomb_error", "viscous", "viscous_error", "offset", "offset_error"),
        *("rms_beside_friction", "correlation_beside_friction", "explained_beside_friction"),
    },
}

# Groups that a run has only where there is something to say.
OPTIONAL_GROUPS = {"measured_torque", "motions", "recording"}


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
        As `validate`.
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
    validate(dataset, group, turning)
    return dataset


def _unit_coordinates(kinds: Mapping[str, tuple[str, ...]], turning: Sequence[bool]) -> dict[str, Any]:
    """Units row by row, of the kinds in use."""
    return {
        coordinate_of(kind): (tuple(dim for dim in dims if dim.startswith("joint")), units_of(kind, turning))
        for kind, dims in kinds.items()
        if kind in UNITS
    }


def validate(dataset: xr.Dataset, group: str, turning: Sequence[bool]) -> None:
    """Check that a table holds what is declared of its group, in schema.csv and schema_labels.csv.

    Values of variables that are numbers are left to `require_numbers`, as a long one may be read later.

    Parameters
    ----------
    dataset, group
        The table, and of which group it is.
    turning
        Whether each joint of the arm turns.

    Raises
    ------
    StoreError
        If a variable, a coordinate or an attribute is missing, has other dimensions or another kind of
        values, or is in another unit; if a variable or a coordinate is unknown.
    """
    declared = GROUPS[group]
    for name in declared:
        if name not in dataset and name not in OPTIONAL.get(group, ()):
            found = ", ".join(str(known) for known in dataset.data_vars) or "no variables"
            raise StoreError(f"{group} lacks {name}", expected=", ".join(declared), found=found)
    for key, array in dataset.data_vars.items():
        name = str(key)
        if name not in declared:
            raise StoreError(f"{name} is not a variable of {group}", expected=", ".join(declared))
        _require_as_declared(array, declared[name], group, turning)
    units = (
        {}
        if _uniform(turning)
        else _unit_coordinates(
            {declared[str(name)].unit: declared[str(name)].dims for name in dataset.data_vars}, turning
        )
    )
    require_coordinates(dataset, group, len(turning), units)
    require_attributes(dataset.attrs, group, len(turning))


def _require_as_declared(
    array: xr.DataArray, declared: Variable, group: str, turning: Sequence[bool]
) -> None:
    what = f"{declared.name} of {group}"
    if tuple(array.dims) != declared.dims:
        raise StoreError(
            f"{what} has other dimensions than declared",
            expected=str(declared.dims),
            found=str(tuple(array.dims)),
        )
    declared.values.require_kind(array.dtype, what)
    if declared.values.among:
        declared.values.require(array.values, what, len(turning))
    units = declared.attributes(turning)
    for name in ("units", "units_in"):
        if array.attrs.get(name) != units.get(name):
            raise StoreError(
                f"{what} is in other units than declared",
                expected=units.get(name, f"no {name}"),
                found=str(array.attrs.get(name, f"no {name}")),
            )


def require_numbers(values: Array, name: str, group: str) -> None:
    """Check that values of a variable, or of a coordinate, are finite or what else is declared of it.

    None is so large that its square would not be a number any more.

    Raises
    ------
    StoreError
        If one is nan or infinite where that cannot be.
    """
    if values.dtype.kind != "f" or bool((np.abs(values) <= LARGEST_RESULT).all()):
        return
    besides = GROUPS[group][name].besides.split() if name in GROUPS[group] else []
    beyond = np.isfinite(values) & (np.abs(values) > LARGEST_RESULT)
    for kind, found in (("nan", np.isnan(values)), ("inf", np.isinf(values)), ("", beyond)):
        if kind not in besides and found.any():
            place = ", ".join(str(index + 1) for index in np.argwhere(found)[0])
            raise StoreError(
                f"{name} of {group} holds what is no finite number, or too large",
                expected=" or ".join([f"finite numbers up to {LARGEST_RESULT:g}", *besides]),
                found=f"{values[found][0]}, entry {place}",
            )
