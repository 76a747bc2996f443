"""Tests written beside an export: they pass where it lands, and fail where a number of it was changed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from exported_cases import subject
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import OF_PARAMETERS
from long_cases import long
from running import STRICT, called, needs, needs_gcc, needs_gpp

CASES = ("two_link term", "two_link further", "stanford decomposition")
MATLAB = ("octave", "--no-gui", "--no-init-file", "--quiet")
SOURCES = {"c": ".c", "cpp": ".hpp", "python": ".py", "matlab": ".m"}
# Where the values of a function stand that its test expects.
WANTED = {"c": "of_{}[states]", "python": '"{}": (', "matlab": "wanted.{} = ["}
BUILT = {
    "c": ("gcc", "-std=c99", *STRICT, "{}_test.c", "{}.c", "-lm", "-o", "run"),
    "cpp": ("g++", "-std=c++11", *STRICT, "{}_test.cpp", "-o", "run"),
}


def passes(language: str, name: str, folder: Path) -> bool:
    """Build what is to be built, and run the test."""
    if language in BUILT:
        called(*(word.format(name) for word in BUILT[language]), folder=folder)
        command = ["./run"]
    elif language == "python":
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"test_{name}.py"]
    else:
        command = [*MATLAB, "--eval", f"{name}_test"]
    return subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize("case", [CASES[0], *map(long, CASES[1:])])
@pytest.mark.parametrize(
    "language",
    [
        pytest.param("c", marks=needs_gcc),
        pytest.param("cpp", marks=needs_gpp),
        pytest.param("python", marks=pytest.mark.slow),
        pytest.param("matlab", marks=needs("octave")),
    ],
)
def test_a_changed_number_is_noticed(language, case, tmp_path):
    """Coefficients of functions, one after the other, are off by a thousandth."""
    what = subject(case)
    written(what, language, tests=True).save(tmp_path)
    assert passes(language, what.name, tmp_path)
    path = tmp_path / f"{what.name}{SOURCES[language]}"
    text = path.read_text()
    # Numbers that stand in a product, with digits that a coefficient has.
    places = [match.span(1) for match in re.finditer(r"= (?:T\()?(\d+\.\d{3,}(?:e-?\d+)?)\)? \.?\*", text)]
    assert places
    few = 2 if language == "python" else 4  # pytest starts anew for each
    for begin, end in places[:: max(len(places) // few, 1)]:
        path.write_text(text[:begin] + repr(1.001 * float(text[begin:end])) + text[end:])
        assert not passes(language, what.name, tmp_path), text[begin - 30 : end + 20]


@pytest.mark.parametrize(
    "language",
    [
        pytest.param("c", marks=needs_gcc),
        pytest.param("python", marks=pytest.mark.slow),
        pytest.param("matlab", marks=needs("octave")),
    ],
)
@pytest.mark.parametrize("case", [long("two_link"), "two_link term"])
def test_regressor_and_parameters_pass_their_own_test(language, case, tmp_path):
    """Of exact dynamics and of a model; a wrong expected number of either function is noticed."""
    what = subject(case).with_functions(OF_PARAMETERS)
    written(what, language, tests=True).save(tmp_path)
    assert passes(language, what.name, tmp_path)
    (path,) = (path for path in tmp_path.iterdir() if "test" in path.stem)
    text, numbers = path.read_text(), re.compile(r"\d+\.\d{3,}")
    for name in ("regressor", "torque_of_parameters"):
        begin = text.index(WANTED[language].format(name))
        wrong = numbers.sub(lambda number: repr(1.001 * float(number[0]) + 1.0), text[begin:], count=1)
        path.write_text(text[:begin] + wrong)
        assert not passes(language, what.name, tmp_path), name


@needs_gcc
@needs("cmake")
def test_cmake_builds_a_library_that_others_find(tmp_path):
    what = subject("two_link term")
    written(what, ["c", "cpp"], tests=True).save(tmp_path / "source")
    called("cmake", "-S", "source", "-B", "build", folder=tmp_path)
    called("cmake", "--build", "build", folder=tmp_path)
    called("ctest", "--test-dir", "build", folder=tmp_path)
    called("cmake", "--install", "build", "--prefix", "there", folder=tmp_path)
    user = tmp_path / "user"
    user.mkdir()
    (user / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.15)\nproject(user C)\n"
        f"find_package({what.name} REQUIRED)\nadd_executable(user main.c)\n"
        f"target_link_libraries(user {what.name})\n"
    )
    (user / "main.c").write_text(
        f"#include <{what.name}.h>\nint main(void) {{ double q[2] = {{0}}, c[2];\n"
        f"{what.name}_gravity_loading(q, c); return c[0] < 0; }}\n"
    )
    there = tmp_path / "there"
    called("cmake", "-S", "user", "-B", "used", f"-DCMAKE_PREFIX_PATH={there}", folder=tmp_path)
    called("cmake", "--build", "used", folder=tmp_path)
    called("./used/user", folder=tmp_path)


@needs_gcc
def test_single_precision_passes_its_own_test(tmp_path):
    what = subject("two_link further")
    written(what, "c", "float", tests=True).save(tmp_path)
    assert passes("c", what.name, tmp_path)


def test_languages_without_a_test_have_none():
    assert "CMakeLists.txt" not in written(subject("two_link"), ["latex", "jax"], tests=True).files
