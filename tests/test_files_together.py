"""Several files appear together or not at all, whoever else writes or is killed there."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from gd_analyze.errors import StorageError
from gd_analyze.files import replacing_together
from strategies import names_in


def three(folder: Path) -> list[Path]:
    return [folder / name for name in ("one", "two", "three")]


def write_all(paths: list[Path], text: str) -> None:
    with replacing_together(paths) as temporaries:
        for temporary in temporaries:
            temporary.write_text(text)


def test_a_set_is_replaced_together(tmp_path):
    paths = three(tmp_path)
    write_all(paths, "old")
    with replacing_together(paths) as temporaries:
        for temporary in temporaries:
            temporary.write_text("new")
            assert [path.read_text() for path in paths] == ["old"] * 3
    assert [path.read_text() for path in paths] == ["new"] * 3
    assert names_in(tmp_path) == sorted(path.name for path in paths)


def test_one_that_fails_leaves_the_whole_set(tmp_path):
    paths = three(tmp_path)
    write_all(paths, "old")
    with pytest.raises(StorageError, match="writing failed"), replacing_together(paths) as temporaries:  # noqa: PT012 - the block is the test
        temporaries[0].write_text("new")
        raise OSError(errno.ENOSPC, "No space left on device")
    assert [path.read_text() for path in paths] == ["old"] * 3
    assert names_in(tmp_path) == sorted(path.name for path in paths)


def test_all_is_on_the_disk_before_the_first_rename(tmp_path, monkeypatch):
    done: list[str] = []
    fsync, replace = os.fsync, Path.replace

    def synced(descriptor: int) -> None:
        done.append("folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file")
        fsync(descriptor)

    def renamed(self: Path, target: Path) -> Path:
        done.append("rename")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", renamed)
    write_all(three(tmp_path), "new")
    assert done == ["file"] * 3 + ["rename"] * 3 + ["folder"]


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="no /proc on this system")
def test_nothing_is_given_free_between_two_renames(tmp_path, monkeypatch):
    """A replaced file stays open until all are: its blocks would take longer than all the renames."""
    paths = three(tmp_path)
    write_all(paths, "old")
    still_open: list[int] = []
    replace = Path.replace

    def renamed(self: Path, target: Path) -> Path:
        replaced = replace(self, target)
        links = [os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]  # noqa: PTH115 - it names what is gone
        still_open.append(
            sum(link.startswith(str(tmp_path)) and link.endswith("(deleted)") for link in links)
        )
        return replaced

    monkeypatch.setattr(Path, "replace", renamed)
    write_all(paths, "new")
    assert still_open == [1, 2, 3]


def test_a_rename_that_fails_midway_says_what_is_where(tmp_path, monkeypatch):
    paths = three(tmp_path)
    replace = Path.replace

    def renamed(self: Path, target: Path) -> Path:
        if target.name == "two":
            raise OSError(errno.EIO, "Input/output error")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", renamed)
    with pytest.raises(StorageError, match="only one could be put in place; two, three are still"):
        write_all(paths, "new")
    assert names_in(tmp_path) == ["one"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_between_two_renames_waits(tmp_path, monkeypatch, number):
    paths = three(tmp_path)
    replace = Path.replace

    def renamed(self: Path, target: Path) -> Path:
        signal.raise_signal(number)
        return replace(self, target)

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", renamed)
    before = signal.signal(number, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            write_all(paths, "new")
        assert signal.getsignal(number) is interrupt
    finally:
        signal.signal(number, before)
    assert [path.read_text() for path in paths] == ["new"] * 3
    assert names_in(tmp_path) == sorted(path.name for path in paths)


def test_many_processes_write_one_set(tmp_path):
    """Each set is whole, whichever comes last."""
    code = """
import sys
from pathlib import Path
from gd_analyze.files import replacing_together
folder, text = Path(sys.argv[1]), sys.argv[2]
for _ in range(60):
    with replacing_together([folder / name for name in ("one", "two", "three")]) as temporaries:
        for temporary in temporaries:
            temporary.write_text(text)
"""
    writers = [subprocess.Popen([sys.executable, "-c", code, str(tmp_path), text]) for text in "abc"]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    assert len({path.read_text() for path in three(tmp_path)}) == 1
    assert names_in(tmp_path) == ["one", "three", "two"]
