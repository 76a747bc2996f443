"""Arms of which hardly anything is left: no mass, no angle, one joint."""

from __future__ import annotations

import importlib.util
from functools import cache

import numpy as np
import pytest
from compiled import STRICT, called, needs_gcc, needs_gpp, run_c
from rounded_programs import assert_same

from gd_analyze.exporting.export import printed
from gd_analyze.exporting.export_input import ExportInput, subject_of_decomposition, subject_of_form
from gd_analyze.exporting.languages import LANGUAGES
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.simplification.exact_form import ExactForm
from strategies import random_states


def arm_of(name: str, *kinds: str, mass: float = 1.0) -> RobotArm:
    limits = {"lower": -3.0, "upper": 3.0, "velocity_limit": 3.0, "acceleration_limit": 10.0}
    joints = tuple(Joint(f"j{k}", kind, **limits) for k, kind in enumerate(kinds))
    inertia = np.eye(3) * 0.1 * mass
    links = tuple(Link(f"l{k}", mass, np.zeros(3), inertia) for k in range(len(kinds)))
    return RobotArm(name, joints, links, np.array([0.0, 0.0, -9.81]))


ARMS = (
    arm_of("weightless", "revolute", "prismatic", mass=0.0),
    arm_of("lifts", "prismatic"),
    arm_of("slides", "prismatic", "prismatic"),
    arm_of("spins", "revolute"),
)


@cache
def subjects() -> dict[str, ExportInput]:
    """Dynamics and decomposition of each."""
    every = [
        *(subject_of_form(ExactForm(arm)) for arm in ARMS),
        *(subject_of_decomposition(arm) for arm in ARMS),
    ]
    return {what.name: what for what in every}


@pytest.fixture(params=[f"{arm.name}{parts}" for arm in ARMS for parts in ("", "_decomposition")])
def what(request) -> ExportInput:
    return subjects()[request.param]


@needs_gcc
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_c(what: ExportInput, scalar, tmp_path):
    drawn = random_states(what.n, 40, 2)
    counts = (0, 40) if what.torque else ()
    results, bulk = run_c(what, printed(what, "c", scalar).files, drawn, tmp_path, scalar, counts)
    # Some roundings, of the inputs too, each paid for by the largest number there is, a hundred.
    eps = np.finfo(scalar if scalar == "double" else np.float32).eps
    for function in what.functions:
        wanted = function.program.run(_inputs(drawn))
        assert np.abs(results[function.name] - wanted).max(initial=0.0) <= 1e3 * eps
    for torque in bulk[1:]:
        assert np.abs(torque - what.torque.program.run(_inputs(drawn))).max() <= 1e3 * eps


def _inputs(drawn):
    named = zip(("q", "qd", "qdd"), drawn.arrays, strict=True)
    return {f"{kind}{j + 1}": x[:, j] for kind, x in named for j in range(x.shape[1])}


@needs_gpp
def test_cpp(tmp_path):
    for what in subjects().values():
        printed(what, "cpp").save(tmp_path)
    calls = []
    for what in subjects().values():
        for function in what.functions:
            places = ", ".join(["x"] * (len(function.arguments) + len(function.results)))
            calls.append(f"    {what.name}::{function.name}({places});")
    includes = "".join(f'#include "{what.name}.hpp"\n' for what in subjects().values())
    text = "\n".join([f"{includes}int main()", "{", "    double x[99] = {0};", *calls, "}", ""])
    (tmp_path / "main.cpp").write_text(text)
    called("g++", "-std=c++11", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")


@pytest.mark.parametrize("language", ["python", "jax", "casadi"])
def test_python(what: ExportInput, language, tmp_path):
    pytest.importorskip({"python": "numpy"}.get(language, language))
    (path,) = printed(what, language).save(tmp_path)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    drawn = random_states(what.n, 1, 2)
    for function in what.functions:
        given = [getattr(drawn, name)[0] for name in function.arguments]
        results = getattr(module, function.name)(*given)
        listed = results if len(function.results) > 1 else [results]
        found = np.concatenate([np.asarray(x).reshape(-1, 1) for x in listed])
        if language == "jax":
            # In single precision, unless it is told otherwise.
            assert np.abs(found - function.program.run(_inputs(drawn))).max() <= 1e-4
        else:
            assert_same(found, function.program, drawn)


def test_every_language_prints_it(what: ExportInput):
    for language in LANGUAGES:
        if language != "latex" or what.torque:
            assert all(printed(what, language).files.values())
