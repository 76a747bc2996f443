"""Tables as frames: one row per entry along a dimension, which CSV, JSON, terminal and reports show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def frame_of(table: xr.Dataset, dim: str, *others: str) -> pd.DataFrame:
    """Take what a table says along one dimension, or of every pair of labels of two that it has.

    Parameters
    ----------
    table
        A table of `gd_analyze.schema.GROUPS`.
    dim, others
        The dimension; its labels are the first column. A variable that has a second dimension besides gives
        one column per label of that, "part_peak_translation"; others are left out.

    Returns
    -------
    pandas.DataFrame
        Units that differ between rows stand in columns of their own.
    """
    import pandas as pd

    if others:
        return table.to_dataframe(dim_order=[dim, *others]).reset_index()
    columns: dict[str, Any] = {dim: table[dim].values}
    for name, array in (*table.data_vars.items(), *table.coords.items()):
        if name == dim or not array.dims or array.dims[0] != dim:
            continue
        if array.dims == (dim,):
            columns[str(name)] = array.values
        elif len(array.dims) == 2:
            for k, label in enumerate(table[array.dims[1]].values):
                columns[f"{name}_{label}"] = array.values[:, k]
    return pd.DataFrame(columns)


def rows_of(table: xr.Dataset, dim: str, *others: str) -> list[dict[str, Any]]:
    """Take the same as plain values, as JSON has them; what is not a number is None."""
    frame = frame_of(table, dim, *others)
    plain = {name: frame[name].to_numpy().tolist() for name in frame.columns}
    return [
        {
            name: None if isinstance(x := column[k], float) and np.isnan(x) else x
            for name, column in plain.items()
        }
        for k in range(len(frame))
    ]
