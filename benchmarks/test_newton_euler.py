"""Newton-Euler in link frames at 100 000 set points, vectorised, against a Python loop over Pinocchio's rnea.

Run with `python -m pytest benchmarks -s`; the ratio per set point is printed and kept in `extra_info`.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pinocchio as pin

import gd_analyze as gd
from gd_analyze.dynamics.methods import METHODS, torque_of_states
from gd_analyze.dynamics.pinocchio_check import pinocchio_model, round_off_bounds

N_OURS = 100_000
N_THEIRS = 20_000
ROUNDS = 7


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def test_newton_euler_against_a_loop_over_rnea(benchmark) -> None:
    arm = gd.load_arm("puma560")
    random = np.random.default_rng(1987)
    q, qd, qdd = random.uniform(-2.0, 2.0, (3, N_OURS, 6))
    model = pinocchio_model(arm)
    data = model.createData()
    method = METHODS["newton_euler_link"]

    def theirs() -> np.ndarray:
        out = np.empty((N_THEIRS, 6))
        for k in range(N_THEIRS):
            out[k] = pin.rnea(model, data, q[k], qd[k], qdd[k])
        return out

    def ours() -> np.ndarray:
        return torque_of_states(method, arm, q, qd, qdd)

    difference = np.abs(ours()[:N_THEIRS] - theirs()).max()
    assert difference <= round_off_bounds(arm, q, qd, qdd)["torque"]
    # Interleaved, so that a machine whose speed drifts slows both; the fixture times ours once more.
    pairs = [(seconds(theirs) / N_THEIRS, seconds(ours) / N_OURS) for _ in range(ROUNDS)]
    benchmark.pedantic(ours, rounds=ROUNDS)
    ratios = sorted(their / our for their, our in pairs)
    ratio = ratios[len(ratios) // 2]
    their_time, our_time = (1e6 * float(np.median(times)) for times in zip(*pairs, strict=True))
    benchmark.extra_info["pinocchio_loop_us_per_set_point"] = their_time
    benchmark.extra_info["ours_us_per_set_point"] = our_time
    benchmark.extra_info["times_faster"] = ratio
    print(
        f"\nper set point: Pinocchio loop {their_time:.2f} us, ours {our_time:.2f} us, {ratio:.2f} times "
        f"faster (rounds: {', '.join(f'{r:.2f}' for r in ratios)})"
    )
