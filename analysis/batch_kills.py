"""Does a batch lose rows, or do any twice, when it is killed?

A batch on two processes is killed with SIGKILL at random moments, is started again where it stopped, and is looked at
after every kill: rows recorded before are there, none is recorded twice, and every recorded row has its model. When all
rows are done another batch begins; each one's table is compared with that of one process that nobody kills.

    python analysis/batch_kills.py
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import gd_analyze as gd
from gd_analyze.studies.batch import RECORD

KILLS, SEED, ROWS = 60, 1987, 40
_PROGRAM = "from gd_analyze.cli import main\nmain()"


class Told(NamedTuple):
    """What was seen."""

    kills: int
    batches: int  # that came to their end
    rows: int  # that these have together
    after_rows: int  # kills after the first and before the last row of a batch
    torn: int  # kills that cut the record's last line short
    wrong: list[str]  # what must not be


def table_of(folder: Path, rows: int) -> Path:
    """A table of motions and budgets of the two-link arm, a tenth of a second each."""
    lines = [f"two_link,two-link-swing,{1 + k // 2}%,{'true' if k % 2 else 'false'}" for k in range(rows)]
    path = folder / "rows.csv"
    path.write_text("arm,trajectory,budget,at_set_points\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def recorded(path: Path) -> int:
    """Rows that a record has."""
    return path.read_bytes().count(b"\n") if path.exists() else 0


def killed(folder: Path, kills: int, rows: int = ROWS, seed: int = SEED) -> Told:
    """Kill batches again and again."""
    drawn, table = random.Random(seed), table_of(folder, rows)
    expected = gd.batch(table, folder / "alone")
    done = batches = after = torn = 0
    known, wrong = set[str](), list[str]()
    command = [sys.executable, "-c", _PROGRAM, "batch", str(table), "--jobs", "2", "--quiet", "--out"]
    out = folder / "killed-0"
    while done < kills:
        # At a moment after some more rows, 0 to 9 and up to half a second.
        path, target, code = out / RECORD, len(known) + drawn.randrange(10), None
        process = subprocess.Popen([*command, str(out)], start_new_session=True, stderr=subprocess.DEVNULL)
        while (code := process.poll()) is None and recorded(path) < target:
            time.sleep(0.01)
        with suppress(subprocess.TimeoutExpired):
            code = process.wait(timeout=drawn.uniform(0.0, 0.5 if target > len(known) else 5.0))
        if code is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            done += 1
        data = path.read_bytes() if path.exists() else b""
        lines = data[: data.rfind(b"\n") + 1].splitlines()
        torn += len(data) > data.rfind(b"\n") + 1
        keys = [json.loads(line)["key"] for line in lines]
        after += code is None and 0 < len(keys) < rows
        if len(keys) != len(set(keys)):
            wrong.append(f"kill {done}: a row twice")
        if not known <= set(keys):
            wrong.append(f"kill {done}: {len(known - set(keys))} rows lost")
        if not all((out / key / "model.json").is_file() for key in keys):
            wrong.append(f"kill {done}: a row without its model")
        known = set(keys)
        if code is not None:
            batches += 1
            made = gd.batch(table, out)
            if code != 0 or len(keys) != rows or not made.equals(expected):
                wrong.append(f"batch {batches}: exit code {code}, {len(keys)} rows, another table")
            out, known = folder / f"killed-{batches}", set()
    made = gd.batch(table, out)
    if not made.equals(expected):
        wrong.append("the last batch has another table")
    return Told(done, batches, batches * rows, after, torn, wrong)


def page(told: Told, seconds: float) -> str:
    """Markdown of what was seen."""
    return f"""# Kills of a batch

`python analysis/batch_kills.py` kills `gd-analyze batch --jobs 2` with SIGKILL, the whole process group, after 0 to
9 more rows and up to half a second (5 s before the first), starts it again in the same folder, and looks at the record. {ROWS} rows
of the two-link arm, each with its model file; a batch that ends is compared, cell by cell, with one process that nobody kills.

| | |
|---|---|
| kills | {told.kills} |
| of these after the first and before the last row | {told.after_rows} |
| record's last line cut short | {told.torn} |
| batches that came to their end | {told.batches}, {told.rows} rows |
| rows lost, recorded twice, or without their model | {len(told.wrong)} |
| tables unlike that of one process | {sum("table" in one for one in told.wrong)} |
| seconds | {seconds:.0f} |

A kill loses the rows under way, two here, and nothing else: a row is on the disk, its files first, before the next is begun
by the process that records it.
"""


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made_in:
        begin = time.time()
        found = killed(Path(made_in), KILLS)
        print(found)
        Path(__file__).with_suffix(".md").write_text(page(found, time.time() - begin), encoding="utf-8")
    sys.exit(bool(found.wrong))
