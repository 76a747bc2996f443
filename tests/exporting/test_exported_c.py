"""C: it compiles without a warning, and gives what the model gives, one state at a time and many at once."""

from __future__ import annotations

import ctypes
import math
import platform
import re
import subprocess

import numpy as np
import pytest
from compiled import STRICT, called, needs_gcc, run_c
from exported_cases import CASES, states, subject
from hypothesis import given
from rounded_programs import assert_same, evaluated, inputs_of

from few_tries import few_tries
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States
from gd_analyze.simplification.exact_form import ExactForm
from strategies import arms, examples, random_states

pytestmark = needs_gcc
# None, one, a block less one, a block, a block and one, all.
COUNTS = (0, 1, 7, 8, 9, 1000)


@pytest.mark.parametrize("case", CASES)
def test_it_gives_what_the_model_gives(case, tmp_path):
    what = subject(case)
    drawn = states(what.arm.name)
    counts = COUNTS if what.torque else ()
    results, bulk = run_c(what, written(what, "c").files, drawn, tmp_path, counts=counts)
    for function in what.functions:
        assert_same(results[function.name], function.program, drawn)
    for count, torque in zip(counts, bulk, strict=True):
        assert torque.shape == (what.n, count)
        if count:
            assert_same(torque, what.torque.program, drawn.at(slice(count)))


@examples(4)
@given(arms(max_joints=2))
@few_tries()
def test_so_it_does_for_any_arm(tmp_path_factory, arm):
    what = ExportInput.of_exact(ExactForm(arm))
    drawn = random_states(arm.n_joints, 40, 1)
    folder = tmp_path_factory.mktemp("drawn")
    results, bulk = run_c(what, written(what, "c").files, drawn, folder, counts=(40,))
    for function in what.functions:
        assert_same(results[function.name], function.program, drawn)
    assert_same(bulk[0], what.torque.program, drawn)


@pytest.mark.parametrize("case", ["two_link", "puma560 recursive", "stanford energy"])
def test_single_precision_errs_no_more_than_its_header_says(case, tmp_path):
    what = subject(case)
    drawn = states(what.arm.name)
    files = written(what, "c", "float").files
    results, (bulk,) = run_c(what, files, drawn, tmp_path, "float", (1000,))
    exact, _ = evaluated(what.torque.program, drawn)
    text = files[f"{what.name}.h"].partition("by at most ")[2]
    stated = [float(word) for word in text.partition(" (joint")[0].split(", ")]
    for found in (results["torque"], bulk):
        measured = np.abs(found - exact).max(axis=1)
        assert (measured <= stated).all()
        # It says no more than it has to: the largest of other states is not many times less.
        assert (measured >= np.array(stated) / 20).all()


@pytest.fixture(scope="module", params=["double", "float"])
def library(request, tmp_path_factory):
    """The model with a bound as a library, and its scalar."""
    what = subject("two_link energy")
    folder = tmp_path_factory.mktemp("library")
    written(what, "c", request.param).save(folder)
    source, out = folder / "two_link.c", folder / "two_link.so"
    called("gcc", "-std=c99", *STRICT, "-O3", "-shared", "-fPIC", source, "-o", out, "-lm")
    return ctypes.CDLL(str(out)), ctypes.c_double if request.param == "double" else ctypes.c_float


def constants(library, name):
    code, number = library
    return np.array((number * 2).in_dll(code, f"two_link_{name}")[:], dtype=float)


def test_the_constants_are_the_certificates_and_never_promise_more(library):
    stated = subject("two_link energy").certificate
    box = stated.box
    pairs = {
        "error_bound": (stated.certified, 1),
        "lower": (box.lower, 1),
        "upper": (box.upper, -1),
        "velocity": (box.velocity, -1),
        "acceleration": (box.acceleration, -1),
    }
    for name, (true, direction) in pairs.items():
        found = constants(library, name)
        assert (direction * found >= direction * true).all(), name
        # Rounded once: bounds to six digits, and to single precision.
        np.testing.assert_allclose(found, true, rtol=1e-5 if name == "error_bound" else 2e-7)
        if library[1] is ctypes.c_double and name != "error_bound":
            np.testing.assert_array_equal(found, true)


def within(library, *state):
    code, number = library
    return code.two_link_is_within(*((number * 2)(*x) for x in state))


def test_a_state_is_within_up_to_the_edges(library):
    lower, upper, rate, most = (constants(library, x) for x in ("lower", "upper", "velocity", "acceleration"))
    kind = np.float64 if library[1] is ctypes.c_double else np.float32

    def beyond(values, towards):
        return np.nextafter(values.astype(kind), kind(towards)).astype(float)

    nothing = np.zeros(2)
    inside = [(lower, rate, most), (upper, -rate, -most), (upper, nothing, nothing)]
    outside = [
        (beyond(lower, -np.inf), nothing, nothing),
        (np.array([0.0, beyond(upper, np.inf)[1]]), nothing, nothing),
        (nothing, beyond(rate, np.inf), nothing),
        (nothing, -beyond(rate, np.inf), nothing),
        (nothing, nothing, beyond(most, np.inf)),
        (nothing, nothing, -beyond(most, np.inf)),
        *((np.array([0.0, x]), nothing, nothing) for x in (math.nan, math.inf, -math.inf)),
        *((nothing, np.array([x, 0.0]), nothing) for x in (math.nan, math.inf)),
        (nothing, nothing, np.array([math.nan, 0.0])),
    ]
    assert [within(library, *state) for state in inside] == [1] * len(inside)
    assert [within(library, *state) for state in outside] == [0] * len(outside)


