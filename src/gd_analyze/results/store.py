"""The results file: tables in HDF5, a group per subject, a JSON document, and a digest at the end.

A damaged HDF5 file can make the HDF5 library loop for ever, so damage must be detected before the library
reads. The digest follows the HDF5 data as one line of text. HDF5 readers know the length of the data from the
head and ignore what follows; a program that edits the file loses or invalidates the line.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from gd_analyze.dynamics.decomposition import MOST_KEPT
from gd_analyze.errors import Location, StoreError, require_type
from gd_analyze.files import path_of, replacing, warn_of_others
from gd_analyze.results.findings import Findings
from gd_analyze.results.hdf5 import read_attributes, read_table, write_tables
from gd_analyze.results.motion_tables import trajectory_in
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.description import describe
from gd_analyze.schema import GROUPS, SCHEMA_VERSION, table
from gd_analyze.simplification.accuracy import STATED
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model import SimplifiedModel

if TYPE_CHECKING:
    import h5py
    import xarray as xr

RESULTS_FORMAT = "gd-analyze results"
# First bytes of an HDF5 file.
_HDF5 = b"\x89HDF\r\n\x1a\n"
# Bytes between the HDF5 file and its digest.
_MARK = b"\ngd-analyze sha256 "
# The mark, a digest in hexadecimal, the end of the line.
SEAL_LENGTH = len(_MARK) + 64 + 1
# Bytes read at a time, the memory needed for checking.
_BYTES_AT_ONCE = 2**20
# Root attributes that are not of the run.
_OF_FILE = ("format", "schema", "open_with", "groups")
_DAMAGED = "the results file is damaged"
_NAME_IT = "name the analysis.h5 of a results folder"
_UNCHANGED = "a file as gd-analyze wrote it, e.g. analysis.h5"
_AGAIN = "take a copy that was not changed, or run the analysis again"


def save_results(findings: Findings, path: str | Path) -> None:
    """Write all results into one HDF5 file, atomically.

    Parameters
    ----------
    findings
        Results of the main job.
    path
        The file; it holds the groups of `gd_analyze.schema.GROUPS`.

    Raises
    ------
    OutputError
        If the file cannot be written.
    StoreError
        If a number is not finite although its variable must be.
    """
    require_type(findings, Findings, "findings", "the Findings of `analyze` or `load_findings`")
    with replacing(path) as temporary:
        write_results(findings, temporary)


def write_results(findings: Findings, path: Path) -> None:
    """Write the file in place, not atomically: for a path that is replaced as a whole."""
    from gd_analyze.simplification.model_file import document_of  # loads pydantic

    models = {"model": findings.model}
    if findings.element_model is not findings.model:
        models["element_model"] = findings.element_model
    documents = {name: document_of(model).model_dump(mode="json") for name, model in models.items()} | {
        "arm": describe(findings.arm),
        "ranked_terms": [TERM.entry(term) for term in findings.ranked_terms],
    }
    encoded = np.frombuffer(json.dumps(documents, ensure_ascii=False).encode(), dtype=np.uint8)
    stored = table("documents", {"json": encoded}, findings.arm.is_revolute)
    tables = {**findings.tables, "documents": stored}
    tables = {name: tables[name] for name in GROUPS if name in tables}
    attributes = {
        "format": RESULTS_FORMAT,
        "schema": SCHEMA_VERSION,
        "open_with": 'xarray.open_dataset(file, group="dominance")',
        "groups": ", ".join(tables),
        **findings.provenance,
        "warnings": "\n".join(findings.warnings),
    }
    write_tables(path, tables, attributes)
    seal(path)


def load_findings(path: str | Path) -> Findings:
    """Read a results file back as the Findings of the main job.

    For a long trajectory, D, h and h_ijk are read on access, and the file stays open.

    Parameters
    ----------
    path
        The analysis.h5 of a results folder.

    Raises
    ------
    StoreError
        As for `load_results`, with the same warnings.
    """
    path = path_of(path)
    file = _opened(path)
    attributes, tables = read_attributes(file), _read(file, MOST_KEPT)
    documents = json.loads(tables.pop("documents").json.values.tobytes())
    arm = arm_in(documents["arm"])
    model = elements = _model(documents["model"])
    if "element_model" in documents:
        elements = _model(documents["element_model"])
    ranked = TERM.from_entries(model.form, documents["ranked_terms"])
    warn_of_others(path, str(attributes.get("run", "")))
    if all(table.sizes.get("time", 0) <= MOST_KEPT for table in tables.values()):
        file.close()
    lines = attributes.pop("warnings")
    return Findings(
        arm=arm,
        trajectory=trajectory_in(tables),
        tables=tables,
        model=model,
        element_model=elements,
        ranked_terms=ranked,
        warnings=tuple(lines.split("\n")) if lines else (),
        proof=STATED,
        provenance={name: str(attributes[name]) for name in attributes if name not in _OF_FILE},
    )


def _model(document: Any) -> SimplifiedModel:
    from gd_analyze.simplification.model_file import ModelDocument, model_of

    return model_of(ModelDocument.model_validate(document))


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back as labelled tables.

    Parameters
    ----------
    path
        The analysis.h5 of a results folder.

    Returns
    -------
    xarray.DataTree
        The groups of `gd_analyze.schema.GROUPS` that the run has, in memory; units are attributes.

    Raises
    ------
    StoreError
        If the file is missing, damaged, changed, foreign or of another schema version.

    Warns
    -----
    GdAnalyzeWarning
        If its folder contains files of another run.
    """
    import xarray as xr

    path = path_of(path)
    with _opened(path) as file:
        root, tables = xr.Dataset(attrs=read_attributes(file)), _read(file)
    warn_of_others(path, str(root.attrs.get("run", "")))
    return xr.DataTree.from_dict({"/": root} | {f"/{name}": table for name, table in tables.items()})


