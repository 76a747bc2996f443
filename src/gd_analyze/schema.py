"""Every variable, coordinate and attribute a result may hold, declared once: a line each of schema.csv.

The same declaration makes a table, validates it, documents it and is stored with it as attributes. Where an
arm has revolute and prismatic joints, a unit that depends on their kind is given row by row, as a coordinate;
a unit that depends on what a row is about always is.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import Array
from gd_analyze.errors import StoreError
from gd_analyze.text import LEVEL_NAMES

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 6

# Inputs are bounded so that torques stay below 1e65, see `gd_analyze.text.LARGEST`.
LARGEST_RESULT = 1e150

# Quantities of joints have units by the number of revolute joints among those they are about.
UNITS: dict[str, tuple[str, ...]] = {
    "position": ("m", "rad"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
    "effort": ("N", "N m"),
    "viscous": ("N s/m", "N m s"),
    "effort per mass": ("N/kg", "N m/kg"),
    "inertia": ("kg", "kg m", "kg m^2"),
    "christoffel": ("kg/m", "kg", "kg m", "kg m^2"),
}

# NumPy's types by what they are called in a declaration; text is of any length.
_TYPES = {"number": "float64", "whole": "int64", "flag": "bool", "byte": "uint8", "text": "str"}


@dataclass(frozen=True)
class Declared:
    """Declaration of a variable, a coordinate or an attribute: one line of schema.csv.

    Parameters
    ----------
    group, role, name
        Its table; "variable", "optional" (a variable that may be missing), "coordinate" or "attribute"; and
        its name there.
    dims
        Dimensions; the coordinate of the same name as its dimension holds the labels along it.
    unit
        A unit; a kind of `UNITS`; the name of a coordinate that holds one per row, with "@" before it; or "".
    besides
        What a variable may hold besides finite numbers: "nan" where a number is not known, "inf" for a share
        of nothing.
    kind
        "number", "whole", "flag" (true or false), "byte" or "text".
    among
        "nonnegative" or "positive" of numbers; or the values there may be, with "|" between, of which "1..n"
        stands for all joints, "units" and "levels" for the names of these. "" for all of the kind.
    symbol, equation, meaning
        In formulas; where it is defined, or how; in words.
    """

    group: str
    role: str
    name: str
    dims: tuple[str, ...]
    unit: str
    besides: str
    kind: str
    among: str
    symbol: str
    equation: str
    meaning: str

    def attributes(self, revolute: Sequence[bool]) -> dict[str, str]:
        """Attributes stored with the variable of an arm whose joints are revolute or not."""
        out = {"long_name": self.meaning, "equation": self.equation}
        if self.symbol:
            out["symbol"] = self.symbol
        if self.unit.startswith("@"):
            out["units_in"] = self.unit[1:]
        elif self.unit in UNITS and len(set(revolute)) > 1:
            out["units_in"] = _unit_coordinate(self.unit)
        elif self.unit:
            joints = [revolute[0]] * sum(dim.startswith("joint") for dim in self.dims)
            out["units"] = unit_of(self.unit, *joints) if self.unit in UNITS else self.unit
        return out

    def require(self, dims: tuple[Any, ...], dtype: np.dtype[Any], values: Any, n_joints: int) -> None:
        """Raise a StoreError unless dimensions, kind and values are those declared.

        `values` may be an array that reads itself when asked for its `values`; numbers of any sign are not
        asked for them.
        """
        what = f"{self.name} of {self.group}"
        if dims != self.dims:
            raise StoreError(f"{what} has other dimensions", expected=str(self.dims), found=str(dims))
        if dtype != _TYPES[self.kind] and not (self.kind == "text" and dtype.kind == "U"):
            raise StoreError(f"{what} is of another kind", expected=_TYPES[self.kind], found=str(dtype))
        if not self.among:
            return
        held = np.asarray(values)
        if self.among in ("nonnegative", "positive"):
            wrong = held[held < 0 if self.among == "nonnegative" else held <= 0]
            if wrong.size:
                raise StoreError(f"{what} is not {self.among}", found=str(wrong.min()))
            return
        choices = self._choices(n_joints)
        for value in np.unique(held.astype(str)).tolist():
            if value not in choices:
                raise StoreError(f"{what} cannot be {value!r}", expected=", ".join(choices), found=value)
        if self.role == "coordinate" and self.dims == (self.name,) and held.astype(str).tolist() != choices:
            raise StoreError(f"{what} is not in order", expected=", ".join(choices), found=str(held.tolist()))

    def _choices(self, n_joints: int) -> list[str]:
        named = {
            "1..n": map(str, range(1, n_joints + 1)),
            "units": [unit for units in UNITS.values() for unit in units],
            "levels": LEVEL_NAMES,
        }
        return [word for part in self.among.split("|") for word in named.get(part, [part])]


def _declared(*roles: str) -> dict[str, dict[str, Declared]]:
    """Declarations by group and name."""
    groups: dict[str, dict[str, Declared]] = {}
    lines = (Path(__file__).parent / "schema.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        one = Declared(**(row | {"dims": tuple(row["dims"].split())}))
        if one.role in roles:
            groups.setdefault(one.group, {})[one.name] = one
    return groups


GROUPS = _declared("variable", "optional")
COORDINATES = _declared("coordinate")
ATTRIBUTES = _declared("attribute")
OPTIONAL = {group: set(declared) for group, declared in _declared("optional").items()}

# Groups that a run has only where there is something to say.
OPTIONAL_GROUPS = {"measured_torque", "motions", "recording"}


def unit_of(kind: str, *revolute: bool) -> str:
    """Unit of a quantity of joints, given whether each of them is revolute.

    Examples
    --------
    >>> unit_of("inertia", True, False)
    'kg m'
    """
    return UNITS[kind][sum(revolute)]


def units_of(kind: str, revolute: Sequence[bool]) -> Array:
    """Unit of every entry of a quantity of an arm's joints: one axis per joint that it is about.

    Examples
    --------
    >>> units_of("inertia", [True, False]).tolist()
    [['kg m^2', 'kg m'], ['kg m', 'kg']]
    """
    flags = np.array(revolute, dtype=int)
    axes = np.meshgrid(*[flags] * (len(UNITS[kind]) - 1), indexing="ij")
    return np.array(UNITS[kind])[sum(axes)]


def table(
    group: str,
    values: Mapping[str, Any],
    revolute: Sequence[bool],
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
    revolute
        Whether each joint of the arm is revolute.
    coords, attrs
        Coordinates beside those of the joints, and attributes.

    Raises
    ------
    StoreError
        As `validate`.
    """
    import xarray as xr

    declared = _known(group, values)
    variables = {
        name: (declared[name].dims, values[name], declared[name].attributes(revolute)) for name in values
    }
    dims = {dim for name in values for dim in declared[name].dims}
    joints = np.arange(1, len(revolute) + 1)
    given = {dim: joints for dim in sorted(dims) if dim.startswith("joint")} | dict(coords or {})
    dataset = xr.Dataset(variables, given | _units_by_row(group, values, revolute), dict(attrs or {}))
    validate(dataset, group, revolute)
    return dataset


