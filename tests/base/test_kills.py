"""A process is killed again and again while it writes: no mixture goes unseen, and no file is half."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

import kills

# Six after each number of renames, the others at random.
KILLS = int(os.environ.get("GD_ANALYZE_KILLS", "9"))


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL and fork, which only POSIX has")
def test_kills(tmp_path):
    words = [sys.executable, kills.__file__, str(tmp_path), str(KILLS), "1987"]
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # as the process forks
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=alone)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["kills"], told["wrong"]) == (KILLS, [])
    # After one to four of five renames, and before the last: what the test is about has happened.
    assert told["mixed"] >= 4
    assert told["left_something"] >= 5
