"""A `Result` as text and as JSON: units, bounds, unknown values, widths, and names that act on a terminal."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.report.document import result_document
from gd_analyze.report.terminal import text_of
from gd_analyze.result import (
    Column,
    Equations,
    Fact,
    Result,
    Section,
    Shown,
    ShownColumn,
    Table,
    Value,
    ValueColumn,
    for_people,
    joint_columns,
    plain,
    value_text,
    values_of_parts,
)

LONG = "tau1 = " + " + ".join(f"{k}.5 (C2 - S3) p{k}" for k in range(12))


@pytest.mark.parametrize(
    ("value", "unit", "shown", "text"),
    [
        (0.01301, "of peak torque", "bound_percent", "1.4 % of peak torque"),
        (0.00313, "N m", "number", "3.13 mN m"),
        (1.0001, "N m", "bound", "1.01 N m"),
        (2.5, "kg m^2", "number", "2.5 kg m²"),
        (math.nan, "N m", "number", "–"),
        (None, "", "count", "–"),
        ([1, 2], "", "count", "1, 2"),
    ],
)
def test_values_as_a_person_reads_them(value, unit, shown, text):
    assert value_text(value, unit, shown) == text


@pytest.fixture
def result() -> Result:
    joints = gd.load_arm("two_link").joints
    torque = Column("torque", "torque", np.array([5.0, math.nan]), ["N m", "N m"])
    share = Column("share", "of peak", [0.5, math.inf], shown="percent")
    table = Table("joints", "Torques", (*joint_columns(joints), torque, share))
    mixed = ShownColumn("force", [1.0, 2.0], ["N", "N m"])
    other = Table("", "Only for people", (mixed, ShownColumn("term", ["a", "b"], shown="text")), top=1)
    return Result(
        "An arm\x1b[2J",
        headline="72 operations instead of 308.",
        facts=(Fact("error", "Error", 0.01, shown="percent", note="joint 2"), Value("hidden", {"a": [1]})),
        parts=(
            table,
            other,
            Section("more", "More", (Fact("error", "Error", 1.0),)),
            Equations("equations", "Equations", (LONG,)),
        ),
        notices=("Note.",),
    )


def test_as_text(result):
    lines = text_of(result_document(result)).splitlines()
    assert max(map(len, lines)) <= 80
    assert "\x1b" not in "\n".join(lines)
    assert "Error  1 % (joint 2)" in lines
    assert "Only for people (1 of 2)" in lines
    assert "hidden" not in "\n".join(lines)
    row = next(line for line in lines if line.startswith("2 "))
    assert row.split()[-2:] == ["–", "∞"]


def test_long_cells_wrap():
    said = ["follows", "follows roughly; friction leaves 4.8 times the noise of the readings", ""]
    numbers = Column("torque", "largest torque", [1.5, 2.5, 3.5], "N m")
    columns = (
        Column("joint", "joint", [1, 2, 3], shown="count"),
        numbers,
        Column("v", "verdict", said, "", "text"),
    )
    lines = text_of(result_document(Result("Table", parts=(Table("t", "", columns),))), 50).splitlines()
    assert max(map(len, lines)) <= 50
    (row,) = (k for k, line in enumerate(lines) if "2.5" in line)
    assert lines[row - 1].split() == ["1", "1.5", *said[0].split()]
    assert " ".join(lines[row:-1]).split() == ["2", "2.5", *said[1].split()]
    assert lines[-1].split() == ["3", "3.5"]


def test_two_columns_of_long_cells_wrap_and_nothing_of_them_is_lost():
    names = ["/joint_states/shoulder_lift_joint/position", "/joint_states/elbow_joint/velocity"]
    said = ["no unit stated, and none in its name", "by name"]
    columns = (Column("column", "column", names, "", "text"), Column("reason", "reason", said, "", "text"))
    lines = text_of(result_document(Result("Table", parts=(Table("t", "", columns),))), 50).splitlines()
    assert max(map(len, lines)) <= 50
    shown = "".join(line.split("  ")[0] for line in lines[lines.index("") + 3 :])
    assert shown == "".join(names)


def test_a_sum_in_brackets_longer_than_a_line_wraps():
    inner = " - ".join(f"0.{k}23 C2 S{k}" for k in range(9))
    formula = f"h1 = -({inner}) qd1 qd2 + (C2 + S3) qd1 qd3"
    shown = text_of(
        result_document(Result("Model", parts=(Equations("equations", "Equations", (formula,)),)))
    )
    assert max(map(len, shown.splitlines())) <= 80
    assert formula in " ".join(shown.split())


def test_as_json(result):
    document = result.values()
    assert document["joints"][0] == {
        "joint": 1, "joint_name": "shoulder", "effort_unit": "N m", "torque": 5.0, "share": 0.5,
    }  # fmt: skip
    assert document["joints"][1]["torque"] is document["joints"][1]["share"] is None
    assert (document["error"], document["more"], document["hidden"]) == (0.01, {"error": 1.0}, {"a": [1]})
    assert document["notices"] == ["Note."]
    assert plain({"share": math.inf, "rows": [(math.nan, 1.5)]}) == {"share": None, "rows": [[None, 1.5]]}
    with pytest.raises(ValueError, match="error"):
        Result("twice", facts=(Value("error", 1), Value("error", 2))).values()


@pytest.mark.parametrize(
    ("part", "names"),
    [
        (Fact, ("", "label")),
        (Fact, ("key", "")),
        (Value, ("",)),
        (Shown, ("",)),
        (Column, ("", "label")),
        (Column, ("key", "")),
        (ValueColumn, ("",)),
        (ShownColumn, ("",)),
    ],
)
def test_every_part_has_the_names_that_its_class_takes(part, names):
    with pytest.raises(ValueError, match="key or"):
        part(*names, "x")


def test_json_and_people_see_their_own(result):
    assert values_of_parts([result.parts[0]]) == {"joints": result.parts[0].rows()}
    assert values_of_parts([Shown("a", "b"), Fact("error", "Error", 1.0)]) == {"error": 1.0}
    column = for_people(Column("torque", "torque", [1.0], "N m", "bound", "meant"))
    assert column == ShownColumn("torque", [1.0], "N m", "bound", "meant")
