"""Words and numbers as people and other languages read them, one case each that has gone wrong or could."""

from __future__ import annotations

import ast
import math
import re
from pathlib import Path

import pytest

import gd_analyze
from gd_analyze.exporting.export_input import Constant, up
from gd_analyze.exporting.language import Language
from gd_analyze.exporting.latex import Latex
from gd_analyze.exporting.names import identifier, identifiers
from gd_analyze.formulas.languages import rounded
from gd_analyze.harmonics.terms import Factor, TorqueTerm, Velocity
from gd_analyze.report.budget import budget_words
from gd_analyze.schema import quantity_units, unit_of
from gd_analyze.text import parted, short_name, short_names, to_digits_of, with_error

# A prismatic joint's variable, times an acceleration of the first.
SLIDING = TorqueTerm(0, (Velocity(2, 1),), (Factor("power", (0, 1)),))


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (with_error(15.4512, 0.3811), "15.45 ± 0.38"),
        (with_error(-2043.0, 120.0), "-2040 ± 120"),
        (with_error(0.0, math.nan), "0"),
        (to_digits_of(-8.123e-5, 9.4e-4), "-0.00008"),
        ([parted(*x) for x in (("12", 10, {2}), ("1,10", 10, {2}), ("10", 9, {1}))], [(0, 1), (0, 9), None]),
        (short_name("left_gripper_extension_joint_r", 16), "left_gri…joint_r"),
        (unit_of("inertia", True, False), "kg m"),
        (quantity_units("inertia", [True, False]).tolist(), [["kg m^2", "kg m"], ["kg m", "kg"]]),
        (
            [*map(identifier, ("Überarm 3000*/", "double", "7-bot", "腕"))],
            ["Uberarm_3000", "arm_double", "arm_7_bot", "arm"],
        ),
        (identifiers(["a b", "A-b", "a_b_2", ""]), ("a_b", "A_b_2", "a_b_2_2", "joint")),
        ([*map(up, (0.1, -2.3, 0.12345678))], [0.1, -2.3, 0.123457]),
        (Latex().tex("50% of \\input{x}"), "50\\% of \\textless{}U+5C\\textgreater{}input\\{x\\}"),
        (Language().foreign('arm */ int x; "??/'), "arm <U+2A>/ int x; <U+22><U+3F><U+3F>/"),
        (budget_words("1% or 10% friction"), "1 % of peak torque or 10 % of friction"),
        (SLIDING.weight_unit([True, False]), "kg"),
        ([rounded(x, 2) for x in (0.0712, 1234.0, 5.85e-5)], [("0.071", 0), ("1200", 0), ("5.8", -5)]),
    ],
)
def test_words(found, expected):
    assert found == expected


@pytest.mark.parametrize("towards", [math.inf, -math.inf])
def test_bounds_in_single_precision_are_on_the_safe_side(towards):
    """0.1 is no number of single precision; 0.5 is."""
    tenth, half = Constant("a bound", [0.1, 0.5], towards).in_single.values
    assert half == 0.5
    assert (tenth > 0.1) == (towards > 0)
    assert abs(tenth - 0.1) < 1e-8


@pytest.mark.parametrize(
    ("names", "short"),
    [
        (["panda_joint1", "panda_joint2"], ["joint1", "joint2"]),
        (["left_arm_joint_1", "left_arm_joint_2"], ["joint_1", "joint_2"]),  # not "1 1"
        (["ur/shoulder_pan", "ur/shoulder_lift"], ["pan", "lift"]),
        (["joint_1", "joint_2"], ["joint_1", "joint_2"]),
        (["arm_a", "arm_a_b"], ["a", "a_b"]),
        (["a_", "a_b"], ["a_", "a_b"]),  # nothing would be left
        (["shoulder", "elbow"], ["shoulder", "elbow"]),
        (["arm_one"], ["arm_one"]),
        ([], []),
    ],
)
def test_names_without_the_words_that_all_share(names, short):
    assert short_names(names) == short


def test_errors_of_the_library_advise_arguments():
    """A terminal shows them as options; whole commands are commands everywhere."""
    advice = []
    for path in Path(gd_analyze.__file__).parent.rglob("*.py"):
        if "cli" not in path.parts:
            raised = [
                node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Raise)
            ]
            texts = [ast.unparse(part) for node in raised for part in ast.walk(node) if is_text(part)]
            advice += [re.sub("`gd-analyze [^`]*`", "", text) for text in texts]
    assert len(advice) > 500
    assert [text for text in advice if re.search("--[a-z]", text)] == []


def is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
