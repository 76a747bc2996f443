"""Figures of README and pages are those of analysis/claims.md; those of the first page are computed anew."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest
from markdown_pages import ROOT

claims: Any = import_module("claims")
CLAIMS = claims.claims()


def test_the_list_has_what_the_pages_state() -> None:
    written = (ROOT / "analysis" / "claims.md").read_text(encoding="utf-8")
    assert claims.report([(claim, claim.stated, claim.stated) for claim in CLAIMS]) == written


@pytest.mark.parametrize(
    "claim", [claim for claim in CLAIMS if claim.page == claims.MINUTES], ids=lambda claim: claim.words
)
def test_the_three_minutes_are_those_of_the_run(claim: Any) -> None:
    assert claim.found == claim.stated


@pytest.mark.slow
@pytest.mark.parametrize(
    "claim", [claim for claim in CLAIMS if claim.page != claims.MINUTES], ids=lambda claim: claim.words
)
def test_the_others_are_those_of_their_commands(claim: Any) -> None:
    assert claim.found == claim.stated


def test_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120
