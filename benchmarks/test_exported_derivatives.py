"""The torque's derivatives by q and qd: exported C against CasADi's C and Pinocchio, all of one run.

CasADi differentiates Newton and Euler's recursion as its users do. Pinocchio's computeRNEADerivatives is
called from Python, state by state. Run with `python -m pytest benchmarks/test_exported_derivatives.py -s`.
"""

from __future__ import annotations

import ctypes
import shutil
import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import gd_analyze as gd
from exported_c import FAST, arm_named, simplified
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact import ExactForm
from peers.newton_euler_in_casadi import newton_euler
from peers.timed import Way, library, nanoseconds

ca = pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
ROUNDS, STATES = 50, 500

_LOOP = """
{declared}
void all(long passes, long count, const double *q, const double *qd, const double *qdd, double *out)
{{
    for (long p = 0; p < passes; p++)
        for (long s = 0; s < count; s++) {{
            {call}
        }}
}}
"""
_OURS = (
    "arm_torque_derivatives(q + {n} * s, qd + {n} * s, qdd + {n} * s, out + {m} * s, out + {m} * s + {h});"
)
_CASADI = """const double *given[3] = {{q + {n} * s, qd + {n} * s, qdd + {n} * s}};
            double *taken[2] = {{out + {m} * s, out + {m} * s + {h}}};
            derivatives(given, taken, 0, 0, 0);"""
_DECLARED = "int derivatives(const double **, double **, long long *, double *, int);"


def compiled(
    name: str, folder: Path, sources: dict[str, str], declared: str, call: str, states: States
) -> Way:
    n = states.q.shape[1]
    call = call.format(n=n, m=2 * n * n, h=n * n)
    made = library(
        folder, sources | {"driver.c": _LOOP.format(declared=declared, call=call)}, "gcc", *FAST.split()
    )
    arrays = [np.ascontiguousarray(x) for x in states.arrays]
    out = np.full((len(states.q), 2, n, n), np.nan)
    pointers = [ctypes.c_void_p(x.ctypes.data) for x in (*arrays, out)]

    def run(passes: int, _kept: object = arrays) -> None:
        made.all(ctypes.c_long(passes), ctypes.c_long(len(out)), *pointers)

    return Way(name, run, out)


def of_casadi(arm: RobotArm, folder: Path, states: States) -> Way:
    q, qd, qdd = (ca.SX.sym(name, arm.n_joints) for name in ("q", "qd", "qdd"))
    torque = newton_euler(arm, q, qd, qdd)
    # Transposed: CasADi's dense outputs are column by column.
    outputs = [ca.densify(ca.jacobian(torque, by).T) for by in (q, qd)]
    made = ca.Function("derivatives", [q, qd, qdd], outputs, {"cse": True})
    assert not made.sz_iw()
    generator = ca.CodeGenerator("derivatives", {"casadi_int": "long long"})
    generator.add(made)
    return compiled("CasADi", folder, {"made.c": generator.dump()}, _DECLARED, _CASADI, states)


def of_pinocchio(arm: RobotArm, states: States) -> Way:
    model = pinocchio_model(arm)
    data = model.createData()
    out = np.full((len(states.q), 2, arm.n_joints, arm.n_joints), np.nan)

    def run(passes: int) -> None:
        for _ in range(passes):
            for k, state in enumerate(zip(*states.arrays, strict=True)):
                out[k] = pin.computeRNEADerivatives(model, data, *state)[:2]

    return Way("Pinocchio from Python", run, out)


@pytest.mark.parametrize("name", ["PUMA 560 with drives", "LBR7"])
def test_derivatives_against_casadi_and_pinocchio(benchmark, tmp_path, name) -> None:
    arm = arm_named(name)
    assert arm is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        states = states_in_box(arm, STATES, seed=1)
    model = simplified(arm, states=500, effort=0.05)
    subjects = {
        "exact": ExportInput.of_exact(ExactForm(arm, model.drives), "arm"),
        "simplified": ExportInput.of_model(model, "arm"),
    }
    ways, counts = [of_casadi(arm, tmp_path / "CasADi", states), of_pinocchio(arm, states)], {}
    for what, subject in subjects.items():
        wider = subject.with_functions(["derivatives"])
        counts[what] = {each.name: each.count.total for each in wider.functions}["torque_derivatives"]
        files = dict(written(wider, "c").files)
        ways.append(compiled(what, tmp_path / what, files, '#include "arm.h"', _OURS, states))
    found = benchmark.pedantic(lambda: nanoseconds(ways, ROUNDS), rounds=1)
    by_name = {each.name: each.torque for each in ways}
    for other in ("CasADi", "Pinocchio from Python"):
        # Two ways through some thousand operations: round-off, of the largest element.
        close = 1e-10 * np.abs(by_name["exact"]).max()
        np.testing.assert_allclose(by_name["exact"], by_name[other], rtol=0, atol=close)
    for what in subjects:
        for than in ("CasADi", "Pinocchio from Python"):
            benchmark.extra_info[f"{what}: times faster than {than}"] = found[than] / found[what]
    cells = ", ".join(f"{each} {ns:.0f}" for each, ns in found.items())
    print(f"\n{name}: ns per state: {cells}; operations {counts}")
    assert found["simplified"] < found["CasADi"]
