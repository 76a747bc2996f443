"""Every variable a result may hold: name, dimensions, unit, equation and meaning, said once in schema.csv.

The same declaration makes a table, validates it, documents it and is stored with it as attributes. A unit
that depends on whether joints turn or slide is given row by row, as a coordinate, where an arm has joints of
both kinds; a unit that depends on what a row is about always is.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import StoreError
from gd_analyze.text import LEVEL_NAMES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray as xr

    from gd_analyze.arrays import Array


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


@dataclass(frozen=True)
class Label:
    """Declaration of a coordinate or an attribute.

    Parameters
    ----------
    name, dims
        As stored; the coordinate of the same name as its dimension holds the labels along it.
    values
        What it may hold. Labels along a dimension that are declared one by one are there in this order.
    meaning
        In words.
    """

    name: str
    dims: tuple[str, ...]
    values: Values
    meaning: str


def _declared_labels(role: str) -> dict[str, dict[str, Label]]:
    """Read the declarations of a role: one line each of schema_labels.csv."""
    groups: dict[str, dict[str, Label]] = {}
    lines = (Path(__file__).parent / "schema_labels.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        if row["role"] == role:
            values = Values(row["kind"], row["among"])
            label = Label(row["name"], tuple(row["dims"].split()), values, row["meaning"])
            groups.setdefault(row["group"], {})[label.name] = label
    return groups


COORDINATES = _declared_labels("coordinate")
ATTRIBUTES = _declared_labels("attribute")


def require_coordinates(
    dataset: xr.Dataset, group: str, n_joints: int, units: Mapping[str, tuple[tuple[str, ...], Any]]
) -> None:
    """Check that a table has the coordinates declared of its dimensions, and no other.

    Parameters
    ----------
    dataset, group
        The table, and of which group it is.
    n_joints
        Joints of the arm.
    units
        Coordinates beside the declared ones, dimensions and values, that say units row by row.

    Raises
    ------
    StoreError
        If one is missing or unknown, has other dimensions, or holds what it cannot.
    """
    declared = {
        name: label
        for name, label in COORDINATES.get(group, {}).items()
        if set(label.dims) <= set(dataset.dims)
    }
    names = [*declared, *units]
    for name in sorted(set(names) ^ set(map(str, dataset.coords))):
        what = "lacks the coordinate" if name in names else "has no coordinate"
        raise StoreError(f"{group} {what} {name}", expected=", ".join(names))
    for name in names:
        array, dims = dataset[name], declared[name].dims if name in declared else units[name][0]
        what = f"{name} of {group}"
        _require_dims(tuple(map(str, array.dims)), dims, what)
        if name in declared:
            _require_labels(array.values, declared[name], what, n_joints)
        elif not np.array_equal(array.values, units[name][1]):
            raise StoreError(f"{what} does not fit the joints of the arm")


def require_attributes(attributes: Mapping[Any, Any], group: str, n_joints: int) -> None:
    """Check that a table has the attributes declared; it may have others.

    Raises
    ------
    StoreError
        If one is missing or holds what it cannot.
    """
    for name, label in ATTRIBUTES.get(group, {}).items():
        if name not in attributes:
            raise StoreError(f"{group} lacks the attribute {name}", expected=label.meaning)
        value, what = np.asarray(attributes[name]), f"the attribute {name} of {group}"
        expected = tuple(n_joints for _ in label.dims)
        if value.shape != expected:
            raise StoreError(f"{what} has another shape", expected=str(expected), found=str(value.shape))
        label.values.require(value, what, n_joints)
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            raise StoreError(f"{what} is no finite number", found=str(attributes[name]))


def _require_dims(found: tuple[str, ...], declared: tuple[str, ...], what: str) -> None:
    if found != declared:
        raise StoreError(
            f"{what} has other dimensions than declared", expected=str(declared), found=str(found)
        )


def _require_labels(values: Any, label: Label, what: str, n_joints: int) -> None:
    label.values.require(values, what, n_joints)
    if label.dims == (label.name,):
        words = label.values.words(n_joints)
        if words and values.astype(str).tolist() != words:
            raise StoreError(
                f"{what} are not those of the arm, in order",
                expected=", ".join(words),
                found=", ".join(values.astype(str)),
            )
        if len(np.unique(values)) < len(values):
            raise StoreError(f"{what} names one of its rows twice")


SCHEMA_VERSION = 4

# Inputs are bounded so that torques stay below 1e65, see `gd_analyze.text.LARGEST`.
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
