"""Coordinates and attributes of every table, said once in schema_labels.csv."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.declared_values import Values
from gd_analyze.errors import StoreError

if TYPE_CHECKING:
    import xarray as xr


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


def _declared(role: str) -> dict[str, dict[str, Label]]:
    """Read the declarations of a role: one line each of schema_labels.csv."""
    groups: dict[str, dict[str, Label]] = {}
    lines = (Path(__file__).parent / "schema_labels.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        if row["role"] == role:
            values = Values(row["kind"], row["among"])
            label = Label(row["name"], tuple(row["dims"].split()), values, row["meaning"])
            groups.setdefault(row["group"], {})[label.name] = label
    return groups


COORDINATES = _declared("coordinate")
ATTRIBUTES = _declared("attribute")


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
