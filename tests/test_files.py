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
from gd_analyze.files import (
    megabytes,
    read_at_most,
    replacing,
    replacing_together,
    require_writable,
    write_text,
)
from strategies import names_in


def test_writes_and_replaces(tmp_path):
    path = tmp_path / "new" / "folder" / "file.txt"
    write_text(path, "Größe\n")
    assert path.read_text(encoding="utf-8") == "Größe\n"
    write_text(path, "again")
    assert path.read_text() == "again"
    assert names_in(path.parent) == ["file.txt"]


def test_an_exception_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="midway"), replacing(path) as temporary:  # noqa: PT012 - the block is the test
        temporary.write_text("half")
        raise RuntimeError("midway")
    assert path.read_text() == "old"
    assert names_in(tmp_path) == ["file.txt"]


def test_an_interrupt_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), replacing(tmp_path / "file.txt") as temporary:  # noqa: PT012 - the block is the test
        temporary.write_text("half")
        raise KeyboardInterrupt
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


@pytest.mark.parametrize("size", [0, 1, 2**20 - 1, 2**20, 2**20 + 1, 3 * 2**20])
def test_reading_ends_at_the_largest_size(tmp_path, size):
    path = tmp_path / "text"
    path.write_bytes(b"x" * size)
    assert read_at_most(path, size) == b"x" * size
    assert read_at_most(path, size + 1) == b"x" * size
    if size:
        assert read_at_most(path, size - 1) is None


def test_reading_of_what_is_no_text_ends_early():
    assert read_at_most("/dev/zero", 10**12) == bytes(2**20)
    assert (megabytes(10_000), megabytes(10**9)) == ("0.01 MB", "1000 MB")


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
