"""What cannot be simulated is refused, and what gives up says where."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from simulated import DRIVEN, LENGTH, limp, pendulum, undriven

from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.simulation import Integration, simulate
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError

TIME, VALUES = [0.0, 0.5, 1.0], np.zeros((3, 2))


@pytest.mark.parametrize(
    ("change", "what", "where"),
    [
        ({"q0": [0.0]}, "q0 does not fit arm two_link", "q0"),
        ({"q0": np.zeros((2, 2)), "qd0": np.zeros((2, 2))}, "starts from one state", "q0"),
        ({"qd0": [0.0, np.nan]}, "qd0 is not finite", "qd0[1]"),
        ({"duration": 0.0}, "duration is not positive", "duration"),
        ({"duration": np.inf}, "duration is not positive", "duration"),
        ({"set_points": 1}, "at least two set points", "set_points"),
        ({"set_points": 2.5}, "at least two set points", "set_points"),
        ({"method": "lagrange"}, "no formulation 'lagrange'", "method"),
        ({"integrator": "Euler"}, "no integrator 'Euler'", "integrator"),
        ({"rtol": 1e-15}, "cannot keep these tolerances", "rtol, atol"),
        ({"atol": 0.0}, "cannot keep these tolerances", "rtol, atol"),
        ({"atol": np.nan}, "cannot keep these tolerances", "rtol, atol"),
        ({"torque": 3.0}, "neither a function nor a history", "torque"),
        ({"torque": (TIME, "abc")}, "neither a function nor a history", "torque"),
        ({"torque": (TIME, np.zeros((3, 3)))}, "torque history does not fit arm two_link", "torque"),
        ({"torque": ([0.0], np.zeros((1, 2)))}, "torque history does not fit arm two_link", "torque"),
        ({"torque": ([0.0, 1.0, 1.0], VALUES)}, "its time does not increase", "torque"),
        ({"torque": (TIME, VALUES + np.inf)}, "not finite", "torque"),
        ({"torque": (TIME, VALUES), "duration": 1.5}, "does not cover the simulation", "torque"),
        ({"torque": (np.array(TIME) + 0.1, VALUES)}, "does not cover the simulation", "torque"),
    ],
)
def test_bad_input(two_link, change, what, where):
    arguments = {"torque": limp(2), "q0": [0.0, 0.0], "qd0": [0.0, 0.0], "duration": 0.5} | change
    how = {name: arguments.pop(name) for name in vars(Integration()) if name in arguments}
    with pytest.raises(UsageError, match=what) as caught:
        simulate(two_link, **arguments, integration=Integration(**how))
    assert caught.value.details["where"] == where


def test_an_arm_without_drives(two_link):
    for asked in (DRIVEN, Drivetrain(friction=True)):
        with pytest.raises(ArmError, match="describes no drives"):
            undriven(two_link, 0.1, asked)


def test_a_torque_function_that_misbehaves(two_link):
    for torque, found in (
        (lambda t, q, qd: [1.0], "shape (1,)"),
        (lambda t, q, qd: [np.nan, 0], "[nan, 0.0]"),
    ):
        with pytest.raises(GdAnalyzeError, match="torque function does not give") as caught:
            simulate(two_link, torque, [0, 0], [0, 0], 0.1)
        assert caught.value.details["found"] == found
        assert caught.value.details["where"] == "t = 0 s"


def test_an_integrator_that_gives_up():
    """qdd grows with the square of the rate: infinite at t = 1, and no step is small enough there."""
    arm = dataclasses.replace(pendulum(), gravity=np.zeros(3))
    inertia = 2.0 * LENGTH**2
    rough = Integration(rtol=1e-6, atol=1e-6)
    with pytest.raises(GdAnalyzeError, match=r"gives up|grows without bounds") as caught:
        simulate(arm, lambda t, q, qd: inertia * qd**2, [0.0], [1.0], 2.0, integration=rough)
    assert caught.value.details["where"].startswith(("t = 1 ", "t = 1.0", "t = 0.99"))
