"""Python: a module of NumPy, one of JAX and one of CasADi, each run as it was printed."""

from __future__ import annotations

import importlib.util
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from exported_cases import CASES, FEW, states, subject
from rounded_programs import assert_same, slope

from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from made_models import ROUND_OFF

EDGES = [([-0.7, 1.1], [2.3, -2.3], [-3.3, 3.3]), ([0.0, 0.0],) * 3]
BEYOND = [
    ([-0.7001, 0.0], [0.0, 0.0], [0.0, 0.0]),
    ([0.0, 1.1001], [0.0, 0.0], [0.0, 0.0]),
    ([0.0, 0.0], [2.3001, 0.0], [0.0, 0.0]),
    ([0.0, 0.0], [0.0, 0.0], [0.0, -3.3001]),
    *(tuple([math.nan if k == j else 0.0, 0.0] for k in range(3)) for j in range(3)),
]


def imported(what: ExportInput, language: str, folder):
    """The module that was written."""
    (path,) = written(what, language).save(folder)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rows(function, results) -> np.ndarray:
    """What a function of many states gave, as a program's outputs (outputs, states)."""
    listed = results if len(function.outputs) > 1 else [results]
    for result, values in zip(function.outputs, listed, strict=True):
        assert values.shape[1:] == result.shape
    return np.concatenate([np.asarray(values).reshape(len(values), -1).T for values in listed])


def given_to(function, drawn) -> list[np.ndarray]:
    return [dict(zip(("q", "qd", "qdd"), drawn.arrays, strict=True))[name] for name in function.arguments]


@pytest.mark.parametrize("case", CASES)
def test_numpy_gives_what_the_model_gives(case, tmp_path):
    what = subject(case)
    module, drawn = imported(what, "python", tmp_path), states(what.arm.name)
    for function in what.functions:
        results = getattr(module, function.name)(*given_to(function, drawn))
        assert_same(rows(function, results), function.program, drawn)
    assert what.joints == module.JOINTS


def test_numpy_takes_any_leading_axes(tmp_path):
    module = imported(subject("two_link energy"), "python", tmp_path)
    q, nothing = np.random.default_rng(0).uniform(-3, 3, (3, 5, 2)), np.zeros(2)
    torque = module.torque(q, nothing, nothing)
    assert torque.shape == (3, 5, 2)
    np.testing.assert_array_equal(torque[1, 2], module.torque([*q[1, 2]], [0, 0], [0, 0]))
    assert module.inertia(q).shape == (3, 5, 2, 2)
    assert module.torque(np.zeros((0, 2)), nothing, nothing).shape == (0, 2)
    with pytest.raises(ValueError, match=r"a state has 2 joints, in the last axis: shape \(\.\.\., 2\), not"):
        module.torque(np.zeros(3), nothing, nothing)


def test_numpy_states_the_constants(tmp_path):
    what = subject("two_link energy")
    module = imported(what, "python", tmp_path)
    assert (what.certificate.certified <= module.ERROR_BOUND).all()
    np.testing.assert_array_equal(module.LOWER, what.certificate.box.lower)
    assert [bool(module.is_within(*state)) for state in EDGES] == [True] * len(EDGES)
    assert [bool(module.is_within(*state)) for state in BEYOND] == [False] * len(BEYOND)
    many = module.is_within(*map(np.array, zip(*EDGES, *BEYOND, strict=True)))
    assert many.tolist() == [True] * len(EDGES) + [False] * len(BEYOND)


def test_the_module_needs_numpy_alone(tmp_path):
    written(subject("two_link energy"), "python").save(tmp_path)
    script = "import sys, two_link; print(sorted({m.split('.')[0] for m in sys.modules}))"
    environment = {key: x for key, x in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        check=True,
        text=True,
    )
    assert "numpy" in done.stdout
    assert not {"gd_analyze", "scipy", "xarray", "pandas", "jax"} & set(done.stdout.split("'"))


