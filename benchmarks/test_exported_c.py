"""Exported C, one state at a time and many at once, against CasADi's C and Pinocchio's rnea, all of one run.

Models are made of few states with little effort. Compiling Pinocchio's rnea takes half a minute, and is done
where GD_ANALYZE_COMPILE_RNEA=1 is in the environment. Ratios are printed and kept in `extra_info`, with the
processor's name. Run with `python -m pytest benchmarks/test_exported_c.py -s`.
"""

from __future__ import annotations

import os
import shutil
from ctypes import CDLL

import pytest

from exported_c import FAST, MODELS, NAMES, arm_named, block, simplified, timed
from peers.rnea_compiled import rnea_library
from psdm_measure import machine

pytest.importorskip("casadi")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
ROUNDS = 100


@pytest.fixture(scope="session")
def rnea(tmp_path_factory: pytest.TempPathFactory) -> CDLL | str:
    """Pinocchio's rnea, compiled; or why it is not."""
    if not os.environ.get("GD_ANALYZE_COMPILE_RNEA"):
        return "GD_ANALYZE_COMPILE_RNEA is not set"
    made = rnea_library(tmp_path_factory.mktemp("rnea") / "rnea")
    if isinstance(made, str):
        print(f"\nrnea C++ is left out: {made}")
    return made


@pytest.mark.parametrize("name", NAMES)
def test_torque_in_c_against_casadi_and_rnea(benchmark, tmp_path, rnea, name) -> None:
    arm = arm_named(name)
    if arm is None:
        pytest.skip("example-robot-data is not installed")
    model = simplified(arm, states=500, effort=0.05)
    row = benchmark.pedantic(lambda: timed(name, arm, model, tmp_path, rnea, ROUNDS), rounds=1)
    benchmark.extra_info["processor"] = machine()
    for how in ("one", "many"):
        ours, exact = (f"{what}, {how}, {FAST}" for what in ("simplified", "exact"))
        benchmark.extra_info[f"{ours}: times faster than exact"] = row.faster(ours, exact)
    for what in MODELS:
        for how in ("one", "many"):
            ours = f"{what}, {how}, {FAST}"
            peers = [f"CasADi, {FAST}", *([] if isinstance(rnea, str) else ["rnea C++"]), "rnea Python"]
            for than in peers:
                benchmark.extra_info[f"{ours}: times faster than {than}"] = row.faster(ours, than)
    print(f"\n{machine()}, {block(row)}")
    assert not row.slower_than_exact
