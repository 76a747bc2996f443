"""Labelled tables in HDF5, in netCDF-4's layout; everything that is read has a checksum.

Strings have a fixed length: values of variable length are stored in a heap without checksums, and a damaged
heap can make the HDF5 library loop for ever. The only exception is netCDF's DIMENSION_LIST, which xarray
needs; we read the attribute "dims" instead. Links and impossible numbers, as in a forged file, are refused.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, Array, chunks
from gd_analyze.dynamics.decomposition import on_demand
from gd_analyze.errors import Location, StoreError
from gd_analyze.schema import GROUPS, dataset_of, require_numbers, validate

if TYPE_CHECKING:
    import h5py
    import xarray as xr

# Oldest and newest version of the format to write; HDF5 1.10 appeared in 2016.
_VERSIONS = ("v110", "v110")
# Attributes that make a dimension scale.
OF_SCALES = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}
# Attribute with a variable's dimensions, for us.
_DIMS = "dims"
# Attributes with a table's coordinates and a variable's types, for xarray.
_COORDINATES, _DTYPE, _ENCODING = "coordinates", "dtype", "_Encoding"
# netCDF's name of a dimension without labels; its length follows.
_WITHOUT_LABELS = "This is a netCDF dimension but not a netCDF variable."
_NUMBERS = (np.float64, np.int64, np.int8, np.uint8)
# More bytes than a variable's description takes.
_DESCRIPTION_BYTES = 1 << 14


def write_tables(path: Path, tables: Mapping[str, xr.Dataset], attributes: Mapping[str, Any]) -> None:
    """Write each table as a group, and the file's attributes; equal tables give equal files."""
    import h5py

    _require_room(path, sum(map(_most_bytes, tables.values())))
    with h5py.File(path, "w", libver=_VERSIONS, track_order=True) as file:
        _describe(file, attributes)
        for name, dataset in tables.items():
            _write_table(file.create_group(name, track_order=True), dataset, name)


def _write_table(group: h5py.Group, dataset: xr.Dataset, name: str) -> None:
    """Write a table: variables along time block by block, as they may be evaluated while they are read.

    The numbers are checked against the declarations of the group of that name.
    """
    labels = [key for key in dataset.coords if key not in dataset.dims]
    _describe(group, dataset.attrs | ({_COORDINATES: " ".join(map(str, labels))} if labels else {}))
    along_time = [key for key, variable in dataset.variables.items() if variable.dims[:1] == ("time",)]
    for key, variable in dataset.variables.items():
        is_long = key in along_time
        values, coding = _stored(np.empty(0, variable.dtype) if is_long else variable.values)
        require_numbers(values, str(key), name)
        stored = group.create_dataset(
            str(key),
            variable.shape,
            values.dtype,
            data=None if is_long else values,
            chunks=(min(variable.shape[0], CHUNK), *variable.shape[1:]) if variable.size else None,
            fletcher32=variable.size > 0,
            track_order=True,
        )
        _describe(stored, variable.attrs | coding | {_DIMS: " ".join(map(str, variable.dims))})
    for chunk in chunks(dataset.sizes["time"]) if along_time else ():
        block = dataset[along_time].isel(time=chunk)
        for key in along_time:
            values = np.ascontiguousarray(_stored(block[key].values)[0])
            require_numbers(values, str(key), name)
            group[str(key)][chunk] = values
    for dim, size in dataset.sizes.items():
        if dim not in dataset.variables:
            group.create_dataset(str(dim), (size,), ">f4").make_scale(f"{_WITHOUT_LABELS}{size:10d}")
        else:
            group[str(dim)].make_scale(str(dim))
    for key, variable in dataset.variables.items():
        if variable.dims != (key,):
            for axis, dim in zip(group[str(key)].dims, variable.dims, strict=True):
                axis.attach_scale(group[str(dim)])


def _require_room(path: Path, size: int) -> None:
    """Raise the system's error where a file of this size would not fit.

    HDF5 cannot close a file that did not fit: the process ends in a segmentation fault (HDF5 1.14 and 2.0).
    """
    with path.open("wb") as file:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
            file.truncate(0)
        elif shutil.disk_usage(path.parent).free < size:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _most_bytes(dataset: xr.Dataset) -> int:
    """More bytes than a table takes in a file, whose last block of rows is filled up."""
    rows = dataset.sizes.get("time", 1)
    filled = 1 + (CHUNK / rows if rows > CHUNK else 0)
    return sum(int(variable.nbytes * filled) + _DESCRIPTION_BYTES for variable in dataset.variables.values())