@pytest.fixture(scope="module")
def jax():
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@pytest.mark.parametrize("case", [*FEW[:2], FEW[-1]])
def test_jax_compiles_maps_and_differentiates(jax, case, tmp_path):
    what = subject(case)
    module, drawn = imported(what, "jax", tmp_path), states(what.arm.name)
    for function in what.functions:
        compiled = jax.jit(getattr(module, function.name))
        assert_same(rows(function, compiled(*given_to(function, drawn))), function.program, drawn)


def test_gradients_of_jax_are_slopes(jax, tmp_path):
    what = subject("two_link recursive")
    module, drawn = imported(what, "jax", tmp_path), states("two_link").at(slice(50))
    by_q, by_qdd = jax.vmap(jax.jit(jax.jacfwd(module.torque, argnums=(0, 2))))(*drawn.arrays)
    for j in range(2):
        exact = slope(what.torque.program, drawn, f"q{j + 1}").T
        # Derivatives sum some dozen products: a few hundred eps of the largest.
        assert np.abs(by_q[..., j] - exact).max() <= ROUND_OFF * np.abs(exact).max()
    found = module.inertia(drawn.q)
    assert np.abs(by_qdd - found).max() <= ROUND_OFF * np.abs(found).max()
    power = jax.grad(lambda qd: qd @ module.coriolis_centrifugal(drawn.q[0], qd))(drawn.qd[0])
    assert np.isfinite(power).all()


def test_jax_states_the_box(jax, tmp_path):
    module = imported(subject("two_link energy"), "jax", tmp_path)
    assert [bool(module.is_within(*state)) for state in EDGES] == [True] * len(EDGES)
    assert [bool(module.is_within(*state)) for state in BEYOND] == [False] * len(BEYOND)


@pytest.fixture(scope="module")
def casadi():
    return pytest.importorskip("casadi")


@pytest.mark.parametrize("case", CASES)
def test_casadi_gives_what_the_model_gives(casadi, case, tmp_path):
    what = subject(case)
    module, drawn = imported(what, "casadi", tmp_path), states(what.arm.name).at(slice(200))
    count = len(drawn.q)
    for function in what.functions:
        mapped = getattr(module, function.name).map(count)
        results = mapped(*(x.T for x in given_to(function, drawn)))
        listed = results if isinstance(results, tuple) else (results,)
        # Matrices of the states stand side by side.
        shaped = [
            np.array(x).reshape(result.shape[0], count, -1).swapaxes(0, 1).reshape(count, -1)
            for result, x in zip(function.outputs, listed, strict=True)
        ]
        assert_same(np.concatenate(shaped, axis=1).T, function.program, drawn)


def test_casadi_differentiates(casadi, tmp_path):
    what = subject("puma560 recursive")
    module, drawn = imported(what, "casadi", tmp_path), states("puma560").at(slice(20))
    symbols = [casadi.SX.sym(name, 6) for name in ("q", "qd", "qdd")]
    jacobians = [casadi.jacobian(module.torque(*symbols), x) for x in symbols]
    function = casadi.Function("slopes", symbols, jacobians)
    for j in range(6):
        for k, kind in enumerate(("q", "qd", "qdd")):
            exact = slope(what.torque.program, drawn, f"{kind}{j + 1}")
            found = np.array(
                [np.array(function(*state)[k])[:, j] for state in zip(*drawn.arrays, strict=True)]
            ).T
            # Some hundred products of sizes up to the largest torque's.
            assert np.abs(found - exact).max() <= ROUND_OFF * max(1.0, np.abs(exact).max())


def test_casadi_is_named_and_generates_code(casadi, tmp_path, monkeypatch):
    what = subject("two_link energy")
    module = imported(what, "casadi", tmp_path)
    assert module.torque.name() == "two_link_torque"
    assert module.torque.name_in() == ["q", "qd", "qdd"]
    assert module.inertia.size_out(0) == (2, 2)
    assert (np.array(module.ERROR_BOUND).ravel() >= what.certificate.certified).all()
    monkeypatch.chdir(tmp_path)
    module.torque.generate("again.c")
    assert "two_link_torque" in (tmp_path / "again.c").read_text()
