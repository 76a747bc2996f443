"""Programs of general arms with something left out: their error is bounded, whatever was done to them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.tube import Tube
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from pruned_recursions import errors_at, general_arm, pruned, round_off, searched
from strategies import arms, examples


def box_of(arm: RobotArm, rng: np.random.Generator) -> Box:
    """Narrow ranges, wide ones, and full circles."""
    n = arm.n_joints
    middle, half = rng.uniform(-1.0, 1.0, n), rng.choice([0.1, 1.5, 2.9, 4.0], n)
    half = np.where(arm.is_revolute, half, 0.3)
    return Box(middle - half, middle + half, rng.uniform(0.5, 2.0, n), rng.uniform(0.0, 5.0, n))


@examples(25)
@given(arms(max_joints=5), st.integers(0, 2**32 - 1), st.sampled_from([1, 300, 10_000]))
def test_no_state_exceeds_it(arm: RobotArm, seed: int, effort: int) -> None:
    rng = np.random.default_rng(seed)
    model, box = pruned(arm, rng.choice([0.02, 0.2]), rng), box_of(arm, rng)
    certificate = certify(model, box, effort=effort)
    for joint in range(arm.n_joints):
        state = searched(model, box, joint, rng)[:, None]
        found = errors_at(model, *state)[0, joint]
        assert found <= certificate.certified[joint] + round_off(model, *state)
    worst = certificate.worst_states
    reached = np.diag(errors_at(model, *worst))
    assert certificate.worst_found == pytest.approx(reached, rel=1e-9, abs=round_off(model, *worst))
    assert (certificate.worst_found <= certificate.certified).all()


@examples(2)
@given(st.integers(6, 7), st.integers(0, 2**32 - 1), st.booleans())
def test_of_many_joints(joints: int, seed: int, slides: bool) -> None:
    """Six and seven joints in general: 4 to 6 positions per angle do for a bound, if for no close one."""
    rng = np.random.default_rng(seed)
    arm = general_arm(joints, rng, slides)
    model = pruned(arm, 0.03, rng)
    box = box_of(arm, rng)
    certificate = certify(model, box, effort=40)
    for joint in range(joints):
        state = searched(model, box, joint, rng)[:, None]
        assert errors_at(model, *state)[0, joint] <= certificate.certified[joint] + round_off(model, *state)
        assert errors_at(model, *state)[0, joint] <= 1.2 * certificate.worst_found[joint] + round_off(
            model, *state
        )


@examples(8)
@given(arms(max_joints=6), st.integers(0, 2**32 - 1))
def test_along_a_motion(arm: RobotArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model, n = pruned(arm, 0.05, rng), arm.n_joints
    time = np.linspace(0.0, 1.0, 6)[:, None]
    ends = rng.uniform(-1.0, 1.0, (2, n))
    q = ends[0] + (ends[1] - ends[0]) * (3 * time**2 - 2 * time**3)
    qd = (ends[1] - ends[0]) * 6 * (time - time**2)
    qdd = (ends[1] - ends[0]) * (6 - 12 * time)
    tube = Tube.along(arm, Trajectory(time[:, 0], q, qd, qdd, "drawn"))
    certificate = certify(model, tube, effort=2000)
    for piece in range(0, len(tube), max(1, len(tube) // 8)):
        states = rng.uniform(tube.lower[piece], tube.upper[piece], (50, 3, n)).transpose(1, 0, 2)
        assert certificate.along is not None
        assert (errors_at(model, *states) <= certificate.along[piece] + round_off(model, *states)).all()


def test_more_effort_is_closer_for_many_joints() -> None:
    """Of a general six-joint arm the amplitudes alone leave a factor of four and more."""
    rng = np.random.default_rng(5)
    arm = general_arm(6, rng, slides=False)
    model = pruned(arm, 0.01, rng)
    around = Box(np.full(6, -np.pi), np.full(6, np.pi), np.ones(6), np.full(6, 5.0))
    ratios = [certify(model, around, effort=effort).ratio.max() for effort in (1, 2_000)]
    assert ratios[0] > 2.5
    assert ratios[1] < 2.2
