"""Templates compiled before give the same page, and are told from those of other code."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from gd_analyze.report import compiled_templates
from gd_analyze.report.page_environment import environment

NAME = "macros.html.j2"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where Python, and so we, keep what is compiled."""
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    return tmp_path


def compiled() -> set[str]:
    """Compile a template in a fresh environment; the functions and names its code is made of."""
    template = environment.__wrapped__().get_template(NAME)
    return {*template.blocks, *vars(template.module)}


def files(place: Path) -> list[Path]:
    return sorted(place.rglob("*.template.pyc"))


def test_a_template_is_compiled_once(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, (kept,) = compiled(), files(place)
    monkeypatch.setattr("jinja2.Environment.compile", None)  # what is kept needs no compiling
    assert compiled() == first
    assert files(place) == [kept]


@pytest.mark.parametrize("damage", [0, 1, 40, 60, 300])
def test_a_damaged_one_is_compiled_anew(place: Path, damage: int) -> None:
    first, (kept,) = compiled(), files(place)
    whole = kept.read_bytes()
    kept.write_bytes(whole[:damage])
    assert compiled() == first
    assert kept.read_bytes() == whole


def test_other_code_compiles_anew(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled()
    (before,) = files(place)
    monkeypatch.setattr(compiled_templates, "_state_of_code", lambda: "other")
    compiled()
    (after,) = files(place)
    assert after.name.startswith("other-")
    assert not before.exists()


def test_nothing_is_written_where_python_writes_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    compiled()
    assert not files(place)


@pytest.mark.skipif(os.name == "nt", reason="a file in the place of a folder is another error there")
def test_a_place_that_cannot_be_written_does_no_harm(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = place / "file"
    file.touch()
    monkeypatch.setattr(sys, "pycache_prefix", str(file))
    assert compiled()
