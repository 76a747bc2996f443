"""The cross-check must pass what is right, and must not pass what is wrong."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.dynamics.decomposition import decompose
from gd_analyze.dynamics.pinocchio_check import (
    MOST_SET_POINTS,
    cross_check,
    round_off_bounds,
)
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.trajectory import Trajectory
from strategies import examples, motions

QUANTITIES = ("inertia", "coriolis_centrifugal", "gravity_loading", "torque")


@examples(15)
@given(motions(max_joints=8))
def test_every_arm_passes(case):
    arm, motion = case
    residuals = cross_check(arm, decompose(arm, motion))
    assert tuple(dict.fromkeys(r.quantity for r in residuals)) == QUANTITIES
    assert all(0 <= r.largest <= r.bound for r in residuals)


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("wrong", ["one number", "nan"])
def test_a_wrong_number_anywhere_is_caught(puma, pick_and_place, pick_and_place_dataset, quantity, wrong):
    bounds = round_off_bounds(puma, pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    spoiled = pick_and_place_dataset.copy(deep=True)
    values = spoiled[quantity].values
    # Twice the bound: what is left after the honest residual still exceeds it.
    values[(17, *(-1,) * (values.ndim - 1))] += 2 * bounds[quantity] if wrong == "one number" else np.nan
    with pytest.raises(GdAnalyzeError, match=f"{quantity} disagrees with Pinocchio") as caught:
        cross_check(puma, spoiled)
    assert "round-off" in caught.value.details["expected"]
    assert "report" in caught.value.details["next"]


def test_another_arms_dataset_is_caught(two_link, puma, pick_and_place_dataset):
    heavier = _with_mass(puma, 1.000001)
    with pytest.raises(GdAnalyzeError, match="disagrees with Pinocchio"):
        cross_check(heavier, pick_and_place_dataset)


def test_drive_torque_does_not_count(puma, pick_and_place):
    driven = decompose(puma, pick_and_place, drives=True)
    assert cross_check(puma, driven)[3].largest <= cross_check(puma, driven)[3].bound
    with pytest.raises(GdAnalyzeError, match="torque disagrees"):
        cross_check(puma, driven.drop_vars("drive_torque"))


def test_long_trajectories_are_sampled_from_end_to_end(two_link):
    count = 5 * MOST_SET_POINTS
    time = np.arange(count) / 100
    q = np.stack([np.sin(time), np.cos(time)], axis=1)
    dataset = decompose(two_link, Trajectory(time, q, q, -q))
    cross_check(two_link, dataset)
    for k in (0, count - 1):
        spoiled = dataset.copy(deep=True)
        spoiled.torque.values[k, 0] += 1.0
        with pytest.raises(GdAnalyzeError):
            cross_check(two_link, spoiled)


def _with_mass(arm, factor):
    from dataclasses import replace

    links = (*arm.links[:-1], replace(arm.links[-1], mass=arm.links[-1].mass * factor))
    return replace(arm, links=links)
