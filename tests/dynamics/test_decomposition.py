"""The Dataset: its parts sum to the whole, whatever the shape and length of the states."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import TrajectoryError, UsageError
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.text import LARGEST
from gd_analyze.types import Link, Placement
from strategies import arms_with_states, examples, motions, random_states
from told import Told


@pytest.mark.parametrize("name", sorted(shipped_trajectories()))
def test_parts_sum_to_what_pinocchio_finds_on_every_shipped_trajectory(name):
    arm = gd.load_arm("two_link" if name.startswith("two-link") else "puma560")
    trajectory = gd.read_trajectory(name, arm)
    dataset = gd.decompose(arm, trajectory, drives=False)
    motion = trajectory.q, trajectory.qd, trajectory.qdd
    bounds = round_off_bounds(arm, *motion)
    for quantity, theirs in pinocchio_dynamics(arm, *motion).items():
        ours = dataset[quantity]
        ours = ours.sum("effect") if "effect" in ours.dims else ours
        assert np.abs(ours.values - theirs).max() <= bounds[quantity], quantity


@examples(15)
@given(arms_with_states(max_joints=4))
def test_arrays_are_states_in_place_of_a_motion(case):
    arm, states = case
    q, qd, qdd = states.arrays
    dataset = gd.decompose(arm, q=q, qd=qd, qdd=qdd)
    expected = gd.tables.decompose_states(arm, states)
    for name in ("inertia", "coriolis_centrifugal", "gravity_loading", "torque"):
        np.testing.assert_array_equal(dataset[name].values, expected[name], err_msg=name)
    assert dataset.time.values.tolist() == list(range(len(q)))
    # One velocity for all positions, at rest otherwise; a single state is a row.
    np.testing.assert_array_equal(gd.decompose(arm, q=q, qd=qd[0]).qd.values, np.broadcast_to(qd[0], q.shape))
    still = gd.decompose(arm, q=q[0])
    np.testing.assert_array_equal(still.torque.values, still.gravity_loading.values)
    assert still.sizes["time"] == 1


def test_a_motion_or_states_are_decomposed():
    for arguments, told in (
        ({}, "nothing to decompose"),
        ({"trajectory": "two-link-swing", "q": [0, 0]}, "a motion and states"),
        ({"trajectory": "two-link-swing", "qd": [0, 0]}, "qd is for states"),
        ({"q": [0, 0, 0]}, "q does not fit arm two_link"),
        ({"q": np.zeros((2, 2, 2))}, "q does not number its states"),
        ({"q": np.zeros((0, 2))}, "q does not number its states"),
        ({"q": [0, 0], "qd": "fast"}, "qd is not made of numbers"),
    ):
        with pytest.raises(UsageError, match=told):
            gd.decompose("two_link", **arguments)


@examples(15)
@given(motions(max_joints=6))
def test_everything_adds_up(case):
    arm, motion = case
    found = gd.decompose(arm, motion, by_link=True, terms=True)
    h, qd = found.coriolis_centrifugal, found.qd.values
    by_effect = found.coriolis_centrifugal_terms.groupby("term_effect").sum()
    centrifugal = np.einsum("teijj,tj->tei", found.christoffel.values, qd**2)
    coriolis = np.einsum("teijk,tj,tk->tei", found.christoffel.values, qd, qd) - centrifugal
    accelerating = np.einsum("teij,tj->ti", found.inertia.values, found.qdd.values)
    bounds = round_off_bounds(arm, motion.q, motion.qd, motion.qdd)
    for bound, sum_, whole in (
        ("inertia", found.inertia_by_link.sum("link"), found.inertia),
        ("gravity_loading", found.gravity_loading_by_link.sum("link"), found.gravity_loading),
        ("coriolis_centrifugal", found.coriolis_centrifugal_by_link.sum("link"), h),
        ("coriolis_centrifugal", by_effect.sel(term_effect=found.effect.values).values, h.values),
        # One rounding of each, of numbers no larger than h's own bound allows.
        ("coriolis_centrifugal", found.centrifugal + found.coriolis, h),
        ("coriolis_centrifugal", centrifugal, found.centrifugal.values),
        ("coriolis_centrifugal", coriolis, found.coriolis.values),
        ("torque", accelerating + h.sum("effect").values + found.gravity_loading.values, found.torque.values),
    ):
        assert float(np.abs(sum_ - whole).max()) <= bounds[bound]


@pytest.mark.parametrize("count", [CHUNK, CHUNK + 1])
def test_chunks_leave_no_seam(puma, count):
    """A set point's numbers are the same alone, in a short run and across a chunk's edge."""
    states = random_states(6, count, 11)
    long = gd.tables.decompose_states(puma, states, by_link=True, terms=True, drives=True)
    bounds = round_off_bounds(puma, *states.arrays)
    for k in {0, CHUNK // 2, CHUNK - 1, count - 1}:
        alone = gd.tables.decompose_states(puma, states.at(k), by_link=True, terms=True, drives=True)
        for name, values in alone.items():
            # Long and short loops of NumPy may sum in another order and take cos and sin by another path,
            # so the argument of two correct programs applies; nearly always the bits agree.
            quantity = "inertia" if values.ndim >= 3 and "coriolis" not in name else "torque"
            assert np.abs(values - long[name][k]).max() <= bounds[quantity], name


@examples(15)
@given(arms_with_states(max_joints=4))
def test_the_written_arithmetic_gives_the_same_numbers(case):
    arm, states = case
    every = {"by_link": True, "terms": True, "drives": bool(arm.drives)}
    told = Told()
    ran = gd.tables.decompose_states(arm, states, **every, written=True, progress=told)
    bounds = round_off_bounds(arm, *states.arrays)
    count = states.q[..., 0].size
    assert (told.stages, sum(told.steps[0])) == ([("decomposing", count)], count)
    for name, values in gd.tables.decompose_states(arm, states, **every, written=False).items():
        # Both are correct programs.
        quantity = "inertia" if values.ndim >= 3 and "coriolis" not in name else "torque"
        assert ran[name].shape == values.shape
        assert np.abs(ran[name] - values).max(initial=0.0) <= bounds[quantity], name


@pytest.mark.parametrize("count", [CHUNK - 1, 2 * CHUNK + 5])
def test_written_blocks_leave_no_seam(puma, count):
    states = random_states(6, count, 12)
    bound = round_off_bounds(puma, *states.arrays)["torque"]
    told = Told()
    ran = gd.tables.decompose_states(puma, states, written=True, progress=told)
    found = gd.tables.decompose_states(puma, states, written=False)
    assert (told.stages, sum(told.steps[0])) == ([("decomposing", count)], count)
    for name, values in found.items():
        # Both are correct programs; torque has the largest bound.
        assert np.abs(ran[name] - values).max() <= bound, name
    assert np.abs(gd.types.ArmDynamics(puma).torque(*states.arrays) - found["torque"]).max() <= bound
    lean = gd.tables.decompose_states(puma, states, christoffel=False, shares=False, written=True)
    assert {*found} - {*lean} == {"christoffel", "centrifugal", "coriolis"}
    assert all(np.array_equal(lean[name], ran[name]) for name in lean)


@examples(15)
@given(arms_with_states(max_joints=4))
def test_any_leading_shape_goes_through_the_same_code(case):
    arm, states = case
    nested = gd.types.States(*(x.reshape(2, 3, arm.n_joints) for x in states.arrays))
    flat, nested, single = (gd.tables.decompose_states(arm, each) for each in (states, nested, states.at(4)))
    assert flat.keys() == nested.keys() == single.keys()
    allowed = max(round_off_bounds(arm, *states.arrays).values())
    for name, values in flat.items():
        np.testing.assert_array_equal(nested[name].reshape(values.shape), values, err_msg=name)
        assert single[name].shape == values.shape[1:]
        assert np.abs(single[name] - values[4]).max() <= allowed, name


def test_without_christoffel_the_rest_is_the_same(puma, pick_and_place, pick_and_place_dataset):
    lean = gd.decompose(puma, pick_and_place, christoffel=False, drives=False)
    assert "christoffel" not in lean
    for name in lean.data_vars:
        np.testing.assert_array_equal(lean[name], pick_and_place_dataset[name], err_msg=str(name))


def test_trajectory_of_another_arm_is_refused(puma, swing):
    with pytest.raises(TrajectoryError, match="puma560") as caught:
        gd.decompose(puma, swing)
    assert (caught.value.details["expected"], caught.value.details["found"]) == ("6 joints", "2 joints")


def test_the_largest_numbers_do_not_overflow(two_link):
    """All numbers of the arm and of its states at the limit: nothing becomes infinite on the way."""
    far = np.full(3, LARGEST)
    link = Link("most", LARGEST, far, LARGEST * np.eye(3), Placement(np.eye(3), far))
    arm = dataclasses.replace(two_link, links=(link, link), gravity_vector=far)
    states = LARGEST * np.random.default_rng(3).uniform(-1, 1, (3, 4, 2))
    for array in gd.tables.decompose_states(arm, gd.types.States(*states), by_link=True, terms=True).values():
        assert np.isfinite(np.square(array)).all()
