"""The Dataset: its parts sum to the whole, whatever the shape and length of the states."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics.decomposition import decompose, decompose_states
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.read import read_trajectory, shipped_trajectories
from gd_analyze.motions.states import States
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Placement
from gd_analyze.schema import GROUPS
from gd_analyze.text import LARGEST
from strategies import arms_with_states, examples, motions, random_states

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("name", sorted(shipped_trajectories()))
def test_parts_sum_to_what_pinocchio_finds_on_every_shipped_trajectory(name):
    arm = load_arm("two_link" if name.startswith("two-link") else "puma560")
    trajectory = read_trajectory(name, arm)
    dataset = decompose(arm, trajectory, drives=False)
    theirs = pinocchio_dynamics(arm, trajectory.q, trajectory.qd, trajectory.qdd)
    bounds = round_off_bounds(arm, trajectory.q, trajectory.qd, trajectory.qdd)
    ours = {
        "inertia": dataset.inertia.sum("effect"),
        "coriolis_centrifugal": dataset.coriolis_centrifugal.sum("effect"),
        "gravity_loading": dataset.gravity_loading,
        "torque": dataset.torque,
    }
    for quantity, values in ours.items():
        assert np.abs(values.values - theirs[quantity]).max() <= bounds[quantity], quantity


@examples(15)
@given(motions(max_joints=6))
def test_everything_adds_up(case):
    arm, motion = case
    found = decompose(arm, motion, by_link=True, terms=True)
    bounds = round_off_bounds(arm, motion.q, motion.qd, motion.qdd)
    h_bound = bounds["coriolis_centrifugal"]

    def differs(a, b):
        return float(np.abs(a - b).max())

    assert differs(found.inertia_by_link.sum("link"), found.inertia) <= bounds["inertia"]
    h = found.coriolis_centrifugal
    assert differs(found.coriolis_centrifugal_by_link.sum("link"), h) <= h_bound
    assert (
        differs(found.gravity_loading_by_link.sum("link"), found.gravity_loading) <= bounds["gravity_loading"]
    )
    by_effect = found.coriolis_centrifugal_terms.groupby("term_effect").sum()
    assert differs(by_effect.sel(term_effect=found.effect.values).values, h.values) <= h_bound
    # centrifugal + (h - centrifugal): one rounding of each, of numbers no larger than h's own bound allows.
    assert differs(found.centrifugal + found.coriolis, h) <= h_bound
    qd = found.qd.values
    centrifugal = np.einsum("teijj,tj->tei", found.christoffel.values, qd**2)
    assert differs(centrifugal, found.centrifugal.values) <= h_bound
    coriolis = np.einsum("teijk,tj,tk->tei", found.christoffel.values, qd, qd) - centrifugal
    assert differs(coriolis, found.coriolis.values) <= h_bound
    accelerating = np.einsum("teij,tj->ti", found.inertia.values, found.qdd.values)
    whole = accelerating + h.sum("effect").values + found.gravity_loading.values
    assert differs(whole, found.torque.values) <= bounds["torque"]


@pytest.mark.parametrize("count", [CHUNK - 1, CHUNK, CHUNK + 1])
def test_chunks_leave_no_seam(puma, count):
    """A set point's numbers are the same alone, in a short run and across a chunk's edge."""
    states = random_states(6, count, 11)
    long = decompose_states(puma, states, by_link=True, terms=True, drives=True)
    bounds = round_off_bounds(puma, states.q, states.qd, states.qdd)
    picks = sorted({0, 1, CHUNK // 2, count - 2, count - 1, min(CHUNK, count - 1)})
    for k in picks:
        alone = decompose_states(puma, states.at(k), by_link=True, terms=True, drives=True)
        for name, values in alone.items():
            # Long and short loops of NumPy may sum in another order and take cos and sin by another path,
            # so the argument of two correct programs applies; nearly always the bits agree.
            quantity = "inertia" if values.ndim >= 3 and "coriolis" not in name else "torque"
            assert np.abs(values - long[name][k]).max() <= bounds[quantity], name


@examples(15)
@given(arms_with_states(max_joints=4))
def test_any_leading_shape_goes_through_the_same_code(case):
    arm, states = case
    flat = decompose_states(arm, states)
    n = arm.n_joints
    nested = decompose_states(arm, States(*(x.reshape(2, 3, n) for x in states.arrays)))
    single = decompose_states(arm, states.at(4))
    assert flat.keys() == nested.keys() == single.keys()
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
    for name, values in flat.items():
        assert values.shape[0] == 6
        np.testing.assert_array_equal(nested[name].reshape(values.shape), values, err_msg=name)
        assert single[name].shape == values.shape[1:]
        assert np.abs(single[name] - values[4]).max() <= max(bounds.values()), name


def test_without_christoffel_the_rest_is_the_same(puma, pick_and_place, pick_and_place_dataset):
    lean = decompose(puma, pick_and_place, christoffel=False, drives=False)
    assert "christoffel" not in lean
    assert "joint_k" not in lean.coords
    for name in lean.data_vars:
        np.testing.assert_array_equal(lean[name], pick_and_place_dataset[name], err_msg=str(name))


def test_every_variable_is_as_declared(puma_findings):
    dataset = puma_findings.decomposition
    assert set(dataset.data_vars) == set(GROUPS["decomposition"])
    for name, variable in GROUPS["decomposition"].items():
        assert dataset[name].dims == variable.dims
        assert dataset[name].attrs == variable.attributes([True] * 6)
    assert dataset.effect.values.tolist() == ["translation", "rotation"]
    assert dataset.joint.values.tolist() == dataset.joint_k.values.tolist() == [1, 2, 3, 4, 5, 6]
    assert dataset.joint_name.values.tolist()[:2] == ["waist", "shoulder"]
    assert dataset.term.values.tolist() == ["T1", "T2", "T3", "T4", "R1", "R2"]
    assert dataset.time.attrs["units"] == "s"


def test_trajectory_of_another_arm_is_refused(puma, swing):
    with pytest.raises(TrajectoryError, match="not for arm puma560") as caught:
        decompose(puma, swing)
    assert caught.value.details["expected"] == "6 joints"
    assert caught.value.details["found"] == "2 joints"


def test_the_largest_numbers_do_not_overflow(two_link):
    """All numbers of the arm and of its states at the limit: nothing becomes infinite on the way."""
    links = tuple(
        dataclasses.replace(
            link,
            mass=LARGEST,
            com=np.full(3, LARGEST),
            inertia_com=LARGEST * np.eye(3),
            frame=Placement(np.eye(3), np.full(3, LARGEST)),
        )
        for link in two_link.links
    )
    arm = dataclasses.replace(two_link, links=links, gravity=np.full(3, LARGEST))
    states = LARGEST * np.random.default_rng(3).uniform(-1, 1, (3, 4, 2))
    for array in decompose_states(arm, States(*states), by_link=True, terms=True).values():
        assert np.isfinite(array).all()
        assert np.isfinite(np.square(array)).all()
