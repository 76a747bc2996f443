"""How much of two cores does a batch of a thousand arms use?

Draws arms like the PUMA's first two links, masses, lengths and centres of mass up to a fifth off, does the main job
without files for all of them on two processes, and for every 10th by itself in one process, and writes
`batch_efficiency.md` beside this file. It takes a quarter of an hour on two cores that nothing else uses:

    python analysis/batch_efficiency.py
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from joblib.externals.loky import get_reusable_executor

import gd_analyze as gd
from gd_analyze.cache import VARIABLE

ARMS, JOINTS, JOBS, EVERY, SEED = 1000, 2, 2, 10, 1987
# Numbers that are drawn, and the PUMA's own.
VARIED = {
    "link2.mass": 17.4,
    "joint2.a": 0.4318,
    "link2.com.x": -0.3638,
    "link2.com.z": 0.07745,
    "drive1.inertia": 1.14,
}


def table_of(folder: Path, count: int) -> list[dict[str, str]]:
    """Write the arm and its motion; a row for every draw of its numbers."""
    puma = gd.load_arm("puma560")
    parts = {name: getattr(puma, name)[:JOINTS] for name in ("joints", "links", "drives", "dh_table")}
    gd.save_arm(replace(puma, name="drawn", title="Drawn", **parts), folder / "arm.toml")
    motion = gd.read_trajectory("pick-and-place", puma)
    q, qd, qdd = (np.asarray(x[:, :JOINTS]) for x in (motion.q, motion.qd, motion.qdd))
    gd.write_trajectory(gd.Trajectory(motion.time, q, qd, qdd), folder / "motion.csv")
    files = {"arm": str(folder / "arm.toml"), "trajectory": str(folder / "motion.csv")}
    rng = np.random.default_rng(SEED)
    return [
        files | {name: str(value * rng.uniform(0.8, 1.2)) for name, value in VARIED.items()}
        for _ in range(count)
    ]


class Run(NamedTuple):
    """One batch."""

    seconds: float
    own: float  # processor seconds of this process and its workers
    others: float  # processor seconds that everything else on the machine took meanwhile
    largest: float  # memory of the largest worker, or of this process, MB
    failed: int


def timed(rows: list[dict[str, str]], out: Path, jobs: int) -> Run:
    """Do a batch, its workers' start and end included."""
    begin, before, busy = time.time(), _processor(), _busy()
    table = gd.batch(rows, out, formats=(), jobs=jobs)
    get_reusable_executor().shutdown(wait=True)  # what workers took is known when they have ended
    own, seconds = _processor() - before, time.time() - begin
    kind = resource.RUSAGE_CHILDREN if jobs > 1 else resource.RUSAGE_SELF
    largest = resource.getrusage(kind).ru_maxrss / 1e3
    return Run(seconds, own, max(_busy() - busy - own, 0.0), largest, int((table.state == "failed").sum()))


def _processor() -> float:
    """Processor seconds of this process and of its children that have ended."""
    used = [resource.getrusage(kind) for kind in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def _busy() -> float:
    """Processor seconds of the machine, but for those that were idle (proc(5), /proc/stat)."""
    words = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0].split()[1:9]
    ticks = list(map(int, words))
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def page(count: int, alone: Run, some: int, many: Run) -> str:
    """Markdown of what was measured."""
    work, room = count * alone.own / some, JOBS * many.seconds
    names = ", ".join(VARIED)
    return f"""# A thousand arms on two cores

`python analysis/batch_efficiency.py` does the main job without files (`gd-analyze batch --format none --jobs {JOBS}`) for
{count} arms, drawn around the PUMA's first two links ({names} up to a fifth off),
along 31 set points, with the cache off. What rows take by themselves is measured on every {EVERY}th in one process, just before
and with the same other programs beside it.

| | |
|---|---|
| rows, failed | {count}, {many.failed} |
| processor seconds of a row in one process | {alone.own / some:.2f} |
| seconds of the batch, workers' start and end included | {many.seconds:.0f} |
| processor seconds of the batch | {many.own:.0f}, {many.own / work:.3f} of the rows' by themselves |
| processor seconds of other programs meanwhile | {many.others:.0f} of the {room:.0f} that two cores have |
| efficiency: rows by themselves, of all that two cores have | {work / room:.1%} |
| the same, of what other programs left | {work / (room - many.others):.1%} |
| memory of the largest worker | {many.largest:.0f} MB |
"""


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else ARMS
    os.environ[VARIABLE] = "off"  # no row finds what another has left
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        rows = table_of(folder, count)
        timed(rows[:1], folder / "warm", 1)
        some = rows[::EVERY]
        alone = timed(some, folder / "alone", 1)
        many = timed(rows, folder / "many", JOBS)
    print(alone, many)
    Path(__file__).with_suffix(".md").write_text(page(count, alone, len(some), many), encoding="utf-8")
