"""Operations counted in the text that was printed are those that are claimed, in every language."""

from __future__ import annotations

import re

import pytest
from exported_cases import CASES, TORQUES, subject

from gd_analyze.exporting import printed
from gd_analyze.operations import OperationCount

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
        assert counted(body) == function.count, function.name


@pytest.mark.parametrize("case", TORQUES)
def test_many_at_once_take_as_many_each(case):
    what = subject(case)
    text = printed(what, "c").files[f"{what.name}.c"]
    loop = r"^        for \(l = 0; l < lanes; l\+\+\) \{(.*?)^        \}"
    loops = re.findall(loop, text, re.DOTALL | re.MULTILINE)
    claimed = what.torque.count
    found = counted("".join(loops))
    assert (found.multiplications, found.additions) == (claimed.multiplications, claimed.additions)
    # Sine and cosine of an angle are taken together, and before.
    pairs = len(re.findall(r"^        sines_cosines\(", text, re.MULTILINE))
    assert claimed.sines_cosines / 2 <= pairs <= claimed.sines_cosines
    assert not found.sines_cosines


@pytest.mark.parametrize("case", ["two_link energy", "puma560"])
def test_the_count_is_told_on_top(case):
    what = subject(case)
    for language in ("c", *BODIES):
        text = next(iter(printed(what, language).files.values()))
        for function in what.functions:
            assert f"{function.name}: {function.meaning};" in text
            assert str(function.count) in text
    assert f"{what.torque.count.total} " in printed(what, "latex").files[f"{what.name}.tex"]
