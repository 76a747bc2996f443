"""Motions of arrays in memory: plans as they are, readings smoothed."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import TrajectoryError
from recordings import Motion, instants, rms

TIME = instants(100.0, 5.0)


def test_a_plan_is_taken_as_it_is():
    motion = Motion.of(1)
    q, qd, qdd = (motion.at(TIME, order) for order in range(3))
    found = gd.Trajectory.from_arrays(TIME.tolist(), q.tolist(), qd, qdd, name="mine")
    assert (found.q == q).all()
    assert (found.qdd == qdd).all()
    assert found.name == "mine"
    assert found.rates_from == "given"
    assert found.recording is None


def test_what_is_missing_is_derived():
    motion = Motion.of(1)
    found = gd.Trajectory.from_arrays(TIME, motion.at(TIME))
    # A quintic spline errs by h^4 times the sixth derivative, 1e-8 * (2 pi 1.4)^6 * 0.02 = 1e-4; ends more.
    np.testing.assert_allclose(found.qdd, motion.at(TIME, 2), atol=5e-3)
    assert found.derived == ("qd", "qdd")


def test_readings_are_smoothed(two_link):
    motion = Motion.of(1)
    noise = 1e-4 * np.random.default_rng(2).normal(size=(len(TIME), 2))
    found = gd.Trajectory.from_arrays(TIME, motion.at(TIME) + noise, measured=True, arm=two_link)
    assert found.recording.measured
    truth = motion.at(TIME, 2)
    assert (rms(found.qdd - truth) < 0.1 * rms(truth)).all()
    stiff = gd.Trajectory.from_arrays(
        TIME, motion.at(TIME) + noise, measured=True, treatment=gd.Treatment(cutoff=2.0)
    )
    assert stiff.recording.cutoff.tolist() == [2.0, 2.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0, 1.0], [[0.0], [1.0]]), "too few set points to derive what is missing"),
        ((TIME, np.zeros(500)), "at least one set point"),
        ((TIME, np.zeros((499, 2))), "time has the wrong shape"),
        ((TIME, np.zeros((500, 2)), np.zeros((500, 3))), "qd has the wrong shape"),
        ((TIME[::-1], np.zeros((500, 2))), "time does not increase"),
        ((TIME, np.full((500, 2), np.nan)), "q is not finite at set point 1"),
        ((TIME, "here"), "q"),
    ],
)
def test_what_is_no_motion_is_refused(arguments, message):
    with pytest.raises(TrajectoryError, match=message):
        gd.Trajectory.from_arrays(*arguments)
