"""Reading labelled tables from HDF5: what the layout has, and nothing else that a file may hold.

The file may be damaged or forged in spite of its digest. What is read has a fixed length and a checksum;
links to other files, values of varying length and numbers that cannot be are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array
from gd_analyze.errors import StoreError
from gd_analyze.results.hdf5_layout import COORDINATES, DIMS, OF_SCALES, restored
from gd_analyze.results.refusal import damage_named
from gd_analyze.schema import GROUPS, require_numbers, validate

if TYPE_CHECKING:
    import h5py
    import xarray as xr

# What is stored: numbers of these types, and bytes of a fixed length.
_NUMBERS = (np.float64, np.int64, np.int8, np.uint8)


def open_tables(path: Path) -> h5py.File:
    """Open a file for `read_attributes` and `read_table`."""
    import h5py

    return h5py.File(path, "r", track_order=True)


def read_attributes(item: Any) -> dict[str, Any]:
    """Attributes of a file, a group or a variable as plain values, in the order written."""
    found: dict[str, Any] = {}
    for name in item.attrs:
        if name not in OF_SCALES:
            if not _is_plain(item.attrs.get_id(name).dtype):
                raise StoreError(f"attribute {name} of {item.name} is of a kind that is never written")
            found[name] = restored(np.asarray(item.attrs[name]), {}).tolist()
    return found


def read_table(file: h5py.File, name: str, turning: Sequence[bool], most_rows: float = np.inf) -> xr.Dataset:
    """Read one group of `gd_analyze.schema.GROUPS`.

    Parameters
    ----------
    file
        From `open_tables`.
    name
        Of the group.
    turning
        Whether each joint of the arm turns; that of "documents", which says so, does not depend on it.
    most_rows
        Of how many set points to read all there is of them. Of more, a variable that is not one number per
        joint is read when somebody asks for its values, and holds the file open until then.

    Raises
    ------
    StoreError
        If it is not as `write_tables` writes it, or not as declared.
    """
    import xarray as xr

    group, declared = _member(file, name), GROUPS[name]
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for key in group:
        dataset = _member(group, key)
        attributes = read_attributes(dataset)
        if DIMS in attributes:  # what has none is the scale of a dimension without labels
            dims = tuple(attributes.pop(DIMS).split())
            _require_plain(dataset)
            if dims[0] == "time" and len(dims) > 2 and len(dataset) > most_rows:
                values: Any = _later(file, dataset)
            else:
                values = restored(np.asarray(dataset[()]), attributes)
                require_numbers(values, key, name)
            (variables if key in declared else coordinates)[key] = (dims, values, attributes)
    attributes = read_attributes(group)
    attributes.pop(COORDINATES, None)
    table = xr.Dataset(variables, coordinates, attributes)
    validate(table, name, turning)
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
        raise StoreError(f"{dataset.name} is not stored as variables are, with a checksum")
    if dataset.id.get_storage_size() < dataset.nbytes:
        raise StoreError(f"{dataset.name} is larger than what is stored of it")


def _later(file: h5py.File, dataset: Any) -> Any:
    """Values of a long variable, read when they are asked for; referring to the file holds it open."""
    from gd_analyze.dynamics.long_decomposition import on_demand

    *_, group, name = dataset.name.split("/")

    def read(rows: NDArray[np.intp]) -> Array:
        with damage_named(file.filename):
            first, behind = int(rows[0]), int(rows[-1]) + 1
            together = behind - first == len(rows)
            values = np.asarray(dataset[first:behind] if together else dataset[rows])
            require_numbers(values, name, group)
            return values

    return on_demand(dataset.shape, read)
