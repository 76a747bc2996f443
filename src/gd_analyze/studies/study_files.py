"""Files of a run, of the main job or of a study, written all together or not at all."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from gd_analyze.files import RESULT_FILES, mark_of, replacing_together, require_one_run, write_together
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.report.document import Document, result_document
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.report.pdf import pdf_of
from gd_analyze.result import Result
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import frame_of
from gd_analyze.results.store import write_results
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint

_WRITERS: Mapping[str, Callable[[Document], bytes]] = {
    "html": lambda document: page_of(document).encode(),
    "pdf": pdf_of,
    "json": lambda document: (
        json.dumps(document.content["values"], indent=2, allow_nan=False) + "\n"
    ).encode(),
}


class StudyFolder:
    """Files NAME.html, NAME.pdf and NAME.json in a folder, of one run: see `require_one_run`.

    Without a folder there are none, and none is written.
    """

    def __init__(
        self,
        folder: Path | None,
        name: str,
        formats: Collection[str],
        inputs: Sequence[str],
        *,
        overwrite: bool,
    ) -> None:
        self._mark, self._paths, self._stale = mark_of(inputs), dict[str, Path](), tuple[Path, ...]()
        if folder is not None:
            files = {format_: f"{name}.{format_}" for format_ in _WRITERS}
            self._stale = require_one_run(folder, files, formats, self._mark, overwrite=overwrite)
            self._paths = {format_: folder / files[format_] for format_ in formats}

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files to write."""
        return tuple(self._paths.values())

    def write(self, result: Result, progress: Progress) -> None:
        """Write all files once the last is made, each with the mark of the run, and remove another run's."""
        if not self._paths:
            return
        progress.stage(f"writing {', '.join(self._paths)}")
        marked = replace(result, provenance={**result.provenance, "run": self._mark})
        document = result_document(marked)
        write_together({path: _WRITERS[format_](document) for format_, path in self._paths.items()})
        for path in self._stale:
            path.unlink(missing_ok=True)


def write_findings(
    findings: Findings,
    folder: Path,
    formats: Collection[str],
    strangers: Collection[Path] = (),
    progress: Progress = NO_PROGRESS,
) -> None:
    """Write the chosen files together, once the last is made, and remove `strangers`, files of another run.

    The file from which the others can be rebuilt is put in place first.
    """
    progress.stage(f"writing {', '.join(formats)}")
    chosen = [name for name in RESULT_FILES if name in formats]
    paths = [folder / RESULT_FILES[name] for name in chosen]
    with replacing_together(paths) as temporaries:
        places = dict(zip(chosen, temporaries, strict=True))
        report = main_report(findings) if {"pdf", "html"} & places.keys() else None
        if report is not None and "html" in places:
            places["html"].write_bytes(page_of(report).encode())
        if "csv" in places:
            ranking = frame_of(findings.dominance, "element")
            if "motions" in findings.tables:  # verdict and torque share along each: "verdict_MOTION"
                by_motion = frame_of(findings.tables["motions"][["verdict", "torque_share"]], "element")
                ranking = ranking.join(by_motion.drop(columns=["element", "quantity"]))
            if "run" in findings.provenance:
                ranking["run"] = findings.provenance["run"]
            places["csv"].write_bytes(ranking.to_csv(index=False, lineterminator="\n").encode())
        if "json" in places:
            from gd_analyze.simplification.model_file import model_text  # loads pydantic

            places["json"].write_text(model_text(findings.model), encoding="utf-8")
        if "h5" in places:
            write_results(findings, places["h5"])
        if report is not None and "pdf" in places:
            places["pdf"].write_bytes(pdf_of(report))
    for path in strangers:
        path.unlink(missing_ok=True)


def inputs_stated(arm: RobotArm, motion: Trajectory | None) -> dict[str, str]:
    """State arm, payload and motion with their hashes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # given when the arm was read
        stated = {"arm": f"{arm.name}, SHA-256 {fingerprint(arm)[:16]}"}
    payload = [note for note in arm.assumptions if "payload" in note]
    if payload:
        stated["payload"] = "; ".join(payload)
    motion_stated = "none given" if motion is None else f"{motion.name}, SHA-256 {motion.fingerprint[:16]}"
    return stated | {"trajectory": motion_stated}
