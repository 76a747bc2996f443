"""Identification of a PUMA 560 from a log against the usual loop: Pinocchio's regressors and lstsq.

Run with `python -m pytest benchmarks/test_identify.py -s`.
"""

from __future__ import annotations

import time

import numpy as np
import pinocchio as pin

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from logs_of_arms import TrueArm, fourier

ROUNDS = 3


def test_against_a_loop_over_pinocchios_regressors(benchmark) -> None:
    puma = gd.load_arm("puma560")
    log = TrueArm.near(puma, 1).log(*fourier(puma, 30.0, 200.0, 0))
    model, n = pinocchio_model(puma), 6
    data = model.createData()
    assert log.recording is not None

    def theirs() -> np.ndarray:
        rows = []
        for q, qd, qdd in zip(log.q, log.qd, log.qdd, strict=True):
            links = pin.computeJointTorqueRegressor(model, data, q, qd, qdd)
            rows.append(np.hstack([links, *map(np.diag, (qdd, np.sign(qd), qd)), np.eye(n)]))
        return np.linalg.lstsq(np.vstack(rows), log.recording.torque.ravel(), rcond=None)[0]

    def ours() -> gd.types.Identification:
        return gd.identify(puma, log)

    ours()
    pairs = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        theirs()
        middle = time.perf_counter()
        ours()
        pairs.append((middle - begin) / (time.perf_counter() - middle))
    benchmark.pedantic(ours, rounds=ROUNDS)
    benchmark.extra_info["times_faster"] = float(np.median(pairs))
    print(f"\nidentification of {len(log.time)} readings: {np.median(pairs):.1f} times faster than the loop")
