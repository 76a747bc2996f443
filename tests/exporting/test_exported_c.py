"""C: bare machines, single precision, sines of its own, many states at once, and the box of a certificate."""

from __future__ import annotations

import ctypes
import math
import platform
import re
import shutil
import subprocess

import mpmath
import numpy as np
import pytest

import gd_analyze as gd
from exported_cases import states, subject
from gd_analyze.exporting.export import written
from gd_analyze.operations.program import program_inputs
from long_cases import long
from rounded_programs import evaluated
from running import COMPILERS, STRICT, called, needs, needs_gcc, needs_gpp, run_compiled

pytestmark = needs_gcc
# What the generated code calls, and what a compiler may put in for a loop that copies or a sum of both.
LIBM = {"sin", "cos", "fabs", "sincos"}
COPIES = {"memcpy", "memset", "memmove"}


def sources(tmp_path, scalar):
    for case in ("two_link energy", "puma560", "two_link decomposition"):
        what = subject(case)
        written(what, "c", scalar).save(tmp_path)
        yield tmp_path / f"{what.name}.c"


@needs("nm")
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


def test_single_precision_computes_in_single_precision(tmp_path):
    """Not a number, a sine or a sum in between is a double: `-Wdouble-promotion` would say so."""
    for source in sources(tmp_path, "float"):
        words = ("-Wdouble-promotion", "-Wunsuffixed-float-constants", "-Wfloat-conversion")
        called("gcc", "-std=c99", *STRICT, *words, "-c", source, "-o", source.with_suffix(".o"))


@pytest.mark.parametrize("case", ["two_link", "puma560 program", long("stanford energy")])
def test_single_precision_errs_no_more_than_its_header_says(case, tmp_path):
    what, drawn = subject(case), states(case)
    results, (bulk,) = run_compiled(what, "c", drawn, tmp_path, "float", (1000,))
    exact, _ = evaluated(what.torque.program, drawn)
    text = (
        (tmp_path / f"{what.name}.h").read_text().partition("adds a torque error")[2].partition("at most ")[2]
    )
    stated = [float(word) for word in text.partition(" (joint")[0].split(", ")]
    for found in (results["torque"], bulk):
        measured = np.abs(found - exact).max(axis=1)
        assert (measured <= stated).all()
        # It says no more than it has to: the largest of other states is not many times less.
        assert (measured >= np.array(stated) / 20).all()


@pytest.fixture(scope="module", params=["double", "float"])
def library(request, tmp_path_factory):
    """The model with a bound as a library, its scalar and the array's type."""
    folder = tmp_path_factory.mktemp("library")
    written(subject("two_link energy"), "c", request.param).save(folder)
    source, out = folder / "two_link.c", folder / "two_link.so"
    called("gcc", "-std=c99", *STRICT, "-O3", "-shared", "-fPIC", source, "-o", out, "-lm")
    double = request.param == "double"
    kinds = (ctypes.c_double, np.float64) if double else (ctypes.c_float, np.float32)
    return ctypes.CDLL(str(out)), *kinds


def constants(library, name):
    code, number, _ = library
    return np.array((number * 2).in_dll(code, f"two_link_{name}")[:], dtype=float)


def test_the_constants_are_the_certificates_and_never_promise_more(library):
    stated = subject("two_link energy").certificate
    box = stated.box
    promised = {"error_bound": stated.certified, "lower": box.lower, "upper": box.upper}
    promised |= {"velocity": box.velocity, "acceleration": box.acceleration}
    for name, true in promised.items():
        found, direction = constants(library, name), 1 if name in ("error_bound", "lower") else -1
        assert (direction * found >= direction * true).all(), name
        # Rounded once: bounds to six digits, and to single precision.
        np.testing.assert_allclose(found, true, rtol=1e-5 if name == "error_bound" else 2e-7)
        if library[1] is ctypes.c_double and name != "error_bound":
            np.testing.assert_array_equal(found, true)


