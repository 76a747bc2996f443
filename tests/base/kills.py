"""Kills a process that writes results, again and again, and tells what each left: FOLDER, NUMBER, SEED.

It writes two runs in turn, of one arm and motion and different budgets. First one kill comes after each
number of renames, then they come in turn at a random moment of the writing and at one about the renames. Page
and PDF are rendered once, as no file is touched meanwhile; for kills about the renames, so is the HDF5 file.
"""

from __future__ import annotations

import itertools
import json
import os
import random
import signal
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import pandas as pd

import gd_analyze as gd
import gd_analyze.report.main_page
import gd_analyze.report.main_pdf
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.files import RESULT_FILES, mark_in
from gd_analyze.results.findings import Findings
from gd_analyze.studies import main_job_files as results_folder
from gd_analyze.studies.main_job_files import write_findings


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# Before each rename that shall be hit, and longer than all of them take then, s: by itself it takes 20e-6.
PAUSE, RENAMING = 1e-3, 8e-3


def two_runs() -> list[Findings]:
    arm = gd.load_arm("two_link")
    motion = gd.read_trajectory("two-link-swing", arm)
    return [gd.find(arm, motion, gd.Settings(budget=gd.Budget.parse(budget))) for budget in ("1%", "30%")]


def render_once(runs: list[Findings]) -> None:
    pages = {run.provenance["run"]: gd_analyze.report.main_page.render_html(run) for run in runs}
    papers = {run.provenance["run"]: gd_analyze.report.main_pdf.prepare_pdf(run)() for run in runs}
    gd_analyze.report.main_page.render_html = lambda run, *_: pages[run.provenance["run"]]
    gd_analyze.report.main_pdf.prepare_pdf = lambda run, *_: lambda: papers[run.provenance["run"]]


def with_hdf5_copied(runs: list[Findings], folder: Path) -> Callable[[Callable[[], None]], None]:
    """Make what calls a function so that it copies HDF5 files, which takes no time."""
    write_results = results_folder.write_results
    stored = {}
    for run in runs:
        write_results(run, folder / "copied.h5")
        stored[run.provenance["run"]] = (folder / "copied.h5").read_bytes()
    (folder / "copied.h5").unlink()

    def call(write: Callable[[], None]) -> None:
        results_folder.write_results = lambda run, path: path.write_bytes(stored[run.provenance["run"]])
        write()
        results_folder.write_results = write_results

    return call


def killed(work: Callable[[int], None], wait: Callable[[int], None]) -> None:
    """Let a process work, which may write to a pipe, and kill it when the wait for it is over."""
    hear, tell = os.pipe()
    child = os.fork()
    if child == 0:
        work(tell)
        os._exit(1)
    os.close(tell)
    wait(hear)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(hear)
    assert os.WIFSIGNALED(status), "it was not killed, but ended"


def dies_after(renames: int, write: Callable[[], None]) -> Callable[[int], None]:
    """Write, and die before one rename more than the number given, or after all."""

    def work(_: int) -> None:
        done, replace = 0, Path.replace

        def counted(self: Path, target: Path) -> Path:
            nonlocal done
            if done == renames:
                os.kill(os.getpid(), signal.SIGKILL)
            done += 1
            return replace(self, target)

        Path.replace = counted
        write()
        os.kill(os.getpid(), signal.SIGKILL)

    return work


def for_ever(write: Callable[[], None], before: Callable[[int], None] | None = None) -> Callable[[int], None]:
    """Write again and again, after a preparation."""

    def work(tell: int) -> None:
        if before is not None:
            before(tell)
        while True:
            write()

    return work


def telling_of_renames(tell: int) -> None:
    """Write a byte when renames begin, and take time for each."""
    replace = Path.replace

    def slow(self: Path, target: Path) -> Path:
        if target.name == RESULT_FILES["h5"]:
            os.write(tell, b".")
        time.sleep(PAUSE)
        return replace(self, target)

    Path.replace = slow


def what_is_wrong(folder: Path) -> tuple[list[str], bool]:
    """What must never be, and whether the folder holds files of both runs."""
    wrong: list[str] = []
    names = [name for name in RESULT_FILES.values() if (folder / name).exists()]
    marks = {name: mark_in(folder / name) for name in names}
    wrong += [f"{name} has no mark" for name, found in marks.items() if not found]
    mixed = len(set(marks.values())) > 1
    for name, load in (("analysis.h5", gd.load_findings), ("model.json", gd.load_model)):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", GdAnalyzeWarning)
            try:
                load(folder / name)
            except GdAnalyzeError as error:
                wrong.append(f"{name} does not load: {error}")
        others = [other for other in names if marks[other] != marks[name]]
        said = " ".join(str(warning.message) for warning in told)
        if mixed != ("different runs" in said) or not all(other in said for other in others):
            wrong.append(f"{name} beside others of another run, {others}: {said!r}")
    if len(pd.read_csv(folder / RESULT_FILES["csv"])) != 7:  # D11, D12, D22, h1, h2, c1, c2
        wrong.append("the ranking is cut off")
    if not (folder / RESULT_FILES["html"]).read_text(encoding="utf-8").rstrip().endswith("</html>"):
        wrong.append("the page is cut off")
    if not (folder / RESULT_FILES["pdf"]).read_bytes().rstrip().endswith(b"%%EOF"):
        wrong.append("the PDF is cut off")
    return wrong, mixed


def main(folder: Path, number: int, seed: int) -> None:
    runs = two_runs()
    render_once(runs)
    draw, names = random.Random(seed), sorted(RESULT_FILES.values())
    start = time.perf_counter()
    for run in runs:
        write_findings(run, folder, RESULT_FILES)
    duration = time.perf_counter() - start
    copied = with_hdf5_copied(runs, folder)
    turns = itertools.cycle(runs)

    def write() -> None:
        write_findings(next(turns), folder, RESULT_FILES)

    def write_quickly() -> None:
        copied(write)

    def about_renames(hear: int) -> None:
        os.read(hear, 1)
        end = time.perf_counter() + draw.uniform(0, RENAMING)
        while time.perf_counter() < end:
            pass

    each_number = [
        (dies_after(k, write_quickly), lambda hear: os.read(hear, 1)) for k in range(len(RESULT_FILES) + 1)
    ]
    at_random = (for_ever(write), lambda _: time.sleep(draw.uniform(0, duration)))
    renaming = (for_ever(write_quickly, telling_of_renames), about_renames)
    ways = [
        *each_number,
        *itertools.islice(itertools.cycle((renaming, at_random)), number - len(each_number)),
    ]
    wrong, mixed, left = [], 0, 0
    for k, (work, wait) in enumerate(ways):
        killed(work, wait)
        found, is_mixed = what_is_wrong(folder)
        wrong += [f"kill {k + 1}: {sentence}" for sentence in found]
        mixed += is_mixed
        left += names_in(folder) != names
        next(turns)
        if k < len(each_number) or draw.random() < 0.5:  # the others are followed by a second kill
            write_quickly()
            if [name for name in names_in(folder) if not name.startswith(".gd-analyze.")] != names:
                wrong.append(f"kill {k + 1}: the next run left {names_in(folder)}")
    print(json.dumps({"kills": len(ways), "mixed": mixed, "left_something": left, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
