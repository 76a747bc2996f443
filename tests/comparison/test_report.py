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

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.errors import UsageError
from gd_analyze.studies.comparison_chart import PAPER, growth_chart
from gd_analyze.studies.comparison_document import comparison_document
from gd_analyze.studies.comparison_files import (
    FILES,
    render_comparison_html,
    render_comparison_pdf,
    write_comparison,
)
from gd_analyze.studies.cost_explanations import N_JOINTS, explanation
from gd_analyze.studies.text_costs import text_costs


@pytest.fixture(scope="module")
def told(swing_comparison):
    return comparison_document(swing_comparison)


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


def test_the_comparison_holds_everything(swing_comparison, told):
    assert swing_comparison.agreement.holds
    assert swing_comparison.warnings == ("odd",)
    assert "set points of two-link-swing" in told["subtitle"]
    assert [row["name"] for row in told["methods"]] == list(METHODS)
    for row in told["methods"]:
        assert row["executed"]["additions"] == swing_comparison.costs[row["name"]].executed.additions
        stated = text_costs().of(row["name"])
        assert (row["text"] is None) == (stated is None)
        if stated:
            assert row["text"]["multiplications"] == stated.multiplications(2)
    assert told["agrees"]
    assert "agree" in told["headline"]


def test_a_disagreement_is_the_headline(swing_comparison):
    bounds = dict.fromkeys(swing_comparison.agreement.bounds, 0.0)
    apart = dataclasses.replace(swing_comparison.agreement, bounds=bounds)
    disagreeing = dataclasses.replace(swing_comparison, agreement=apart)
    told = comparison_document(disagreeing)
    assert not told["agrees"]
    assert "disagree" in told["headline"]
    assert "one of these programs is wrong" in visible(render_comparison_html(disagreeing))


@pytest.mark.parametrize("name", list(METHODS))
def test_explanations_are_made_of_the_counts(grown, name):
    sentence = explanation(name, grown)
    cost = grown.costs[name][grown.sizes.index(N_JOINTS)]
    assert str(cost.executed.total) in sentence
    assert str(cost.folded.total) in sentence
    stated = text_costs().of(name)
    if stated:
        total = stated.at(N_JOINTS).total
        assert str(total) in sentence
        assert f"{100 * cost.executed.total / total:.0f} %" in sentence


def test_the_traces_of_lagrange_euler_are_as_told(grown):
    """One per h_ikm or D_ik and link in ours; in the text one per link and pair for D, n times that for h."""
    n, sentence = N_JOINTS, explanation("lagrange_euler", grown)
    assert f"takes {sum(j**2 + j**3 for j in range(1, n + 1))} traces" in sentence
    assert f"each of its {n * (n + 1) ** 2 * (n + 2) // 6} traces" in sentence


def test_json_is_finite_and_complete(told):
    document = json.loads(json.dumps(told, allow_nan=False))
    assert len(document["curves"]) == len(METHODS)
    assert document["sizes"] == list(range(1, 13))
    assert len(document["torque_differences"]) == len(METHODS) + 1


def test_the_page_shows_the_numbers_and_asks_nothing_of_the_network(swing_comparison, told):
    page = render_comparison_html(swing_comparison)
    text = visible(page)
    for row in told["methods"]:
        assert row["title"] in text
        assert row["explanation"] in text
        assert f"{row['executed']['multiplications']}" in text
        assert f"{1e6 * row['seconds']:.2f}" in text
    assert not re.search(r"(?:src|href)=\"(?!#)", page)
    # The one address is the SVG namespace, which is a name and is never fetched.
    assert set(re.findall(r"https?://[^\"'\s)]+", page)) <= {"http://www.w3.org/2000/svg"}
    assert "odd" in text


def test_names_from_files_are_only_text(swing_comparison):
    arm = dataclasses.replace(swing_comparison.arm, title="<script>alert(1)</script>")
    hostile = dataclasses.replace(swing_comparison, arm=arm, warnings=("<b>",))
    assert "<script>alert" not in render_comparison_html(hostile)


def test_the_chart_draws_every_curve_and_the_text(grown):
    chart = growth_chart(grown, "executed", PAPER)
    stated = sum(bool(grown.counts(name, "text")) for name in METHODS)
    assert chart.count("<polyline") == len(METHODS) + stated
    assert chart.count("stroke-dasharray") == stated
    for name, method in METHODS.items():
        assert f"{method.short}, n = 12: {grown.costs[name][-1].executed.total} operations" in chart
    labels = [float(y) for y in re.findall(r'<text x="\d+" y="([\d.]+)" style="[^"]*font-weight', chart)]
    assert len(labels) == len(METHODS)
    # Labels of 10.5 px letters stand clear of each other.
    assert min(b - a for a, b in pairwise(labels)) > 11.9


def test_the_pdf_is_the_same_every_time_and_holds_the_numbers(swing_comparison, told, tmp_path):
    pdf = render_comparison_pdf(swing_comparison)
    assert pdf == render_comparison_pdf(swing_comparison)
    program = shutil.which("pdftotext")
    if program is None:
        pytest.skip("pdftotext (poppler-utils) is not installed")
    (tmp_path / "c.pdf").write_bytes(pdf)
    done = subprocess.run(
        [program, "-layout", str(tmp_path / "c.pdf"), "-"], capture_output=True, check=True, text=True
    )
    for row in told["methods"]:
        assert row["title"] in done.stdout
        assert str(row["executed"]["multiplications"]) in done.stdout
        assert str(row["folded"]["additions"]) in done.stdout
        assert f"{1e6 * row['seconds']:.2f}" in done.stdout


def test_only_the_files_asked_for_are_written(swing_comparison, tmp_path):
    write_comparison(swing_comparison, tmp_path / "r", ("json",))
    assert [path.name for path in (tmp_path / "r").iterdir()] == [FILES["json"]]
    with pytest.raises(UsageError, match="no format 'csv'"):
        write_comparison(swing_comparison, tmp_path / "r", ("csv",))
