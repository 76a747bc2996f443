"""Programs of general arms with something left out: their error is bounded, whatever was done to them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification import Box, Tube, certify
from gd_analyze.levels import TERM, ErrorTable, ExactForm, Promise, SimplifiedModel
from gd_analyze.levels.kept_programs import inputs_of
from gd_analyze.levels.recursion import NUMBER, Change
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.states import States
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray
from strategies import arms, examples


def model_of(arm: RobotArm, program: Program) -> SimplifiedModel:
    """A model that is this program and promises nothing."""
    n = arm.n_joints
    nothing = ErrorTable(np.ones(n), np.zeros(n), np.zeros(n))
    promise = Promise(np.ones(n), "1 N m", nothing, {"box": "drawn", "states": 5, "seed": 0})
    return SimplifiedModel(
        level=TERM,
        form=ExactForm(arm),
        terms={},
        program=program,
        operations_full=OperationCount(3, 2, 1),
        promise=promise,
    )


def pruned(arm: RobotArm, share: float, rng: np.random.Generator) -> SimplifiedModel:
    """The exact recursion with products replaced by nothing, and sines and cosines by numbers."""
    recursion = ExactForm(arm).recursion
    changes = {}
    for place, step in enumerate(recursion.steps):
        if rng.random() < share and step.operation in ("multiply", "cos", "sin"):
            changes[Change(place, NUMBER)] = 0.0 if step.operation == "multiply" else float(rng.normal())
    return model_of(arm, recursion.changed(changes))


def box_of(arm: RobotArm, rng: np.random.Generator) -> Box:
    """Narrow ranges, wide ones, and full circles."""
    n = arm.n_joints
    middle, half = rng.uniform(-1.0, 1.0, n), rng.choice([0.1, 1.5, 2.9, 4.0], n)
    half = np.where(arm.is_revolute, half, 0.3)
    return Box(middle - half, middle + half, rng.uniform(0.5, 2.0, n), rng.uniform(0.0, 5.0, n))


def errors_at(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
    """Differences from the exact recursion, shape (N, n)."""
    inputs = inputs_of(States(q, qd, qdd))
    return np.abs(model.program.run(inputs) - model.form.recursion.program.run(inputs)).T


def round_off(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> float:
    """Some thousand operations' eps of the largest torques, whose parts may be some ten times larger."""
    inputs = inputs_of(States(q, qd, qdd))
    largest = np.abs(model.program.run(inputs)).max() + np.abs(model.form.recursion.program.run(inputs)).max()
    return 1e4 * float(np.finfo(float).eps) * float(largest)


def searched(model: SimplifiedModel, box: Box, joint: int, rng: np.random.Generator) -> FloatArray:
    """State (3, n) that climbing in all its numbers finds, from the best of many drawn."""
    lower = np.stack([box.lower, -box.rate, -box.acceleration])
    upper = np.stack([box.upper, box.rate, box.acceleration])

    def value(states: FloatArray) -> FloatArray:
        return errors_at(model, *states.transpose(1, 0, 2))[:, joint]

    drawn = rng.uniform(lower, upper, (2000, *lower.shape))
    drawn[::2, 1:] = np.sign(drawn[::2, 1:]) * upper[1:]
    best = drawn[value(drawn).argmax()]
    for step in (0.2, 0.1, 0.05, 0.02, 0.01):
        for _ in range(4):
            moves = step * rng.normal(size=(300, *lower.shape)) * (rng.random((300, *lower.shape)) < 0.3)
            tried = np.clip(best + moves * (upper - lower), lower, upper)
            tried[0] = best
            best = tried[value(tried).argmax()]
    return best


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


def general_arm(joints: int, rng: np.random.Generator, slides: bool) -> RobotArm:
    """Axes in any direction, full inertias; perhaps the third joint slides."""
    from gd_analyze.robots import Joint, Link, Placement
    from strategies import random_inertia, random_rotation

    kinds = ["prismatic" if slides and i == 2 else "revolute" for i in range(joints)]
    made = [
        (
            Joint(f"joint {i}", kind, Placement(random_rotation(rng), rng.uniform(-0.3, 0.3, 3))),
            Link(
                f"link {i}",
                rng.uniform(0.5, 3.0),
                rng.uniform(-0.1, 0.1, 3),
                random_inertia(rng),
                Placement(),
            ),
        )
        for i, kind in enumerate(kinds)
    ]
    return RobotArm("general", *(tuple(x) for x in zip(*made, strict=True)), np.array([0.0, 0.0, -9.81]))


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
    arm = dataclasses.replace(arm)
    model = pruned(arm, 0.01, rng)
    around = Box(np.full(6, -np.pi), np.full(6, np.pi), np.ones(6), np.full(6, 5.0))
    ratios = [certify(model, around, effort=effort).ratio.max() for effort in (1, 2_000)]
    assert ratios[0] > 2.5
    assert ratios[1] < 2.2
