"""Kills a process that writes results, again and again, and tells what each left: FOLDER, NUMBER, SEED.

It writes two runs in turn, of one arm and motion and different budgets. First one kill comes after each
number of renames, then they come at random moments. Page and PDF are rendered once, as no file is touched
meanwhile.
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
from functools import partial
from pathlib import Path

import pandas as pd

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.files import RESULT_FILES, mark_in
from gd_analyze.studies import study_files
from gd_analyze.studies.study_files import write_findings
from gd_analyze.types import Findings

NAMES = sorted(RESULT_FILES.values())


def render_once(runs: list[Findings]) -> None:
    reports = {run.provenance["run"]: study_files.main_report(run) for run in runs}
    pages = {mark: study_files.page_of(report) for mark, report in reports.items()}
    papers = {mark: study_files.pdf_of(report) for mark, report in reports.items()}
    study_files.main_report = lambda run: reports[run.provenance["run"]]
    study_files.page_of = lambda report: pages[report.content["run"]]
    study_files.pdf_of = lambda report: papers[report.content["run"]]


def killed(work: Callable[[], None], after: float | None) -> None:
    """Let a process work and kill it after so many seconds, or let it kill itself."""
    child = os.fork()
    if child == 0:
        work()
        os._exit(1)
    if after is not None:
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status), "it was not killed, but ended"


def dying_after(renames: int, write: Callable[[], None]) -> None:
    """Write, and die before one rename more than the number given, or after all."""
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


def what_is_wrong(folder: Path) -> tuple[list[str], bool]:
    """What must never be, and whether the folder holds files of both runs."""
    marks = {name: mark_in(folder / name) for name in NAMES}
    wrong = [f"{name} has no mark" for name, found in marks.items() if not found]
    mixed = len(set(marks.values())) > 1
    for name, load in (("analysis.h5", gd.load_findings), ("model.json", gd.load_model)):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", GdAnalyzeWarning)
            try:
                load(folder / name)
            except GdAnalyzeError as error:
                wrong.append(f"{name} does not load: {error}")
        others = [other for other in NAMES if marks[other] != marks[name]]
        said = " ".join(str(warning.message) for warning in told)
        if mixed != ("different runs" in said) or not all(other in said for other in others):
            wrong.append(f"{name} beside others of another run, {others}: {said!r}")
    for kind, end in (("html", b"</html>"), ("pdf", b"%%EOF")):
        if not (folder / RESULT_FILES[kind]).read_bytes().rstrip().endswith(end):
            wrong.append(f"{kind} is cut off")
    if len(pd.read_csv(folder / RESULT_FILES["csv"])) != 7:  # D11, D12, D22, h1, h2, c1, c2
        wrong.append("the ranking is cut off")
    return wrong, mixed


def main(folder: Path, number: int, seed: int) -> None:
    runs = [gd.analyze("two_link", "two-link-swing", budget=budget) for budget in ("1%", "30%")]
    render_once(runs)
    draw, turns = random.Random(seed), itertools.cycle(runs)

    def write() -> None:
        write_findings(next(turns), folder, RESULT_FILES)

    write()
    start = time.perf_counter()
    write()
    duration = time.perf_counter() - start
    wrong, mixed, left = [], 0, 0
    for k in range(number):
        if k <= len(NAMES):
            killed(partial(dying_after, k, write), None)
        else:
            killed(lambda: [write() for _ in itertools.count()], draw.uniform(0, duration))
        found, is_mixed = what_is_wrong(folder)
        wrong += [f"kill {k + 1}: {sentence}" for sentence in found]
        mixed += is_mixed
        left += sorted(path.name for path in folder.iterdir()) != NAMES
        next(turns)
        if k <= len(NAMES) or draw.random() < 0.5:  # the others are followed by a second kill
            write()
            if sorted(path.name for path in folder.glob("[!.]*")) != NAMES:
                wrong.append(f"kill {k + 1}: the next run left another set of files")
    print(json.dumps({"kills": number, "mixed": mixed, "left_something": left, "wrong": wrong}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
