"""`gd-analyze export`: the files it writes, what it says of them, and what it refuses."""

from __future__ import annotations

import json
import re

import pytest

from gd_analyze.exporting.export import export, export_decomposition
from gd_analyze.exporting.registry import LANGUAGES


@pytest.fixture
def model(run, here):
    words = (
        "simplify",
        "two_link",
        "two-link-swing",
        "--budget",
        "5%",
        "--level",
        "energy",
        "--effort",
        "0.1",
    )
    assert run(*words, "-o", "model.json", "--quiet").code == 0
    return here / "model.json"


def test_every_language_is_written_and_the_same_as_by_the_library(run, here):
    result = run("export", "two_link", "--to", ",".join(LANGUAGES), "--out", "made")
    assert (result.code, result.err) == (0, "")
    files = export("two_link", LANGUAGES).files
    assert {path.name: path.read_text() for path in (here / "made").iterdir()} == dict(files)
    assert result.out.count("wrote ") == len(files)
    assert re.search(r"torque +12 +10 +4", result.out)


def test_a_model_is_written_with_its_bound(run, model, here):
    result = run("export", model, "--to", "c,latex", "--name", "mine")
    assert (result.code, result.err) == (0, "")
    certified = [joint["certified"] for joint in run("certify", model, "--json").json["joints"]]
    document = run("export", model, "--to", "c", "--out", "json", "--json").json
    for stated, proven in zip(document["stated"]["error_bound"], certified, strict=True):
        assert proven <= stated <= proven * (1 + 1e-5)
    assert "mine_error_bound" in (here / "mine.h").read_text()
    assert "Proven" in (here / "mine.tex").read_text()


def test_without_a_bound_none_is_claimed(run, model, here):
    result = run("export", model, "--to", "c", "--no-bound")
    assert (result.code, result.err) == (0, "")
    text = (here / "two_link.h").read_text()
    assert "Nothing is proven of other states" in text
    assert "error_bound" not in text
    assert "is_within" not in text


def test_json_tells_what_became_of_the_names(run, here):
    document = run("export", "puma560", "--to", "c", "--out", "x", "--json").json
    assert document["joints"][3] == {"name": "wrist roll", "identifier": "wrist_roll"}
    torque = document["functions"][0]
    assert torque == {"function": "torque", "multiplications": 168, "additions": 140, "sines_cosines": 10}
    assert document["files"] == ["x/puma560.h", "x/puma560.c"]
    assert (document["stated"], document["warnings"]) == ({}, [])


def test_drives_are_in_or_out(run, here):
    for words, told in (((), "included"), (("--no-drives",), "left out")):
        assert run("export", "puma560", "--to", "c", "--overwrite", *words).code == 0
        assert f"Inertia of the drives: {told}." in (here / "puma560.h").read_text()


def test_a_decomposition_in_single_precision(run, here):
    words = ("--what", "decomposition", "--float")
    assert run("export", "two_link", "--to", "c", *words).code == 0
    files = export_decomposition("two_link", "c", scalar="float").files
    for name, text in files.items():
        assert (here / name).read_text() == text


def test_what_cannot_be_bounded_is_written_with_a_warning(run, model, here, monkeypatch):
    import gd_analyze as gd
    from gd_analyze.errors import ModelError

    def refuse(*_, **__):
        raise ModelError("it has too many terms to be bounded")

    monkeypatch.setattr(gd, "certify", refuse, raising=False)
    result = run("export", model, "--to", "c")
    assert result.code == 0
    said = " ".join(result.err.split())
    assert "no bound is written: it has too many terms to be bounded; --no-bound" in said
    assert "error_bound" not in (here / "two_link.h").read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("two_link",), ("missing option '--to'", "next:")),
        (("two_link", "--to", "fortran"), ("fortran", "casadi, cpp")),
        (("two_link", "--to", ""), ("--to",)),
        (
            ("two_link", "--to", "c", "--name", "a b"),
            ("the name is no identifier", "next: a_b would do"),
        ),
        (("two_link", "--to", "c", "--name", "double"), ("found: double", "next: arm_double would do")),
        (("two_link", "--to", "c", "--name", "../up"), ("found: ../up", "next: up would do")),
        (("two_link", "--to", "c,python", "--float"), ("--float goes with --to c alone",)),
        (("model.json", "--to", "c", "--drives"), ("are of arms: a model has its own",)),
        (("model.json", "--to", "c", "--tip", "x"), ("are of arms: a model has its own",)),
        (("model.json", "--to", "c", "--what", "decomposition"), ("is of an arm: give the arm in place",)),
        (("two_link", "--to", "c", "--what", "decomposition", "--drives"), ("it goes without --drives",)),
        (
            ("two_link", "--to", "latex", "--what", "decomposition"),
            ("latex", "next:"),
        ),
        (("two_link", "--to", "c,latex", "--what", "decomposition"), ("latex", "gd-analyze equations")),
        (("nothing.json", "--to", "c"), ("nothing.json", "next:")),
        (("other.json", "--to", "c"), ("this is not a gd-analyze model", "where: other.json", "next:")),
        (("nobody", "--to", "c"), ("nobody", "next:")),
        (("two_link", "--to", "c", "--out", "file"), ("file", "next:")),
        (("two_link", "--to", "c", "--out", "file/below"), ("file", "next:")),
    ],
)
def test_what_is_wrong_is_said_and_nothing_written(run, model, here, listing, words, says):
    (here / "other.json").write_text('{"some": "thing"}')
    (here / "file").write_text("in the way")
    before = listing()
    result = run("export", *words)
    assert result.code == 2, result.err
    said = " ".join(result.err.split())
    for words_ in says:
        assert words_ in said
    assert "Traceback" not in result.err
    assert result.out == ""
    assert listing() == before


def test_files_that_are_there_stay_unless_told(run, here):
    (here / "two_link.c").write_text("mine")
    for words in ((), ("--to", "c,python")):
        result = run("export", "two_link", "--to", "c", *words)
        assert result.code == 2
        said = " ".join(result.err.split())
        assert "the file exists" in said
        assert "where: two_link.c" in said
        assert "next: name another folder with --out or another name with --name, or give --overwrite" in said
    assert [path.name for path in here.iterdir() if path.suffix] == ["two_link.c"]
    assert (here / "two_link.c").read_text() == "mine"
    assert run("export", "two_link", "--to", "c", "--overwrite").code == 0
    assert (here / "two_link.c").read_text() != "mine"


def test_the_model_itself_is_never_written_over(run, model):
    """No language has the model's suffix; its name may be the same."""
    before = model.read_bytes()
    assert run("export", model, "--to", ",".join(LANGUAGES), "--name", "model_1").code == 0
    assert model.read_bytes() == before
    json.loads(before)


def test_a_run_that_fails_midway_leaves_nothing(run, here, listing, monkeypatch):
    from gd_analyze.exporting.export import Exported

    assert run("export", "two_link", "--to", "c").code == 0
    before = {name: (here / name).read_text() for name in ("two_link.h", "two_link.c")}
    save = Exported.save

    def broken(self, folder="."):
        files = dict(self.files)
        files["two_link.c"] = "not in ASCII: \u00e4"
        object.__setattr__(self, "files", files)
        return save(self, folder)

    monkeypatch.setattr(Exported, "save", broken)
    result = run("export", "two_link", "--to", "c", "--name", "two_link", "--overwrite")
    assert result.code == 1
    assert {name: (here / name).read_text() for name in before} == before
    assert {name for name in listing() if not name.startswith(".")} == set(before)
