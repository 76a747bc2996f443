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
    Table,
    Value,
    joint_values,
    plain,
    value_text,
    values_of_parts,
)
from gd_analyze.schema import declared_columns, declared_table

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
    values = joint_values(gd.load_arm("two_link").joints)
    values |= {"peak_torque": np.array([5.0, math.nan]), "largest_share": [0.5, math.inf]}
    names = ["joint", "peak_torque", "largest_share"]
    table = declared_table("simplified_model", "joints", "Torques", values, names)
    mixed = Column("force", [1.0, 2.0], ["N", "N m"])
    other = Table(None, "Only for people", (mixed, Column("term", ["a", "b"], shown="text")), top=1)
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
    columns = (
        Column("joint", [1, 2, 3], shown="count"),
        Column("largest torque", [1.5, 2.5, 3.5], "N m"),
        Column("verdict", said, "", "text"),
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
    columns = (Column("column", names, "", "text"), Column("reason", said, "", "text"))
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
        "joint": 1, "joint_name": "shoulder", "effort_unit": "N m", "peak_torque": 5.0, "largest_share": 0.5,
    }  # fmt: skip
    assert document["joints"][1]["peak_torque"] is document["joints"][1]["largest_share"] is None
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
        (Column, ("",)),
        (Table, ("", "title")),
        (Section, ("", "title")),
        (Equations, ("", "title")),
    ],
)
def test_every_part_has_the_names_that_its_class_takes(part, names):
    with pytest.raises(ValueError, match="has no"):
        part(*names, "x")


def test_json_and_people_see_their_own(result):
    table, other, *_ = result.parts
    assert values_of_parts([table, other]) == {"joints": table.rows()}
    assert [column.label for column, _, _ in table.shown()] == ["joint", "peak", "of peak"]
    assert values_of_parts([Shown("a", "b"), Fact("error", "Error", 1.0)]) == {"error": 1.0}


def test_pages_may_show_more_columns_than_a_terminal():
    values = {"rank": [1], "element": ["D12"], "verdict": ["both"], "rms": [0.5]}
    seen = {"verdict": ["B"]}
    table = declared_table(
        "dominance", "ranking", "", values, ["element", "verdict"], [*values][:3], seen=seen
    )
    assert table.rows() == [{"rank": 1, "element": "D12", "verdict": "both", "rms": 0.5}]
    shown = [(column.key, column.pages_only, cells) for column, _, cells in table.shown()]
    assert shown == [("rank", True, ["1"]), ("element", False, ["D12"]), ("verdict", False, ["B"])]


def test_a_heading_takes_a_word_or_the_label_of_a_second_dimension():
    values = {"part_peak_rotation": [1.0], "change_without_rotation": [0.5], "unit": ["kg m^2"]}
    names = ["part_peak_rotation", "change_without_rotation"]
    peak, change = declared_columns("dominance", values, names, words={names[1]: "R"})
    assert (peak.label, peak.unit, change.label, change.shown) == (
        "rotation",
        ["kg m^2"],
        "without R",
        "percent",
    )


def test_a_column_that_nobody_declares_is_an_error():
    with pytest.raises(LookupError, match="bogus in the group dominance"):
        declared_columns("dominance", {"bogus": [1.0]}, ["bogus"])
