"""Reports tell errors in the terms of the budget, and notice a budget below friction."""

from __future__ import annotations

import json

import pytest

import gd_analyze as gd
from gd_analyze.report.document import document
from gd_analyze.report.figure_trade_off import trade_off_figure
from gd_analyze.report.html import render_html
from gd_analyze.report.interactive import _trade_off


@pytest.fixture(scope="module")
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
        own = 100 * findings.model.promise.shares.max()
        assert drawn["model"]["x"] == pytest.approx(own, rel=1e-3)
        assert document(findings)["trade_off"]["shares_of"] == told
        assert f"in percent of the {told}, by budget" in render_html(findings)


def test_the_errors_to_drag_are_shares_of_the_same(in_torque):
    page = render_html(in_torque)
    assert '"shares_of":"allowed error"' in page.replace('": ', '":')
    assert json.dumps(in_torque.model.promise.allowed.tolist()[0]) in page
    assert "largest error,<br>of allowed error" in page
