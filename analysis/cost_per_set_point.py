"""What does a set point of the main job cost, in time, memory and on the disk?

The PUMA 560 moves all joints by sums of four sines at 1 kHz, for as long as it takes; the file of set points gives time,
q, qd and qdd in 12 digits. The command is run as a user runs it, with all its files, and its processor time and the
largest memory it held are the system's own figures. What storing takes is measured apart: the decomposition of 100 000
set points in chunks of several lengths, with and without compression.
Writes `cost_per_set_point.md` beside this file: `python analysis/cost_per_set_point.py [SET POINTS]...`; ten million set
points are a file of 2.8 GB and take some ten minutes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

import gd_analyze as gd
from gd_analyze.arrays import FloatArray

COUNTS = (31, 8192, 100_000, 1_000_000)
RATE, SINES, AT_ONCE = 1000.0, 4, 100_000
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
CHUNKS, STORED = (512, 4096, 32_768), 100_000
GROWTH = """## What grows, and what does not

Of more than 8 192 set points [some hundred stand for all](../docs/decisions/0012-results-file.md) in searches, so that search and
reports take 5 to 12 s for any motion. All else grows by 15 to 20 us per set point: reading text 4, decomposing 2.7, the proof near the
motion 1.5, evaluating models 3.5, storing D, h, c and torques, where asked for, 5 to 10. A log costs what a plan of its rows does;
smoothing adds 2 us and 150 bytes per reading. Decomposing takes 1.2 us of array code; Pinocchio's crba, Coriolis matrix and gravity,
which give no split, take 5.3 us in a loop of Python and 2.9 us in C++ (`benchmarks/test_decomposition.py`). This paragraph and the table
below were measured on a Xeon of 2023.

| where | bytes per set point of six joints |
|---|---:|
| text of time, q, qd and qdd in 12 digits | 283 |
| the motion in memory; smoothed logs; several motions at once | 152; 300; 1 000 |
| `analysis.h5`, every set point stored: up to 131 072, or `--every-set-point` | 1 180 |
| the same with h_ijk: up to 8 192, or `--christoffel` | 4 640 |
| `analysis.h5` otherwise | none: 5.5 MB in all |

The libraries take 250 MB of memory, typesetting the PDF 120 to 150 MB more, a search at 5 000 states 300 MB.
"""
FILTERS: dict[str, dict[str, object]] = {
    "none": {},
    "shuffle, lzf": {"shuffle": True, "compression": "lzf"},
    "shuffle, gzip 1": {"shuffle": True, "compression": "gzip", "compression_opts": 1},
}


def motion(instants: FloatArray) -> FloatArray:
    """Time, q, qd and qdd, (N, 19), within the PUMA's ranges."""
    random, limits = np.random.default_rng(7), gd.load_arm("puma560").joints
    low, high = (np.array([getattr(joint, side) for joint in limits]) for side in ("lower", "upper"))
    speed = random.uniform(0.3, 2.0, (SINES, 6))
    size = random.dirichlet(np.ones(SINES), 6).T * 0.4 * np.minimum(high - low, 3.0)
    angle = instants[:, None, None] * speed + random.uniform(0.0, 2.0 * np.pi, (SINES, 6))
    q = (low + high) / 2.0 + (size * np.sin(angle)).sum(axis=1)
    qd, qdd = (size * speed * np.cos(angle)).sum(axis=1), -(size * speed**2 * np.sin(angle)).sum(axis=1)
    return np.column_stack([instants, q, qd, qdd])


def write(path: Path, count: int) -> None:
    """Write a file of set points."""
    names = [f"{kind}{i}" for kind in ("q", "qd", "qdd") for i in range(1, 7)]
    with path.open("w") as file:
        file.write(",".join(["time", *names]) + "\n")
        for start in range(0, count, AT_ONCE):
            rows = motion(np.arange(start, min(start + AT_ONCE, count)) / RATE)
            pd.DataFrame(rows).to_csv(file, header=False, index=False, float_format="%.12g")


def job(folder: Path, count: int, *options: str) -> tuple[float, float, dict[str, int]]:
    """Processor time, s, and peak memory, MB, of the main job, and the sizes of its files."""
    path, out = folder / "motion.csv", folder / "out"
    write(path, count)
    command = [COMMAND, "puma560", str(path), "--out", str(out), "--overwrite", "--quiet", *options]
    child = subprocess.Popen(command, env=os.environ | {"GD_ANALYZE_CACHE": "off"}, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    assert status == 0, command
    sizes = {file.name: file.stat().st_size for file in out.iterdir()}
    return used.ru_utime + used.ru_stime, used.ru_maxrss * 1.024e-3, sizes


def stored() -> list[str]:
    """Rows on chunks and compression."""
    q, qd, qdd = np.split(motion(np.arange(STORED) / RATE)[:, 1:], 3, axis=1)
    states = gd.types.States(q, qd, qdd)
    arrays = gd.tables.decompose_states(gd.load_arm("puma560"), states, christoffel=False)
    rows = []
    for name, options in FILTERS.items():
        for length in CHUNKS:
            with tempfile.NamedTemporaryFile(suffix=".h5") as file:
                begin = time.process_time()
                with h5py.File(file.name, "w") as sink:
                    for key, values in arrays.items():
                        chunk = (length, *values.shape[1:])
                        sink.create_dataset(key, data=values, chunks=chunk, fletcher32=True, **options)
                taken, size = time.process_time() - begin, Path(file.name).stat().st_size
                begin = time.process_time()
                with h5py.File(file.name) as source:
                    for key in arrays:
                        source[key][()]
                read = time.process_time() - begin
            us = 1e6 / STORED
            rows.append(f"| {name} | {length} | {size / STORED:.0f} | {us * taken:.1f} | {us * read:.1f} |")
    return rows


def report(counts: tuple[int, ...]) -> str:
    """Write the study as Markdown."""
    rows, figures = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for count in counts:
            seconds, megabytes, sizes = job(Path(folder), count)
            figures[count] = seconds
            page, file = (sizes[name] / 1e6 for name in ("report.html", "analysis.h5"))
            rows.append(
                f"| {count:,} | {seconds:.1f} | {megabytes:.0f} | {file:.1f} | {page:.2f} |".replace(",", " ")
            )
        seconds, megabytes, sizes = job(Path(folder), 100_000, "--no-every-set-point")
        every = figures.get(100_000, seconds) - seconds
    text = __doc__.splitlines()
    (few, least), (most, largest) = sorted(figures.items())[-2:]
    slope = 1e6 * (largest - least) / (most - few)
    return "\n".join(
        [
            "# What a set point of the main job costs",
            "",
            *text[2:6],
            "",
            "| set points | processor time, s | memory, MB | analysis.h5, MB | report.html, MB |",
            "|---:|---:|---:|---:|---:|",
            *rows,
            "",
            f"From {few} to {most} set points each takes {slope:.1f} us. Storing D, h and c at every one of\n100 000 "
            f"takes {every:.1f} s of the time above.",
            "",
            GROWTH,
            "## Chunks and compression",
            "",
            "| filter | set points per chunk | bytes per set point | written, us | read, us |",
            "|---|---:|---:|---:|---:|",
            *stored(),
            "",
        ]
    )


if __name__ == "__main__":
    chosen = tuple(map(int, sys.argv[1:])) or COUNTS
    Path(__file__).with_suffix(".md").write_text(report(chosen), encoding="utf-8")
