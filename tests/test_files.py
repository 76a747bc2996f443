"""A file appears whole or not at all, whatever happens while it is written."""

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
from gd_analyze.files import replacing, require_writable, write_text
from killed_midway import KILLED_MIDWAY
from strategies import names_in


def test_writes_and_replaces(tmp_path):
    path = tmp_path / "new" / "folder" / "file.txt"
    write_text(path, "Größe\n")
    assert path.read_text(encoding="utf-8") == "Größe\n"
    write_text(path, "again")
    assert path.read_text() == "again"
    assert names_in(path.parent) == ["file.txt"]


def half_written(path: Path, end: BaseException) -> None:
    with replacing(path) as temporary:
        temporary.write_text("half")
        raise end


def test_an_exception_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="midway"):
        half_written(path, RuntimeError("midway"))
    assert path.read_text() == "old"
    assert names_in(tmp_path) == ["file.txt"]


def test_an_interrupt_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        half_written(tmp_path / "file.txt", KeyboardInterrupt())
    assert names_in(tmp_path) == []


def test_a_full_disk_is_an_output_error(tmp_path):
    path = tmp_path / "file.txt"
    with pytest.raises(OutputError, match="writing failed") as caught, replacing(path):
        raise OSError(28, "No space left on device")
    assert caught.value.details["found"] == "No space left on device"
    assert names_in(tmp_path) == []


def test_the_old_file_stays_readable_while_the_new_one_is_written(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert path.read_text() == "old"
        # Replacing across file systems would not be atomic.
        assert temporary.stat().st_dev == path.stat().st_dev
        assert temporary.suffix == path.suffix
    assert path.read_text() == "new"


def test_results_are_as_readable_as_any_file(tmp_path):
    write_text(tmp_path / "ours", "")
    (tmp_path / "any").touch()
    assert stat.S_IMODE((tmp_path / "ours").stat().st_mode) == stat.S_IMODE((tmp_path / "any").stat().st_mode)


def test_a_folder_in_the_way(tmp_path):
    (tmp_path / "results").mkdir()
    with pytest.raises(OutputError, match="cannot write there") as caught:
        write_text(tmp_path / "results", "text")
    assert caught.value.details["found"] == "is a folder"
    assert str(tmp_path / "results") in caught.value.details["where"]


def test_a_file_where_the_folder_should_be(blocked_folder):
    with pytest.raises(OutputError, match="cannot write there") as caught:
        write_text(blocked_folder / "file.txt", "text")
    assert caught.value.details["next"]


def test_a_name_longer_than_the_file_system_allows(tmp_path):
    with pytest.raises(OutputError):
        write_text(tmp_path / ("x" * 300), "text")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="permissions do not stop this user")
def test_a_folder_without_write_permission(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="cannot write there"):
            write_text(tmp_path / "file.txt", "text")
    finally:
        tmp_path.chmod(0o700)


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is a matter of POSIX")
@pytest.mark.parametrize("before", [None, "old"])
def test_a_killed_process_leaves_no_half_file(tmp_path: Path, before: str | None):
    path = tmp_path / "file.txt"
    if before is not None:
        path.write_text(before)
    with subprocess.Popen(
        [sys.executable, "-c", KILLED_MIDWAY, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert (path.read_text() if path.exists() else None) == before
    left = [name for name in names_in(tmp_path) if name != path.name]
    assert len(left) == 1
    assert left[0].startswith(".")
    write_text(path, "new")
    assert names_in(tmp_path) == [path.name]


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (errno.ENOSPC, StorageError),
        (errno.EDQUOT, StorageError),
        (errno.EFBIG, StorageError),
        (errno.EIO, StorageError),
        (errno.EMFILE, StorageError),
        (errno.EACCES, OutputError),
        (errno.EROFS, OutputError),
        (errno.ENAMETOOLONG, OutputError),
    ],
    ids=lambda value: errno.errorcode.get(value) if isinstance(value, int) else None,
)
def test_whose_fault_it_is(tmp_path, number, kind):
    with pytest.raises(OutputError) as caught, replacing(tmp_path / "file"):
        raise OSError(number, os.strerror(number))
    assert type(caught.value) is kind
    assert caught.value.details["found"] == os.strerror(number)


def test_a_device_is_no_file_to_replace(tmp_path):
    for path in (Path(os.devnull), tmp_path / "pipe"):
        if not path.exists():
            os.mkfifo(path)
        for refused in (require_writable, lambda path: write_text(path, "text")):
            with pytest.raises(OutputError, match="cannot write there") as caught:
                refused(path)
            assert "a device or a pipe" in caught.value.details["found"]
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)