def _describe(item: h5py.Group | h5py.Dataset, attributes: Mapping[Any, Any]) -> None:
    for key, value in attributes.items():
        item.attrs.create(str(key), _stored(value)[0])


def _stored(values: Any) -> tuple[Array, dict[str, str]]:
    """Return an array as stored, and the attributes that state its type."""
    import h5py

    array = np.asarray(values)
    if array.dtype.kind in "UO":
        encoded = np.char.encode(array.astype(str), "utf-8")
        # A single byte would be netCDF's character, which readers return as bytes.
        fixed = h5py.string_dtype("utf-8", max(encoded.dtype.itemsize, 2))
        return encoded.astype(fixed), {_ENCODING: "utf-8"}
    return (array.astype(np.int8), {_DTYPE: "bool"}) if array.dtype.kind == "b" else (array, {})


def _restored(array: Array, attributes: dict[str, Any]) -> Array:
    """Undo `_stored`, and remove its attributes."""
    attributes.pop(_ENCODING, None)
    if array.dtype.kind == "S":
        return np.char.decode(array, "utf-8")
    return array.astype(bool) if attributes.pop(_DTYPE, None) == "bool" else array


def read_attributes(item: Any) -> dict[str, Any]:
    """Attributes of a file, a group or a variable as plain values, in the order written."""
    attributes: dict[str, Any] = {}
    for name in item.attrs:
        if name not in OF_SCALES:
            if not _is_plain(item.attrs.get_id(name).dtype):
                raise StoreError(f"attribute {name} of {item.name} has a type that is never written")
            attributes[name] = _restored(np.asarray(item.attrs[name]), {}).tolist()
    return attributes


def read_table(file: h5py.File, name: str, revolute: Sequence[bool], most_rows: float = np.inf) -> xr.Dataset:
    """Read one group of `gd_analyze.schema.GROUPS`.

    Beyond `most_rows` set points, variables with more than one number per joint, and those of the group
    every_set_point, are read on access and keep the file open until then.
    """
    group, declared = _member(file, name), GROUPS[name]
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for key in group:
        dataset = _member(group, key)
        attributes = read_attributes(dataset)
        if _DIMS in attributes:  # without it, the item is the scale of a dimension without labels
            dims = tuple(attributes.pop(_DIMS).split())
            _require_plain(dataset)
            is_large = key in declared and (len(dims) > 2 or name == "every_set_point")
            if dims[0] == "time" and is_large and len(dataset) > most_rows:
                values: Any = _later(dataset, name, key)
            else:
                values = _restored(np.asarray(dataset[()]), attributes)
                require_numbers(values, key, name)
            (variables if key in declared else coordinates)[key] = (dims, values, attributes)
    attributes = read_attributes(group)
    attributes.pop(_COORDINATES, None)
    table = dataset_of(variables, coordinates, attributes)
    validate(table, name, revolute)
    return table


def _member(group: h5py.Group, name: str) -> Any:
    import h5py

    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise StoreError(f"{name} of {group.name} is a link to elsewhere")
    return group[name]


def _is_plain(dtype: np.dtype[Any]) -> bool:
    return dtype.kind == "S" or dtype in _NUMBERS


def _require_plain(dataset: Any) -> None:
    import h5py

    is_plain = isinstance(dataset, h5py.Dataset) and _is_plain(dataset.dtype)
    if not is_plain or not (dataset.fletcher32 or dataset.size == 0):
        raise StoreError(f"{dataset.name} is not stored with a checksum, as variables are")
    if dataset.id.get_storage_size() < dataset.nbytes:
        raise StoreError(f"{dataset.name} is larger than its stored data")


def _later(dataset: Any, group: str, name: str) -> Any:
    """Values of a long variable, read on access; `dataset` keeps the file open."""

    def read(rows: NDArray[np.intp]) -> Array:
        first, behind = int(rows[0]), int(rows[-1]) + 1
        try:
            values = np.asarray(dataset[first:behind] if behind - first == len(rows) else dataset[rows])
        except OSError as error:
            where = Location(dataset.file.filename)
            raise StoreError("the results file is damaged", where=where, found=str(error)) from None
        require_numbers(values, name, group)
        return values

    return on_demand(dataset.shape, read)
