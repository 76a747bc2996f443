"""Versions stand in several files; they agree."""

from __future__ import annotations

import re
import tomllib

import yaml
from markdown_pages import ROOT, tables

import gd_analyze as gd
from gd_analyze.schema import SCHEMA_VERSION
from gd_analyze.simplification.model_file import VERSION


def test_the_changelog_and_the_citation_are_of_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version, date = re.findall(r"^## (\d\S*) - (\S+)$", text, re.MULTILINE)[0]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert version == citation["version"] == gd.__version__
    assert date == str(citation["date-released"])


def test_the_policy_states_the_versions_of_files() -> None:
    promises = {
        row[""]: row["promise"] for row in tables(ROOT / "docs" / "stability.md", "What stays stable")
    }
    assert f"now {VERSION}." in promises["`model.json`"]
    assert f"now {SCHEMA_VERSION}." in promises["`analysis.h5`"]


def test_the_extras_of_the_install_page_exist() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    rows = tables(ROOT / "docs" / "install.md", "Install")
    named = {re.findall(r"\[(\w+)\]", row["extra"])[0] for row in rows}
    assert named == set(extras["optional-dependencies"]) - {"test"}
