"""What Sphinx does not check of the site. It is built by `.ci/run`."""

from __future__ import annotations

import re

import pytest
from markdown_pages import ROOT

import gd_analyze as gd


def test_the_reference_has_every_public_name_once() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    named = re.findall(r"^\.\. \S+:: gd_analyze\.(\S+)$", page, re.MULTILINE)
    groups = {"tables": gd.tables, "types": gd.types}
    grouped = [f"{group}.{name}" for group, module in groups.items() for name in module.__all__]
    jobs = set(gd.__all__) - {"__version__", *groups}
    assert sorted(named) == sorted([*jobs, *grouped])


@pytest.mark.slow  # where the extra dev is installed
def test_tutorials_have_title_text_and_code_cells(monkeypatch) -> None:
    pytest.importorskip("nbformat", reason="cells are made by nbformat, of the extra docs")
    monkeypatch.syspath_prepend(ROOT / "docs")
    from percent_format import notebook

    for script in (ROOT / "docs" / "tutorials").glob("*.py"):
        text = script.read_text(encoding="utf-8")
        first, *cells = notebook(text).cells
        title, introduction, *_ = first.source.split("\n\n")
        assert title.startswith("# ")
        assert introduction
        assert len(cells) == text.count("\n# %%")
        code = "\n".join(cell.source for cell in cells if cell.cell_type == "code")
        assert code.count("\n") > 5
        assert all(line in text for line in code.splitlines())
