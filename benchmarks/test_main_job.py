"""The main job and its first answer, against what Python takes to import the libraries of tables and plots.

Run as a user runs it: the installed command, with compiled bytecode as an installation leaves it. Warm is a
run that finds programs in the cache which one of the same arm and motion wrote before; cold, one without.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import NamedTuple

import pytest

ROUNDS = 1
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
IMPORTS = (sys.executable, "-c", "import numpy, pandas, xarray, matplotlib")
MAIN_JOB = (COMMAND, "puma560", "pick-and-place")
# Exact programs are shipped for the PUMA, not for the PUMA with a payload.
OPTIONS = [(), ("--payload", "2,0,0,0.1")]
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}


class Taken(NamedTuple):
    """What a process takes: seconds on the clock, and of processors, those of the system included."""

    clock: float
    processor: float


def taken(*command: str, cache: str = "off") -> Taken:
    """Run a command to its end."""
    environment = ENVIRONMENT | {"GD_ANALYZE_CACHE": cache}
    return timed(lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment))


def taken_until(text: bytes, *command: str) -> Taken:
    """Run a command until a terminal shows a text."""
    environment = ENVIRONMENT | {"GD_ANALYZE_CACHE": "off", "TERM": "xterm"}

    def run() -> None:
        terminal, far_end = os.openpty()
        with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=far_end) as process:
            os.close(far_end)
            shown = b""
            while text not in shown:
                shown += os.read(terminal, 4096)
            process.kill()
        os.close(terminal)

    return timed(run)


def timed(run: Callable[[], object]) -> Taken:
    """Time the processes that begin and end in a function."""
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    run()
    clock, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Taken(clock, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


def compared(benchmark, name: str, job: Callable[[], Taken]) -> None:
    """Run a job and the bare imports in turn, and state how many times as long the job takes."""
    benchmark.pedantic(job, rounds=1)
    pairs = [(job(), taken(*IMPORTS)) for _ in range(ROUNDS)]
    print(f"\n{name}")
    for what in Taken._fields:
        ours, imports = zip(*((getattr(a, what), getattr(b, what)) for a, b in pairs), strict=True)
        ratios = sorted(a / b for a, b in zip(ours, imports, strict=True))
        benchmark.extra_info[f"times_the_bare_imports_{what}"] = median(ratios)
        print(
            f"  {what}: {median(ours):.2f} s, bare imports {median(imports):.2f} s: "
            f"{median(ratios):.2f} times (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
        )


@pytest.mark.parametrize("cache", ["warm", "cold"])
def test_main_job_against_bare_imports(benchmark, tmp_path: Path, cache: str) -> None:
    kept = str(tmp_path / "cache") if cache == "warm" else "off"
    words = (*MAIN_JOB, "--out", str(tmp_path / "out"), "--quiet")
    compared(benchmark, f"main job, {cache}", lambda: taken(*words, cache=kept))


@pytest.mark.parametrize("formats", ["csv,json", "h5,json,csv,html,pdf"])
@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_level_element_against_bare_imports(
    benchmark, tmp_path: Path, options: tuple[str, ...], formats: str
) -> None:
    words = (*MAIN_JOB, *options, "--level", "element", "--format", formats)
    name = " ".join(["level element", formats, *options])
    compared(benchmark, name, lambda: taken(*words, "--out", str(tmp_path / "out"), "--quiet"))


@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_first_answer_against_bare_imports(benchmark, tmp_path: Path, options: tuple[str, ...]) -> None:
    words = (*MAIN_JOB, *options, "--out", str(tmp_path / "out"))
    compared(benchmark, " ".join(["first answer", *options]), lambda: taken_until(b"Verdicts at", *words))


def test_finding_the_main_job_against_bare_imports(benchmark) -> None:
    words = (sys.executable, "-c", "import gd_analyze as gd; gd.analyze")
    compared(benchmark, "import gd_analyze; gd.analyze", lambda: taken(*words))


def test_help_against_bare_interpreter(benchmark) -> None:
    def answer() -> float:
        return taken(COMMAND, "--help").clock

    answer()
    pairs = [(answer(), taken(sys.executable, "-c", "pass").clock) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
