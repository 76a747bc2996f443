"""Every language gives what the model gives, its derivatives, and the box of a certificate."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from exported_cases import CASES, FEW, ODD, states, subject
from few_tries import few_tries
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.types import ExactForm
from long_cases import long, long_but
from made_models import ROUND_OFF
from rounded_programs import assert_same, evaluated, slope
from running import STRICT, called, compiled, imported, needs_gcc, needs_gpp, run_compiled, run_imported
from strategies import arms, examples, random_states

ALL = (*CASES, *ODD, "weightless decomposition", "spins decomposition")
# Of every arm, level and kind of function one that is compiled soon.
COMPILED = (
    "two_link",
    "two_link element",
    "two_link energy",
    "puma560 term",
    "two_link further",
    *FEW[:2],
    *ODD,
)
IMPORTED = ("python", "casadi")
CPP = (*(case for case in FEW if case != "stanford further"), "two_link further", "puma560 term", *ODD)
# Of many states at once: none, one, a block less one, a block, a block and one, all.
COUNTS = (0, 1, 7, 8, 9, 200)
NONE = [0.0, 0.0]
EDGES = [([-0.7, 1.1], [2.3, -2.3], [-3.3, 3.3]), (NONE, NONE, NONE)]
BEYOND = [
    *(([x, 0.0], NONE, NONE) for x in (-0.7001, 1.1001, math.nan)),
    *((NONE, [x, 0.0], NONE) for x in (2.3001, math.nan)),
    *((NONE, NONE, [0.0, x]) for x in (-3.3001, math.nan)),
]


@pytest.fixture(autouse=True, scope="module")
def jax():
    """In double precision, where it is installed."""
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    try:
        import jax
    except ImportError:
        yield None
        return
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@needs_gcc
@pytest.mark.parametrize("case", long_but(COMPILED, ALL))
def test_c_gives_what_the_model_gives(case, tmp_path):
    what, drawn = subject(case), states(case)
    results, bulk = run_compiled(what, "c", drawn, tmp_path, counts=COUNTS)
    for function in what.functions:
        assert_same(results[function.name], function.program, drawn)
    assert_same_at_once(what, drawn, bulk)


def assert_same_at_once(what, drawn, bulk):
    """Of many states at once, the torque or the parts."""
    program = what.functions[0].program
    for count, outputs in zip(COUNTS, bulk, strict=True):
        assert outputs.shape == (len(program.outputs), count)
        if count:
            assert_same(outputs, program, drawn.at(slice(count)))


@pytest.mark.parametrize(
    ("language", "case"),
    [
        *(pytest.param("cpp", case, marks=needs_gpp) for case in CPP),
        pytest.param("cpp", "stanford further", marks=[needs_gpp, pytest.mark.slow]),
        *((name, case) if case in COMPILED else long(name, case) for name in IMPORTED for case in ALL),
        *(
            (name, f"two_link {what}")
            for name in ("jax", "sympy")
            for what in ("element", "program", "decomposition", "further")
        ),
    ],
)
def test_other_languages_do_too(language, case, tmp_path):
    what, drawn = subject(case), states(case, 20 if language == "sympy" else 200)
    if language == "cpp":
        found, bulk = run_compiled(what, language, drawn, tmp_path, counts=COUNTS)
        assert_same_at_once(what, drawn, bulk)
    else:
        found = run_imported(what, language, drawn, tmp_path)
    for function in what.functions:
        assert_same(found[function.name], function.program, drawn)


@needs_gcc
@examples(3)
@given(arms(max_joints=2))
@few_tries()
def test_so_it_is_with_any_arm(tmp_path_factory, arm):
    what = ExportInput.of_exact(ExactForm(arm))
    drawn = random_states(arm.n_joints, 40, 1)
    results, bulk = run_compiled(what, "c", drawn, tmp_path_factory.mktemp("drawn"), counts=(40,))
    for function in what.functions:
        assert_same(results[function.name], function.program, drawn)
    assert_same(bulk[0], what.torque.program, drawn)


@needs_gpp
def test_cpp_of_single_precision(tmp_path):
    what, drawn = subject("two_link program"), states("two_link", 100)
    found, _ = run_compiled(what, "cpp", drawn, tmp_path, "float")
    eps = float(np.finfo(np.float32).eps)
    values, bound = evaluated(what.torque.program, drawn, eps)
    # Inputs are rounded, too: a slope of some hundred times eps of an input of at most ten.
    assert (np.abs(found["torque"] - values) <= bound + 1e4 * eps).all()


DUAL = """
// Forward differentiation, as a stranger would write it: nothing but a value and a slope.
struct Dual {
    double v, d;
    explicit Dual(double value = 0, double slope = 0) : v(value), d(slope) {}
};
inline Dual operator+(Dual a, Dual b) { return Dual(a.v + b.v, a.d + b.d); }
inline Dual operator-(Dual a, Dual b) { return Dual(a.v - b.v, a.d - b.d); }
inline Dual operator-(Dual a) { return Dual(-a.v, -a.d); }
inline Dual operator*(Dual a, Dual b) { return Dual(a.v * b.v, a.d * b.v + a.v * b.d); }
inline Dual sin(Dual a);
inline Dual cos(Dual a);
#include "stanford.hpp"
#include <cstdio>
inline Dual sin(Dual a) { return Dual(std::sin(a.v), a.d * std::cos(a.v)); }
inline Dual cos(Dual a) { return Dual(std::cos(a.v), -a.d * std::sin(a.v)); }
int main()
{
    double given[18];
    while (std::fread(given, 8, 18, stdin) == 18) {
        Dual x[18], tau[6];
        for (int j = 0; j < 18; j++)
            x[j] = Dual(given[j], j == 1);
        stanford::torque(x, x + 6, x + 12, tau);
        for (int j = 0; j < 6; j++)
            std::fwrite(&tau[j].v, 8, 1, stdout), std::fwrite(&tau[j].d, 8, 1, stdout);
    }
}
"""
EIGEN = """
#include <Eigen/Core>
#include "two_link.hpp"
#include <cstdio>
int main()
{
    double x[6];
    while (std::fread(x, 8, 6, stdin) == 6) {
        // A map, a dynamic vector, an expression.
        const Eigen::Map<const Eigen::VectorXd> q(x, 2);
        const Eigen::VectorXd qd = Eigen::Map<const Eigen::Vector2d>(x + 2);
        const Eigen::Matrix<double, 2, 1> qdd(x[4], x[5]);
        const Eigen::Vector2d apart = two_link::inertia(q) * qdd
            + two_link::coriolis_centrifugal(q, 2.0 * qd / 2.0) + two_link::gravity_loading(q)
            - two_link::torque(q, qd, qdd + 0.0 * qd);
        std::fwrite(apart.data(), 8, 2, stdout);
    }
}
"""
EIGEN_PARTS = """
#include <Eigen/Core>
#include "parts.hpp"
#include <cstdio>
int main()
{
    double x[4];
    while (std::fread(x, 8, 4, stdin) == 4) {
        Eigen::Matrix2d tran, rot;
        Eigen::Vector2d h_tran, h_rot, c;
        const Eigen::Map<const Eigen::Vector2d> q(x), qd(x + 2);
        std::tie(tran, rot, h_tran, h_rot, c) = parts::decomposition(q, qd);
        for (const Eigen::Matrix2d &each : {tran, rot})
            for (int i = 0; i < 4; i++)
                std::fwrite(&each(i / 2, i % 2), 8, 1, stdout);
        for (const Eigen::Vector2d &each : {h_tran, h_rot, c})
            std::fwrite(each.data(), 8, 2, stdout);
    }
}
"""
SPAN = """
#include "two_link.hpp"
#include <array>
#include <cstdio>
#include <vector>
int main()
{
    std::vector<double> x(6), tau(2);
    std::array<double, 2> q;
    while (std::fread(x.data(), 8, 6, stdin) == 6) {
        q = {x[0], x[1]};
        two_link::torque(q, std::span(x).subspan(2, 2), std::span(x).last(2), tau);
        std::fwrite(tau.data(), 8, 2, stdout);
    }
}
"""
BOX = """
#include "two_link.hpp"
#include "two_link.hpp"
#include <cstdio>
int main()
{
    using namespace two_link;
    double x[6];
    while (std::fread(x, 8, 6, stdin) == 6) {
        const double found[5] = {double(is_within(x, x + 2, x + 4)), error_bound[0], error_bound[1],
                                 joint_shoulder, joint_elbow};
        std::fwrite(found, 8, 5, stdout);
    }
}
"""


def run_cpp(what: ExportInput, text: str, folder: Path, given: np.ndarray, *flags: str) -> np.ndarray:
    """What a program prints, given states one after the other."""
    written(what, "cpp").save(folder)
    (folder / "main.cpp").write_text(text, encoding="ascii")
    program = compiled("cpp", [folder / "main.cpp"], folder / "run", *flags)
    return np.frombuffer(called(program, given=given.tobytes()))


@needs_gpp
def test_types_that_differentiate_themselves_work(tmp_path):
    """Values and slopes of the torque by q2, by dual numbers whose sin and cos are their own."""
    what, drawn = subject("stanford"), states("stanford", 100)
    found = run_cpp(what, DUAL, tmp_path, np.hstack(drawn.arrays)).reshape(100, 6, 2)
    assert_same(found[..., 0].T, what.torque.program, drawn)
    exact = slope(what.torque.program, drawn, "q2")
    # Some hundred products of sizes up to the largest slope's.
    assert np.abs(found[..., 1].T - exact).max() <= ROUND_OFF * np.abs(exact).max()


@needs_gpp
@pytest.mark.skipif(not Path("/usr/include/eigen3").exists(), reason="Eigen's headers are not installed")
def test_vectors_of_eigen(tmp_path):
    what, drawn = subject("two_link energy"), states("two_link", 20)
    # Eigen's own headers have warnings that are not ours.
    flags = ("-isystem", "/usr/include/eigen3", "-Wno-unused-parameter")
    apart = run_cpp(what, EIGEN, tmp_path, np.hstack(drawn.arrays), *flags)
    largest = np.abs(evaluated(what.torque.program, drawn)[0]).max()
    # A dozen roundings of sums of the torque's size.
    assert apart.size == 40
    assert np.abs(apart).max() <= 64 * np.finfo(float).eps * largest


@needs_gpp
def test_spans_of_cpp_20(tmp_path):
    what, drawn = subject("two_link energy"), states("two_link", 20)
    found = run_cpp(what, SPAN, tmp_path, np.hstack(drawn.arrays), "-std=c++20")
    assert_same(found.reshape(20, 2).T, what.torque.program, drawn)


@needs_gpp
@pytest.mark.skipif(not Path("/usr/include/eigen3").exists(), reason="Eigen's headers are not installed")
def test_eigen_takes_several_outputs_as_a_tuple(tmp_path):
    what, drawn = replace(subject("two_link decomposition"), name="parts"), states("two_link", 20)
    flags = ("-isystem", "/usr/include/eigen3", "-Wno-unused-parameter")
    found = run_cpp(what, EIGEN_PARTS, tmp_path, np.hstack(drawn.arrays[:2]), *flags)
    assert_same(found.reshape(20, -1).T, what.functions[0].program, drawn)


@needs_gpp
def test_cpp_states_the_box_in_every_standard(tmp_path):
    what = subject("two_link energy")
    found = run_cpp(what, BOX, tmp_path, np.reshape([*EDGES, *BEYOND], (-1, 6))).reshape(-1, 5)
    assert found[:, 0].tolist() == [1] * len(EDGES) + [0] * len(BEYOND)
    assert (found[0, 1:3] >= what.certificate.certified).all()
    assert found[0, 3:].tolist() == [0, 1]
    for standard in ("c++14", "c++17", "c++20"):
        called("g++", f"-std={standard}", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")


@pytest.mark.parametrize("language", ["python", "jax"])
def test_modules_state_the_constants_and_the_box(language, tmp_path):
    what = subject("two_link energy")
    module = imported(what, language, tmp_path)
    assert what.joints == module.JOINTS
    assert (what.certificate.certified <= np.asarray(module.ERROR_BOUND)).all()
    np.testing.assert_array_equal(module.LOWER, what.certificate.box.lower)
    many = module.is_within(*map(np.array, zip(*EDGES, *BEYOND, strict=True)))
    assert many.tolist() == [True] * len(EDGES) + [False] * len(BEYOND)


def test_numpy_takes_any_leading_axes_and_needs_nothing_else(tmp_path):
    module = imported(subject("two_link energy"), "python", tmp_path)
    q, nothing = np.random.default_rng(0).uniform(-3, 3, (3, 5, 2)), np.zeros(2)
    torque = module.torque(q, nothing, nothing)
    assert torque.shape == (3, 5, 2)
    np.testing.assert_array_equal(torque[1, 2], module.torque([*q[1, 2]], [0, 0], [0, 0]))
    assert module.inertia(q).shape == (3, 5, 2, 2)
    assert module.torque(np.zeros((0, 2)), nothing, nothing).shape == (0, 2)
    with pytest.raises(ValueError, match="a state has 2 joints"):
        module.torque(np.zeros(3), nothing, nothing)
    script = "import sys, two_link; print(*{m.split('.')[0] for m in sys.modules})"
    environment = {key: x for key, x in os.environ.items() if key != "PYTHONPATH"}
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, check=True, text=True)
    assert "numpy" in done.stdout
    assert not {"gd_analyze", "scipy", "xarray", "pandas", "jax"} & set(done.stdout.split())


def test_gradients_of_jax_are_slopes(jax, tmp_path):
    what = subject("two_link program")
    module, drawn = imported(what, "jax", tmp_path), states("two_link", 50)
    by_q, by_qdd = jax.vmap(jax.jit(jax.jacfwd(module.torque, argnums=(0, 2))))(*drawn.arrays)
    for j in range(2):
        exact = slope(what.torque.program, drawn, f"q{j + 1}").T
        # Derivatives sum some dozen products: a few hundred eps of the largest.
        assert np.abs(by_q[..., j] - exact).max() <= ROUND_OFF * np.abs(exact).max()
    found = module.inertia(drawn.q)
    assert np.abs(by_qdd - found).max() <= ROUND_OFF * np.abs(found).max()


def test_casadi_differentiates_and_generates_code(tmp_path, monkeypatch):
    casadi = pytest.importorskip("casadi")
    what = subject("puma560 program")
    module, drawn = imported(what, "casadi", tmp_path), states("puma560", 20)
    symbols = [casadi.SX.sym(name, 6) for name in ("q", "qd", "qdd")]
    jacobians = [casadi.jacobian(module.torque(*symbols), x) for x in symbols]
    function = casadi.Function("slopes", symbols, jacobians)
    found = np.array([[*map(np.array, function(*state))] for state in zip(*drawn.arrays, strict=True)])
    for k, kind in enumerate(("q", "qd", "qdd")):
        exact = [slope(what.torque.program, drawn, f"{kind}{j + 1}").T for j in range(6)]
        # Some hundred products of sizes up to the largest torque's.
        allowed = ROUND_OFF * max(1.0, np.abs(exact).max())
        assert np.abs(np.moveaxis(found[:, k], -1, 0) - exact).max() <= allowed
    assert (module.torque.name(), module.torque.name_in()) == ("puma560_torque", ["q", "qd", "qdd"])
    assert module.inertia.size_out(0) == (6, 6)
    assert (np.array(module.ERROR_BOUND).ravel() >= what.certificate.certified).all()
    monkeypatch.chdir(tmp_path)
    module.torque.generate("again.c")
    assert "puma560_torque" in (tmp_path / "again.c").read_text()
