"""What cannot be written, or would replace what is read, is refused before anything is computed."""

from __future__ import annotations

import errno
import importlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import gd_analyze as gd
from gd_analyze.files import RESULT_FILES
from long_cases import long

LONG = "a" * 300
COMPUTING = {
    "gd_analyze.studies.main_job": "find",
    "gd_analyze.studies.simplifying": "search_model",
}
resource = pytest.importorskip("resource", reason="limits on file size are a matter of POSIX")


@pytest.fixture
def nothing_computed(monkeypatch):
    def fail(*words, **more):
        raise AssertionError("computed before the output was known to be writable")

    for module, name in COMPUTING.items():
        monkeypatch.setattr(importlib.import_module(module), name, fail)
    for name in ("diagnose", "evaluate"):
        monkeypatch.setattr(gd, name, fail, raising=False)


@pytest.fixture
def plenty(here, motion, model):
    """Inputs under several names, and things in the way."""
    (here / "own.toml").write_bytes(gd.builtin_arms()["two_link"].read_bytes())
    (here / "link.csv").symlink_to(motion)
    os.link(motion, here / "hard.csv")
    (here / "r" / "report.html").mkdir(parents=True)
    (here / "r" / "diagnosis.pdf").mkdir()
    os.link(motion, here / "r" / "dominance.csv")


REPLACES = "the output would replace an input"
REFUSED = [
    ("evaluate model.json gentle.csv -o gentle.csv", REPLACES),
    ("evaluate model.json gentle.csv -o link.csv", REPLACES),
    ("evaluate model.json gentle.csv -o hard.csv", REPLACES),
    ("evaluate model.json gentle.csv -o model.json", REPLACES),
    ("simplify own.toml gentle.csv -o own.toml", REPLACES),
    ("equations own.toml -o own.toml", REPLACES),
    ("two_link gentle.csv --out r --format csv", REPLACES),
    ("two_link gentle.csv --out r --format json,html", "report.html"),
    ("diagnose own.toml gentle.csv --report r", "diagnosis.pdf"),
    ("simplify two_link -o r", "error: r: "),
    ("simplify two_link -o /dev/null", "error: /dev/null: "),
    ("equations two_link -o own.toml/x", "found: own.toml "),
]
OUT_OF = [
    "two_link gentle.csv",
    "simplify two_link gentle.csv",
    "equations two_link",
]


@pytest.mark.usefixtures("plenty", "nothing_computed")
@pytest.mark.parametrize(("line", "says"), REFUSED, ids=[line for line, _ in REFUSED])
def test_refused(run, listing, motion, line, says):
    before, content = listing(), motion.read_bytes()
    result = run(line)
    assert (result.code, result.out) == (2, ""), result
    assert says in result.err
    assert listing() == before
    assert motion.read_bytes() == content


@pytest.mark.usefixtures("plenty", "nothing_computed")
@pytest.mark.parametrize("line", OUT_OF)
@pytest.mark.parametrize(
    ("out", "says"), [("", "empty"), (LONG, os.strerror(errno.ENAMETOOLONG))], ids=["empty", "long"]
)
def test_no_such_output(run, listing, line, out, says):
    before = listing()
    result = run(line, "--out", out)
    assert (result.code, result.out) == (2, "")
    assert says in result.err
    assert listing() == before


@pytest.mark.slow
def test_standard_input_is_an_input(process, here, motion):
    (here / "r").mkdir()
    (here / "r" / "dominance.csv").write_bytes(motion.read_bytes())
    with (here / "r" / "dominance.csv").open() as given:
        done = process("two_link - --out r --format csv", stdin=given)
    assert (done.code, REPLACES in done.err) == (2, True)
    assert (here / "r" / "dominance.csv").read_bytes() == motion.read_bytes()


