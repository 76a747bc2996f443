"""What is printed, word by word: any change of it is seen. `GD_ANALYZE_UPDATE_GOLDEN=1` writes it anew."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from exported_cases import proven, round_model

from gd_analyze.exporting.export import printed
from gd_analyze.exporting.languages import LANGUAGES
from gd_analyze.version import __version__

FOLDER = Path(__file__).parent / "golden"
UPDATE = "GD_ANALYZE_UPDATE_GOLDEN"


def texts(arm) -> dict[str, str]:
    """Every language of a model with a bound, and C of single precision, without what changes by itself."""
    what = proven(round_model(arm))
    files = dict(printed(what, tuple(LANGUAGES)).files)
    single = printed(what, "c", "float").files
    files |= {name.replace(".", "_float."): text for name, text in single.items()}
    return {name: settled(text) for name, text in files.items()}


def settled(text: str) -> str:
    """Our version, the hash of the file, which holds it, and errors by the sines here stand for any."""
    text = text.replace(f"gd-analyze {__version__}", "gd-analyze VERSION")
    text = re.sub(r"(by at most )[^(]* \(", r"\1ERRORS (", text)
    return re.sub(r"(model's file:\n\W*)[0-9a-f]{64}", r"\1HASH", text)


def test_every_text_is_as_it_was(two_link):
    found = texts(two_link)
    if os.environ.get(UPDATE):
        for path in FOLDER.glob("*"):
            path.unlink()
        for name, text in found.items():
            (FOLDER / name).write_text(text, encoding="ascii")
        pytest.skip("written anew: look at what git says has changed")
    stored = {path.name: path.read_text(encoding="ascii") for path in FOLDER.glob("*")}
    assert sorted(stored) == sorted(found)
    for name, text in found.items():
        assert text == stored[name], f"{name} has changed; if it should, set {UPDATE}=1 and look at it"


def test_nothing_of_them_is_of_this_machine_or_day(two_link):
    for text in texts(two_link).values():
        assert not re.search(r"20\d\d-\d\d|/home|/tmp|/work", text)
        assert text.isascii()
        assert all(line == line.rstrip() for line in text.splitlines())
        assert text.endswith("\n")
