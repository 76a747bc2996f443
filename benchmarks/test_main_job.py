"""The main job and its first answer, against what Python takes to import the libraries of tables and plots.

Run as a user runs it: the installed command, with compiled bytecode as an installation leaves it. Warm is a
run that finds programs in the cache which one of the same arm and motion wrote before; cold, one without.
A long log is compared with set points of the same rows.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
import pytest

import gd_analyze as gd
from chains import generic_chain

ROUNDS = 1
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
IMPORTS = (sys.executable, "-c", "import numpy, pandas, xarray, matplotlib")
MAIN_JOB = (COMMAND, "puma560", "pick-and-place")
# Exact programs are shipped for the PUMA, not for the PUMA with a payload.
OPTIONS = [(), ("--payload", "2,0,0,0.1")]
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}


class Taken(NamedTuple):
    """Seconds on the clock and of processors, those of the system included, and MB that a process takes.

    Memory is at least that of the process that runs the benchmarks.
    """

    clock: float
    processor: float
    memory: float


UNITS = ("s", "s", "MB")


def taken(*command: str, cache: str = "off", until: bytes | None = None) -> Taken:
    """Run a command to its end, or until its terminal shows a text."""
    environment = ENVIRONMENT | {"GD_ANALYZE_CACHE": cache, "TERM": "xterm"}
    terminal, far_end = os.openpty()
    stderr = subprocess.DEVNULL if until is None else far_end
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr, env=environment)
    os.close(far_end)
    if until is not None:
        shown = b""
        while until not in shown:
            shown += os.read(terminal, 4096)
        process.kill()
    _, status, used = os.wait4(process.pid, 0)
    clock = time.perf_counter() - start
    os.close(terminal)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert until is not None or process.returncode == 0, command
    return Taken(clock, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def compared(
    benchmark, what: str, job: Callable[[], Taken], peer_job: Callable[[], Taken], peer: str = "bare imports"
) -> None:
    """Run a job and a peer in turn, and state how many times as much the job takes."""
    benchmark.pedantic(job, rounds=1)
    pairs = [(job(), peer_job()) for _ in range(ROUNDS)]
    print(f"\n{what}")
    for name, unit in zip(Taken._fields, UNITS, strict=True):
        ours, theirs = zip(*((getattr(a, name), getattr(b, name)) for a, b in pairs), strict=True)
        ratios = sorted(a / b for a, b in zip(ours, theirs, strict=True))
        benchmark.extra_info[f"times_the_{peer.replace(' ', '_')}_{name}"] = median(ratios)
        print(
            f"  {name}: {median(ours):.2f} {unit}, {peer} {median(theirs):.2f} {unit}: "
            f"{median(ratios):.2f} times (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
        )


def imports() -> Taken:
    """Import the libraries of tables and plots."""
    return taken(*IMPORTS)


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

    what = f"{READINGS} readings, {treatment}"
    compared(benchmark, what, lambda: job(log, *asked), lambda: job(plan), "set points")


@pytest.mark.parametrize("cache", ["warm", "cold"])
def test_main_job_against_bare_imports(benchmark, tmp_path: Path, cache: str) -> None:
    kept = str(tmp_path / "cache") if cache == "warm" else "off"
    words = (*MAIN_JOB, "--out", str(tmp_path / "out"), "--quiet")
    compared(benchmark, f"main job, {cache}", lambda: taken(*words, cache=kept), imports)


@pytest.mark.parametrize("n", [7, 8])
def test_general_joints_against_bare_imports(benchmark, tmp_path: Path, n: int) -> None:
    """The main job along a plan of 200 set points, of links with full inertias off their axes."""
    arm, plan = str(tmp_path / "arm.toml"), str(tmp_path / "plan.csv")
    gd.save_arm(generic_chain(n), arm)
    ends = ("--from", ",".join(["0"] * n), "--to", ",".join(["40"] * n))
    taken(COMMAND, "plan", arm, *ends, "--duration", "3", "--points", "200", "--allow-violations", "-o", plan)
    words = (COMMAND, arm, plan, "--out", str(tmp_path / "out"), "--quiet", "--overwrite")
    compared(benchmark, f"{n} general joints", lambda: taken(*words), imports)


def test_simplifying_within_limits_against_bare_imports(benchmark, tmp_path: Path) -> None:
    words = (COMMAND, "simplify", "puma560", "-o", str(tmp_path / "model.json"))
    compared(benchmark, "PUMA 560 within its limits", lambda: taken(*words), imports)


@pytest.mark.parametrize("formats", ["csv,json", "h5,json,csv,html,pdf"])
@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_level_element_against_bare_imports(
    benchmark, tmp_path: Path, options: tuple[str, ...], formats: str
) -> None:
    words = (*MAIN_JOB, *options, "--level", "element", "--format", formats)
    name = " ".join(["level element", formats, *options])
    compared(benchmark, name, lambda: taken(*words, "--out", str(tmp_path / "out"), "--quiet"), imports)


@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_first_answer_against_bare_imports(benchmark, tmp_path: Path, options: tuple[str, ...]) -> None:
    words = (*MAIN_JOB, *options, "--out", str(tmp_path / "out"))
    what = " ".join(["first answer", *options])
    compared(benchmark, what, lambda: taken(*words, until=b"Verdicts at"), imports)


def test_finding_the_main_job_against_bare_imports(benchmark) -> None:
    words = (sys.executable, "-c", "import gd_analyze as gd; gd.analyze")
    compared(benchmark, "import gd_analyze; gd.analyze", lambda: taken(*words), imports)


def test_help_against_bare_interpreter(benchmark) -> None:
    def answer() -> float:
        return taken(COMMAND, "--help").clock

    answer()
    pairs = [(answer(), taken(sys.executable, "-c", "pass").clock) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
