"""Arrays that no state of an arm has are refused with the documented error, by everything that takes some."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.forward_dynamics import joint_accelerations
from gd_analyze.dynamics.kinematics import kinetic_energy
from gd_analyze.errors import ArmError, GdAnalyzeError, ModelError, TrajectoryError, UsageError
from gd_analyze.tables import with_payload

FINE = np.zeros((3, 6))

WRONG: dict[str, Any] = {
    "another number of joints": np.zeros((3, 5)),
    "a scalar": 0.5,
    "nothing": None,
    "no states": np.zeros(0),
    "rows of different lengths": [[0.0] * 6, [0.0] * 5],
    "text": "abc",
    "complex numbers": np.full((3, 6), 1j),
    "a mapping": {"a": 1},
    "nan": np.full((3, 6), np.nan),
    "numbers too large": np.full((3, 6), 1e300),
}


def in_place(x: Any, k: int) -> list[Any]:
    return [x if j == k else FINE for j in range(3)]


@pytest.fixture(scope="module")
def calls(puma, pick_and_place, two_link, swing) -> list[tuple[Any, type[GdAnalyzeError], str]]:
    """Functions of one array, what each raises, and what is right there after all."""
    model = gd.simplify(puma, pick_and_place, "2%")
    dataset = gd.decompose(puma, pick_and_place, christoffel=False)
    # What takes nothing for everything does all the work then.
    small, time = gd.simplify(two_link, swing, "5%"), np.arange(3.0)
    return [
        *((lambda x, k=k: model.torque(*in_place(x, k)), ModelError, "") for k in range(3)),
        (model.inertia, ModelError, ""),
        (lambda x: model.coriolis_centrifugal(FINE, x), ModelError, ""),
        (model.gravity_loading, ModelError, ""),
        *((lambda x, k=k: gd.types.States(*in_place(x, k)), TrajectoryError, "") for k in range(3)),
        (lambda x: gd.tables.decompose_states(puma, gd.types.States(x, x, x)), TrajectoryError, ""),
        (lambda x: gd.Trajectory(time, x, FINE, FINE), TrajectoryError, ""),
        (lambda x: gd.Trajectory(x, FINE, FINE, FINE), TrajectoryError, ""),
        (lambda x: gd.types.Box(x, np.ones(6), np.ones(6), np.ones(6)), UsageError, ""),
        (lambda x: gd.plan(puma, x, np.zeros(6), 2.0), TrajectoryError, ""),
        (lambda x: gd.plan(puma, np.zeros(6), np.full(6, 0.1), x), TrajectoryError, "a scalar"),
        (lambda x: with_payload(puma, 1.0, x), ArmError, ""),
        (lambda x: gd.rank(dataset, budget=x), UsageError, "a scalar"),
        (lambda x: kinetic_energy(puma, x, FINE), UsageError, ""),
        (lambda x: joint_accelerations(puma, x, FINE, FINE), UsageError, ""),
        (lambda x: gd.analyze(x, pick_and_place), ArmError, ""),
        (lambda x: gd.analyze(puma, x), TrajectoryError, ""),
        (lambda x: gd.simplify(two_link, x), TrajectoryError, "nothing"),
        (lambda x: gd.evaluate(model, x), TrajectoryError, ""),
        (lambda x: gd.certify(small, x), UsageError, "nothing"),
        (lambda x: gd.simplify(two_link, swing, x), UsageError, "nothing, a scalar"),
    ]  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_array_is_refused(calls, wrong):
    for k, (call, error, fits) in enumerate(calls):
        if wrong in fits.split(", "):
            call(WRONG[wrong])
            continue
        with pytest.raises(GdAnalyzeError) as caught:
            call(WRONG[wrong])
        assert type(caught.value) is error, (k, caught.value)
        assert {"where", "expected", "found"} & caught.value.details.keys()


@pytest.mark.parametrize("use", [gd.types.ExactDynamics.of, gd.simplify, gd.tables.torque_uncertainty])
def test_of_no_states_nothing_can_be_said(puma, use):
    with pytest.raises(TrajectoryError, match="there are no states"):
        use(puma, gd.types.States(*[np.zeros((0, 6))] * 3))


def test_lists_and_states_of_any_leading_shape_will_do(puma):
    model = gd.simplify("two_link", "two-link-swing", "5%")
    arrays = np.broadcast_arrays([0.0, 1.0], [1.0, 0.0], [[0.0] * 2, [1.0] * 2])
    np.testing.assert_array_equal(model.torque([0, 1], [1, 0], [[0, 0], [1, 1]]), model.torque(*arrays))
    assert gd.tables.decompose_states(puma, gd.types.States([0] * 6, [0] * 6, [0] * 6))["torque"].shape == (
        6,
    )
    states = gd.tables.states_in_box(puma, 12)
    torque = gd.types.ExactDynamics.of(puma, states).torque
    rows = gd.types.States(*(x.reshape(3, 4, 6) for x in states.arrays))
    np.testing.assert_array_equal(gd.types.ExactDynamics.of(puma, rows).torque, torque)
