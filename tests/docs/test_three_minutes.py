"""The figures of the first page are those of the run that it shows; what is printed, test_blocks compares."""

from __future__ import annotations

import re

import numpy as np
import pytest
from markdown_pages import ROOT

import gd_analyze as gd
from documented_tables import elbow, table
from gd_analyze.text import number

PAGE = (ROOT / "docs" / "three_minutes.md").read_text(encoding="utf-8")
TEXT = " ".join(PAGE.split())


@pytest.fixture(scope="module")
def findings() -> gd.Findings:
    return gd.analyze("puma560", "pick-and-place", budget="1%")


def stated(pattern: str) -> tuple[str, ...]:
    """What the page says where a pattern matches, which it does once."""
    (match,) = re.finditer(pattern, TEXT)
    return match.groups()


def test_the_parts_are_those_of_the_arm() -> None:
    assert f"<!-- table: elbow -->\n{table(elbow())}" in PAGE


def test_the_verdict_is_that_of_the_run(findings: gd.Findings) -> None:
    changed = findings.dominance.change_without.sel(element="D13", effect="rotation").item()
    assert stated(r"without its rotation it changes by ([\d.]+) % of its peak") == (f"{100 * changed:.1g}",)


def test_the_dropped_term_is_as_large_as_it_says(findings: gd.Findings) -> None:
    coefficient, peak = -0.028241856, np.abs(findings.exact_torque[:, 2]).max()
    (term,) = (
        term
        for term, value in findings.ranked_terms.items()
        if term.row == 2 and value == pytest.approx(coefficient, rel=1e-6) and len(term.monomial) == 3
    )
    torque = np.full(len(findings.trajectory.q), findings.ranked_terms[term])
    for function, multiples in term.monomial:
        torque *= getattr(np, function)(findings.trajectory.q @ np.array(multiples))
    largest = np.abs(torque).max()
    assert stated(r"makes at most ([\d.]+) N m on this motion, ([\d.]+) % of") == (
        number(largest),
        f"{100 * largest / peak:.2g}",
    )


def test_so_many_terms_stay(findings: gd.Findings) -> None:
    assert stated(r"Of (\d+) terms, (\d+) stay") == tuple(map(str, reversed(findings.model.size)))


def test_readme_states_the_proven_error() -> None:
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    (share,) = re.findall(r"an error proven to be at most ([\d.]+) % of peak torque", readme)
    assert stated(r"3 elbow .* ([\d.]+) % ```") == (share,)
