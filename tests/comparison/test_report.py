"""The comparison as a value, and the reports made of it."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from itertools import pairwise

import pytest

from gd_analyze.comparison import METHODS, text_costs
from gd_analyze.comparison.explanation import explanations
from gd_analyze.errors import UsageError
from gd_analyze.report.comparison import FILES, as_document, comparison_context, write_comparison
from gd_analyze.report.comparison_chart import PAPER, growth_chart
from gd_analyze.report.comparison_html import render_comparison_html
from gd_analyze.report.comparison_pdf import render_comparison_pdf

CREATED = "2024-05-01T12:00:00+00:00"


@pytest.fixture(scope="module")
def context(swing_comparison):
    return comparison_context(swing_comparison)


def visible(page: str) -> str:
    class Text(HTMLParser):
        text = ""
        skip = False

        def handle_starttag(self, tag, attrs):
            self.skip = tag in ("style", "script") or (self.skip and tag != "body")

        def handle_data(self, data):
            self.text += "" if self.skip else data

    parser = Text()
    parser.feed(page)
    return " ".join(parser.text.split())


def test_the_comparison_holds_everything(swing_comparison, context):
    assert swing_comparison.agreement.holds
    assert swing_comparison.warnings == ("odd",)
    assert "set points of two-link-swing" in swing_comparison.states
    assert [row.name for row in context.methods] == list(METHODS)
    for row in context.methods:
        assert row.executed.total == swing_comparison.costs[row.name].executed.total
        stated = text_costs().of(row.name)
        assert (row.text is None) == (stated is None)
        if row.text and stated:
            assert row.text.total == stated.total(2)
    assert context.agrees
    assert "agree" in context.headline


def test_a_disagreement_is_the_headline(swing_comparison):
    bounds = dict.fromkeys(swing_comparison.agreement.bounds, 0.0)
    apart = dataclasses.replace(swing_comparison.agreement, bounds=bounds)
    context = comparison_context(dataclasses.replace(swing_comparison, agreement=apart))
    assert not context.agrees
    assert "disagree" in context.headline
    assert "one of these programs is wrong" in visible(render_comparison_html(context))


def test_explanations_are_made_of_the_counts(grown):
    told = {one.method: one.sentence for one in explanations(grown, 6)}
    assert list(told) == list(METHODS)
    at = grown.sizes.index(6)
    for name, sentence in told.items():
        cost = grown.costs[name][at]
        assert str(cost.executed.total) in sentence
        assert str(cost.folded.total) in sentence
        stated = text_costs().of(name)
        if stated:
            assert str(stated.total(6)) in sentence
            assert f"{100 * cost.executed.total / stated.total(6):.0f} %" in sentence
    # One trace of 16 multiplications per h_ikm or D_ik and link: sum of j^2 + j^3 for j up to 6.
    assert f"takes {sum(j**2 + j**3 for j in range(1, 7))} traces" in told["lagrange_euler"]


def test_json_is_finite_and_complete(context):
    document = json.loads(json.dumps(as_document(context), allow_nan=False))
    assert len(document["curves"]) == len(METHODS)
    assert document["sizes"] == list(range(1, 13))
    assert len(document["torque_differences"]) == len(METHODS) + 1


def test_the_page_shows_the_numbers_and_asks_nothing_of_the_network(context):
    page = render_comparison_html(context)
    text = visible(page)
    for row in context.methods:
        assert row.title in text
        assert row.explanation in text
        assert f"{row.executed.multiplications}" in text
        assert f"{1e6 * row.seconds:.2f}" in text
    assert not re.search(r"(?:src|href)=\"(?!#)", page)
    # The one address is the SVG namespace, which is a name and is never fetched.
    assert set(re.findall(r"https?://[^\"'\s)]+", page)) <= {"http://www.w3.org/2000/svg"}
    assert "odd" in text


def test_names_from_files_are_only_text(context):
    hostile = dataclasses.replace(context, title="<script>alert(1)</script>", warnings=("<b>",))
    assert "<script>alert" not in render_comparison_html(hostile)


def test_the_chart_draws_every_curve_and_the_text(context):
    chart = growth_chart(context, "executed", PAPER)
    stated = sum(bool(curve.text) for curve in context.curves)
    assert chart.count("<polyline") == len(METHODS) + stated
    assert chart.count("stroke-dasharray") == stated
    for curve in context.curves:
        assert f"{curve.short}, n = 12: {curve.executed[-1].total} operations" in chart
    labels = [float(y) for y in re.findall(r'<text x="\d+" y="([\d.]+)" style="[^"]*font-weight', chart)]
    assert len(labels) == len(METHODS)
    # Labels of 10.5 px letters stand clear of each other.
    assert min(b - a for a, b in pairwise(labels)) > 11.9


def test_the_pdf_is_the_same_every_time_and_holds_the_numbers(context, tmp_path):
    pdf = render_comparison_pdf(context, CREATED)
    assert pdf == render_comparison_pdf(context, CREATED)
    program = shutil.which("pdftotext")
    if program is None:
        pytest.skip("pdftotext (poppler-utils) is not installed")
    (tmp_path / "c.pdf").write_bytes(pdf)
    done = subprocess.run(
        [program, "-layout", str(tmp_path / "c.pdf"), "-"], capture_output=True, check=True, text=True
    )
    for row in context.methods:
        assert row.title in done.stdout
        assert str(row.executed.multiplications) in done.stdout
        assert str(row.folded.additions) in done.stdout
        assert f"{1e6 * row.seconds:.2f}" in done.stdout


def test_only_the_files_asked_for_are_written(swing_comparison, context, tmp_path):
    write_comparison(swing_comparison, context, tmp_path / "r", ("json",))
    assert [path.name for path in (tmp_path / "r").iterdir()] == [FILES["json"]]
    with pytest.raises(UsageError, match="no format 'csv'"):
        write_comparison(swing_comparison, context, tmp_path / "r", ("csv",))
