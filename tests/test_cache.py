"""The folder of what takes long to make: where it is, and that nothing depends on what is in it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification import cache
from gd_analyze.simplification.cache import VARIABLE, folder, keep, kept, name_of, without_cache
from strategies import examples, names_in

NAME = name_of(["a key", 1.5])
VALUE = [["a", 1.0, -0.0], {"b": None}]


@pytest.fixture
def place(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "deep" / "cache"))
    return tmp_path / "deep" / "cache"


def entry(place: Path) -> Path:
    (path,) = place.iterdir()
    return path


def test_what_was_kept_is_there(place):
    assert kept(NAME) is None
    keep(NAME, VALUE)
    assert kept(NAME) == VALUE
    assert str(kept(NAME)[0][2]) == "-0.0"
    assert kept(name_of(["a key", 1.0])) is None
    assert len(names_in(place)) == 1


def test_another_version_has_other_names(monkeypatch):
    monkeypatch.setattr(cache, "__version__", "0.0.1")
    assert name_of(["a key", 1.5]) != NAME


@pytest.mark.parametrize(
    ("platform", "given", "expected"),
    [
        ("linux", {"XDG_CACHE_HOME": "/x/cache"}, "/x/cache/gd-analyze"),
        ("linux", {"XDG_CACHE_HOME": "not/absolute"}, "/home/me/.cache/gd-analyze"),
        ("linux", {}, "/home/me/.cache/gd-analyze"),
        ("darwin", {"XDG_CACHE_HOME": "/x/cache"}, "/home/me/Library/Caches/gd-analyze"),
        ("win32", {"LOCALAPPDATA": "/c/Local"}, "/c/Local/gd-analyze"),
        ("linux", {VARIABLE: "/here"}, "/here"),
        ("linux", {VARIABLE: "off", "XDG_CACHE_HOME": "/x"}, None),
        ("linux", {VARIABLE: "OFF"}, None),
        ("linux", {VARIABLE: ""}, None),
    ],
)
def test_where_it_is(monkeypatch, platform, given, expected):
    for name in (VARIABLE, "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.setattr(sys, "platform", platform)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    assert folder() == (None if expected is None else Path(expected))


def test_it_can_be_switched_off(place):
    keep(NAME, VALUE)
    with without_cache():
        assert folder() is None
        assert kept(NAME) is None
        keep(name_of("another"), VALUE)
    assert kept(NAME) == VALUE
    assert len(names_in(place)) == 1


@examples(100)
@given(st.data())
def test_a_damaged_entry_is_none(tmp_path_factory, data):
    place = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(place))
        keep(NAME, VALUE)
        path = entry(place)
        content = path.read_bytes()
        at = data.draw(st.integers(0, len(content) - 1))
        changed = data.draw(
            st.sampled_from(
                [
                    content[:at],
                    content[:at]
                    + bytes([content[at] ^ 1 << data.draw(st.integers(0, 7))])
                    + content[at + 1 :],
                    content + content[at:],
                    b"\0" * at,
                    content.partition(b"\n")[2],
                ]
            )
        )
        path.write_bytes(changed)
        assert kept(NAME) in (None, VALUE)
        assert kept(NAME) is None or changed == content
        keep(NAME, VALUE)
        assert kept(NAME) == VALUE


def test_an_entry_under_another_name_is_none(place):
    keep(NAME, VALUE)
    other = name_of("another")
    (place / (other + entry(place).name.removeprefix(NAME))).write_bytes(entry(place).read_bytes())
    assert kept(other) is None


@pytest.mark.parametrize("body", [b"[" * 100_000, b"{", b"NaN\xff", b"", b"1" * 5000])
def test_what_is_no_json_is_none_even_with_its_digest(place, body):
    keep(NAME, VALUE)
    entry(place).write_bytes(cache._digest(NAME, body).encode() + b"\n" + body)
    assert kept(NAME) is None


def test_an_endless_entry_is_none(place):
    place.mkdir(parents=True)
    (place / f"{NAME}.gd.json").symlink_to("/dev/zero")
    assert kept(NAME) is None


def test_a_folder_that_cannot_be_made_is_done_without(tmp_path, monkeypatch, blocked_folder):
    monkeypatch.setenv(VARIABLE, str(blocked_folder))
    keep(NAME, VALUE)
    assert kept(NAME) is None


def test_a_full_disk_leaves_nothing_behind(place, monkeypatch):
    def full(path: Path, content: bytes) -> None:
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    keep(NAME, VALUE)
    assert names_in(place) == []


def test_old_entries_go(place, monkeypatch):
    monkeypatch.setattr(cache, "MOST", 20_000)
    place.mkdir(parents=True)
    (place / "notes.txt").write_text("the user's" * 10_000)
    names = [name_of(k) for k in range(200)]
    for age, name in enumerate(names):
        keep(name, "x" * 1000)
        os.utime(place / f"{name}.gd.json", (age, age))
    keep(min(names), "x" * 1000)
    held = [path for path in place.iterdir() if path.suffix == ".json"]
    assert sum(path.stat().st_size for path in held) <= 20_000
    # The youngest are left, and what is no entry.
    assert {f"{name}.gd.json" for name in names[-5:]} <= {path.name for path in held}
    assert (place / "notes.txt").exists()


WRITE = """
import sys
from gd_analyze.simplification.cache import keep, kept, name_of
for k in range(60):
    name = name_of(k % 7)
    keep(name, [k % 7] * 2000)
    assert kept(name) in ([k % 7] * 2000, None), k
"""


def test_processes_do_not_disturb_each_other(place):
    running = [subprocess.Popen([sys.executable, "-c", WRITE], stderr=subprocess.PIPE) for _ in range(4)]
    for process in running:
        _, told = process.communicate(timeout=60)
        assert process.returncode == 0, told
    for k in range(7):
        assert kept(name_of(k)) == [k] * 2000
    assert len(names_in(place)) == 7


def test_the_tests_have_a_folder_of_their_own(cache_of_the_tests):
    assert folder() == cache_of_the_tests
