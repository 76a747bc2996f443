"""Tables as frames: one row per entry along a dimension, which CSV, JSON, terminal and reports show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def frame_of(table: xr.Dataset, *dims: str) -> pd.DataFrame:
    """Take what a table says along one dimension, or of every pair of labels of two.

    Parameters
    ----------
    table
        A table of `gd_analyze.schema.GROUPS`.
    dims
        The dimensions; their labels are the first columns. Where one is named, a variable that has a second
        besides gives one column per label of that, "part_peak_translation"; others are left out.

    Returns
    -------
    pandas.DataFrame
        Units that differ between rows stand in columns of their own.
    """
    import pandas as pd

    if len(dims) > 1:
        return table.to_dataframe(dim_order=list(dims)).reset_index()
    return pd.DataFrame(_columns(table, dims[0]))


def rows_of(table: xr.Dataset, *dims: str) -> list[dict[str, Any]]:
    """Take the same as plain values, as JSON has them; what is not a number is None."""
    columns: Any = _columns(table, dims[0]) if len(dims) == 1 else frame_of(table, *dims)
    plain = {name: np.asarray(columns[name]).tolist() for name in columns}
    return [
        {name: None if isinstance(x, float) and x != x else x for name, x in zip(plain, row, strict=True)}
        for row in zip(*plain.values(), strict=True)
    ]


def _columns(table: xr.Dataset, dim: str) -> dict[str, np.ndarray]:
    columns: dict[str, np.ndarray] = {dim: table[dim].values}
    for name, array in (*table.data_vars.items(), *table.coords.items()):
        if array.dims == (dim,):
            columns[str(name)] = array.values
        elif len(array.dims) == 2 and array.dims[0] == dim:
            labels = table[array.dims[1]].values
            columns |= {f"{name}_{label}": array.values[:, k] for k, label in enumerate(labels)}
    return columns
