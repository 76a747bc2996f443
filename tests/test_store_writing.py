"""A results file is never half there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from gd_analyze.errors import OutputError
from gd_analyze.results import store
from gd_analyze.results.store import save_results
from strategies import names_in


def test_an_exception_while_writing_keeps_the_old_file(swing_findings, tmp_path, monkeypatch):
    path = tmp_path / "analysis.h5"
    save_results(swing_findings, path)
    old = path.read_bytes()

    def fail(path, *_):
        path.write_bytes(b"half")
        raise RuntimeError("midway")

    monkeypatch.setattr(store, "write_tables", fail)
    with pytest.raises(RuntimeError, match="midway"):
        save_results(swing_findings, path)
    assert path.read_bytes() == old
    assert names_in(tmp_path) == ["analysis.h5"]


def test_unwritable(swing_findings, blocked_folder):
    with pytest.raises(OutputError):
        save_results(swing_findings, blocked_folder / "analysis.h5")


KILLED_MIDWAY = """
import sys
import gd_analyze as gd
from gd_analyze.results import store

write = store.write_tables

def stall(path, *rest):
    write(path, *rest)
    with open(path, "r+b") as file:
        file.truncate(1000)
    print("writing", flush=True)
    sys.stdin.read()

arm = gd.load_arm("two_link")
findings = gd.find(arm, gd.read_trajectory("two-link-swing", arm))
store.write_tables = stall
gd.save_results(findings, sys.argv[1])
"""


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is a matter of POSIX")
def test_a_killed_run_leaves_no_half_file(tmp_path):
    path = tmp_path / "analysis.h5"
    with subprocess.Popen(
        [sys.executable, "-c", KILLED_MIDWAY, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert not path.exists()
