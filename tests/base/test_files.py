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
from gd_analyze.files import read_at_most, replacing, replacing_together, require_writable, write_text
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


def test_a_set_is_replaced_when_all_of_it_is_written(tmp_path):
    paths = [tmp_path / "new" / name for name in ("one", "two", "three")]
    for text in ("old", "new"):
        write_all(paths, text)
        assert [path.read_text() for path in paths] == [text] * 3
    assert names_in(tmp_path / "new") == ["one", "three", "two"]
    (tmp_path / "any").touch()
    assert stat.S_IMODE(paths[0].stat().st_mode) == stat.S_IMODE((tmp_path / "any").stat().st_mode)


@pytest.mark.parametrize("end", [RuntimeError("midway"), KeyboardInterrupt(), OSError(28, "No space left")])
def test_one_that_fails_leaves_the_whole_set(tmp_path, end):
    paths = [tmp_path / name for name in ("one", "two")]
    write_all(paths, "old")
    # Both statements are meant to stand in the block: a file is written, then the block ends badly.
    with pytest.raises((type(end), StorageError)), replacing_together(paths) as temporaries:  # noqa: PT012
        temporaries[0].write_text("new")
        raise end
    assert [path.read_text() for path in paths] == ["old"] * 2
    assert names_in(tmp_path) == ["one", "two"]


def test_all_is_on_the_disk_before_the_first_file_is_replaced(tmp_path, monkeypatch):
    done: list[str] = []
    fsync, replace = os.fsync, Path.replace
    monkeypatch.setattr(os, "fsync", lambda descriptor: (done.append("sync"), fsync(descriptor))[1])
    monkeypatch.setattr(Path, "replace", lambda path, to: (done.append("replace"), replace(path, to))[1])
    write_all([tmp_path / "one", tmp_path / "two"], "new")
    assert done == ["sync"] * 2 + ["replace"] * 2


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is a matter of POSIX")
def test_a_killed_process_leaves_no_half_file(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with subprocess.Popen(
        [sys.executable, "-c", KILLED_MIDWAY, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert path.read_text() == "old"
    (left,) = [name for name in names_in(tmp_path) if name != path.name]
    assert left.startswith(".gd-analyze.")
    write_text(path, "new")
    assert names_in(tmp_path) == [left, path.name]  # its owner may live
    os.utime(tmp_path / left, (0, 0))
    write_text(path, "new")
    assert names_in(tmp_path) == [path.name]


def test_what_cannot_be_a_file_is_refused(tmp_path, blocked_folder):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    wrong = [tmp_path / "folder", tmp_path / "pipe", blocked_folder / "f", tmp_path / ("x" * 300)]
    for path in wrong:
        with pytest.raises(OutputError) as caught:
            write_text(path, "text")
        assert caught.value.details["where"]
        assert caught.value.details["next"]
        if path != wrong[-1]:
            with pytest.raises(OutputError):
                require_writable(path)
    require_writable(tmp_path / "new" / "folder" / "file")


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        *((getattr(errno, name), StorageError) for name in ("ENOSPC", "EDQUOT", "EIO")),
        *((getattr(errno, name), OutputError) for name in ("EACCES", "EROFS")),
    ],
)
def test_failures_of_the_place_and_of_the_machine(tmp_path, number, kind):
    with pytest.raises(OutputError) as caught, replacing(tmp_path / "file"):
        raise OSError(number, os.strerror(number))
    assert type(caught.value) is kind
    assert caught.value.details["found"] == os.strerror(number)


@pytest.mark.parametrize("size", [0, 1, 2**20, 2**20 + 1])
def test_reading_ends_at_the_largest_size(tmp_path, size):
    path = tmp_path / "text"
    path.write_bytes(b"x" * size)
    assert read_at_most(path, size) == b"x" * size
    assert not size or read_at_most(path, size - 1) is None
    assert read_at_most("/dev/zero", 10**12) == bytes(2**20)
