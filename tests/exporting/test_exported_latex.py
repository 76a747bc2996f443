"""LaTeX: documents that are typeset, or, where nothing typesets, are at least closed as they were opened."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from exported_cases import TORQUES, subject
from hostile import HOSTILE, hostile

from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.text import number

PLACES = [(case, first) for case, first in HOSTILE if case in TORQUES]


def text_of(what: ExportInput) -> str:
    (text,) = written(what, "latex").files.values()
    return text


def subject_of(place) -> ExportInput:
    """A case by its name, or with hostile names."""
    return subject(place) if isinstance(place, str) else hostile(*place)


@pytest.mark.parametrize("place", [*TORQUES, *PLACES], ids=str)
def test_what_is_opened_is_closed(place):
    what = subject_of(place)
    text = re.sub(r"^%.*$", "", text_of(what), flags=re.MULTILINE)
    plain = re.sub(r"\\[{}\\%#&$_]", "", text)
    open_ = []
    for kind, name in re.findall(r"\\(begin|end)\{(\w+\*?)\}", plain):
        if kind == "begin":
            open_.append(name)
        else:
            assert open_.pop() == name
    assert not open_
    depth = 0
    for sign in plain:
        depth += (sign == "{") - (sign == "}")
        assert depth >= 0
    assert depth == 0
    assert plain.count("$") % 2 == 0
    # A comment is none of ours, nor is a command that reads or writes.
    assert "%" not in plain
    assert not re.search(r"\\(input|include|write|openout|read|catcode|def|immediate)\b", text)


@pytest.mark.parametrize("case", TORQUES)
def test_it_tells_errors_and_bounds(case):
    what = subject(case)
    text = text_of(what)
    for j in range(what.n):
        assert rf"\tau_{{{j + 1}}} &=" in text or what.model is None
    if what.certificate is None:
        assert "Proven" not in text
        return
    assert "Proven: no state within these limits has an error above the bound." in text
    for stated, bound in zip(
        re.findall(r"& ([\d.e-]+) \\\\$", text.rpartition("Proven: ")[2], re.MULTILINE),
        what.certificate.certified,
        strict=True,
    ):
        assert float(stated) >= bound
    for error in what.model.accuracy.errors.peak_torque:
        assert number(float(error)) in text


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
@pytest.mark.parametrize("place", ["two_link energy", "puma560 recursive", "stanford", *PLACES[::5]], ids=str)
def test_it_is_typeset(place, tmp_path):
    what = subject_of(place)
    written(what, "latex").save(tmp_path)
    words = ["pdflatex", "-no-shell-escape", "-interaction=nonstopmode", "-halt-on-error"]
    done = subprocess.run(
        [*words, f"{what.name}.tex"],
        cwd=tmp_path,
        capture_output=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    log = done.stdout.decode(errors="replace")
    assert done.returncode == 0, log[-2000:]
    assert (tmp_path / f"{what.name}.pdf").stat().st_size > 10_000
    assert "undefined" not in log
    assert {path.suffix for path in tmp_path.iterdir()} == {".tex", ".pdf", ".log", ".aux"}