def torques(library, q):
    """Of many states at rest at once, q (joints, states)."""
    code, number = library
    kind = np.float64 if number is ctypes.c_double else np.float32
    given = np.array([q, np.zeros_like(q), np.zeros_like(q)], dtype=kind)
    out = np.empty(q.shape, dtype=kind)
    pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*given, out)]
    code.two_link_torque_many(ctypes.c_size_t(q.shape[1]), *pointers)
    return out.astype(float)


def one_by_one(library, q):
    """Gravity loading of each state, q (joints, states), a call each."""
    code, number = library
    found, out = np.empty_like(q), (number * 2)()
    for k in range(q.shape[1]):
        code.two_link_gravity_loading((number * 2)(*q[:, k]), out)
        found[:, k] = out
    return found


def test_sines_are_as_exact_as_the_librarys_at_any_angle(library):
    """Around quarter turns, drawn from the polynomials' reach, beyond it, and where there is no sine."""
    single = library[1] is ctypes.c_float
    kind = np.float32 if single else np.float64
    reach = 8e3 if single else 1e6
    quarters = np.arange(-200, 200) * np.pi / 4
    drawn = np.random.default_rng(0).uniform(-reach, reach, 1000)
    q1 = np.concatenate([quarters, np.nextafter(quarters, 9e9), drawn, [reach, -reach, 2.0**24, -(2.0**30)]])
    q1 = np.concatenate([q1, [math.inf, math.nan, -math.inf]]).astype(kind).astype(float)
    q = np.array([q1, np.zeros_like(q1)])
    sound = np.isfinite(q1)
    still = States(q.T[sound], *np.zeros((2, sound.sum(), 2)))
    expected = subject("two_link energy").torque.program.run(inputs_of(still))
    weights = np.abs(expected).max(axis=1)
    for found in (one_by_one(library, q), torques(library, q)):
        assert np.isnan(found[:, ~sound]).any(axis=0).all()
        # Sines of both are off by two roundings of 1, sums and products by some more of the largest.
        assert (np.abs(found[:, sound] - expected) <= 8 * np.finfo(kind).eps * weights[:, None]).all()


def test_one_output_may_stand_where_the_input_stood(library):
    q = np.random.default_rng(1).uniform(-3, 3, (2, 70))
    expected = torques(library, q)
    code, number = library
    kind = np.float64 if number is ctypes.c_double else np.float32
    place, zeros = q.astype(kind), np.zeros(q.shape, dtype=kind)
    pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (place, zeros, zeros, place)]
    code.two_link_torque_many(ctypes.c_size_t(70), *pointers)
    np.testing.assert_array_equal(place.astype(float), expected)


@pytest.mark.parametrize("case", ["puma560", "puma560 term", "stanford"])
def test_compilers_vectorise_what_is_for_many_states(case, tmp_path):
    """Both loops that hold the arithmetic; a branch or a call in them would undo it."""
    version = called("gcc", "-dumpversion").decode().partition(".")[0]
    if int(version) < 12 or platform.machine() not in ("x86_64", "aarch64"):
        pytest.skip("which loops are vectorised is known of gcc 12 for processors of 64 bits")
    what = subject(case)
    _, source = written(what, "c").save(tmp_path)
    words = ["gcc", "-std=c99", "-O3", "-fopt-info-vec", "-c", str(source), "-o", str(tmp_path / "out.o")]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stderr
    vectorised = {int(line) for line in re.findall(r":(\d+):\d+: optimized: +loop vectorized", said)}
    lines = source.read_text().splitlines()
    loops = [k for k, line in enumerate(lines, start=1) if line.strip() == "for (l = 0; l < lanes; l++) {"]
    # Of the sines and cosines, and of the torque: the last loop before its first result.
    result = next(k for k, line in enumerate(lines, start=1) if line.strip().startswith("out[0][l] = "))
    assert {loops[0], max(k for k in loops if k < result)} <= vectorised


def test_the_header_is_one_for_cpp_too(tmp_path):
    written(subject("two_link energy"), "c").save(tmp_path)
    words = ["g++", "-std=c++11", *STRICT, "-x", "c++", "-fsyntax-only", str(tmp_path / "two_link.h")]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("g++ is not installed")
    errors = [line for line in done.stderr.splitlines() if "pragma once" not in line]
    assert done.returncode == 0, errors
