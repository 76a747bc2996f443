"""Operations counted in the text that was printed are those that are claimed, in every language."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from exported_cases import CASES, TORQUES, subject

from gd_analyze.exporting.export import printed
from gd_analyze.exporting.functions import Function, Result
from gd_analyze.exporting.strides import in_strides
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Trace

# How a function begins and ends; its body is what stands between.
BODIES = {
    "c": r"^void \w+_{}\([^;]*?\)\n\{{(.*?)^\}}",
    "cpp": r"^void {}\([^;]*?\)\n\{{(.*?)^\}}",
    "python": r"^def {}\((.*?)^    return ",
    "jax": r"^def {}\((.*?)^    return ",
    "casadi": r"^def _{}\((.*?)^    return ",
    "matlab": r"^function [^\n]* = \w+_{}\((.*?)^end",
}
SINE = re.compile(r"\b(?:sin|cos|sinf|cosf)\(")


def counted(text: str) -> OperationCount:
    """Binary operators, which stand between spaces, and calls."""
    code = re.sub(r'""".*?"""|^%.*?$', "", text, flags=re.DOTALL | re.MULTILINE)
    return OperationCount(
        len(re.findall(r" \.?\* ", code)), len(re.findall(r" [+-] ", code)), len(SINE.findall(code))
    )


@pytest.mark.parametrize("language", BODIES)
@pytest.mark.parametrize("case", CASES)
def test_what_stands_there_is_what_is_claimed(case, language):
    what = subject(case)
    text = list(printed(what, language).files.values())[-1]
    for function in what.functions:
        flags = re.DOTALL | re.MULTILINE
        # MATLAB's file is a function, too, which calls the others.
        *_, body = re.findall(BODIES[language].format(function.name), text, flags)
        found = counted(body)
        if language == "c":
            found = replace(found, sines_cosines=len(re.findall(r" = (?:co)?sine\[", body)))
        assert found == function.count, function.name


@pytest.mark.parametrize("case", TORQUES)
def test_many_at_once_take_as_many_each_but_for_sines_of_sums(case):
    what = subject(case)
    text = printed(what, "c").files[f"{what.name}.c"]
    (inner,) = re.findall(r"^static void torque_of_lanes\(.*?^\}", text, re.DOTALL | re.MULTILINE)
    # Without the copy at its end, and places in arrays.
    found = counted(re.sub(r"\[[^]]*\]", "", inner.rpartition("    for (j = 0; j < ")[0]))
    claimed = what.torque.count
    angles = {step.arguments[0] for step in what.torque.program.steps if step.operation in ("sin", "cos")}
    from_others = len(angles) - sum(
        each.results[0].size for each in in_strides(what.torque, of_sums=True).angles
    )
    # Sine and cosine of a sum are two products and a sum each; the sum of the angles itself may fall away.
    assert 0 <= found.multiplications - claimed.multiplications <= 4 * from_others
    assert -from_others <= found.additions - claimed.additions <= 2 * from_others
    assert not found.sines_cosines


def test_sines_of_sums_are_taken_from_those_of_the_summands():
    trace = Trace()
    a, b, c = (trace.record("input", f"q{j}") for j in (1, 2, 3))
    outputs = [(a + b).sin(), (c - (a + b)).cos(), b.cos(), c.sin(), a.sin(), (a + a).cos()]
    whole = Function("torque", "", ("q",), (Result("tau", (6,)),), Program.of(trace, outputs))
    strides = in_strides(whole, of_sums=True)
    (angles,) = strides.angles
    assert [each.arguments for each in angles.program.outputs] == [("q1",), ("q2",), ("q3",)]
    q = np.random.default_rng(0).uniform(-9.0, 9.0, (3, 100))
    sines = {f"{f.__name__}{j + 1}": f(q[j]) for f in (np.sin, np.cos) for j in range(3)}
    expected = whole.program.run({f"q{j + 1}": q[j] for j in range(3)})
    # Three sines of at most 1, and angles of up to 27 rad rounded, each to half a unit of 32 eps.
    np.testing.assert_allclose(
        strides.rest.program.run(sines), expected, rtol=0, atol=32 * np.finfo(float).eps
    )


def test_sines_of_sines_come_in_waves():
    trace = Trace()
    q = trace.record("input", "q1")
    outputs = [(q.sin() + q).cos(), (q + 1.0).sin()]
    strides = in_strides(Function("torque", "", ("q",), (Result("tau", (2,)),), Program.of(trace, outputs)))
    assert [each.used for each in strides.angles] == [{"q1"}, {"q1", "sin1"}]
    assert sorted(strides.rest.used) == ["cos2", "sin3"]


@pytest.mark.parametrize("case", ["two_link energy", "puma560"])
def test_the_count_is_told_on_top(case):
    what = subject(case)
    for language in ("c", *BODIES):
        text = next(iter(printed(what, language).files.values()))
        for function in what.functions:
            assert f"{function.name}: {function.meaning};" in text
            assert str(function.count) in text
    assert f"{what.torque.count.total} " in printed(what, "latex").files[f"{what.name}.tex"]
