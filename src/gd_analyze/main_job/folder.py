"""The folder of results: what is in it, and how it is written as a whole or not at all."""

from __future__ import annotations

from collections.abc import Collection
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from gd_analyze.files import replacing_together, require_writable
from gd_analyze.levels.model_file import model_text
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import frame_of
from gd_analyze.results.store import write_results
from gd_analyze.robots import RobotArm
from gd_analyze.run import RESULT_FILES, marks_in, warn_of_what_was_there
from gd_analyze.trajectories import Trajectory

FILES = RESULT_FILES


def write_findings(findings: Findings, folder: Path, formats: Collection[str]) -> None:
    """Write the chosen files, all together when the last is made: one that fails leaves no file behind.

    The PDF is typeset beside the others, as that leaves the interpreter free. The first to be put in place is
    that which the others can be made from.

    Warns
    -----
    GdAnalyzeWarning
        If files of another run remain in the folder, or those of another arm or motion were replaced.
    """
    chosen = [name for name in FILES if name in formats]
    before = {name: marks_in(folder / name) for name in FILES.values()}
    paths = [folder / FILES[name] for name in chosen]
    with ThreadPoolExecutor(max_workers=1) as beside, replacing_together(paths) as temporaries:
        places = dict(zip(chosen, temporaries, strict=True))
        pdf: Future[bytes] | None = None
        if "pdf" in places:
            from gd_analyze.report.pdf import prepare_pdf

            pdf = beside.submit(prepare_pdf(findings))
        if "html" in places:
            from gd_analyze.report.html import render_html

            places["html"].write_bytes(render_html(findings).encode())
        if "csv" in places:
            places["csv"].write_bytes(_ranking_csv(findings).encode())
        if "json" in places:
            places["json"].write_text(model_text(findings.model), encoding="utf-8")
        if "h5" in places:
            write_results(findings, places["h5"])
        if pdf is not None:
            places["pdf"].write_bytes(pdf.result())
    mark = findings.provenance.get("run", "")
    if chosen:
        warn_of_what_was_there(folder, before, [path.name for path in paths], mark)


def _ranking_csv(findings: Findings) -> str:
    """Rank the elements, and say in a last column, the same in every row, of which run this is."""
    ranking = frame_of(findings.dominance, "element")
    if "run" in findings.provenance:
        ranking["run"] = findings.provenance["run"]
    return ranking.to_csv(index=False, lineterminator="\n")


def default_folder(arm: RobotArm, trajectory: Trajectory) -> Path:
    """Folder the results go to when none is named."""
    return Path("reports") / f"{arm.name}-{trajectory.name}"


def require_folder(folder: Path, formats: Collection[str]) -> None:
    """Fail early, before any computing, when the files of these formats could not be written."""
    for name in formats:
        require_writable(folder / FILES[name])
