"""Labelled tables in HDF5, in netCDF-4's layout; everything that is read has a checksum.

Strings have a fixed length: values of variable length are stored in a heap without checksums, and a damaged
heap can make the HDF5 library loop for ever. The only exception is netCDF's DIMENSION_LIST, which xarray
needs; we read the attribute "dims" instead. Numbers are checked when they are written: the digest proves that
those read are the same.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, Array, chunks
from gd_analyze.dynamics.decomposition import on_demand
from gd_analyze.errors import Location, StoreError
from gd_analyze.schema import dataset_of, require_numbers

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
    return {
        name: _restored(np.asarray(item.attrs[name]), {}).tolist()
        for name in item.attrs
        if name not in OF_SCALES
    }


def read_table(file: h5py.File, name: str, most_rows: float = np.inf) -> xr.Dataset:
    """Read one group of `gd_analyze.schema.GROUPS`.

    Beyond `most_rows` set points, variables with more than one number per joint, and those of the group
    every_set_point, are read on access and keep the file open until then.
    """
    group = file[name]
    attributes = read_attributes(group)
    labels = attributes.pop(_COORDINATES, "").split()
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for key, dataset in group.items():
        described = read_attributes(dataset)
        if _DIMS not in described:  # the scale of a dimension without labels
            continue
        dims = tuple(described.pop(_DIMS).split())
        is_coordinate = key in labels or dims == (key,)
        is_large = not is_coordinate and (len(dims) > 2 or name == "every_set_point")
        if dims[0] == "time" and is_large and len(dataset) > most_rows:
            values: Any = _later(dataset)
        else:
            values = _restored(np.asarray(dataset[()]), described)
        (coordinates if is_coordinate else variables)[key] = (dims, values, described)
    return dataset_of(variables, coordinates, attributes)


def _later(dataset: Any) -> Any:
    """Values of a long variable, read on access; `dataset` keeps the file open."""

    def read(rows: NDArray[np.intp]) -> Array:
        first, behind = int(rows[0]), int(rows[-1]) + 1
        try:
            return np.asarray(dataset[first:behind] if behind - first == len(rows) else dataset[rows])
        except OSError as error:
            where = Location(dataset.file.filename)
            raise StoreError("the results file is damaged", where=where, found=str(error)) from None

    return on_demand(dataset.shape, read)
