"""Jobs take one thread of linear algebra, however they are started, and leave the process as it was."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from gd_analyze.threads import _VARIABLES

# The largest number of threads before, during and after a job.
SCRIPT = """
import numpy, scipy.linalg
from threadpoolctl import threadpool_info
from gd_analyze.threads import one_thread

def most():
    return max(library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas")

def job(fails):
    print(most())
    if fails:
        raise ValueError

@one_thread()
def outer():
    try:
        one_thread()(job)(True)
    except ValueError:
        print(most())

print(most())
outer()
print(most())
"""


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor has one thread anyway")
@pytest.mark.parametrize("chosen", [None, "2"])
def test_a_job_takes_one_thread_unless_the_environment_says_how_many(chosen):
    environment = {key: value for key, value in os.environ.items() if key not in _VARIABLES}
    environment |= {} if chosen is None else {"OPENBLAS_NUM_THREADS": chosen}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, check=True, text=True, env=environment
    )
    before, inside, after_failure, after = map(int, done.stdout.split())
    assert before > 1
    assert after == before
    assert {inside, after_failure} == ({1} if chosen is None else {before})


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor has one thread anyway")
@pytest.mark.parametrize("chosen", [None, "2"])
def test_the_program_begins_with_one_thread_and_loads_nothing_to_limit_it(chosen):
    script = """
import atexit, sys
sys.argv = ["gd-analyze", "rank-terms", "two_link", "two-link-swing", "--quiet"]

def tell():
    loaded = "scipy.linalg" in sys.modules
    import numpy, scipy.linalg
    from threadpoolctl import threadpool_info
    threads = [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]
    print(int(loaded), min(threads), max(threads), file=sys.stderr)

atexit.register(tell)
from gd_analyze.cli import main
main()
"""
    environment = {key: value for key, value in os.environ.items() if key not in _VARIABLES}
    environment |= {} if chosen is None else {"OPENBLAS_NUM_THREADS": chosen}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=True, text=True, env=environment
    )
    loaded, fewest, most = map(int, done.stderr.split())
    assert (loaded, fewest, most) == ((0, 1, 1) if chosen is None else (0, 2, 2))
