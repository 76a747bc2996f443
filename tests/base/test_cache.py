"""The folder of what takes long to make: where it is, and that nothing depends on what is in it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.cache import VARIABLE, cache_folder, keep, kept, name_of, without_cache
from strategies import examples, names_in

NAME = name_of(["a key", 1.5])
VALUE = [["a", 1.0, -0.0], {"b": None}]


@pytest.fixture
def place(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "deep" / "cache"))
    return tmp_path / "deep" / "cache"


def test_what_was_kept_is_there_unless_it_is_switched_off(place, monkeypatch):
    assert kept(NAME) is None
    keep(NAME, VALUE)
    assert kept(NAME) == VALUE
    assert str(kept(NAME)[0][2]) == "-0.0"
    with without_cache():
        assert cache_folder() is kept(NAME) is None
        keep(name_of("another"), VALUE)
    assert len(names_in(place)) == 1
    monkeypatch.setattr("gd_analyze.cache.__version__", "0.0.1")
    assert name_of(["a key", 1.5]) != NAME
    for name in ("off", "OFF", ""):
        monkeypatch.setenv(VARIABLE, name)
        assert cache_folder() is None
    monkeypatch.delenv(VARIABLE)
    assert cache_folder().name == "gd-analyze"


@examples(40)
@given(st.data())
def test_a_damaged_entry_is_none(tmp_path_factory, data):
    place = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(place))
        keep(NAME, VALUE)
        (path,) = place.iterdir()
        content = path.read_bytes()
        at = data.draw(st.integers(0, len(content) - 1))
        flipped = bytes([content[at] ^ 1 << data.draw(st.integers(0, 7))])
        whole = [content[:at], content[:at] + flipped + content[at + 1 :], content + content[at:], b"\0" * at]
        changed = data.draw(st.sampled_from([*whole, b"[" * 100_000]))
        path.write_bytes(changed)
        assert kept(NAME) is None or changed == content
        keep(NAME, VALUE)
        assert kept(NAME) == VALUE


def test_another_entrys_content_a_device_no_folder_and_a_full_disk(place, monkeypatch, blocked_folder):
    keep(NAME, VALUE)
    (path,) = place.iterdir()
    other = name_of("another")
    path.with_name(path.name.replace(NAME, other)).write_bytes(path.read_bytes())
    assert kept(other) is None
    path.unlink()
    path.symlink_to("/dev/zero")
    assert kept(NAME) is None

    def full(path: Path, content: bytes) -> None:
        path.touch()
        raise OSError(28, "No space left on device")

    before = names_in(place)
    monkeypatch.setattr(Path, "write_bytes", full)
    keep(name_of("third"), VALUE)
    assert names_in(place) == before
    monkeypatch.setenv(VARIABLE, str(blocked_folder))
    keep(NAME, VALUE)
    assert kept(NAME) is None


def test_old_entries_go(place, monkeypatch):
    monkeypatch.setattr("gd_analyze.cache.LARGEST_CACHE", 20_000)
    place.mkdir(parents=True)
    (place / "notes.txt").write_text("the user's" * 10_000)
    names = [name_of(k) for k in range(60)]
    for age, name in enumerate(names):
        keep(name, "x" * 1000)
        os.utime(place / f"{name}.gd.json", (age, age))
    held = {path.name: path.stat().st_size for path in place.glob("*.json")}
    assert sum(held.values()) <= 20_000
    assert {f"{name}.gd.json" for name in names[-5:]} <= set(held)
    assert (place / "notes.txt").exists()


WRITE = """
from gd_analyze.cache import keep, kept, name_of
for k in range(60):
    keep(name_of(k % 7), [k % 7] * 2000)
    assert kept(name_of(k % 7)) in ([k % 7] * 2000, None), k
"""


def test_processes_do_not_disturb_each_other(place):
    running = [subprocess.Popen([sys.executable, "-c", WRITE], stderr=subprocess.PIPE) for _ in range(3)]
    for process in running:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert [kept(name_of(k)) for k in range(7)] == [[k] * 2000 for k in range(7)]


@pytest.mark.slow
def test_other_code_finds_nothing_of_this(tmp_path):
    """An entry is a function of the code that wrote it: one character more, and it is written anew."""
    package, place = tmp_path / "gd_analyze", tmp_path / "cache"
    shutil.copytree(Path(gd.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    words = (
        "import sys, gd_analyze as gd; arm = gd.load_arm(sys.argv[1]);"
        "gd.simplify(arm, gd.tables.states_in_box(arm, 9))"
    )
    arm = str(gd.builtin_arms()["two_link"])
    environment = os.environ | {"PYTHONPATH": str(tmp_path), VARIABLE: str(place)}
    counts = []
    for addition in ("", "", "#\n"):
        with (package / "operations" / "sharing.py").open("a") as file:
            file.write(addition)
        subprocess.run([sys.executable, "-c", words, arm], env=environment, cwd=tmp_path, check=True)
        counts.append(len(names_in(place)))
    assert 0 < counts[0] == counts[1]
    assert counts[2] == 2 * counts[0]
