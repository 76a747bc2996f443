"""docs/notation.md against the code: every name exists, with that shape and unit, and none is left out."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
from markdown_pages import ROOT, code, tables

import gd_analyze as gd
from gd_analyze import load_arm
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.kinematics import Kinematics, solve_kinematics
from gd_analyze.dynamics.regrouping import PARAMETER_KINDS
from gd_analyze.schema import GROUPS

PAGE = ROOT / "docs" / "notation.md"
ALONG = {code(row["name"]): row for row in tables(PAGE, "Quantities along a trajectory")}
GEOMETRY = {code(row["name"]): row for row in tables(PAGE, "Geometry at every set point")}
ARM = {code(row["name"]): row for row in tables(PAGE, "The arm")}


def shape(text: str, sizes: dict[str, int]) -> tuple[int, ...]:
    names = [name.strip() for name in text.strip("()").split(",") if name.strip()]
    return tuple(sizes[name] if name in sizes else int(name) for name in names)


def test_the_variables_are_those_of_the_schema():
    assert list(ALONG) == list(GROUPS["decomposition"])
    for name, row in ALONG.items():
        declared = GROUPS["decomposition"][name]
        assert tuple(row["dimensions"].split(", ")) == declared.dims
        assert row["unit"] == declared.attributes([True])["units"]
        assert re.findall(r"\(3\.4-\d+\)", row["equation"]) == re.findall(r"\(3\.4-\d+\)", declared.equation)
    assert all(f"`{effect}`" in PAGE.read_text(encoding="utf-8") for effect in EFFECTS)


def test_shapes_of_geometry_and_arm():
    own = {field.name for field in dataclasses.fields(Kinematics)}
    own |= {name for name, value in vars(Kinematics).items() if isinstance(value, property)}
    assert set(GEOMETRY) == own
    arm, sizes = load_arm("puma560"), {"n": 6, "N": 5}
    solved = solve_kinematics(arm, np.zeros((6, 5)))
    for value, rows in ((solved, GEOMETRY), (arm, ARM)):
        for name, row in rows.items():
            assert np.shape(getattr(value, name)) == shape(row["shape"], sizes), name


def test_base_parameters_and_their_kinds():
    names = [code(row["name"]) for row in tables(PAGE, "Base parameters")]
    assert names == [field.name for field in dataclasses.fields(gd.types.BaseParameter)]
    section = PAGE.read_text(encoding="utf-8").partition("## Base parameters")[2].partition("## ")[0]
    names_of_kinds = re.findall(r"`(\w+)`", section.partition("Kinds are")[2].partition(":")[0])
    assert names_of_kinds == list(PARAMETER_KINDS)