def test_a_state_is_within_up_to_the_edges(library):
    code, number, kind = library
    lower, upper, velocity, most = (
        constants(library, x) for x in ("lower", "upper", "velocity", "acceleration")
    )

    def beyond(values, towards):
        return np.nextafter(values.astype(kind), kind(towards)).astype(float)

    nothing = np.zeros(2)
    inside = [(lower, velocity, most), (upper, -velocity, -most), (upper, nothing, nothing)]
    odd = [np.array([0.0, x]) for x in (math.nan, math.inf, -math.inf)]
    fast, faster = beyond(velocity, np.inf), beyond(most, np.inf)
    outside = [
        *((q, nothing, nothing) for q in (beyond(lower, -np.inf), beyond(upper, np.inf) * [0, 1], *odd)),
        *((nothing, qd, nothing) for qd in (fast, -fast, *odd)),
        *((nothing, nothing, qdd) for qdd in (faster, -faster, *odd)),
    ]
    found = [code.two_link_is_within(*((number * 2)(*x) for x in state)) for state in (*inside, *outside)]
    assert found == [1] * len(inside) + [0] * len(outside)


# Two functions of the exported text, which it keeps to itself.
PROBE = """
#include "{source}"
#ifdef __cplusplus
using namespace two_link::inside;
extern "C"
#endif
void sines_cosines(int count, const {scalar} *x, {scalar} *sine, {scalar} *cosine, int *far)
{{
    int k;
    for (k = 0; k < count; k++)
        far[k] = any_far(x + k, 1);
    for (k = 0; k < count; k += block)
        if (!any_far(x + k, block))
            polynomials(x + k, sine + k, cosine + k, block);
}}
"""
# Largest angle of the polynomials, and what they may be off by: docs/decisions/0017-exported-text.md.
REACH = {"double": (1e6, 2.5e-16), "float": (8e3, 1.4e-7)}


@pytest.mark.parametrize("flags", [["-O0"], ["-O3"], ["-O3", "-march=native"]], ids=" ".join)
@pytest.mark.parametrize("scalar", list(REACH))
@pytest.mark.parametrize("language", ["c", "cpp"])
def test_sines_and_cosines_against_more_digits(language, scalar, flags, tmp_path):
    """Around multiples of eighths of a turn, of all sizes, and beyond the polynomials' reach."""
    compiler, standard, main = COMPILERS[language]
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    reach, most = REACH[scalar]
    kind = np.dtype({"double": np.float64, "float": np.float32}[scalar])
    texts = written(subject("two_link"), language, scalar if language == "c" else "double")
    *_, source = texts.save(tmp_path)
    (tmp_path / main).write_text(PROBE.format(source=source.name, scalar=scalar))
    words = ["-shared", "-fPIC", main, "-o", "probe.so", "-lm"]
    called(compiler, standard, *flags, *words, folder=tmp_path)
    random = np.random.default_rng(0)
    eighths = np.concatenate([np.arange(-500, 500), random.integers(-reach, reach, 500)]) * np.pi / 4
    near = np.concatenate(
        [
            eighths,
            eighths + random.normal(0.0, 1e-6, eighths.shape),
            random.uniform(-7.0, 7.0, 2000),
            random.uniform(-reach, reach, 1000),
            10.0 ** random.uniform(-37.0, np.log10(reach), 499),  # so that there are whole blocks
            [reach, -reach, 0.0, -0.0, np.nextafter(kind.type(0), kind.type(1))],
        ]
    ).astype(kind)
    far = np.array([1.00001 * reach, -1.00001 * reach, 2.0**24, 1e30, -1e30, np.inf, -np.inf, np.nan], kind)
    x = np.concatenate([near, far])
    found = np.full((2, len(x)), np.nan, kind)
    beyond = np.full(len(x), -1, np.intc)
    probe = ctypes.CDLL(str(tmp_path / "probe.so")).sines_cosines
    probe(len(x), *(array.ctypes.data_as(ctypes.c_void_p) for array in (x, *found, beyond)))
    np.testing.assert_array_equal(beyond != 0, np.arange(len(x)) >= len(near))
    with mpmath.workdps(60):
        for value, sine, cosine in zip(near.tolist(), *found[:, : len(near)].tolist(), strict=True):
            assert abs(mpmath.sin(value) - sine) <= most, value
            assert abs(mpmath.cos(value) - cosine) <= most, value
    assert (found[:, x == 0.0] == [[0.0], [1.0]]).all()


def torques(library, q, *, in_place: bool = False):
    """Of many states at rest at once, q (joints, states)."""
    code, _, kind = library
    given = np.array([q, np.zeros_like(q), np.zeros_like(q)], dtype=kind)
    out = given[0] if in_place else np.empty(q.shape, dtype=kind)
    pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*given, out)]
    code.two_link_torque_many(ctypes.c_size_t(q.shape[1]), *pointers)
    return out.astype(float)


