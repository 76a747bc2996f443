"""Writing labelled tables to HDF5, block by block where they are long."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import CHUNK, chunks
from gd_analyze.results.hdf5_layout import COORDINATES, DIMS, VERSIONS, stored
from gd_analyze.results.sound_file import SoundFile, sound_file
from gd_analyze.schema import require_numbers

if TYPE_CHECKING:
    import h5py
    import xarray as xr

# What netCDF calls a dimension without labels, before its length.
_WITHOUT_LABELS = "This is a netCDF dimension but not a netCDF variable."


def write_tables(path: Path, tables: Mapping[str, xr.Dataset], attributes: Mapping[str, Any]) -> None:
    """Write tables, each a group of its name, and attributes of the whole; equal ones give equal files.

    Raises
    ------
    StoreError
        If a number is not finite where all are; the file is not whole then.
    OSError
        If the file cannot be written.
    """
    import h5py

    with sound_file(path) as sink, h5py.File(sink, "w", libver=VERSIONS, track_order=True) as file:
        _describe(file, attributes)
        for name, dataset in tables.items():
            _write_table(file.create_group(name, track_order=True), dataset, name)
            _fill(file[name], dataset, name, sink)


def _write_table(group: h5py.Group, dataset: xr.Dataset, name: str) -> None:
    """Make all variables of a table, and write those that are not along time."""
    labels = [key for key in dataset.coords if key not in dataset.dims]
    _describe(group, dataset.attrs | ({COORDINATES: " ".join(map(str, labels))} if labels else {}))
    for key, variable in dataset.variables.items():
        _create(group, str(key), variable, name)
    for dim, size in dataset.sizes.items():
        if dim not in dataset.variables:
            group.create_dataset(str(dim), (size,), ">f4").make_scale(f"{_WITHOUT_LABELS}{size:10d}")
        else:
            group[str(dim)].make_scale(str(dim))
    for key, variable in dataset.variables.items():
        if variable.dims != (key,):
            for axis, dim in zip(group[str(key)].dims, variable.dims, strict=True):
                axis.attach_scale(group[str(dim)])


def _create(group: h5py.Group, key: str, variable: xr.Variable, name: str) -> None:
    """Make a variable and what describes it; one along time is still without values."""
    along_time = variable.dims[:1] == ("time",)
    values, attributes = (None, {}) if along_time else stored(variable.values)
    if values is not None:
        require_numbers(values, key, name)
    made = group.create_dataset(
        key,
        variable.shape,
        variable.dtype if values is None else values.dtype,
        data=values,
        chunks=(min(variable.shape[0], CHUNK), *variable.shape[1:]) if variable.size else None,
        fletcher32=variable.size > 0,
        track_order=True,
    )
    _describe(made, variable.attrs | attributes | {DIMS: " ".join(map(str, variable.dims))})


def _fill(group: h5py.Group, dataset: xr.Dataset, name: str, sink: SoundFile) -> None:
    """Write the values along time, as long as there is room for them."""
    long = [key for key, variable in dataset.variables.items() if variable.dims[:1] == ("time",)]
    for chunk in chunks(dataset.sizes["time"]) if long else ():
        if sink.failure is not None:
            return
        block = dataset[long].isel(time=chunk)
        for key in long:
            values = np.ascontiguousarray(block[key].values)
            require_numbers(values, str(key), name)
            group[str(key)][chunk] = values


def _describe(item: h5py.Group | h5py.Dataset, attributes: Mapping[Any, Any]) -> None:
    for key, value in attributes.items():
        item.attrs.create(str(key), stored(value)[0])
