"""A document is JSON, decides what every medium shows, and asks terminal answers for no slow library."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from gd_analyze.formulas.formula import Symbol
from gd_analyze.report.document import result_document
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import JSON, TERMINAL, main_report, main_result
from gd_analyze.report.pdf import pdf_of
from gd_analyze.report.terminal import text_of
from gd_analyze.result import (
    Column,
    Equations,
    Fact,
    Mark,
    Result,
    Section,
    Table,
    Value,
)
from gd_analyze.text import pretty
from gd_analyze.types import Findings
from page_reader import Page
from pdf_reader import read

NOW = {"created": "2024-05-01T00:00:00+00:00"}
RAISED = ["an area of 3 m^2", "2.10e-14 N m", "1.5e+06 kg m^2", "hash 12e34", "x^-1 in 0.5e-3"]


def test_documents_are_json(puma_findings: Findings) -> None:
    for document in (result_document(main_result(puma_findings, TERMINAL)), main_report(puma_findings)):
        assert json.loads(json.dumps(document.content, allow_nan=False)) == document.content


def test_values_are_what_json_prints(puma_findings: Findings) -> None:
    result = main_result(puma_findings, JSON)
    assert result_document(result).content["values"] == result.values()


def test_a_table_is_decided_once() -> None:
    symbols = [Symbol("D", "11"), Mark("rotation", "R")]
    columns = (
        Column("torque", [2.5e-3, float("nan")], "N m"),
        Column("other", [1e-3, 2e-3], "N m", pages_only=True),
        Column("element", ["D11", "R"], shown="text", drawn=symbols),
    )
    document = result_document(Result("Title", parts=(Table("t", "Torques", columns),)))
    (table,) = document.content["parts"]
    torque, other, element = table["columns"]
    assert (torque["unit"], torque["cells"], torque["numbers"]) == ("mN m", ["2.5", "–"], [2.5e-3, None])
    assert element["cells"] == ["D11", "R"]
    assert element["drawn"][0]["mathml"].startswith("<math>")
    assert element["drawn"][0]["typst"] == "D_(11)"
    assert element["drawn"][1] == {"effect": "rotation", "text": "R"}
    assert other["pages_only"]
    assert "other" not in text_of(document)
    assert "other" in page_of(document)


def test_what_page_and_paper_show_is_numbered() -> None:
    shown = Column("x", [1.0])
    tables = [
        Table("json", "For programs", (), values={"x": [1.0]}),
        Table("pages", "For pages", (Column("x", [1.0], pages_only=True),)),
        Table(None, "Without a name", (shown,)),
        Table("all", "For all", (shown,)),
    ]
    parts = (Value("a", 1), Section("s", "Section", (tables[0], tables[1])), *tables[2:])
    section, unnamed, named = result_document(Result("Title", parts=parts)).content["parts"]
    assert [part["number"] for part in section["parts"]] == [1]
    assert (unnamed["number"], named["number"]) == (None, 2)


@pytest.mark.parametrize("words", RAISED)
def test_exponents_are_raised_on_page_and_paper_alike(words: str, tmp_path: Path) -> None:
    table = Table("t", "", (Column("said", [words], shown="text"),))
    document = result_document(
        Result("x^2", headline=words, facts=(Fact("a", words, words),), parts=(table,), provenance=NOW)
    )
    for text in (Page(page_of(document)).text, read(pdf_of(document), tmp_path)):
        assert text.replace("\N{NO-BREAK SPACE}", " ").count(pretty(words)) == 4
    assert text_of(document).count(words) == 4


def test_formulas_that_only_have_lines_are_code(tmp_path: Path) -> None:
    document = result_document(
        Result("T", parts=(Equations("e", "Equations", ("tau1 = <3> qdd1",)),), provenance=NOW)
    )
    for text in (text_of(document), Page(page_of(document)).text, read(pdf_of(document), tmp_path)):
        assert "tau1 = <3> qdd1" in text


def test_a_terminal_answer_loads_no_page() -> None:
    slow = "jinja2", "typst", "matplotlib", "gd_analyze.figures.svg", "gd_analyze.report.html"
    loads = "import sys, gd_analyze.report.document, gd_analyze.report.terminal"
    script = f"{loads}; print({{*{slow}}} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
