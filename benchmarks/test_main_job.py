"""The whole main job, both reports included, against what Python takes to import its base libraries."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

ROUNDS = 5
IMPORTS = "import numpy, xarray, matplotlib, pinocchio"


def seconds(*arguments: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def test_main_job_against_bare_imports(benchmark, tmp_path: Path) -> None:
    run = "import sys; from gd_analyze.cli import main; main(sys.argv[1:])"

    def job() -> float:
        return seconds("-c", run, "puma560", "pick-and-place", "--out", str(tmp_path), "--quiet")

    job(), seconds("-c", IMPORTS)
    pairs = [(job(), seconds("-c", IMPORTS)) for _ in range(ROUNDS)]
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
        return seconds("-c", "from gd_analyze.cli import main; main(['--help'])")

    answer()
    pairs = [(answer(), seconds("-c", "pass")) for _ in range(ROUNDS)]
    benchmark.pedantic(answer, rounds=1)
    extra = sorted(ours - bare for ours, bare in pairs)[ROUNDS // 2]
    benchmark.extra_info["seconds_beyond_the_interpreter"] = extra
    print(f"\n--help takes {extra:.2f} s beyond a bare interpreter")
