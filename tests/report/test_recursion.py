"""A model that is a recursion, on the page and on paper: parameters, equations by link, what is left out."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from page_reader import Page
from pdf_reader import read

from changed_recursions import summands_dropped
from few_tries import few_tries
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.report.main_page import render_html
from gd_analyze.report.main_pdf import prepare_pdf
from gd_analyze.report.old_numbering import numbering
from gd_analyze.report.recursion_document import recursion_data, recursion_shown
from gd_analyze.results.findings import Findings
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.studies.main_job import Origin, Settings, find

MATHS = PageMathML()


@pytest.fixture(scope="module")
@few_tries()
def findings() -> Findings:
    arm = load_arm("puma560")
    motion, origin = read_trajectory("wrist-move", arm), Origin("gd-analyze puma560 wrist-move")
    with pytest.MonkeyPatch.context() as patch:
        # This is about what is told of a model, not how it is found.
        patch.setattr("gd_analyze.simplification.pruning.prune", summands_dropped)
        return find(arm, motion, Settings(level="recursive"), origin=origin)


@pytest.fixture(scope="module")
def source(findings: Findings) -> str:
    return render_html(findings)


def test_every_equation_is_on_the_page(findings: Findings, source: str) -> None:
    formulas = RECURSIVE.reading(findings.model.form, findings.model.terms).formulas
    assert len(formulas) > 20
    for formula in formulas:
        assert MATHS.left(formula) in source
        for element in MATHS.elements(formula):
            assert element in source


def test_parameters_and_changes_are_those_of_the_model(findings: Findings, source: str) -> None:
    shown, page = recursion_shown(findings), Page(source)
    assert shown is not None
    cells = [cell for cell in page.of_class("td", "tally-cell") if " of link " in cell["title"]]
    assert len(cells) == len(shown.kinds) * findings.arm.n_joints
    assert sum(cell["title"].split(": ")[-1].startswith("never acts") for cell in cells) == sum(
        not one.places for own in shown.parameters for one in own
    )
    assert f"{shown.changes} changes make a difference" in page.text
    for group in shown.left_out:
        own = [one.quantity for one in group.rows]
        # Those of one quantity stand together.
        assert len(dict.fromkeys(own)) == 1 + sum(a != b for a, b in pairwise(own))


def test_folds_are_links(source: str) -> None:
    folds = Page(source).of_class("details", "link")
    assert len(folds) >= 6
    assert not any("open" in fold for fold in folds)


def test_on_paper(findings: Findings, tmp_path: Path) -> None:
    words = " ".join(read(prepare_pdf(findings)(), tmp_path).split())
    data = recursion_data(findings)
    assert data is not None
    assert "Regrouped parameters of every link" in words
    assert "The model, link by link" in words
    for one in data["steps"]:
        assert f"Link {one['link']}" in words
    # What Typst cannot lay out it prints as its own source.
    assert "sequence(" not in words
    numbers = numbering(findings)["tables"]
    captions = [f"{text}." for text in numbers.values()]
    places = [words.find(caption) for caption in captions]
    assert -1 not in places, dict(zip(captions, places, strict=True))
    assert places == sorted(places)


def test_other_models_have_none_of_it(puma_findings: Findings) -> None:
    assert recursion_shown(puma_findings) is None
    assert recursion_data(puma_findings) is None
    assert not {"parameters", "left_out"} & numbering(puma_findings)["tables"].keys()