def _read(file: h5py.File, most_rows: float = np.inf) -> dict[str, xr.Dataset]:
    """All tables, including the JSON documents; `most_rows` as for `read_table`."""
    return {name: read_table(file, name, most_rows) for name in GROUPS if name in file}


def _opened(path: Path) -> h5py.File:
    """Open a results file whose digest is right and whose schema is ours; a StoreError names it otherwise.

    It is the caller's to close: tables of a long trajectory are read later.
    """
    import h5py

    if not path.is_file():
        raise StoreError("there is no such results file", where=Location(path), next_step=_NAME_IT)
    try:
        require_sealed(path)
    except OSError as error:
        readable, reason = "give the path of a file you may read", error.strerror or str(error)
        raise _refusal(path, "cannot read the results file", reason, None, readable) from None
    try:
        file = h5py.File(path, "r", track_order=True)
    except OSError as error:
        raise _refusal(path, _DAMAGED, str(error).splitlines()[0]) from None
    schema = read_attributes(file).get("schema")
    if schema != SCHEMA_VERSION:
        file.close()
        message, next_step = "has another schema version", "use the gd-analyze that wrote it, or run again"
        raise _refusal(path, f"the results file {message}", str(schema), str(SCHEMA_VERSION), next_step)
    return file


def _refusal(
    path: Path, message: str, content: str, expected: str | None = _UNCHANGED, next_step: str = _AGAIN
) -> StoreError:
    return StoreError(message, where=Location(path), expected=expected, found=content, next_step=next_step)


def seal(path: Path) -> None:
    """Append the digest of a file's content."""
    with path.open("r+b") as file:
        digest = _digest(file, os.fstat(file.fileno()).st_size)
        file.seek(0, os.SEEK_END)
        file.write(_MARK + digest + b"\n")


def require_sealed(path: Path) -> None:
    """Check that a file ends in the digest of its content; otherwise it is cut short or changed."""
    with path.open("rb") as file:
        if file.read(len(_HDF5)) != _HDF5:
            raise _refusal(path, f"{_DAMAGED} or not HDF5", "another kind of file")
        length = os.fstat(file.fileno()).st_size - SEAL_LENGTH
        file.seek(max(length, 0))
        line = file.read(SEAL_LENGTH)
        if length < 0 or not line.startswith(_MARK):
            content = (
                "no digest at its end: cut short, edited since, or written by another program or version"
            )
            raise _refusal(path, "this HDF5 file is not as gd-analyze wrote it", content)
        if line != _MARK + _digest(file, length) + b"\n":
            raise _refusal(path, f"{_DAMAGED}, or was edited since it was written", "another digest")


def _digest(file: BinaryIO, length: int) -> bytes:
    """SHA-256 of the first bytes of a file, in hexadecimal."""
    digest = hashlib.sha256()
    file.seek(0)
    while length > 0 and (block := file.read(min(length, _BYTES_AT_ONCE))):
        digest.update(block)
        length -= len(block)
    return digest.hexdigest().encode()