def test_sines_are_as_exact_as_the_librarys_at_any_angle(library):
    """Around quarter turns, drawn from the polynomials' reach, beyond it, and where there is no sine."""
    code, number, kind = library
    reach = 8e3 if kind is np.float32 else 1e6
    quarters = np.arange(-200, 200) * np.pi / 4
    drawn = np.random.default_rng(0).uniform(-reach, reach, 1000)
    far = [reach, -reach, 2.0**24, -(2.0**30), math.inf, math.nan, -math.inf]
    q1 = np.concatenate([quarters, np.nextafter(quarters, 9e9), drawn, far]).astype(kind).astype(float)
    q = np.array([q1, np.zeros_like(q1)])
    sound = np.isfinite(q1)
    still = gd.types.States(q.T[sound], *np.zeros((2, sound.sum(), 2)))
    expected = subject("two_link energy").torque.program.run(program_inputs(still))
    weights = np.abs(expected).max(axis=1)
    one_by_one, out = np.empty_like(q), (number * 2)()
    for k in range(len(q1)):
        code.two_link_gravity_loading((number * 2)(*q[:, k]), out)
        one_by_one[:, k] = out
    for found in (one_by_one, torques(library, q)):
        assert np.isnan(found[:, ~sound]).any(axis=0).all()
        # Sines of both are off by two roundings of 1, sums and products by some more of the largest.
        assert (np.abs(found[:, sound] - expected) <= 8 * np.finfo(kind).eps * weights[:, None]).all()


def test_one_output_may_stand_where_the_input_stood(library):
    q = np.random.default_rng(1).uniform(-3, 3, (2, 70))
    np.testing.assert_array_equal(torques(library, q, in_place=True), torques(library, q))


@pytest.mark.parametrize("case", ["two_link", "puma560 term"])
def test_compilers_vectorise_sines_and_what_is_for_many_states(case, tmp_path):
    """All loops that hold the arithmetic; a branch or a call in them would undo it."""
    version = called("gcc", "-dumpversion").decode().partition(".")[0]
    if int(version) < 12 or platform.machine() not in ("x86_64", "aarch64"):
        pytest.skip("which loops are vectorised is known of gcc 12 for processors of 64 bits")
    _, source = written(subject(case), "c").save(tmp_path)
    words = ["gcc", "-std=c99", "-O3", "-fopt-info-vec", "-c", str(source), "-o", str(tmp_path / "out.o")]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stderr
    vectorised = {int(line) for line in re.findall(r":(\d+):\d+: optimized: +loop vectorized", said)}
    lines = source.read_text().splitlines()
    loops = [k for k, line in enumerate(lines, start=1) if line.strip().startswith("for (l = ")]
    # Those of the angles, and of the torque: the last loops before their first results.
    turns, result = (
        next(k for k, line in enumerate(lines, start=1) if line.strip().startswith(words))
        for words in ("const int turns = ", "out[0][l] = ")
    )
    assert {max(k for k in loops if k < first) for first in (turns, result)} <= vectorised


@pytest.mark.parametrize("language", ["c", "cpp"])
def test_fast_math_is_refused_where_it_is_not_asked_for(language, tmp_path):
    """It makes the torque of angles that are no numbers look sound, and breaks the reduction of angles."""
    compiler, standard, _ = COMPILERS[language]
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    *_, path = written(subject("two_link"), language).save(tmp_path)
    command = [compiler, standard, "-ffast-math", "-fsyntax-only", "-x", {"c": "c", "cpp": "c++"}[language]]
    refused = subprocess.run([*command, str(path)], capture_output=True, text=True, check=False)
    assert refused.returncode != 0
    assert "GD_ANALYZE_ALLOW_FAST_MATH" in refused.stderr
    called(*command, "-DGD_ANALYZE_ALLOW_FAST_MATH", path)


@needs_gpp
def test_the_header_is_one_for_cpp_too(tmp_path):
    written(subject("two_link energy"), "c").save(tmp_path)
    (tmp_path / "main.cpp").write_text('#include "two_link.h"\n')
    called("g++", "-std=c++11", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")
