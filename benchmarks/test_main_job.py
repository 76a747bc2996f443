"""The whole main job, both reports included, against what Python takes to import its base libraries.

Run as a user runs it: the installed command, with compiled bytecode as an installation leaves it. Warm is a
run that finds programs in the cache which one of the same arm and motion wrote before; cold, one without.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

import pytest

ROUNDS = 1
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
IMPORTS = (sys.executable, "-c", "import numpy, xarray, matplotlib, pinocchio")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}


class Taken(NamedTuple):
    """What a process takes: seconds on the clock, and of processors, those of the system included."""

    clock: float
    processor: float


def taken(*command: str, cache: str = "off") -> Taken:
    """Run a command to its end."""
    environment = ENVIRONMENT | {"GD_ANALYZE_CACHE": cache}
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    clock, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Taken(clock, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


@pytest.mark.parametrize("cache", ["warm", "cold"])
def test_main_job_against_bare_imports(benchmark, tmp_path: Path, cache: str) -> None:
    kept = str(tmp_path / "cache") if cache == "warm" else "off"

    def job() -> Taken:
        where = ("--out", str(tmp_path / "out"), "--quiet")
        return taken(COMMAND, "puma560", "pick-and-place", *where, cache=kept)

    benchmark.pedantic(job, rounds=1)
    pairs = [(job(), taken(*IMPORTS)) for _ in range(ROUNDS)]
    print(f"\nmain job, {cache}")
    for what in Taken._fields:
        ours, imports = zip(*((getattr(a, what), getattr(b, what)) for a, b in pairs), strict=True)
        ratios = sorted(a / b for a, b in zip(ours, imports, strict=True))
        benchmark.extra_info[f"times_the_bare_imports_{what}"] = median(ratios)
        print(
            f"  {what}: {median(ours):.2f} s, bare imports {median(imports):.2f} s: "
            f"{median(ratios):.2f} times (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
        )


def test_help_against_bare_interpreter(benchmark) -> None:
    def answer() -> float:
        return taken(COMMAND, "--help").clock

    answer()
    pairs = [(answer(), taken(sys.executable, "-c", "pass").clock) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
