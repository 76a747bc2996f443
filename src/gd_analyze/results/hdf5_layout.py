"""How labelled tables lie in HDF5: netCDF-4's layout, in which nothing that we read lacks a checksum.

Since its version 1.10 the format has a checksum on all that describes data, and the filter fletcher32 puts
one on the data. The exception is the heap of values whose lengths vary: a damaged one can make the HDF5
library loop for ever. So strings have a fixed length here. Only netCDF's lists of dimension scales,
DIMENSION_LIST, are kept in the heap; xarray needs them, so we write them, and we read the attribute "dims".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.arrays import Array

# Oldest and newest version of the format to write; HDF5 1.10 is of 2016.
VERSIONS = ("v110", "v110")
# Attributes that dimension scales consist of.
OF_SCALES = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}
# Names of a variable's dimensions.
DIMS = "dims"
# What tells xarray which variables are coordinates, and how numbers and bytes become what they were.
COORDINATES, DTYPE, ENCODING = "coordinates", "dtype", "_Encoding"


def stored(values: Any) -> tuple[Array, dict[str, str]]:
    """Give an array as it is stored, and the attributes that say what it was."""
    import h5py

    array = np.asarray(values)
    if array.dtype.kind in "UO":
        encoded = np.char.encode(array.astype(str), "utf-8")
        # One byte alone would be netCDF's character, of which readers make bytes.
        return encoded.astype(h5py.string_dtype("utf-8", max(encoded.dtype.itemsize, 2))), {ENCODING: "utf-8"}
    if array.dtype.kind == "b":
        return array.astype(np.int8), {DTYPE: "bool"}
    return array, {}


def restored(array: Array, attributes: dict[str, Any]) -> Array:
    """Undo `stored`, and take its attributes away."""
    attributes.pop(ENCODING, None)
    if array.dtype.kind == "S":
        return np.char.decode(array, "utf-8")
    return array.astype(bool) if attributes.pop(DTYPE, None) == "bool" else array
