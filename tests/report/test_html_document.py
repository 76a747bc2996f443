"""The page as a document: whole, closed to the network, in two depths, safe from names."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import pytest
from page_reader import Page
from report_arms import swing

from few_tries import few_tries
from gd_analyze.figures.colours import COLOURS
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.report.interactive import page_data
from gd_analyze.report.main_page import SHORT_TITLES, render_html
from gd_analyze.report.old_numbering import numbering
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.main_job import Settings, find

HOSTILE = '</script><script>alert(1)</script><b title="'


def test_the_document_is_whole(source: str, page: Page) -> None:
    assert source.startswith("<!doctype html>")
    assert source.rstrip().endswith("</html>")
    assert len(page.all("h1")) == 1
    assert page.headings_go_down_by_one


def test_nothing_is_asked_of_the_network(page: Page) -> None:
    loading = {"src", "srcset", "poster", "data", "action", "background", "xlink:href"}
    assert not [(tag, a) for tag, a in page.elements if loading & a.keys()]
    assert not page.all("link")
    assert all(a["href"].startswith("#") for a in page.all("a"))
    assert not re.search(r"url\(|@import", "".join(page.styles))
    policy = next(a["content"] for a in page.all("meta") if "http-equiv" in a)
    assert "default-src 'none'" in policy
    assert "http" not in policy


def test_links_lead_to_sections(page: Page) -> None:
    counted = Counter(page.identifiers)
    assert {a["href"][1:] for a in page.all("a")} <= counted.keys()
    assert max(counted.values()) == 1


def test_the_answer_comes_first(puma_findings: Findings, page: Page) -> None:
    headline = summary.headline(puma_findings)
    assert headline in page.text
    assert page.text.index(headline) < page.text.index("What makes the torque of each joint")
    for value, caption in summary.facts(puma_findings):
        assert value in page.text
        assert caption in page.text


def test_tables_have_captions_and_buttons_names(source: str, page: Page) -> None:
    assert len(page.all("table")) == len(page.all("caption")) > 5
    for attributes in page.all("div"):
        if attributes.get("role") == "group":
            assert attributes["aria-label"]
    assert all(a.get("type") == "button" for a in page.all("button"))
    assert '<button type="button" id="theme" aria-label=' in source


def test_text_verdicts_stand_beside_ours_for_the_texts_arm_only(
    page: Page, arms: dict[str, RobotArm]
) -> None:
    assert "Beside the founding text's verdicts" in page.text
    assert "VAX-11/780" in page.text
    other = Page(render_html(find(arms["sliding"], swing(arms["sliding"]))))
    assert "Beside the founding text's verdicts" not in other.text
    assert "Fig 3.10" not in other.text


def test_names_cannot_become_markup(puma_findings: Findings) -> None:
    arm = puma_findings.arm
    joints = (replace(arm.joints[0], name=HOSTILE), *arm.joints[1:])
    hostile = replace(
        puma_findings,
        arm=replace(arm, title=HOSTILE, joints=joints, sources=(HOSTILE,)),
        trajectory=replace(puma_findings.trajectory, name=HOSTILE, origin=HOSTILE),
        warnings=(HOSTILE,),
        provenance={"command": HOSTILE},
    )
    harmless, attacked = Page(render_html(puma_findings)), Page(render_html(hostile))
    assert "<script>alert" not in render_html(hostile)
    assert len(attacked.all("script")) == len(harmless.all("script"))
    assert len(attacked.all("b")) == len(harmless.all("b"))
    assert HOSTILE in attacked.text
    # As text in the data: the script writes it into the page as text, which the browser's tests watch.
    assert attacked.data["viewer"]["joints"][0]["name"] == HOSTILE


def test_warnings_are_prominent(puma_findings: Findings, page: Page) -> None:
    assert not page.of_class("details", "warnings")
    warned = Page(render_html(replace(puma_findings, warnings=("joint 2 leaves its range", "and again"))))
    assert ["open" in a for a in warned.of_class("details", "warnings")] == [True]
    assert warned.text.index("joint 2 leaves its range") < warned.text.index("What makes the torque")


@pytest.mark.parametrize("level", ["element", "energy"])
@pytest.mark.parametrize("which", ["sliding", "puma560"])
@few_tries()
def test_every_level_has_its_page(arms: dict[str, RobotArm], which: str, level: str) -> None:
    arm = arms.get(which) or load_arm(which)
    findings = find(arm, swing(arm), Settings(level=level))
    page = Page(render_html(findings))
    harmonic = level != "element"
    assert ("elements" in page.identifiers) == harmonic
    assert ("No certificate at this level" in page.text) == findings.tables["beyond"].certified.isnull().all()
    assert bool(page.of_class("td", "tally-cell")) == harmonic
    assert page.headings_go_down_by_one


def test_all_colours_stand_in_one_table(source: str) -> None:
    """A colour said anywhere else would be one that page and paper do not share."""
    for path in TEMPLATES.parent.rglob("*"):
        if path.suffix in (".py", ".css", ".js", ".typ", ".j2"):
            assert not re.search(r"#[0-9a-fA-F]{6}\b", path.read_text(encoding="utf-8")), path.name
    for name, (light, dark) in COLOURS.items():
        assert f"--{name}: light-dark({light}, {dark});" in source


def test_all_but_the_answer_is_folded_into_lettered_appendices(puma_findings: Findings, page: Page) -> None:
    numbers = numbering(puma_findings)
    folds = page.of_class("details", "appendix")
    assert [a["id"] for a in folds] == list(numbers["appendices"])
    assert not any("open" in a for a in folds)
    assert set(numbers["appendices"]) <= SHORT_TITLES.keys()
    for name, letter in numbers["appendices"].items():
        assert f"{letter} {numbers['titles'][name]}" in re.sub(r"\s+", " ", page.text)
    assert {f"#{name}" for name in numbers["appendices"]} <= {a["href"] for a in page.all("a")}
    assert page.text.index("all of it") < page.text.index("Appendices")


def test_every_number_stands_at_one_figure_or_table(puma_findings: Findings, page: Page) -> None:
    numbers = numbering(puma_findings)
    for number in (*numbers["figures"].values(), *numbers["tables"].values()):
        assert page.text.count(f"{number}.") == 1


def test_a_page_is_light(source: str) -> None:
    """Scripts and styles are some 80 kB, and the figures of six joints at 31 set points not much more."""
    assert len(source.encode()) < 700_000
    assert "plotly" not in source.lower()


def test_a_joints_name_is_data(two_link: RobotArm) -> None:
    name = '<a href="https://example.com">R&D</a>'
    arm = replace(two_link, joints=(replace(two_link.joints[0], name=name), *two_link.joints[1:]))
    findings = find(arm, read_trajectory("two-link-swing", arm))
    labels = [
        trace["label"] for figure in page_data(findings)["figures"].values() for trace in figure["traces"]
    ]
    assert f"1 {name}" in labels
    assert '<a href="https://example.com' not in render_html(findings)
