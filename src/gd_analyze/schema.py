"""Every variable a result may hold, and every column that a person reads, declared once in schema.csv.

The same declaration makes a table, documents it, is stored with it as attributes, and heads its column in
terminal, page and PDF. Where an arm has revolute and prismatic joints, a unit that depends on their kind is
given row by row, as a coordinate; a unit that depends on a row's subject always is.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gd_analyze.arrays import Array
from gd_analyze.errors import StoreError, UsageError
from gd_analyze.result import Column, ShownAs, Table, Values
from gd_analyze.text import in_python, joint_name, short_names

if TYPE_CHECKING:
    import xarray as xr

SCHEMA_VERSION = 18

# Inputs are bounded so that torques stay below 1e65, see `gd_analyze.text.LARGEST`.
LARGEST_RESULT = 1e150

# Units of joint quantities, by the number of revolute joints among their indices.
SCHEMA_UNITS: dict[str, tuple[str, ...]] = {
    "position": ("m", "rad"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
    "effort": ("N", "N m"),
    "viscous": ("N s/m", "N m s"),
    "effort per mass": ("N/kg", "N m/kg"),
    "inertia": ("kg", "kg m", "kg m^2"),
    "christoffel": ("kg/m", "kg", "kg m", "kg m^2"),
}


@dataclass(frozen=True)
class Declared:
    """A variable, a coordinate or a column: one line of schema.csv."""

    group: str
    # "variable", "optional" (a variable that may be missing), "coordinate", or "column": of a result's table,
    # and not stored
    role: str
    name: str
    dims: tuple[str, ...]  # the coordinate of the same name as its dimension holds the labels along it
    unit: str  # a unit; a kind of `SCHEMA_UNITS`; "@" and the coordinate that holds one per row; or ""
    besides: str  # finite numbers: "nan" where a number is not known, "inf" for a share of nothing
    symbol: str
    equation: str  # where it is defined, or how
    heading: str  # of its column in a result's table; "{}" stands for a word, see `declared_columns`
    shown: ShownAs | Literal[""]  # how a person reads its values
    meaning: str

    def attributes(self, revolute: Sequence[bool]) -> dict[str, str]:
        """Attributes stored with the variable of an arm whose joints are revolute or not."""
        out = {"long_name": self.meaning, "equation": self.equation}
        if self.symbol:
            out["symbol"] = self.symbol
        if self.unit.startswith("@"):
            out["units_in"] = self.unit[1:]
        elif self.unit in SCHEMA_UNITS and len(set(revolute)) > 1:
            out["units_in"] = _unit_coordinate(self.unit)
        elif self.unit:
            joints = [revolute[0]] * sum(dim.startswith("joint") for dim in self.dims)
            out["units"] = unit_of(self.unit, *joints) if self.unit in SCHEMA_UNITS else self.unit
        return out


def _declared(*roles: str) -> dict[str, dict[str, Declared]]:
    """Declarations by group and name."""
    groups: dict[str, dict[str, Declared]] = {}
    lines = (Path(__file__).parent / "schema.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        declared = Declared(**(row | {"dims": tuple(row["dims"].split())}))
        if declared.role in roles:
            groups.setdefault(declared.group, {})[declared.name] = declared
    return groups


GROUPS = _declared("variable", "optional")
COLUMNS = _declared("coordinate", "column")
# Declares columns of all groups.
_ANY_GROUP = "any"
# The entry that holds the unit of a quantity of joints, in rows about one joint each.
_UNITS_BY_ROW = {
    "position": "unit",
    "acceleration": "qdd_unit",
    "effort": "effort_unit",
    "effort per mass": "effort_unit",
}


def unit_of(kind: str, *revolute: bool) -> str:
    """Unit of a quantity of joints, given whether each of them is revolute."""
    return SCHEMA_UNITS[kind][sum(revolute)]


def quantity_units(kind: str, revolute: Sequence[bool]) -> Array:
    """Unit of every entry of a quantity of an arm's joints: one axis per joint that it is about."""
    flags = np.array(revolute, dtype=int)
    axes = np.meshgrid(*[flags] * (len(SCHEMA_UNITS[kind]) - 1), indexing="ij")
    return np.array(SCHEMA_UNITS[kind])[sum(axes)]


def declared(group: str, name: str) -> tuple[Declared, str]:
    """The declaration of a variable or column, and a label along its second dimension, or "".

    The label may end the name: "part_peak_rotation".
    """
    declarations = COLUMNS[_ANY_GROUP] | GROUPS.get(group, {}) | COLUMNS.get(group, {})
    if name in declarations:
        return declarations[name], ""
    for stem, declaration in declarations.items():
        if len(declaration.dims) == 2 and name.startswith(f"{stem}_"):
            return declaration, name.removeprefix(f"{stem}_")
    raise LookupError(f"schema.csv declares no {name} in the group {group}")


def declared_columns(
    group: str,
    values: Values,
    terminal: Sequence[str],
    page: Sequence[str] | None = None,
    *,
    words: Mapping[str, str] | None = None,
    drawn: Mapping[str, Sequence[Any]] | None = None,
) -> tuple[Column, ...]:
    """Make columns as schema.csv declares them, by name.

    Parameters
    ----------
    group
        The group that declares them.
    values
        Values by name, with those that hold units; None for a column that is left out. "joint" beside
        "joint_name" is shown as both.
    terminal, page
        Names of the columns that a terminal and that pages show, in order; pages may show more.
    words
        Words for "{}" in headings, by name; by default the label along a second dimension.
    drawn
        By name, what pages show in place of the values.
    """
    columns, names = [], terminal if page is None else page
    for name in (name for name in names if values[name] is not None):
        declaration, label = declared(group, name)
        column = Column(
            declaration.heading.format((words or {}).get(name, label)),
            _joint_names(values) if name == "joint" and "joint_name" in values else values[name],
            _unit_in(values, declaration),
            declaration.shown or "number",
            declaration.meaning,
            (drawn or {}).get(name),
            name not in terminal,
            name,
        )
        columns.append(column)
    return tuple(columns)


