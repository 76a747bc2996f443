"""Arrays that no state of an arm has are refused with the documented error, by everything that takes some."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.dynamics.simulation import joint_accelerations
from gd_analyze.errors import ArmError, GdAnalyzeError, ModelError, TrajectoryError, UsageError
from gd_analyze.robots.payload import with_payload

FINE = np.zeros((3, 6))

WRONG: dict[str, Any] = {
    "too few joints": np.zeros((3, 5)),
    "too many joints": np.zeros((3, 7)),
    "a column": np.zeros((6, 1)),
    "a scalar": 0.5,
    "nothing": None,
    "no states": np.zeros(0),
    "rows of different lengths": [[0.0] * 6, [0.0] * 5],
    "text": "abc",
    "a list of text": ["a"] * 6,
    "complex numbers": np.full((3, 6), 1j),
    "objects": np.array([object()] * 6),
    "a mapping": {"a": 1},
    "nan": np.full((3, 6), np.nan),
    "infinity": np.full((3, 6), np.inf),
    "numbers too large": np.full((3, 6), 1e300),
}


class Called(NamedTuple):
    """A function of one array, and what it raises where that is wrong."""

    call: Callable[[Any], Any]
    error: type[GdAnalyzeError]


@pytest.fixture(scope="module")
def calls(puma, pick_and_place) -> dict[str, Called]:
    model = gd.simplify(puma, pick_and_place, "2%")
    dataset = gd.decompose(puma, pick_and_place, christoffel=False)
    time = np.arange(3.0)
    made_of = {
        "decompose_states": lambda states: gd.decompose_states(puma, states),
        "simplify": lambda states: gd.simplify(puma, states),
        "evaluate": lambda states: gd.evaluate(model, states),
        "ExactDynamics.of": lambda states: gd.ExactDynamics.of(puma, states).torque,
        "payload_effect": lambda states: gd.payload_effect(model, states),
        "torque_uncertainty": lambda states: gd.torque_uncertainty(puma, states),
    }
    return {
        "torque, q": Called(lambda x: model.torque(x, FINE, FINE), ModelError),
        "torque, qd": Called(lambda x: model.torque(FINE, x, FINE), ModelError),
        "torque, qdd": Called(lambda x: model.torque(FINE, FINE, x), ModelError),
        "inertia": Called(model.inertia, ModelError),
        "coriolis_centrifugal, q": Called(lambda x: model.coriolis_centrifugal(x, FINE), ModelError),
        "coriolis_centrifugal, qd": Called(lambda x: model.coriolis_centrifugal(FINE, x), ModelError),
        "gravity_loading": Called(model.gravity_loading, ModelError),
        **{
            name: Called(lambda x, use=use: use(gd.States(x, x, x)), TrajectoryError)
            for name, use in made_of.items()
        },
        "States, q": Called(lambda x: gd.States(x, FINE, FINE), TrajectoryError),
        "States, qd": Called(lambda x: gd.States(FINE, x, FINE), TrajectoryError),
        "States, qdd": Called(lambda x: gd.States(FINE, FINE, x), TrajectoryError),
        "Trajectory, q": Called(lambda x: gd.Trajectory(time, x, FINE, FINE), TrajectoryError),
        "Trajectory, qdd": Called(lambda x: gd.Trajectory(time, FINE, FINE, x), TrajectoryError),
        "Trajectory, time": Called(lambda x: gd.Trajectory(x, FINE, FINE, FINE), TrajectoryError),
        "Box": Called(lambda x: gd.Box(x, np.ones(6), np.ones(6), np.ones(6)), UsageError),
        "plan, start": Called(
            lambda x: gd.plan(puma, x, np.zeros(6), schedule=gd.Schedule(2.0)), TrajectoryError
        ),
        "Schedule": Called(lambda x: gd.Schedule(x), TrajectoryError),
        "with_payload": Called(lambda x: with_payload(puma, 1.0, x), ArmError),
        "rank, budget": Called(lambda x: gd.rank(dataset, budget=x), UsageError),
        "kinetic_energy": Called(lambda x: kinetic_energy(puma, x, FINE), UsageError),
        "potential_energy": Called(lambda x: potential_energy(puma, x), UsageError),
        "joint_accelerations": Called(lambda x: joint_accelerations(puma, x, FINE, FINE), UsageError),
        "an arm": Called(lambda x: gd.find(x, pick_and_place), ArmError),
        "a trajectory": Called(lambda x: gd.find(puma, x), TrajectoryError),
        "states to simplify for": Called(lambda x: gd.simplify(puma, x), TrajectoryError),
        "states to evaluate at": Called(lambda x: gd.evaluate(model, x), TrajectoryError),
        "a region": Called(lambda x: gd.certify(model, x), UsageError),
        "a budget": Called(lambda x: gd.simplify(puma, pick_and_place, x), UsageError),
    }


NAMES = [
    *(f"torque, {x}" for x in ("q", "qd", "qdd")),
    "inertia", "coriolis_centrifugal, q", "coriolis_centrifugal, qd", "gravity_loading",
    "decompose_states", "simplify", "evaluate", "ExactDynamics.of", "payload_effect", "torque_uncertainty",
    *(f"States, {x}" for x in ("q", "qd", "qdd")),
    "Trajectory, q", "Trajectory, qdd", "Trajectory, time", "Box", "plan, start", "Schedule", "with_payload",
    "rank, budget", "kinetic_energy", "potential_energy", "joint_accelerations",
    "an arm", "a trajectory", "states to simplify for", "states to evaluate at", "a region", "a budget",
]  # fmt: skip

# What is a value there, or by default.
FITS = {
    ("Schedule", "a scalar"),
    ("rank, budget", "a scalar"),
    ("a region", "nothing"),
    ("a budget", "nothing"),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("name", NAMES)
def test_a_wrong_array_is_refused(calls, name, wrong):
    if (name, wrong) in FITS:
        calls[name].call(WRONG[wrong])
        return
    with pytest.raises(GdAnalyzeError) as caught:
        calls[name].call(WRONG[wrong])
    assert type(caught.value) is calls[name].error, caught.value
    assert {"where", "expected", "found"} & caught.value.details.keys()


@pytest.mark.parametrize(
    "name", ["simplify", "evaluate", "ExactDynamics.of", "payload_effect", "torque_uncertainty"]
)
def test_of_no_states_nothing_can_be_said(calls, name):
    with pytest.raises(TrajectoryError, match="there are no states"):
        calls[name].call(np.zeros((0, 6)))


def test_the_table_is_whole(calls):
    assert list(calls) == NAMES


def test_lists_and_whole_numbers_will_do(calls, puma):
    model = gd.simplify("two_link", "two-link-swing", "5%")
    np.testing.assert_array_equal(
        model.torque([0, 1], [1, 0], [[0, 0], [1, 1]]),
        model.torque(*np.broadcast_arrays([0.0, 1.0], [1.0, 0.0], [[0.0, 0.0], [1.0, 1.0]])),
    )
    assert gd.decompose_states(puma, gd.States([0] * 6, [0] * 6, [0] * 6))["torque"].shape == (6,)


def test_states_of_any_leading_shape(puma):
    """One state, rows of them, or rows of rows."""
    states = gd.states_in_box(puma, 12)
    rows = gd.States(*(x.reshape(3, 4, 6) for x in states.arrays))
    torque = gd.ExactDynamics.of(puma, states).torque
    np.testing.assert_array_equal(gd.ExactDynamics.of(puma, rows).torque, torque)
    one = gd.ExactDynamics.of(puma, gd.States(*(x[0] for x in states.arrays)))
    # One state by itself takes another path through the same sums.
    np.testing.assert_allclose(one.torque, torque[:1], rtol=0, atol=one.round_off + 1e-12)
