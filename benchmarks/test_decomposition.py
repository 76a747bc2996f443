"""Decomposition of 100 000 set points against a Python loop over Pinocchio, which gives no split.

Run with `python -m pytest benchmarks -s`; the ratio per set point is printed and kept in `extra_info`.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model

N_OURS = 100_000
N_THEIRS = 20_000
ROUNDS = 5


@pytest.fixture(scope="module")
def states() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(1987)
    q, qd, qdd = random.uniform(-2.0, 2.0, (3, N_OURS, 6))
    return q, qd, qdd


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def test_decomposition_against_a_loop_over_pinocchio(benchmark, states) -> None:
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

    def ours() -> dict[str, np.ndarray]:
        return gd.decompose_states(arm, gd.States(q, qd, qdd), drives=False)

    ours()
    # Interleaved, so that a machine whose speed drifts slows both; the fixture times ours once more.
    pairs = [(seconds(theirs) / N_THEIRS, seconds(ours) / N_OURS) for _ in range(ROUNDS)]
    benchmark.pedantic(ours, rounds=ROUNDS)
    ratios = sorted(their / our for their, our in pairs)
    ratio = ratios[len(ratios) // 2]
    benchmark.extra_info["pinocchio_loop_us_per_set_point"] = 1e6 * float(np.median([p[0] for p in pairs]))
    benchmark.extra_info["ours_us_per_set_point"] = 1e6 * float(np.median([p[1] for p in pairs]))
    benchmark.extra_info["times_faster"] = ratio
    benchmark.extra_info["peak_memory_mib"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"\nper set point: Pinocchio loop {benchmark.extra_info['pinocchio_loop_us_per_set_point']:.2f} us, "
        f"ours with split and h_ijk {benchmark.extra_info['ours_us_per_set_point']:.2f} us, "
        f"{ratio:.2f} times faster (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
    )


def test_probabilities_of_verdicts_against_a_loop_of_decompositions(benchmark) -> None:
    """10 000 sampled arms, 31 set points, all elements of D and h; the loop does not even judge."""
    arm = gd.load_arm("puma560")
    motion = gd.read_trajectory("pick-and-place", arm)
    uncertainty, samples, looped = "mass=5%,com=2mm,inertia=10%", 10_000, 100

    def ours() -> object:
        return gd.robustness(arm, motion, uncertainty, samples=samples)

    def loop() -> None:
        for _ in range(looped):
            gd.decompose_states(arm, gd.states_of(motion), christoffel=False, drives=False)

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
