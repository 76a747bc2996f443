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

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "gd-analyze results"
GROUPS = ("trajectory", "decomposition", "dominance", "simplified_model")
_MOTION = ("q", "qd", "qdd")


def save_results(findings: Findings, path: str | Path) -> None:
    """Write everything found into one HDF5 file, atomically.

    Parameters
    ----------
    findings
        What the main job found.
    path
        The file; groups `trajectory`, `decomposition`, `dominance` and `simplified_model`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as temporary:
        as_tree(findings).to_netcdf(temporary, engine="h5netcdf")


def as_tree(findings: Findings) -> xr.DataTree:
    """Arrange what was found as the tree that is stored."""
    import xarray as xr

    dataset = findings.decomposition
    trajectory = findings.trajectory
    motion = xr.Dataset({name: dataset[name] for name in _MOTION})
    motion.attrs = {
        "name": trajectory.name,
        "origin": trajectory.origin,
        "rates": trajectory.rates_from,
        "fingerprint": trajectory.fingerprint,
    }
    root = xr.Dataset(
        attrs={
            "format": FORMAT,
            "schema": SCHEMA_VERSION,
            **findings.provenance,
            **{f"residual_{r.quantity}": r.largest for r in findings.residuals},
            **{f"residual_bound_{r.quantity}": r.bound for r in findings.residuals},
            "warnings": "\n".join(findings.warnings),
        }
    )
    return xr.DataTree.from_dict(
        {
            "/": root,
            "/trajectory": motion,
            "/decomposition": dataset,
            "/dominance": findings.dominance,
            "/simplified_model": _model(findings),
        }
    )


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back.

    Returns
    -------
    xarray.DataTree
        Groups `trajectory`, `decomposition`, `dominance` and `simplified_model`, in memory.

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


def _model(findings: Findings) -> xr.Dataset:
    import xarray as xr

    model, evaluation = findings.model, findings.evaluation
    promise = model.promise
    joints = findings.decomposition.joint.values
    per_joint = {
        "allowed_error": (model.budget, "largest torque error the budget allows"),
        "peak_torque": (promise.peak_torque, "largest magnitude of the exact torque"),
        "largest_error": (promise.largest, "largest torque error at the set points"),
        "rms_error": (promise.rms, "root mean square torque error over the set points"),
    }
    return xr.Dataset(
        {
            **{
                name: ("joint", values, {"units": "N m", "long_name": meaning})
                for name, (values, meaning) in per_joint.items()
            },
            "torque": (
                ("time", "joint"),
                evaluation.simplified,
                {"units": "N m", "long_name": "torque of the simplified model"},
            ),
            "torque_error": (
                ("time", "joint"),
                evaluation.simplified - evaluation.exact,
                {"units": "N m", "long_name": "torque of the simplified model minus the exact torque"},
            ),
            "kept": (
                "part",
                np.isin(_labels(findings), findings.element_model.kept),
                {"long_name": "whether the text's own method keeps the part"},
            ),
        },
        coords={
            "time": findings.decomposition.time,
            "joint": joints,
            "part": _labels(findings),
        },
        attrs={
            "level": model.level,
            "budget": model.budget_stated,
            "errors_are": "sampled at the set points",
            "multiplications": model.operations.multiplications,
            "additions": model.operations.additions,
            "sines_cosines": model.operations.sines_cosines,
            "multiplications_full": model.operations_full.multiplications,
            "additions_full": model.operations_full.additions,
            "sines_cosines_full": model.operations_full.sines_cosines,
        },
    )


def _labels(findings: Findings) -> list[str]:
    return [*findings.element_model.kept, *findings.element_model.dropped]
