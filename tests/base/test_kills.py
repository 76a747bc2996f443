"""A process is killed again and again while it writes: no mixture goes unseen, and no file is half."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Seven after each number of renames, the others at random.
KILLS = int(os.environ.get("GD_ANALYZE_KILLS", "15"))


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL and fork are matters of POSIX")
def test_kills(tmp_path):
    script = Path(__file__).parent / "kills.py"
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path), str(KILLS), "1987"],
        capture_output=True,
        text=True,
        check=False,
        # One thread, as the process forks.
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["kills"] == KILLS
    assert told["wrong"] == []
    # After one to four of five renames: what the test is about has happened.
    assert told["mixed"] >= 4
    assert told["left_something"] >= 5
