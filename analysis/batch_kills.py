"""Does a batch lose rows, or do any twice, when it is killed?

A batch on two processes is killed with SIGKILL at random moments, is started again where it stopped, and is looked at
after every kill: rows recorded before are there, none is recorded twice, and every recorded row has its model. When all
rows are done another batch begins; each one's table is compared with that of one process that nobody kills.

    python analysis/batch_kills.py
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from killed_batches import Told, killed

KILLS, SEED, ROWS = 60, 1987, 40


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
        found = killed(Path(made_in), KILLS, ROWS, SEED)
        print(found)
        Path(__file__).with_suffix(".md").write_text(page(found, time.time() - begin), encoding="utf-8")
    sys.exit(bool(found.wrong))
