"""Results in one HDF5 file, a group per concept, readable by plain xarray and plain h5py."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import Location, StoreError
from gd_analyze.files import replacing
from gd_analyze.findings import Findings
from gd_analyze.schema import SCHEMA_VERSION, validate
from gd_analyze.tables import FORMAT, as_tree

if TYPE_CHECKING:
    import xarray as xr

GROUPS = (
    "trajectory",
    "decomposition",
    "dominance",
    "simplified_model",
    "terms",
    "trade_off",
    "beyond",
)


def save_results(findings: Findings, path: str | Path) -> None:
    """Write everything found into one HDF5 file, atomically.

    Parameters
    ----------
    findings
        What the main job found.
    path
        The file, with the groups of `GROUPS`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as temporary:
        write_results(findings, temporary)


def write_results(findings: Findings, path: Path) -> None:
    """Write the file as it is named, without a way back: for a place that is replaced as a whole."""
    as_tree(findings).to_netcdf(path, engine="h5netcdf")


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back.

    Returns
    -------
    xarray.DataTree
        The groups of `GROUPS`, in memory.

    Raises
    ------
    StoreError
        If the file is missing, damaged, foreign or of another schema version.
    """
    import xarray as xr

    path = Path(path)
    _require_ours(path)
    with _damage_named(path), xr.open_datatree(path, engine="h5netcdf") as opened:
        tree: xr.DataTree = opened.load()
    try:
        validate(tree["decomposition"].to_dataset())
    except StoreError as error:
        raise _damaged(path, error.what) from None
    return tree


def _require_ours(path: Path) -> None:
    """Say what is wrong with a file before xarray tries to make sense of it; plain h5py fails cleanly."""
    import h5py

    if not path.is_file():
        raise StoreError(
            "there is no such results file",
            where=Location(path),
            next_step="name the analysis.h5 of a results folder",
        )
    with _damage_named(path), h5py.File(path) as file:
        attributes: Any = dict(file.attrs)
        groups = list(file)
        file.visititems(lambda _, item: dict(item.attrs) and None)
    if not np.array_equal(attributes.get("format"), FORMAT) or not set(GROUPS) <= set(groups):
        raise StoreError(
            "this HDF5 file does not hold gd-analyze results",
            where=Location(path),
            expected=f"the groups {', '.join(GROUPS)}",
            found=", ".join(groups) or "no groups",
            next_step="name the analysis.h5 of a results folder",
        )
    schema = np.ravel(attributes.get("schema")).tolist()  # netCDF stores numbers as arrays of one
    if schema != [SCHEMA_VERSION]:
        raise StoreError(
            "the results file is of another schema version",
            where=Location(path),
            expected=str(SCHEMA_VERSION),
            found=", ".join(str(number) for number in schema),
            next_step="use the gd-analyze that wrote it, or run the analysis again",
        )


@contextmanager
def _damage_named(path: Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # what a damaged file makes HDF5 and its readers raise has no common class
        raise _damaged(path, str(error) or type(error).__name__) from None


def _damaged(path: Path, found: str) -> StoreError:
    return StoreError(
        "the results file is damaged or not HDF5",
        where=Location(path),
        expected="a file that gd-analyze wrote, e.g. analysis.h5",
        found=found.splitlines()[0],
        next_step="run the analysis again",
    )
