"""A file appears whole or not at all, whatever happens while it is written; reading ends."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from gd_analyze.errors import OutputError, StorageError
from gd_analyze.files import (
    read_at_most,
    replacing,
    replacing_together,
    require_writable,
    temporary_folder,
    write_text,
)
from strategies import names_in

KILLED_MIDWAY = """
import sys
from gd_analyze.files import replacing
with replacing(sys.argv[1]) as temporary:
    with temporary.open("w") as file:
        file.write("half" * 100_000)
        file.flush()
        print("writing", flush=True)
        sys.stdin.read()
"""


def write_all(paths: list[Path], text: str) -> None:
    with replacing_together(paths) as temporaries:
        for temporary in temporaries:
            temporary.write_text(text)
            assert not any(path.exists() and path.read_text() == text for path in paths)


def test_a_set_is_replaced_when_all_of_it_is_on_the_disk(tmp_path, monkeypatch):
    paths = [tmp_path / "new" / name for name in ("one", "two")]
    write_all(paths, "old")
    done: list[str] = []
    fsync, replace = os.fsync, Path.replace
    monkeypatch.setattr(os, "fsync", lambda descriptor: (done.append("sync"), fsync(descriptor))[1])
    monkeypatch.setattr(Path, "replace", lambda path, to: (done.append("replace"), replace(path, to))[1])
    write_all(paths, "new")
    assert done == ["sync"] * 2 + ["replace"] * 2
    assert [path.read_text() for path in paths] == ["new"] * 2
    assert names_in(tmp_path / "new") == ["one", "two"]
    (tmp_path / "any").touch()
    assert stat.S_IMODE(paths[0].stat().st_mode) == stat.S_IMODE((tmp_path / "any").stat().st_mode)


@pytest.mark.parametrize(
    ("end", "raised"),
    [
        (KeyboardInterrupt(), KeyboardInterrupt),
        *((OSError(getattr(errno, name), name), StorageError) for name in ("ENOSPC", "EDQUOT", "EIO")),
        *((OSError(getattr(errno, name), name), OutputError) for name in ("EACCES", "EROFS")),
    ],
)
def test_one_that_fails_leaves_the_whole_set(tmp_path, end, raised):
    """And a failure of the machine is told from one of the place."""
    paths = [tmp_path / name for name in ("one", "two")]
    write_all(paths, "old")

    def half_write() -> None:
        with replacing_together(paths) as temporaries:
            temporaries[0].write_text("new")
            raise end

    with pytest.raises(raised) as caught:
        half_write()
    assert type(caught.value) is raised
    assert [path.read_text() for path in paths] == ["old"] * 2
    assert names_in(tmp_path) == ["one", "two"]
    paths = [tmp_path / "made" / "too" / name for name in ("one", "two")]
    with pytest.raises(raised):
        half_write()
    assert names_in(tmp_path) == ["one", "two"]


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL, which only POSIX has")
def test_what_a_killed_process_left_goes_with_the_next_run(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    words = [sys.executable, "-c", KILLED_MIDWAY, str(path)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"writing\n"
        (left,) = [name for name in names_in(tmp_path) if name != path.name]
        write_text(path, "old")
        assert names_in(tmp_path) == [left, path.name]  # its owner lives
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert path.read_text() == "old"
    foreign = [".gd-analyze.0.1.x", ".gd-analyze.x", f"{left[:-20]}.99999999999999999999.x"]
    for name in foreign:
        (tmp_path / name).touch()
    write_text(path, "new")
    assert names_in(tmp_path) == sorted([*foreign, path.name])  # their owners may live on other machines
    for name in foreign:
        os.utime(tmp_path / name, (0, 0))
    write_text(path, "new")
    assert names_in(tmp_path) == [path.name]


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL, which only POSIX has")
def test_a_temporary_folder_of_a_killed_process_goes_with_the_next_one(tmp_path, monkeypatch):
    killed = (
        "import os\nfrom gd_analyze.files import temporary_folder\n"
        "with temporary_folder() as folder:\n    (folder / 'x').touch()\n    os.kill(os.getpid(), 9)"
    )
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    subprocess.run([sys.executable, "-c", killed], check=False)
    assert len(names_in(tmp_path)) == 1
    with temporary_folder() as folder:
        assert names_in(tmp_path) == [folder.name]
    assert names_in(tmp_path) == []


def test_what_cannot_be_a_file_is_refused(tmp_path, blocked_folder):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "folder", tmp_path / "pipe", blocked_folder / "f"):
        for refuse in (require_writable, lambda path: write_text(path, "text")):
            with pytest.raises(OutputError) as caught:
                refuse(path)
            assert caught.value.details["where"]
    with pytest.raises(OutputError), replacing(tmp_path / ("x" * 300)):
        pass
    require_writable(tmp_path / "new" / "folder" / "file")


@pytest.mark.parametrize("size", [0, 2**20, 2**20 + 1])
def test_reading_ends_at_the_largest_size(tmp_path, size):
    path = tmp_path / "text"
    path.write_bytes(b"x" * size)
    assert read_at_most(path, size) == b"x" * size
    assert not size or read_at_most(path, size - 1) is None
    assert read_at_most("/dev/zero", 10**12) == bytes(2**20)
