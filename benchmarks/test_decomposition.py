"""Decomposition of 100 000 set points against loops over Pinocchio, in Python and C++, which give no split.

Run with `python -m pytest benchmarks -s`; the ratio per set point is printed and kept in `extra_info`.
"""

from __future__ import annotations

import ctypes
import os
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model, round_off_bounds
from peers.rnea_compiled import made_arm, rnea_library

N_OURS = 100_000
N_THEIRS = 20_000
ROUNDS = 5


@pytest.fixture(scope="module")
def states() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(1987)
    q, qd, qdd = random.uniform(-2.0, 2.0, (3, N_OURS, 6))
    return q, qd, qdd


def seconds(work: Callable[[], object]) -> float:
    start = time.process_time()  # one thread each: what others do on the machine counts less
    work()
    return time.process_time() - start


def test_decomposition_against_loops_over_pinocchio(benchmark, states, tmp_path: Path) -> None:
    arm = gd.load_arm("puma560")
    q, qd, qdd = states
    model = pinocchio_model(arm)
    data = model.createData()

    def theirs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        inertia = np.empty((N_THEIRS, 6, 6))
        coriolis = np.empty((N_THEIRS, 6, 6))
        gravity = np.empty((N_THEIRS, 6))
        for k in range(N_THEIRS):
            inertia[k] = pin.crba(model, data, q[k])
            coriolis[k] = pin.computeCoriolisMatrix(model, data, q[k], qd[k])
            gravity[k] = pin.computeGeneralizedGravity(model, data, q[k])
        return inertia, coriolis, gravity

    made: ctypes.CDLL | str = "GD_ANALYZE_COMPILE_RNEA is not set"  # it takes a minute
    if os.environ.get("GD_ANALYZE_COMPILE_RNEA"):
        made = rnea_library(tmp_path / "cpp")
    compiled = not isinstance(made, str)
    if compiled:
        handle, out = made_arm(made, arm, False), np.empty((N_OURS, 78))
        pointers = [ctypes.c_void_p(x.ctypes.data) for x in (q, qd, out)]

    def in_cpp() -> None:
        made.elements(handle, ctypes.c_long(N_OURS), *pointers)

    def ours() -> dict[str, np.ndarray]:
        return gd.tables.decompose_states(
            arm, gd.types.States(q, qd, qdd), christoffel=False, shares=False, drives=False
        )

    found = ours()
    if compiled:
        in_cpp()
        c, bound = found["gravity_loading"], round_off_bounds(arm, q, qd, qdd)["gravity_loading"]
        assert np.abs(out[:, 72:] - c).max() <= bound
    ways = {"Pinocchio in Python": (theirs, N_THEIRS), "ours, split": (ours, N_OURS)}
    ways |= {"Pinocchio in C++": (in_cpp, N_OURS)} if compiled else {}
    # Interleaved, so that a machine whose speed drifts slows all; the fixture times ours once more.
    rounds = [{name: seconds(way) / count for name, (way, count) in ways.items()} for _ in range(ROUNDS)]
    benchmark.pedantic(ours, rounds=ROUNDS)
    benchmark.extra_info["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print()
    for name in ways:
        ratios = sorted(one[name] / one["ours, split"] for one in rounds)
        taken = 1e6 * float(np.median([one[name] for one in rounds]))
        benchmark.extra_info[f"{name}_us_per_set_point"] = taken
        benchmark.extra_info[f"times_faster_than_{name}"] = ratios[len(ratios) // 2]
        listed = ", ".join(f"{r:.2f}" for r in ratios)
        print(
            f"{name}: {taken:.2f} us per set point, {ratios[len(ratios) // 2]:.2f} of ours (rounds: {listed})"
        )
    if not compiled:
        print(f"no C++: {made}")


def test_probabilities_of_verdicts_against_a_loop_of_decompositions(benchmark) -> None:
    """10 000 sampled arms, 31 set points, all elements of D and h; the loop does not even judge."""
    arm = gd.load_arm("puma560")
    motion = gd.read_trajectory("pick-and-place", arm)
    uncertainty, samples, looped = "mass=5%,com=2mm,inertia=10%", 10_000, 100

    def ours() -> object:
        return gd.tables.robustness(arm, motion, uncertainty, samples=samples)

    def loop() -> None:
        for _ in range(looped):
            gd.tables.decompose_states(arm, gd.tables.states_of(motion), christoffel=False, drives=False)

    ours()
    pairs = [(seconds(loop) / looped, seconds(ours) / samples) for _ in range(ROUNDS)]
    start = time.process_time()
    benchmark.pedantic(ours, rounds=1)
    benchmark.extra_info["seconds_of_processor_time"] = time.process_time() - start
    benchmark.extra_info["times_faster"] = float(np.median([theirs / own for theirs, own in pairs]))
    print(
        f"\n{samples} arms: {benchmark.extra_info['seconds_of_processor_time']:.2f} s of processor time, "
        f"{benchmark.extra_info['times_faster']:.0f} times faster than a loop of decompositions"
    )


def test_a_table_of_many_columns_against_pandas(benchmark, tmp_path) -> None:
    """32 000 columns, of which two are the joints': each column is looked at once."""
    path, names = tmp_path / "wide.csv", [f"sensor_{k}" for k in range(32_000)]
    table = pd.DataFrame(np.zeros((40, len(names))), columns=names)
    table.insert(0, "q2", np.linspace(0.0, 0.1, 40))
    table.insert(0, "q1", np.linspace(0.0, 0.2, 40))
    table.insert(0, "time", np.linspace(0.0, 1.0, 40))
    table.to_csv(path, index=False)
    arm = gd.load_arm("two_link")

    def ours() -> object:
        return gd.read_trajectory(path, arm)

    ratios = sorted(seconds(ours) / seconds(lambda: pd.read_csv(path)) for _ in range(ROUNDS))
    benchmark.extra_info["times_slower_than_pandas"] = ratios[len(ratios) // 2]
    benchmark.pedantic(ours, rounds=1)
    print(f"\n32 000 columns: {ratios[len(ratios) // 2]:.1f} times the processor time of pandas.read_csv")
