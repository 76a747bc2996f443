"""Many main jobs: a row per arm, motion, options and varied numbers, in one table that grows as they end."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

from gd_analyze import __version__
from gd_analyze.arguments import strict, words_of
from gd_analyze.dynamics.dominance import elements
from gd_analyze.errors import (
    GdAnalyzeError,
    GdAnalyzeWarning,
    Location,
    OutputError,
    UsageError,
    require_type,
)
from gd_analyze.figures.batch import batch_figure
from gd_analyze.files import (
    RESULT_FILES,
    appending_alone,
    mark_of,
    path_of,
    replacing,
    require_writable,
    temporary_folder,
    write_together,
)
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.report.pdf import drawing_file
from gd_analyze.result import StoredFact, plain
from gd_analyze.results.near_motion import near_bound
from gd_analyze.results.run_facts import first_facts, run_headline
from gd_analyze.robots.arm_numbers import with_numbers
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.payload import carrying, parse_payload
from gd_analyze.studies.batch_rows import (
    BatchRow,
    RowInput,
    checked_rows,
    digest_of,
    picked_of,
    row_inputs,
    rows_in,
    settings_of,
    varied_in,
)
from gd_analyze.studies.batch_table import batch_table, varied_column
from gd_analyze.studies.main_job import find
from gd_analyze.studies.many import each
from gd_analyze.studies.settings import Settings
from gd_analyze.studies.study_files import write_findings
from gd_analyze.text import number_in

if TYPE_CHECKING:
    import pandas as pd

    from gd_analyze.results.findings import Findings

# Finished rows, a line of JSON each; the table is made from them.
RECORD = "rows.jsonl"
TABLES = ("csv", "parquet")
DRAWINGS = ("svg", "pdf", "png")


@dataclass(frozen=True)
class BatchTask:
    """All that a worker needs of one row."""

    row: BatchRow
    arm: RowInput
    trajectory: RowInput
    formats: tuple[str, ...]

    @property
    def key(self) -> str:
        """Digest of what the result depends on: inputs by content, options, version."""
        inputs = [self.arm.digest, self.trajectory.digest, {k: str(v) for k, v in self.row.items()}]
        return mark_of([__version__, *self.formats], inputs)[-16:]


@strict
def batch(
    table: str | Path | Sequence[BatchRow],
    out: str | Path,
    *,
    formats: str | Collection[str] = ("json",),
    to: str | Collection[str] = ("csv",),
    jobs: int = 1,
    scheduler: str | None = None,
    progress: Progress = NO_PROGRESS,
) -> pd.DataFrame:
    """Run the main job for every row of a table; a failed row states the reason.

    Rows are recorded in `out` as they end; after an interruption the same call continues. A row is recognized
    by the content of its inputs, its options and the version; failed rows are repeated.

    Parameters
    ----------
    table
        A CSV table with a column per option, a YAML or TOML file with a value or a list per option, a folder
        with a folder of logs per robot, or rows as mappings. Options are `arm`, `trajectory`, `payload`, the
        arguments of `load_arm`, the fields of `Settings`, and numbers that replace those of the arm, named as
        in arm files: "link3.mass", "link3.com.x", "joint2.a" (or "joint2.a_mm"), "drive1.inertia".
    out
        Folder for `batch.csv`, `batch.svg` and others, the record, and a folder of files per row.
    formats
        Files to write for every row, see `analyze`; "json" is the model, an empty collection writes none.
    to
        The table as "csv", "parquet" (needs pyarrow); a figure of peak torques and operations as "svg",
        "pdf", "png".
    jobs, scheduler
        Number of processes on this machine, or the address of a Dask scheduler, see `each`.
    progress
        Told the rows done.

    Returns
    -------
    pandas.DataFrame
        One row per row of the input, in its order: `state` ("done" or "failed"), `error`, the options,
        headline figures, peak torques ("peak_torque_1", N m or N) and verdicts ("D11", ...) by element,
        `files`. Where numbers vary, `changed_verdicts` are those that differ from the first row of the same
        arm and trajectory.

    Raises
    ------
    UsageError
        If the table has no rows or unknown options, or a format is unknown.
    OutputError
        If the folder cannot be written to.
    """
    require_type(table, (str, Path, Sequence), "table", "a file, a folder, or rows as mappings")
    path_of(out)
    if isinstance(table, str | Path):
        rows = rows_in(Path(table))
        base_folder = Path(table) if Path(table).is_dir() else Path(table).parent
    else:
        rows, base_folder = checked_rows(table, "rows"), Path()
    formats = words_of(formats, RESULT_FILES, "formats")
    to = words_of(to, (*TABLES, *DRAWINGS), "to")
    require_type(scheduler, (str, NoneType), "scheduler", "the address of a Dask scheduler, or None")
    if "parquet" in to and find_spec("pyarrow") is None:
        step = "pip install pyarrow, or write csv"
        raise UsageError("Parquet needs the library pyarrow", where="to", found="parquet", next_step=step)
    folder = Path(out)
    for name in (RECORD, *(f"batch.{kind}" for kind in to)):
        require_writable(folder / name)
    folder.mkdir(parents=True, exist_ok=True)
    keys = list[str]()
    with appending_alone(folder / RECORD) as record:
        entries_by_key = _recorded(folder)
        progress.stage("analysing", len(rows))
        states = list[str]()

        def end_row(state: str) -> None:
            states.append(state)
            failed = f", {states.count('failed')} failed" if "failed" in states else ""
            progress.advance()
            progress.counted(f"{len(states)} of {len(rows)} rows{failed}")

        def tasks() -> Iterator[tuple[BatchTask]]:
            task_keys = set[str]()
            for row in rows:
                task = BatchTask(row, *row_inputs(row, base_folder), tuple(sorted(formats)))
                keys.append(task.key)
                if task.key in task_keys or entries_by_key.get(task.key, {}).get("state") == "done":
                    end_row("done")
                else:
                    task_keys.add(task.key)
                    yield (task,)

        for _, (key, entries, files) in each(analysed, tasks(), jobs, scheduler):
            write_together({folder / key / name: content for name, content in files.items()})
            written = {name: digest_of(folder / key / name) for name in files}
            line = {"key": key, **entries, "files": written}
            record.write(json.dumps(line | {"digest": _digest(line)}).encode() + b"\n")
            record.flush()
            os.fsync(record.fileno())
            entries_by_key[key] = entries
            end_row(entries["state"])
        frame = batch_table(rows, [entries_by_key[key] | {"files": key if formats else ""} for key in keys])
        for kind in to:
            with replacing(folder / f"batch.{kind}") as temporary:
                if kind == "csv":
                    frame.map(_no_formula).to_csv(temporary, index=False, lineterminator="\n")
                elif kind == "parquet":
                    frame.to_parquet(temporary, index=False)
                else:
                    temporary.write_bytes(drawing_file(batch_figure(frame, varied_column(rows)), kind))
    return frame


def _no_formula(cell: Any) -> Any:
    """Put an apostrophe before text that a spreadsheet would run."""
    runs = isinstance(cell, str) and cell.startswith(("=", "@", "+", "-", "\t", "\r"))
    return f"'{cell}" if runs and number_in(cell) is None else cell


def analysed(task: BatchTask) -> tuple[str, dict[str, Any], dict[str, bytes]]:
    """Run the main job for one row; return its key, its entries in the table, and its files.

    Any error becomes the row's own, and is stated in it.
    """
    with temporary_folder() as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        try:
            findings = _findings(task, folder, caught)
            write_findings(findings, folder, task.formats)
            names = [RESULT_FILES[name] for name in task.formats]
            return task.key, _headline(findings), {name: (folder / name).read_bytes() for name in names}
        except Exception as error:
            kind = "" if isinstance(error, GdAnalyzeError) else f"{type(error).__name__}: "
            text = f"{kind}{error}".replace(f"{folder}/", "")
            for source, word in ((task.arm, task.row["arm"]), (task.trajectory, task.row["trajectory"])):
                text = text.replace(source.path or source.name, str(word))
            return task.key, {"state": "failed", "error": text}, {}


def _findings(task: BatchTask, folder: Path, caught: Sequence[warnings.WarningMessage]) -> Findings:
    row = task.row
    arm = load_arm(task.arm.at(folder), **picked_of(row))
    if varied := varied_in(row):
        arm = with_numbers(arm, varied)
    if "payload" in row:
        arm = carrying(arm, parse_payload(str(row["payload"])))
    motion = trajectory_of(task.trajectory.at(folder), arm)
    motion = replace(motion, origin=motion.origin.replace(f"{folder}/", ""))
    settings = Settings(**settings_of(row))
    warned = dict.fromkeys(str(warning.message).replace(f"{folder}/", "") for warning in caught)
    return find(arm, motion, settings, warned=list(warned))


def _headline(findings: Findings) -> dict[str, Any]:
    """Entries of an analysis in the table."""
    model, dominance = findings.model, findings.dominance
    stored = [fact for fact in first_facts(findings) if isinstance(fact, StoredFact)]
    endings = ("_error", "_error_of")
    facts = {fact.key: plain(fact.value) for fact in stored if fact.key.endswith(endings)}
    errors = model.accuracy.errors
    by_joint = {"peak_torque": errors.peak_torque, "largest_error": errors.largest}
    by_joint["allowed_error"] = model.accuracy.allowed
    verdicts = dict(zip(dominance.element.values.tolist(), dominance.verdict.values.tolist(), strict=True))
    return {
        "state": "done",
        "error": "",
        "headline": run_headline(findings),
        "joints": findings.arm.n_joints,
        "joint_kinds": "".join("R" if turns else "P" for turns in findings.arm.is_revolute),
        "set_points": findings.trajectory.n_set_points,
        "level_used": model.level.name,
        "drives_used": model.drives,
        "model_operations": model.operations.total,
        "exact_operations": model.operations_full.total,
        "model_sines_cosines": model.operations.sines_cosines,
        "exact_sines_cosines": model.operations_full.sines_cosines,
        "gamma": model.accuracy.gamma,
        **facts,
        "budget_kept": _budget_kept(findings),
        "warnings": "; ".join(findings.warnings),
        **{f"{k}_{i}": x for k, row in by_joint.items() for i, x in enumerate(row.tolist(), start=1)},
        **{element.label: verdicts[element.label] for element in elements(findings.arm.n_joints)},
    }


def _budget_kept(findings: Findings) -> str:
    """Where the model keeps its budget: "proven" near the motion, "at set points", or "no"."""
    accuracy, bound = findings.model.accuracy, near_bound(findings)
    if bound is not None and (bound <= accuracy.allowed).all():
        return "proven"
    return "at set points" if (accuracy.errors.largest <= accuracy.allowed).all() else "no"


def _recorded(folder: Path) -> dict[str, dict[str, Any]]:
    """Rows of a record by key, without rows that were changed or whose files were.

    An incomplete last line is removed from the record.
    """
    path = folder / RECORD
    data = path.read_bytes()
    complete = data[: data.rfind(b"\n") + 1]
    if len(complete) < len(data):
        os.truncate(path, len(complete))
    rows: dict[str, dict[str, Any]] = {}
    try:
        for line in complete.splitlines():
            row = json.loads(line)
            digest, key = row.pop("digest", ""), row["key"]
            if digest == _digest(row):
                rows[key] = row
            else:
                rows.pop(key, None)
    except (ValueError, KeyError, AttributeError, TypeError):
        step = "name another folder, or remove the file to begin anew"
        raise OutputError("the record of the rows is damaged", where=Location(path), next_step=step) from None
    return {
        key: {name: value for name, value in row.items() if name not in ("key", "files")}
        for key, row in rows.items()
        if all(digest_of(folder / key / name) == written for name, written in row["files"].items())
    }


def _digest(row: Mapping[str, Any]) -> str:
    """SHA-256 of a row of the record."""
    return hashlib.sha256(json.dumps(row, sort_keys=True).encode()).hexdigest()
