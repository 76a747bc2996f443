"""The results file: tables in HDF5, a group per concept, and as JSON what is no table, all under seal."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.long_decomposition import MOST_KEPT
from gd_analyze.errors import Location, StoreError
from gd_analyze.files import replacing, warn_of_others
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.findings import Findings
from gd_analyze.results.fit import require_models_fit, require_tables_fit, require_terms_fit
from gd_analyze.results.hdf5_reader import open_tables, read_attributes, read_table
from gd_analyze.results.hdf5_writer import write_tables
from gd_analyze.results.motions_table import motions_in
from gd_analyze.results.recording_table import recording_in
from gd_analyze.results.refusal import damage_named
from gd_analyze.results.seal import require_sealed, seal
from gd_analyze.results.tables import gaps_in
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import arm_from_description, describe_in_full
from gd_analyze.schema import GROUPS, OPTIONAL_GROUPS, SCHEMA_VERSION, table
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model_file import ModelDocument, checked_model, document_of
from gd_analyze.simplification.term import TERM

if TYPE_CHECKING:
    import h5py
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
    StoreError
        If a number is not finite where all must be.
    """
    with replacing(path) as temporary:
        write_results(findings, temporary)


def write_results(findings: Findings, path: Path) -> None:
    """Write the file as it is named, without a way back: for a place that is replaced as a whole."""
    attributes = {
        "format": FORMAT,
        "schema": SCHEMA_VERSION,
        **findings.provenance,
        "warnings": "\n".join(findings.warnings),
    }
    write_tables(path, {**findings.tables, "documents": _documents(findings)}, attributes)
    seal(path)


def _documents(findings: Findings) -> xr.Dataset:
    """What is no table: arm, models and terms, as JSON in bytes."""
    documents = {
        "arm": describe_in_full(findings.arm),
        "model": document_of(findings.model).model_dump(),
        "ranked_terms": TERM.to_entries(findings.ranked_terms),
    }
    if findings.element_model is not findings.model:
        documents["element_model"] = document_of(findings.element_model).model_dump()
    encoded = np.frombuffer(json.dumps(documents, ensure_ascii=False).encode(), dtype=np.uint8)
    return table("documents", {"json": encoded}, findings.arm.is_revolute)


def load_findings(path: str | Path) -> Findings:
    """Read a results file back as what the main job found, to make reports of it again.

    Of a long trajectory, D, h and h_ijk are read from the file, which stays open, when they are asked for.

    Raises
    ------
    StoreError
        As `load_results`, whose warnings are given, too.
    """
    path = Path(path)
    with _opened(path) as file:
        attributes = read_attributes(file)
        tables, documents, arm = _read(file, MOST_KEPT)
        del tables["documents"]
        model = elements = checked_model(ModelDocument.model_validate(documents["model"]))
        if "element_model" in documents:
            elements = checked_model(ModelDocument.model_validate(documents["element_model"]))
        require_models_fit(model, elements, tables, arm)
        ranked = TERM.from_entries(ExactForm(arm), documents["ranked_terms"])
        require_terms_fit(ranked, tables)
        warn_of_others(path, str(attributes.get("run", "")))
        motion, warnings = tables["trajectory"], attributes["warnings"]
        motions = motions_in(tables["motions"]) if "motions" in tables else ()
        if motion.sizes["time"] <= MOST_KEPT:
            file.close()
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
                gaps=gaps_in(motion),
                motions=motions,
                recording=recording_in(tables),
            ),
            tables=tables,
            model=model,
            element_model=elements,
            ranked_terms=ranked,
            warnings=tuple(warnings.split("\n")) if warnings else (),
            provenance={
                name: str(value)
                for name, value in attributes.items()
                if name not in ("format", "schema", "warnings")
            },
        )


def load_results(path: str | Path) -> xr.DataTree:
    """Read a results file back.

    Returns
    -------
    xarray.DataTree
        The groups of `gd_analyze.schema.GROUPS` that the run has, in memory.

    Raises
    ------
    StoreError
        If the file is missing, damaged, changed, foreign or of another schema version.

    Warns
    -----
    GdAnalyzeWarning
        If files of another run stand beside it in a folder of results.
    """
    import xarray as xr

    path = Path(path)
    with _opened(path) as file:
        root = xr.Dataset(attrs=read_attributes(file))
        tables, _, _ = _read(file)
        file.close()
    warn_of_others(path, str(root.attrs.get("run", "")))
    return xr.DataTree.from_dict({"/": root} | {f"/{name}": table for name, table in tables.items()})


def _read(
    file: h5py.File, most_rows: float = np.inf
) -> tuple[dict[str, xr.Dataset], dict[str, Any], RobotArm]:
    """All tables, the JSON documents among them, and the arm; `most_rows` as for `read_table`."""
    stored = read_table(file, "documents", ())
    documents = json.loads(stored.json.values.tobytes())
    arm = arm_from_description(documents["arm"])
    names = [name for name in GROUPS if name != "documents" and (name in file or name not in OPTIONAL_GROUPS)]
    tables = {name: read_table(file, name, arm.is_revolute, most_rows) for name in names}
    require_tables_fit(tables, arm)
    return tables | {"documents": stored}, documents, arm


@contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """Open a results file whose digest is right; whatever is wrong with it is a StoreError that names it.

    It stays open where all is well: tables of a long trajectory are read later.
    """
    if not path.is_file():
        raise StoreError(
            "there is no such results file",
            where=Location(path),
            next_step="name the analysis.h5 of a results folder",
        )
    try:
        require_sealed(path)
    except OSError as error:
        raise StoreError(
            "cannot read the results file",
            where=Location(path),
            found=error.strerror or str(error),
            next_step="give the path of a file you may read",
        ) from None
    with damage_named(path), ExitStack() as failing:
        file = failing.enter_context(open_tables(path))
        _require_ours(file, path)
        yield file
        failing.pop_all()


def _require_ours(file: h5py.File, path: Path) -> None:
    attributes, groups = read_attributes(file), list(file)
    schema = attributes.get("schema")
    if attributes.get("format") == FORMAT and schema != SCHEMA_VERSION:
        raise StoreError(
            "the results file is of another schema version",
            where=Location(path),
            expected=str(SCHEMA_VERSION),
            found=str(schema),
            next_step="use the gd-analyze that wrote it, or run the analysis again",
        )
    if attributes.get("format") != FORMAT or not set(GROUPS) - OPTIONAL_GROUPS <= set(groups):
        raise StoreError(
            "this HDF5 file does not hold gd-analyze results",
            where=Location(path),
            expected=f"the groups {', '.join(GROUPS)}",
            found=", ".join(groups) or "no groups",
            next_step="name the analysis.h5 of a results folder",
        )
