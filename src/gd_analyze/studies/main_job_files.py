"""The folder of the main job's results, written as a whole or not at all."""

from __future__ import annotations

from collections.abc import Collection
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from gd_analyze.files import RESULT_FILES, replacing_together
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import frame_of
from gd_analyze.results.store import write_results
from gd_analyze.simplification.model_file import model_text


def write_findings(
    findings: Findings, folder: Path, formats: Collection[str], strangers: Collection[Path] = ()
) -> None:
    """Write the chosen files, all together when the last is made: one that fails leaves no file behind.

    The PDF is typeset beside the others, as that leaves the interpreter free. The first to be put in place is
    that which the others can be made from; files of another run, `strangers`, are removed then.
    """
    chosen = [name for name in RESULT_FILES if name in formats]
    paths = [folder / RESULT_FILES[name] for name in chosen]
    with ThreadPoolExecutor(max_workers=1) as beside, replacing_together(paths) as temporaries:
        places = dict(zip(chosen, temporaries, strict=True))
        pdf: Future[bytes] | None = None
        report = None
        if {"pdf", "html"} & places.keys():
            from gd_analyze.report.main_report import main_report

            report = main_report(findings)
        if "pdf" in places:
            from gd_analyze.report.main_pdf import prepare_pdf

            pdf = beside.submit(prepare_pdf(findings, report))
        if "html" in places:
            from gd_analyze.report.main_page import render_html

            places["html"].write_bytes(render_html(findings, report).encode())
        if "csv" in places:
            ranking = frame_of(findings.dominance, "element")
            if "motions" in findings.tables:  # verdict and torque share along each: "verdict_MOTION"
                by_motion = frame_of(findings.tables["motions"][["verdict", "torque_share"]], "element")
                ranking = ranking.join(by_motion.drop(columns=["element", "quantity"]))
            if "run" in findings.provenance:
                ranking["run"] = findings.provenance["run"]
            places["csv"].write_bytes(ranking.to_csv(index=False, lineterminator="\n").encode())
        if "json" in places:
            places["json"].write_text(model_text(findings.model), encoding="utf-8")
        if "h5" in places:
            write_results(findings, places["h5"])
        if pdf is not None:
            places["pdf"].write_bytes(pdf.result())
    for path in strangers:
        path.unlink(missing_ok=True)
