"""Reports tell errors in the terms of the budget, and notice a budget below friction."""

from __future__ import annotations

import json

import pytest

import gd_analyze as gd
from few_tries import few_tries
from gd_analyze.report.document import document
from gd_analyze.report.figure_trade_off import trade_off_figure
from gd_analyze.report.html import render_html
from gd_analyze.report.interactive import _trade_off
from gd_analyze.text import percent_cell


@pytest.fixture(scope="module")
@few_tries()
def in_torque(puma, pick_and_place):
    return gd.find(puma, pick_and_place, gd.Settings(budget="0.5 N m"))


def test_a_budget_below_friction_is_noticed_under_the_facts(puma_findings, in_torque):
    for findings in (puma_findings, in_torque):
        assert findings.model.notice
        assert document(findings)["notice"] == findings.model.notice
        assert findings.model.notice.split("; --budget")[0] in render_html(findings)


def test_the_trade_off_is_in_the_terms_of_the_budget(puma_findings, in_torque):
    for findings, told in ((puma_findings, "peak torque"), (in_torque, "allowed error")):
        assert f"% of the {told}" in trade_off_figure(findings).svg()
        drawn = _trade_off(findings)
        assert drawn["shares_of"] == told
        # Values on the page have four digits.
        own = 100 * findings.model.accuracy.shares.max()
        assert drawn["model"]["x"] == pytest.approx(own, rel=1e-3)
        assert document(findings)["trade_off"]["shares_of"] == told
        assert (
            f"in percent of the {told}{'' if findings is puma_findings else ' under 0.5 N m'}, by budget"
            in render_html(findings)
        )


def test_the_errors_to_drag_are_shares_of_the_same(in_torque):
    page = render_html(in_torque)
    assert '"shares_of":"allowed error"' in page.replace('": ', '":')
    assert json.dumps(in_torque.model.accuracy.allowed.tolist()[0]) in page
    assert "largest error,<br>of allowed error" in page


def test_page_and_paper_never_show_a_bound_smaller_than_it_is_and_show_the_same(puma_findings, in_torque):
    for findings in (puma_findings, in_torque):
        page, whole = render_html(findings), findings.model.accuracy.whole
        bounds = findings.tables["tube"].tube_certified.values
        for bound, row, of in zip(bounds, document(findings)["joints"], whole, strict=True):
            assert f"<b>{row['bound']}</b>" in page
            number, unit = row["bound"].split(" ", 1)
            assert float(number) * {"N m": 1.0, "mN m": 1e-3, "µN m": 1e-6}[unit] >= bound * (1 - 1e-12)
            assert float(row["bound_share"]) >= 100 * bound / of * (1 - 1e-12)


def test_shares_on_paper_are_of_what_the_budget_is_told_in(puma_findings, in_torque):
    for findings, told in ((puma_findings, "peak torque"), (in_torque, "allowed error")):
        shown = document(findings)
        assert shown["shares_of"] == told
        shares = [percent_cell(float(share)) for share in findings.model.accuracy.shares]
        assert [row["sampled_share"] for row in shown["joints"]] == shares