def declared_table(
    group: str,
    key: str | None,
    title: str,
    values: Values,
    terminal: Sequence[str],
    page: Sequence[str] | None = None,
    note: str = "",
    top: int | None = None,
    *,
    seen: Values | None = None,
    words: Mapping[str, str] | None = None,
    drawn: Mapping[str, Sequence[Any]] | None = None,
) -> Table:
    """Make a result's table: JSON has all values, people see the columns named.

    `seen` are values that people see beside or in place of those of JSON; other parameters are those of
    `Table` and `declared_columns`.
    """
    columns = declared_columns(group, {**values, **(seen or {})}, terminal, page, words=words, drawn=drawn)
    return Table(key, title, columns, note, top, values)


def _joint_names(values: Values) -> list[str]:
    """Number and name of the joint of each row."""
    numbers, names = list(values["joint"]), list(values["joint_name"])
    if numbers == list(range(1, len(numbers) + 1)):  # some joints alone may share more words
        names = short_names(names)
    return [joint_name(*pair) for pair in zip(numbers, names, strict=True)]


def _unit_in(values: Values, declaration: Declared) -> str | Sequence[str]:
    """The unit of a column, or of each of its rows; none of texts, which state it themselves."""
    unit = declaration.unit.removeprefix("1")  # a number without unit
    if unit.startswith("@"):
        return [*values[unit[1:]]]
    if unit in SCHEMA_UNITS:
        return "" if declaration.shown == "text" else [*values[_UNITS_BY_ROW[unit]]]
    return unit


def table(
    group: str,
    values: Mapping[str, Any],
    revolute: Sequence[bool],
    coords: Mapping[str, Any] | None = None,
    attrs: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Make the table of a group of an arm whose joints are revolute or not.

    `values` are arrays by the names declared, `coords` coordinates beside those of the joints.
    """
    declared = GROUPS[group]
    variables = {
        name: (declared[name].dims, values[name], declared[name].attributes(revolute)) for name in values
    }
    dims = {dim for name in values for dim in declared[name].dims}
    joints = np.arange(1, len(revolute) + 1)
    coordinates = {dim: joints for dim in sorted(dims) if dim.startswith("joint")} | dict(coords or {})
    return dataset_of(variables, coordinates | _units_by_row(group, values, revolute), dict(attrs or {}))


def dataset_of(
    variables: Mapping[str, Any], coords: Mapping[str, Any], attrs: Mapping[str, Any]
) -> xr.Dataset:
    """Make a dataset that has the accessor `gd`."""
    import xarray as xr

    import gd_analyze.results.accessor  # noqa: F401  its import registers the accessor

    return xr.Dataset(variables, coords, attrs)


def require_table(
    value: object, group: str, maker: str, where: str = "dataset", next_step: str | None = None
) -> None:
    """Raise a UsageError unless a value is the table of a group, as the function `maker` returns it."""
    names = getattr(value, "data_vars", None)
    needed = {name for name, declared in GROUPS[group].items() if declared.role == "variable"}
    if names is None or not needed <= {*map(str, names)}:
        content = in_python(value) if names is None else f"a dataset of {', '.join(map(str, names))}"
        message, expected = f"this is not what `{maker}` returns", f"the dataset of `{maker}`"
        raise UsageError(message, where=where, expected=expected, found=content, next_step=next_step)


def require_numbers(values: Array, name: str, group: str) -> None:
    """Raise a StoreError unless all numbers are finite, with finite squares, or declared as nan or inf."""
    if values.dtype.kind != "f" or bool((np.abs(values) <= LARGEST_RESULT).all()):
        return
    besides = GROUPS[group][name].besides.split() if name in GROUPS[group] else []
    wrong = ~(np.abs(values) <= LARGEST_RESULT)
    for kind, allowed in (("nan", np.isnan(values)), ("inf", np.isinf(values))):
        wrong &= ~allowed if kind in besides else True
    if wrong.any():
        place = ", ".join(str(index + 1) for index in np.argwhere(wrong)[0])
        raise StoreError(
            f"{name} of {group} contains a number that is not finite, or too large",
            expected=" or ".join([f"finite numbers up to {LARGEST_RESULT:g}", *besides]),
            found=f"{values[wrong][0]}, entry {place}",
        )


def _unit_coordinate(kind: str) -> str:
    return f"{kind.replace(' ', '_')}_unit"


def _units_by_row(
    group: str, names: Any, revolute: Sequence[bool]
) -> dict[str, tuple[tuple[str, ...], Array]]:
    """Coordinates of units joint by joint: none where all joints are of one kind."""
    kinds = {GROUPS[group][name].unit: GROUPS[group][name].dims for name in names}
    return {
        _unit_coordinate(kind): (
            tuple(dim for dim in dims if dim.startswith("joint")),
            quantity_units(kind, revolute),
        )
        for kind, dims in kinds.items()
        if kind in SCHEMA_UNITS and len(set(revolute)) > 1
    }
