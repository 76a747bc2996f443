"""The whole main job, both reports included, against what Python takes to import its base libraries.

Run as a user runs it: the installed command, with compiled bytecode as an installation leaves it. Warm is a
run that finds programs in the cache which one of the same arm and motion wrote before; cold, one without.
A long log is compared with set points of the same rows.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
import pytest

ROUNDS = 1
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
IMPORTS = (sys.executable, "-c", "import numpy, xarray, matplotlib, pinocchio")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}


class Taken(NamedTuple):
    """Seconds on the clock and of processors, those of the system included, and MB that a process takes."""

    clock: float
    processor: float
    memory: float


UNITS = ("s", "s", "MB")


def taken(*command: str, cache: str = "off") -> Taken:
    """Run a command to its end."""
    environment = ENVIRONMENT | {"GD_ANALYZE_CACHE": cache}
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    clock = time.perf_counter() - start
    return Taken(clock, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def tell(benchmark, what: str, peer: str, pairs: list[tuple[Taken, Taken]]) -> None:
    """Print what we take, a peer beside it, and the ratio of each round."""
    print(f"\n{what}")
    for name, unit in zip(Taken._fields, UNITS, strict=True):
        ours, theirs = zip(*((getattr(a, name), getattr(b, name)) for a, b in pairs), strict=True)
        ratios = sorted(a / b for a, b in zip(ours, theirs, strict=True))
        benchmark.extra_info[f"times_the_{peer.replace(' ', '_')}_{name}"] = median(ratios)
        print(
            f"  {name}: {median(ours):.2f} {unit}, {peer} {median(theirs):.2f} {unit}: "
            f"{median(ratios):.2f} times (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
        )


@pytest.mark.parametrize("cache", ["warm", "cold"])
def test_main_job_against_bare_imports(benchmark, tmp_path: Path, cache: str) -> None:
    kept = str(tmp_path / "cache") if cache == "warm" else "off"

    def job() -> Taken:
        where = ("--out", str(tmp_path / "out"), "--quiet")
        return taken(COMMAND, "puma560", "pick-and-place", *where, cache=kept)

    benchmark.pedantic(job, rounds=1)
    tell(benchmark, f"main job, {cache}", "bare imports", [(job(), taken(*IMPORTS)) for _ in range(ROUNDS)])


READINGS = 200_000


def write_rows(path: Path, clock: str) -> str:
    """Write readings of all joints at 500 Hz, with their velocities and accelerations."""
    instants = np.arange(READINGS) / 500
    rates, sizes = np.linspace(0.7, 1.7, 6), np.array([0.8, 0.5, 0.5, 0.6, 0.4, 0.5])
    phases = np.outer(instants, rates)
    q = sizes * np.sin(phases) + [0.0, -0.8, 1.2, 0.0, 0.5, 0.0]
    qd, qdd = sizes * rates * np.cos(phases), -sizes * rates**2 * np.sin(phases)
    noise = 1e-5 * np.random.default_rng(0).normal(size=q.shape)
    heading = ",".join([clock, *(f"{name}{i}" for name in ("q", "qd", "qdd") for i in range(1, 7))])
    rows = np.column_stack([instants, q + noise, qd, qdd])
    np.savetxt(path, rows, "%.9g", ",", header=heading, comments="")
    return str(path)


@pytest.mark.parametrize("treatment", ["as read", "smoothed"])
def test_long_log_against_set_points_of_its_rows(benchmark, tmp_path: Path, treatment: str) -> None:
    log, plan = (write_rows(tmp_path / f"{clock}.csv", clock) for clock in ("t", "time"))
    asked = ("--measured",) if treatment == "smoothed" else ()

    def job(path: str, *options: str) -> Taken:
        where = ("--out", str(tmp_path / "out"), "--overwrite", "--quiet")
        return taken(COMMAND, "puma560", path, *options, *where)

    benchmark.pedantic(job, args=(log, *asked), rounds=1)
    pairs = [(job(log, *asked), job(plan)) for _ in range(ROUNDS)]
    tell(benchmark, f"{READINGS} readings, {treatment}", "set points", pairs)


def test_help_against_bare_interpreter(benchmark) -> None:
    def answer() -> float:
        return taken(COMMAND, "--help").clock

    answer()
    pairs = [(answer(), taken(sys.executable, "-c", "pass").clock) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