def validate(dataset: xr.Dataset, group: str, revolute: Sequence[bool]) -> None:
    """Check that a table holds what is declared of its group.

    Values of variables that are numbers of any sign are left to `require_numbers`, as a long one may be read
    later. Attributes beyond those declared may be there.

    Raises
    ------
    StoreError
        If a variable, a coordinate or an attribute is missing, has other dimensions or another kind of
        values, or is in another unit; if a variable or a coordinate is unknown.
    """
    n, names = len(revolute), [str(name) for name in dataset.data_vars]
    variables = _known(group, names)
    units = _units_by_row(group, names, revolute)
    coordinates = {k: one for k, one in COORDINATES.get(group, {}).items() if {*one.dims} <= {*dataset.dims}}
    attributes = ATTRIBUTES.get(group, {})
    for kind, expected, found in (
        ("variable", set(variables) - OPTIONAL.get(group, set()), names),
        ("coordinate", {*coordinates, *units}, dataset.coords),
        ("attribute", set(attributes), dataset.attrs),
    ):
        if missing := sorted(expected - set(map(str, found))):
            raise StoreError(
                f"{group} lacks the {kind} {missing[0]}",
                expected=", ".join(sorted(expected)),
                found=", ".join(map(str, found)) or f"no {kind}s",
            )
    for name, one in variables.items():
        if name in names:
            array = dataset[name]
            one.require(array.dims, array.dtype, array, n)
            _require_unit(array, one, revolute)
    for key, array in dataset.coords.items():
        name = str(key)
        if name in coordinates:
            coordinates[name].require(array.dims, array.dtype, array, n)
            if array.dims == (name,) and len(np.unique(array)) < len(array):
                raise StoreError(f"{name} of {group} names one of its rows twice")
        elif name not in units:
            raise StoreError(f"{group} has no coordinate {name}", expected=", ".join([*coordinates, *units]))
        elif array.dims != units[name][0] or not np.array_equal(array, units[name][1]):
            raise StoreError(f"{name} of {group} does not fit the joints of the arm")
    for name, one in attributes.items():
        value = np.asarray(dataset.attrs[name])
        if value.shape != (n,) * len(one.dims):
            raise StoreError(f"{name} of {group} has another shape", found=str(value.shape))
        one.require(one.dims, value.dtype, value, n)
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            raise StoreError(f"{name} of {group} is no finite number", found=str(dataset.attrs[name]))


