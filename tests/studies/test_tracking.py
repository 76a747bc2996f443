"""A budget in tracking error: what it allows of torque, and that models within it track as asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import UsageError
from gd_analyze.studies.control import followable
from gd_analyze.studies.control_law import Reference
from gd_analyze.studies.tracking import TrackingBudget, tip_columns, tip_position
from gd_analyze.types import Placement


def test_words_are_read():
    plain = TrackingBudget.parse("tracking 0.1deg, 2mm")
    assert (plain.tip, plain.settings.tolerance.prismatic) == (None, 2e-3)
    assert (plain.settings.bandwidth, plain.settings.damping, plain.settings.usual_rate) == (20.0, 1.0, 500.0)
    tip = TrackingBudget.parse("Tracking 0.5 mm at the end effector at 60 rad/s damping 0.7")
    assert (tip.tip, tip.settings.bandwidth, tip.settings.damping) == (5e-4, 60.0, 0.7)
    assert tip.settings.usual_rate == 25.0 * 60.0
    assert TrackingBudget.parse("1% norm") is None


@pytest.mark.parametrize(
    "words",
    [
        "tracking",
        "tracking soon",
        "tracking 1deg at the tip",
        "tracking 0mm at the tip",
        "tracking 1mm at 9 Hz",
    ],
)
def test_other_words_are_refused(words):
    with pytest.raises(UsageError):
        TrackingBudget.parse(words)
    with pytest.raises(UsageError):
        gd.types.Budget.parse(words)


@pytest.mark.parametrize("name", ["two_link", "puma560", "stanford"])
def test_columns_are_slopes_of_the_end_effectors_position(name):
    arm = replace(gd.load_arm(name), tip="hand", tip_frame=Placement(np.eye(3), np.array([0.1, -0.2, 0.3])))
    q, step = gd.tables.states_in_box(arm, 20, seed=1).q.T, 1e-6
    found = tip_columns(arm, q)
    for i in range(arm.n_joints):
        moved = [q + sign * step * np.eye(arm.n_joints)[:, [i]] for sign in (1, -1)]
        slope = (tip_position(arm, moved[0]) - tip_position(arm, moved[1])) / (2 * step)
        # Central differences: eps times a metre over the step, and the third derivative times its square.
        np.testing.assert_allclose(np.linalg.norm(slope, axis=0), found[i], atol=1e-8)


@pytest.mark.parametrize(
    ("name", "motion", "words"),
    [
        ("two_link", "two-link-swing", "0.3deg at 15 rad/s damping 0.6"),
        ("two_link", "two-link-swing", "2mm at the end effector"),
        ("puma560", "pick-and-place", "1mm at the end effector"),
    ],
)
def test_no_torque_errors_within_the_budget_do_worse_and_some_as_badly(name, motion, words):
    """The right side of the loop times the integral of its impulse response, signs as bad as can be."""
    arm = gd.load_arm(name)
    planned = gd.read_trajectory(motion, arm)
    wanted = TrackingBudget.parse(f"tracking {words}")
    allowed = gd.tracking_budget(arm, planned, words)
    torques = np.array([entry[0].amount for entry in allowed.entries])
    q, _, _ = Reference.of(followable(planned)).sampled()
    still = gd.types.States(q.T, np.zeros_like(q.T), np.zeros_like(q.T))
    inertia = gd.tables.decompose_states(arm, still, christoffel=False)["inertia"].sum(axis=1)
    inertia += np.diag(arm.drive_inertia) if arm.counts_drives(None) else 0.0
    errors = wanted.settings.gains.error_per_acceleration * (np.abs(np.linalg.inv(inertia)) @ torques).max(
        axis=0
    )
    if wanted.tip is None:
        reached = (errors / wanted.settings.tolerance.of(arm)).max()
    else:
        reached = (tip_columns(arm, q).T @ errors).max() / wanted.tip
    # Inverting D loses its condition number times eps.
    assert reached == pytest.approx(1.0, abs=1e-9)
