"""Kills a batch at random moments, starts it again, and tells what was lost or done twice."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import gd_analyze as gd
from gd_analyze.studies.batch import RECORD

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


def killed(folder: Path, kills: int, rows: int, seed: int) -> Told:
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
