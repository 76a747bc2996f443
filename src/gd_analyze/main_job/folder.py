"""The folder of results: what is in it, and how it is written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Collection
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

from gd_analyze.errors import Location, OutputError
from gd_analyze.files import replacing
from gd_analyze.levels import save_model
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import frame_of
from gd_analyze.results.store import write_results
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory

FILES = {
    "h5": "analysis.h5",
    "json": "model.json",
    "csv": "dominance.csv",
    "html": "report.html",
    "pdf": "report.pdf",
}


def write_findings(findings: Findings, folder: Path, formats: Collection[str]) -> None:
    """Write the chosen files; reports are made first, so that one that fails leaves no file behind.

    The PDF is typeset beside the others, as that leaves the interpreter free.
    """
    made: dict[str, bytes] = {}
    with ThreadPoolExecutor(max_workers=1) as beside, ExitStack() as unfinished:
        pdf: Future[bytes] | None = None
        if "pdf" in formats:
            from gd_analyze.report.pdf import prepare_pdf

            pdf = beside.submit(prepare_pdf(findings))
        if "html" in formats:
            from gd_analyze.report.html import render_html

            made["html"] = render_html(findings).encode()
        if "csv" in formats:
            ranking = frame_of(findings.dominance, "element")
            made["csv"] = ranking.to_csv(index=False, lineterminator="\n").encode()
        if "h5" in formats:
            write_results(findings, unfinished.enter_context(replacing(folder / FILES["h5"])))
        if pdf is not None:
            made["pdf"] = pdf.result()
    if "json" in formats:
        save_model(findings.model, folder / FILES["json"])
    for name, content in made.items():
        with replacing(folder / FILES[name]) as temporary:
            temporary.write_bytes(content)


def default_folder(arm: RobotArm, trajectory: Trajectory) -> Path:
    """Folder the results go to when none is named."""
    return Path("reports") / f"{arm.name}-{trajectory.name}"


def require_writable(folder: Path) -> None:
    """Fail early, before any computing, when results could not be written."""
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
        raise OutputError(
            "cannot write the results there",
            where=Location(folder),
            expected="a folder that exists or can be made",
            found=f"{existing} is {'not writable' if existing.is_dir() else 'not a folder'}",
            next_step="choose another folder with --out",
        )
