"""What a killed process left is removed by the next, and nothing else."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path

from gd_analyze.files import replacing, write_text
from killed_midway import KILLED_MIDWAY
from strategies import names_in


def test_what_a_living_process_writes_stays(tmp_path):
    with replacing(tmp_path / "one") as first:
        first.write_text("one")
        with replacing(tmp_path / "two") as second:
            second.write_text("two")
        assert first.read_text() == "one"
        with subprocess.Popen(
            [sys.executable, "-c", KILLED_MIDWAY, str(tmp_path / "three")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        ) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"writing\n"
            write_text(tmp_path / "four", "")
            process.communicate(b"")
        assert process.returncode == 0
    assert names_in(tmp_path) == ["four", "one", "three", "two"]


def test_what_is_not_known_to_be_abandoned_stays(tmp_path):
    """A folder of the same kind of name with other things in it, or a file."""
    (tmp_path / ".gd-analyze.mine").mkdir()
    (tmp_path / ".gd-analyze.mine" / "notes").touch()
    (tmp_path / ".gd-analyze.file").touch()
    (tmp_path / ".gd-analyze.left").mkdir()
    write_text(tmp_path / "file", "text")
    assert names_in(tmp_path) == [".gd-analyze.file", ".gd-analyze.mine", "file"]


def test_a_process_killed_while_it_removes_leaves_what_the_next_removes(tmp_path, monkeypatch):
    """Without its lock a folder that is not empty would be nobody's."""
    unlink, seen = Path.unlink, []

    def killed(self: Path, missing_ok: bool = False) -> None:
        if self.name == "lock":
            seen.append([path.name for path in self.parent.iterdir()])
            raise OSError(errno.EIO, "as if killed")
        unlink(self, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", killed)
    write_text(tmp_path / "file", "old")
    monkeypatch.undo()
    assert seen == [["lock"]]
    assert len(names_in(tmp_path)) == 2
    write_text(tmp_path / "file", "new")
    assert names_in(tmp_path) == ["file"]
