"""README's figures are those of the pages that scripts write."""

from __future__ import annotations

import re

from markdown_pages import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")


def cells(page: str, *first: str) -> list[list[str]]:
    """Cells of the tables' rows that start with these."""
    lines = (ROOT / page).read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return [row for row in rows if row[: len(first)] == list(first)]


def said(*patterns: str) -> list[str]:
    """What README says where patterns match, once each."""
    found = [re.findall(pattern, " ".join(README.split())) for pattern in patterns]
    assert all(len(matches) == 1 for matches in found), found
    return [matches[0] for matches in found]


def test_operations_are_those_of_the_tables() -> None:
    apart, within, certified = said(
        r"of the PUMA 560 take (\d+) operations",
        r"within the limits: (\d+) operations, up to (0\.\d+) % found",
        r"PUMA's model takes (\d+) operations",
    )
    page = "docs/simplification.md"
    assert cells(page, "puma560 near pick-and-place", "term")[0][2] == apart
    row = cells(page, "puma560", "term")[0]
    assert (row[4].split()[0], row[5]) == within
    assert cells(page, "drives, `term --certified`")[0][2] == certified


def test_the_real_robot_is_that_of_the_study() -> None:
    ((share, joint),) = said(r"seen, ([\d.]+) % is left at joint (\d)")
    ((file, measured),) = said(r"file alone leaves ([\d.]+) of ([\d.]+) N m")
    column = 2 + int(joint)
    rows = {
        row[2]: row[column]
        for row in cells(
            "analysis/identified_robots.md", "ur-20_02_19_14harm50sec", "ur-20_02_12-40sec_12harm"
        )
    }
    assert rows["identified, of measured"] == f"{share} %"
    assert (rows["left by the file"], rows["measured"]) == (file, measured)


def test_the_chains_are_those_of_the_study() -> None:
    ((chains, refused),) = said(r"\[(\d+) chains of published robots\]\S+ were tried; (\d+) were refused")
    page = (ROOT / "analysis" / "arms_as_published.md").read_text(encoding="utf-8")
    assert f": {chains} chains" in page
    assert f"{refused} of these refused or given up" in page


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 120
