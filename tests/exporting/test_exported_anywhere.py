"""C on a bare machine, and arms of which hardly anything is left: no mass, no angle, one joint."""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from compiled import STRICT, called, needs_gcc, needs_gpp, run_c
from exported_cases import subject
from rounded_programs import assert_same
from test_exported_python import imported

from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.simplification.exact_form import ExactForm
from strategies import random_states

CASES = ("two_link energy", "puma560", "stanford decomposition")
SCALARS = ("double", "float")
# What the generated code calls, and what a compiler may put in for a loop that copies or a sum of both.
LIBM = {"sin", "cos", "fabs", "sincos"}
COPIES = {"memcpy", "memset", "memmove"}


def sources(tmp_path, scalar):
    for case in CASES:
        what = subject(case)
        written(what, "c", scalar).save(tmp_path)
        yield tmp_path / f"{what.name}.c"


@needs_gcc
@pytest.mark.skipif(shutil.which("nm") is None, reason="nm is not installed")
@pytest.mark.parametrize(("scalar", "level"), [("double", "-O0"), ("float", "-O2")])
def test_c_needs_sines_and_nothing_else(scalar, level, tmp_path):
    suffix = "f" if scalar == "float" else ""
    for source in sources(tmp_path, scalar):
        texts = source.read_text() + source.with_suffix(".h").read_text()
        assert set(re.findall(r"#include <(.*)>", texts)) <= {"math.h", "stddef.h"}
        out = source.with_suffix(".o")
        called("gcc", "-std=c99", *STRICT, level, "-ffreestanding", "-c", source, "-o", out)
        needed = {line.split()[-1] for line in called("nm", "-u", out).decode().splitlines()}
        assert needed <= {f"{name}{suffix}" for name in LIBM} | COPIES
        # Nothing is written to but what the caller gives: constants alone, no data of its own.
        kinds = set(re.findall(r"^\w* +(\w) ", called("nm", out).decode(), re.MULTILINE))
        assert kinds <= {"T", "t", "R", "r", "U"}


@needs_gcc
@pytest.mark.parametrize("scalar", SCALARS)
@pytest.mark.parametrize(
    "words",
    [
        ["gcc", "-m32"],
        ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
    ],
    ids=["32 bits", "microcontroller"],
)
def test_c_compiles_for_other_machines(words, scalar, tmp_path):
    if shutil.which(words[0]) is None:
        pytest.skip(f"{words[0]} is not installed")
    given = b"#include <math.h>\n#include <stddef.h>\nint x;\n"
    probe = [*words, "-std=c99", "-x", "c", "-c", "-", "-o", "/dev/null"]
    if subprocess.run(probe, input=given, capture_output=True, check=False).returncode:
        pytest.skip("the headers of the C library for that machine are not installed")
    for source in sources(tmp_path, scalar):
        called(*words, "-std=c99", *STRICT, "-c", source, "-o", source.with_suffix(".o"))


@needs_gcc
def test_single_precision_computes_in_single_precision(tmp_path):
    """Not a number, a sine or a sum in between is a double: `-Wdouble-promotion` would say so."""
    for source in sources(tmp_path, "float"):
        words = ("-Wdouble-promotion", "-Wunsuffixed-float-constants", "-Wfloat-conversion")
        called("gcc", "-std=c99", *STRICT, *words, "-c", source, "-o", source.with_suffix(".o"))


def arm_of(name: str, *kinds: str, mass: float = 1.0) -> RobotArm:
    limits = {"lower": -3.0, "upper": 3.0, "velocity_limit": 3.0, "acceleration_limit": 10.0}
    joints = tuple(Joint(f"j{k}", kind, **limits) for k, kind in enumerate(kinds))
    inertia = np.eye(3) * 0.1 * mass
    links = tuple(Link(f"l{k}", mass, np.zeros(3), inertia) for k in range(len(kinds)))
    return RobotArm(name, joints, links, np.array([0.0, 0.0, -9.81]))


@cache
def odd() -> dict[str, ExportInput]:
    """Dynamics and decomposition of each."""
    arms = (
        arm_of("weightless", "revolute", "prismatic", mass=0.0),
        arm_of("slides", "prismatic", "prismatic"),
        arm_of("spins", "revolute"),
    )
    every = [make(arm) for arm in arms for make in (_exact, ExportInput.of_decomposition)]
    return {what.name: what for what in every}


def _exact(arm: RobotArm) -> ExportInput:
    return ExportInput.of_exact(ExactForm(arm))


@pytest.fixture(params=["weightless", "slides", "spins", "weightless_decomposition", "spins_decomposition"])
def what(request) -> ExportInput:
    return odd()[request.param]


@needs_gcc
def test_odd_arms_in_c(what: ExportInput, tmp_path):
    drawn = random_states(what.n, 40, 2)
    counts = (0, 40) if what.torque else ()
    results, bulk = run_c(what, written(what, "c").files, drawn, tmp_path, "double", counts)
    for function in what.functions:
        assert_same(results[function.name], function.program, drawn)
    for torque in bulk[1:]:
        assert_same(torque, what.torque.program, drawn)


@needs_gpp
def test_odd_arms_in_cpp(tmp_path):
    calls = []
    for what in odd().values():
        written(what, "cpp").save(tmp_path)
        for function in what.functions:
            places = ", ".join(["x"] * (len(function.arguments) + len(function.outputs)))
            calls.append(f"    {what.name}::{function.name}({places});")
    includes = "".join(f'#include "{name}.hpp"\n' for name in odd())
    text = "\n".join([f"{includes}int main()", "{", "    double x[99] = {0};", *calls, "}", ""])
    (tmp_path / "main.cpp").write_text(text)
    called("g++", "-std=c++11", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")


@pytest.mark.parametrize("language", ["python", "casadi"])
def test_odd_arms_in_python(what: ExportInput, language, tmp_path):
    pytest.importorskip({"python": "numpy"}.get(language, language))
    module = imported(what, language, tmp_path)
    drawn = random_states(what.n, 1, 2)
    for function in what.functions:
        given = [getattr(drawn, name)[0] for name in function.arguments]
        results = getattr(module, function.name)(*given)
        listed = results if len(function.outputs) > 1 else [results]
        found = np.concatenate([np.asarray(x).reshape(-1, 1) for x in listed])
        assert_same(found, function.program, drawn)