def require_numbers(values: Array, name: str, group: str) -> None:
    """Check that values of a variable, or of a coordinate, are finite or what else is declared of it.

    None is so large that its square would not be a number any more.

    Raises
    ------
    StoreError
        If one is nan, infinite or too large where that cannot be.
    """
    if values.dtype.kind != "f" or bool((np.abs(values) <= LARGEST_RESULT).all()):
        return
    besides = GROUPS[group][name].besides.split() if name in GROUPS[group] else []
    wrong = ~(np.abs(values) <= LARGEST_RESULT)
    for kind, allowed in (("nan", np.isnan(values)), ("inf", np.isinf(values))):
        wrong &= ~allowed if kind in besides else True
    if wrong.any():
        place = ", ".join(str(index + 1) for index in np.argwhere(wrong)[0])
        raise StoreError(
            f"{name} of {group} holds what is no finite number, or too large",
            expected=" or ".join([f"finite numbers up to {LARGEST_RESULT:g}", *besides]),
            found=f"{values[wrong][0]}, entry {place}",
        )


def _known(group: str, names: Any) -> dict[str, Declared]:
    """Declared variables of a group, once all of these names are among them."""
    declared = GROUPS[group]
    for name in names:
        if name not in declared:
            raise StoreError(f"{name} is not a variable of {group}", expected=", ".join(declared))
    return declared


def _unit_coordinate(kind: str) -> str:
    return f"{kind.replace(' ', '_')}_unit"


def _units_by_row(
    group: str, names: Any, revolute: Sequence[bool]
) -> dict[str, tuple[tuple[str, ...], Array]]:
    """Coordinates of units joint by joint: none where all joints are of one kind."""
    if len(set(revolute)) < 2:
        return {}
    kinds = {GROUPS[group][name].unit: GROUPS[group][name].dims for name in names}
    return {
        _unit_coordinate(kind): (
            tuple(dim for dim in dims if dim.startswith("joint")),
            units_of(kind, revolute),
        )
        for kind, dims in kinds.items()
        if kind in UNITS
    }


def _require_unit(array: xr.DataArray, declared: Declared, revolute: Sequence[bool]) -> None:
    expected = declared.attributes(revolute)
    for name in ("units", "units_in"):
        if array.attrs.get(name) != expected.get(name):
            raise StoreError(
                f"{declared.name} of {declared.group} is in other units than declared",
                expected=expected.get(name, f"no {name}"),
                found=str(array.attrs.get(name, f"no {name}")),
            )
