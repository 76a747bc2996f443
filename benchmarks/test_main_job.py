"""The whole main job, both reports included, against what Python takes to import its base libraries.

Run as a user runs it: the installed command, with compiled bytecode as an installation leaves it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

ROUNDS = 7
COMMAND = str(Path(sys.executable).with_name("gd-analyze"))
IMPORTS = (sys.executable, "-c", "import numpy, xarray, matplotlib, pinocchio")
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}


def seconds(*command: str) -> float:
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=ENVIRONMENT)
    return time.perf_counter() - start


def test_main_job_against_bare_imports(benchmark, tmp_path: Path) -> None:
    def job() -> float:
        return seconds(COMMAND, "puma560", "pick-and-place", "--out", str(tmp_path), "--quiet")

    job(), seconds(*IMPORTS)
    pairs = [(job(), seconds(*IMPORTS)) for _ in range(ROUNDS)]
    benchmark.pedantic(job, rounds=1)
    ratios = sorted(ours / imports for ours, imports in pairs)
    ratio = ratios[len(ratios) // 2]
    benchmark.extra_info["times_the_bare_imports"] = ratio
    print(
        f"\nmain job {sorted(p[0] for p in pairs)[ROUNDS // 2]:.2f} s, bare imports "
        f"{sorted(p[1] for p in pairs)[ROUNDS // 2]:.2f} s: {ratio:.2f} times "
        f"(rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
    )


def test_help_against_bare_interpreter(benchmark) -> None:
    def answer() -> float:
        return seconds(COMMAND, "--help")

    answer()
    pairs = [(answer(), seconds(sys.executable, "-c", "pass")) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
