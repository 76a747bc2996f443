"""Page and paper of a run along several motions: a row for each, and the verdicts that change."""

from __future__ import annotations

import re

import pytest
from page_reader import Page
from pdf_reader import read

import gd_analyze as gd
from gd_analyze.report.document import document
from gd_analyze.report.main_page import render_html
from gd_analyze.report.main_pdf import prepare_pdf
from gd_analyze.report.motions_document import MOST_COLUMNS
from gd_analyze.results import summary
from gd_analyze.results.motion_words import changing, motion_rows
from several_motions import swung


@pytest.fixture(scope="module")
def findings(two_link):
    both = [swung(20.0, "slow"), swung(2.2, '<fast> & "loose"')]
    return gd.find(two_link, both, gd.Settings(budget="20%"))


@pytest.fixture(scope="module")
def source(findings) -> str:
    return render_html(findings)


def test_the_page_has_an_appendix_of_motions(findings, source):
    page = Page(source)
    assert "motions" in page.identifiers
    assert "Motion by motion" in source
    assert "&lt;fast&gt; &amp; &#34;loose&#34;" in source
    assert "<fast>" not in source
    for row in motion_rows(findings):
        assert f'<td class="value">{row["set_points"]}</td>' in source
    told = summary.changing_sentence(findings)
    assert told in source
    matrix = re.search(r'<table class="matrix by-motion">(.*?)</table>', source, re.DOTALL)
    assert matrix is not None
    assert len(re.findall("<tr>", matrix[1])) == 1 + len(changing(findings))
    marks = re.findall(r'<td class="kept [a-z]+" title="[^"]+">([^<]+)</td>', matrix[1])
    assert marks == [mark for row in changing(findings) for mark in row["marks"]]


def test_the_head_says_that_there_are_several(findings, source):
    said = summary.opening(findings)
    assert said["subtitle"].startswith("along 2 motions (slow, <fast>")
    assert said["notice"].startswith("The budget holds on each of the 2 motions by itself")
    assert "Near these motions, proven" in said["headline"]


def test_of_one_motion_there_is_none(swing_findings):
    page = render_html(swing_findings)
    assert 'id="motions"' not in page
    assert document(swing_findings)["by_motion"] is None
    assert "motions" not in document(swing_findings)["numbers"]["tables"]


def test_on_paper(findings, tmp_path):
    text = read(prepare_pdf(findings)(), tmp_path)
    assert "Motion by motion" in text
    assert summary.changing_sentence(findings).split(":")[0] in text
    told = document(findings)
    tables = told["numbers"]["tables"]
    assert f"{tables['motions']}. Each motion by itself" in text
    assert f"{tables['verdicts']}. Elements whose verdict depends on the motion" in text


def test_many_motions_are_counted_by_verdict(two_link, tmp_path):
    count = MOST_COLUMNS + 1
    many = gd.find(
        two_link, [swung(2.2 + 1.5 * k, f"motion-{k}", 9) for k in range(count)], gd.Settings(level="element")
    )
    told = document(many)["by_motion"]
    assert not told["by_motion"]
    assert len(told["rows"]) == count
    for row in told["changing"]:
        assert sum(int(cell["mark"] or 0) for cell in row["cells"]) == count
    assert "along how many motions what dominates" in render_html(many)
    assert f"along {count} motions (motion-0+{count - 1}-more)" in read(prepare_pdf(many)(), tmp_path)