@contextmanager
def file_size_limited(size: int) -> Iterator[None]:
    """A limit on file size fails as a full disk does, in the middle of a file."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


RUN = "two_link gentle.csv --out r"


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("formats", ["h5", long("csv"), long("csv,pdf")])
def test_a_disk_that_fills_up(run, motion, here, formats):
    """The last file fails: none of the others is replaced."""
    words = f"{RUN} --overwrite --format {formats} --budget"
    assert run(f"{words} 5%").code == 0
    before = content(here / "r")
    for share in (0.0, 0.9):
        with file_size_limited(int(share * len(before[RESULT_FILES[formats.split(",")[-1]]]))):
            result = run(f"{words} 1%")
        assert (result.code, result.out) == (1, ""), result
        assert result.err.startswith(("error: r: ", "error: r/")), result
        assert f"found: {os.strerror(errno.EFBIG)}" in result.err
        assert content(here / "r") == before


def test_an_export_that_fails_midway_leaves_what_was_there(run, here):
    """The header still fits on the disk, the source does not."""
    words = "export two_link --to c --out r --overwrite"
    assert run(words).code == 0
    before = content(here / "r")
    with file_size_limited(len(before["two_link.h"]) + 1):
        assert len(before["two_link.c"]) > len(before["two_link.h"]) + 1
        assert run(f"{words} --no-drives").code != 0
    assert content(here / "r") == before


def test_a_disk_that_fills_up_does_not_crash_on_leaving(process, motion, here):
    """HDF5 closes what it could not write once more when the process ends."""
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))"
    result = process(f"{RUN} --format h5", before=limit)
    assert (result.code, result.out) == (1, "")
    assert result.err.count("\n") == 2
    assert not (here / "r").exists()


def test_a_folder_is_of_one_run(run, motion, here):
    assert run(f"{RUN} --format h5,json,csv").err == ""
    files = content(here / "r")
    assert run(f"{RUN} --format csv").err == "", "the same run"
    for others in (f"{RUN} --format csv --budget 5%", "puma560 pick-and-place --out r"):
        refused = run(others)
        assert (refused.code, refused.out) == (2, "")
        assert refused.err.startswith("error: the folder r ")
        assert "found: analysis.h5, model.json, dominance.csv\n" in refused.err
        assert "--overwrite" in refused.err
        assert content(here / "r") == files
    done = run(f"{RUN} --format csv --budget 5% --overwrite")
    assert (done.code, done.err) == (0, "")
    assert list(content(here / "r")) == ["dominance.csv"]


@pytest.mark.slow
def test_an_arm_of_the_same_name_replaces_what_it_gave_before(run, motion, here):
    """The loop of who writes an arm's file: edit, run, edit, run."""
    text = run("arms two_link --to toml").out
    for mass in ("1.0", "1.5"):
        (here / "mine.toml").write_text(text.replace("mass = 1.0", f"mass = {mass}"))
        done = run("mine.toml gentle.csv --out r --format json,csv")
        assert (done.code, done.err) == (0, "")
    assert gd.load_model("r/model.json").arm.mass.tolist() == [2.0, 1.5]
    assert run("mine.toml gentle.csv --out r --format csv").code == 0, "nothing changed since"
    (here / "mine.toml").write_text(text)
    refused = run("mine.toml gentle.csv --out r --format csv")
    assert (refused.code, "found: model.json" in refused.err) == (2, True)


def test_reports_go_beside_their_analysis_or_to_a_folder_of_their_own(run, motion, here):
    assert run(f"{RUN} --format h5,csv").code == 0
    assert run("two_link gentle.csv --out other --format csv --at-set-points").code == 0
    assert run("report r/analysis.h5 --format csv").code == 0
    words = "report r/analysis.h5 --format csv --out other"
    refused = run(words)
    assert (refused.code, "--overwrite" in refused.err) == (2, True)
    assert run(f"{words} --overwrite").code == 0
    assert (here / "other" / "dominance.csv").read_bytes() == (here / "r" / "dominance.csv").read_bytes()
