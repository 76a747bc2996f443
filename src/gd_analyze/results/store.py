"""Results in one HDF5 file, a group per concept, readable by plain xarray and plain h5py."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import GdAnalyzeError, Location, StoreError
from gd_analyze.files import replacing
from gd_analyze.levels import TERM, ExactForm
from gd_analyze.levels.model_schema import ModelDocument, document_of, model_of
from gd_analyze.results.findings import Findings
from gd_analyze.results.sound_file import sound_file
from gd_analyze.robots import arm_from_description, describe_in_full
from gd_analyze.run import warn_of_others
from gd_analyze.schema import GROUPS, SCHEMA_VERSION, table, validate
from gd_analyze.trajectories import Trajectory

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "gd-analyze results"


def save_results(findings: Findings, path: str | Path) -> None:
    """Write everything found into one HDF5 file, atomically.

    Parameters
    ----------
    findings
        What the main job found.
    path
        The file, with the groups of `gd_analyze.schema.GROUPS`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    with replacing(path) as temporary:
        write_results(findings, temporary)


def write_results(findings: Findings, path: Path) -> None:
    """Write the file as it is named, without a way back: for a place that is replaced as a whole."""
    import xarray as xr

    root = xr.Dataset(
        attrs={
            "format": FORMAT,
            "schema": SCHEMA_VERSION,
            **findings.provenance,
            "warnings": "\n".join(findings.warnings),
        }
    )
    groups = {f"/{name}": dataset for name, dataset in findings.tables.items()}
    tree = xr.DataTree.from_dict({"/": root, **groups, "/documents": _documents(findings)})
    with sound_file(path) as file:
        tree.to_netcdf(file, engine="h5netcdf")


def _documents(findings: Findings) -> xr.Dataset:
    """What is no table: arm, models and terms, as JSON in bytes."""
    documents = {
        "arm": describe_in_full(findings.arm),
        "model": document_of(findings.model).model_dump(),
        "ranked_terms": TERM.to_entries(findings.ranked_terms),
    }
    if findings.element_model is not findings.model:
        documents["element_model"] = document_of(findings.element_model).model_dump()
    encoded = {
        name: np.frombuffer(json.dumps(value, ensure_ascii=False).encode(), dtype=np.uint8)
        for name, value in documents.items()
    }
    return table("documents", encoded, findings.arm.is_revolute)


def load_findings(path: str | Path) -> Findings:
    """Read a results file back as what the main job found, to make reports of it again.

    Raises
    ------
    StoreError
        As `load_results`.
    """
    tree = load_results(path)
    tables = {name: _plain(tree[name].to_dataset()) for name in GROUPS if name != "documents"}
    documents = tree["documents"].to_dataset()

    def read(name: str) -> Any:
        return json.loads(documents[name].values.astype(np.uint8).tobytes())

    try:
        arm = arm_from_description(read("arm"))
        model = model_of(ModelDocument.model_validate(read("model")))
        elements = model
        if "element_model" in documents:
            elements = model_of(ModelDocument.model_validate(read("element_model")))
        ranked = TERM.from_entries(ExactForm(arm), read("ranked_terms"))
    except (GdAnalyzeError, KeyError, TypeError, ValueError) as error:
        raise _damaged(Path(path), str(error) or type(error).__name__) from None
    motion = tables["trajectory"]
    warnings = str(tree.attrs["warnings"])
    return Findings(
        arm=arm,
        trajectory=Trajectory(
            motion.time.values,
            motion.q.values,
            motion.qd.values,
            motion.qdd.values,
            motion.attrs["name"],
            motion.attrs["origin"],
            motion.attrs["rates"],
        ),
        tables=tables,
        model=model,
        element_model=elements,
        ranked_terms=ranked,
        warnings=tuple(warnings.split("\n")) if warnings else (),
        provenance={
            str(name): str(value)
            for name, value in tree.attrs.items()
            if name not in ("format", "schema", "warnings")
        },
    )


def _plain(dataset: xr.Dataset) -> xr.Dataset:
    """Put attributes as they were before netCDF made NumPy's numbers of them."""
    dataset.attrs = {
        name: value.tolist() if isinstance(value, np.generic | np.ndarray) else value
        for name, value in dataset.attrs.items()
    }
    return dataset


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back.

    Returns
    -------
    xarray.DataTree
        The groups of `gd_analyze.schema.GROUPS`, in memory.

    Raises
    ------
    StoreError
        If the file is missing, damaged, foreign or of another schema version.

    Warns
    -----
    GdAnalyzeWarning
        If files of another run stand beside it in a folder of results.
    """
    import xarray as xr

    path = Path(path)
    _require_ours(path)
    with _damage_named(path), xr.open_datatree(path, engine="h5netcdf") as opened:
        tree: xr.DataTree = opened.load()
    try:
        for name in GROUPS:
            validate(tree[name].to_dataset(), name)
    except StoreError as error:
        raise _damaged(path, error.what) from None
    warn_of_others(path, str(tree.attrs.get("run", "")))
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
    ours = np.array_equal(attributes.get("format"), FORMAT)
    schema = np.ravel(attributes.get("schema")).tolist()  # netCDF stores numbers as arrays of one
    if ours and schema != [SCHEMA_VERSION]:
        raise StoreError(
            "the results file is of another schema version",
            where=Location(path),
            expected=str(SCHEMA_VERSION),
            found=", ".join(str(number) for number in schema),
            next_step="use the gd-analyze that wrote it, or run the analysis again",
        )
    if not ours or not set(GROUPS) <= set(groups):
        raise StoreError(
            "this HDF5 file does not hold gd-analyze results",
            where=Location(path),
            expected=f"the groups {', '.join(GROUPS)}",
            found=", ".join(groups) or "no groups",
            next_step="name the analysis.h5 of a results folder",
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
