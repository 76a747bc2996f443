"""Making a simplified model, and evaluating it, against Pinocchio's recursive Newton-Euler."""

from __future__ import annotations

import time

import numpy as np
import pinocchio
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model

STATES = 4000


def seconds(run, rounds: int = 5) -> float:
    """Shortest of some rounds."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


@pytest.mark.parametrize("level", ["term", "energy"])
def test_simplify_at_the_default_budget(benchmark, level) -> None:
    """The PUMA with drives over 4000 states: asked for are under 5 s."""
    arm = gd.load_arm("puma560")
    states = gd.tables.states_in_box(arm, STATES)
    model = benchmark.pedantic(
        lambda: gd.simplify(arm, states, level=level, drives=True), rounds=3, iterations=1
    )
    identified = seconds(lambda: gd.tables.harmonics_of(arm))
    made = benchmark.stats.stats.min
    benchmark.extra_info["operations"] = model.operations.total
    benchmark.extra_info["times_the_identification"] = made / identified
    print(f"\n{level}: {made:.2f} s, {made / identified:.0f} times the identification; {model.operations}")


def test_torque_of_a_simplified_model_against_a_loop_over_rnea(benchmark) -> None:
    arm = gd.load_arm("puma560")
    states = gd.tables.states_in_box(arm, STATES)
    model = gd.simplify(arm, states, level="energy", drives=False)
    peer = pinocchio_model(arm)
    data = peer.createData()
    q, qd, qdd = states.q, states.qd, states.qdd

    def loop() -> np.ndarray:
        return np.array([pinocchio.rnea(peer, data, *state) for state in zip(q, qd, qdd, strict=True)])

    benchmark(lambda: model.torque(q, qd, qdd))
    ours, theirs = seconds(lambda: model.torque(q, qd, qdd)), seconds(loop)
    benchmark.extra_info["times_faster_than_a_loop_over_rnea"] = theirs / ours
    print(
        f"\ntorque per state: {1e6 * ours / STATES:.2f} us, Pinocchio loop {1e6 * theirs / STATES:.2f} us, "
        f"{theirs / ours:.1f} times faster"
    )
