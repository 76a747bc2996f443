"""Verdicts and ranking, on datasets whose answer is known by construction and on random arms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import decompose
from gd_analyze.dynamics.dominance import elements, rank, text_verdicts
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.simplification.element import parts_of, torque_by_part
from strategies import arms_with_states, examples, motions

EPS = float(np.finfo(float).eps)


def dataset_of(d_tran, d_rot, h_tran=0.0, h_rot=0.0, c=0.0, qdd=1.0) -> xr.Dataset:
    """One joint, given numbers (or series of them)."""
    parts = [np.atleast_1d(np.asarray(x, dtype=float)) for x in (d_tran, d_rot, h_tran, h_rot, c, qdd)]
    dt, dr, ht, hr, c, qdd = np.broadcast_arrays(*parts)
    inertia = np.stack([dt, dr], axis=1)[:, :, None, None]
    h = np.stack([ht, hr], axis=1)[:, :, None]
    return xr.Dataset(
        {
            "inertia": (("time", "effect", "joint", "joint_j"), inertia),
            "coriolis_centrifugal": (("time", "effect", "joint"), h),
            "gravity_loading": (("time", "joint"), c[:, None]),
            "torque": (("time", "joint"), ((dt + dr) * qdd + ht + hr + c)[:, None]),
            "qdd": (("time", "joint"), qdd[:, None]),
        },
        coords={
            "effect": ["translation", "rotation"],
            "joint": [1],
            "joint_j": [1],
            "joint_kind": ("joint", ["revolute"]),
        },
        attrs={"arm": "synthetic", "trajectory": "synthetic"},
    )


def row(dataset: xr.Dataset, label: str = "D11", **options) -> xr.Dataset:
    return rank(dataset, **options).sel(element=label)


@pytest.mark.parametrize(
    ("translation", "rotation", "verdict"),
    [
        (1.0, 0.0, "translation"),
        (1.0, 0.05, "translation"),
        (-1.0, 0.05, "translation"),
        (0.05, 1.0, "rotation"),
        (0.0, -1.0, "rotation"),
        (1.0, 1.0, "both"),
        (1.0, 0.2, "both"),
        (0.0, 0.0, "neither"),
    ],
)
def test_which_part_represents_the_element(translation, rotation, verdict):
    found = row(dataset_of(translation, rotation, c=0.1))
    assert found.dominant == verdict
    if verdict != "neither":  # an element that is zero makes no torque, so its verdict is negligible
        assert found.verdict == verdict
    else:
        assert found.verdict == "negligible"


@pytest.mark.parametrize("which", ["translation", "rotation"])
def test_the_threshold_itself_still_dominates(which):
    """3/4 and 1/4 are exact in binary: at the threshold of 1/4 to the last bit, and a bit beyond."""
    parts = (0.75, 0.25) if which == "translation" else (0.25, 0.75)
    assert row(dataset_of(*parts), threshold=0.25).dominant == which
    assert row(dataset_of(*parts), threshold=np.nextafter(0.25, 0)).dominant == "both"


def test_a_verdict_looks_at_the_worst_set_point():
    """Negligible on average is not enough: one set point where rotation matters makes it both."""
    rotation = np.zeros(100)
    assert row(dataset_of(1.0, rotation)).dominant == "translation"
    rotation[50] = 0.3
    assert row(dataset_of(1.0, rotation)).dominant == "both"


def test_negligible_is_about_torque_not_size():
    """The same D11 with and without an acceleration behind it."""
    large = dataset_of(5.0, 5.0, c=100.0, qdd=1e-3)
    assert row(large).verdict == "negligible"
    assert row(large).dominant == "both"
    assert row(dataset_of(5.0, 5.0, c=100.0, qdd=1.0)).verdict == "both"


def test_the_floor_itself_is_negligible():
    """Peak torque 4, budget 3/4: the floor is 1 for one joint, exactly."""
    dataset = dataset_of(1.0, 0.0, c=3.0)
    assert rank(dataset, budget=0.75).attrs["floor"] == [1.0]
    assert row(dataset, budget=0.75).verdict == "negligible"
    assert row(dataset, budget=np.nextafter(0.75, 0)).verdict == "translation"
    assert row(dataset, budget=np.array([3.0])).verdict == "negligible"
    assert row(dataset, budget=np.array([2.999])).verdict == "translation"


def test_round_off_is_no_part():
    """A rotation of 1e-17 beside elements of size 1 is what cancellation leaves."""
    dataset = dataset_of(1.0, 0.0, h_tran=0.0, h_rot=1.0)
    dataset.inertia.values[:, 1] = 1e-17
    found = row(dataset)
    assert found.part_peak.values.tolist() == [1.0, 0.0]
    assert found.dominant == "translation"


def test_shares_and_peaks_of_parts():
    found = row(dataset_of([3.0, -3.0], [1.0, 1.0], qdd=[1.0, 2.0]))
    assert found.peak == 4.0
    assert found.part_peak.values.tolist() == [3.0, 1.0]
    assert found.part_rms.values.tolist() == [3.0, 1.0]
    assert found.part_share.values.tolist() == [0.75, 0.25]
    assert found.change_without.values.tolist() == [0.75, 0.25]
    assert found.rms == pytest.approx(np.sqrt(10.0), rel=4 * EPS)  # three roundings and a root
    assert found.torque_peak == 4.0
    assert found.torque_joint == 1
    assert found.torque_share == 1.0


def test_ranking_is_by_torque_share():
    ranking = rank(dataset_of(1.0, 0.0, h_tran=7.0, c=2.0))
    assert ranking.element.values.tolist() == ["h1", "c1", "D11"]
    assert ranking.torque_share.values.tolist() == [0.7, 0.2, 0.1]


def test_torques_that_cancel_rank_first_and_stay_numbers():
    """No torque is left at the joint, yet its parts are large: an infinite share, no warning, no NaN."""
    ranking = rank(dataset_of(1.0, 0.0, h_tran=-1.0))
    assert np.isinf(ranking.torque_share.values[:2]).all()
    assert ranking.verdict.values[:2].tolist() == ["translation", "translation"]
    assert ranking.verdict.values[2] == "negligible"


def test_an_arm_at_rest_without_gravity(two_link):
    weightless = dataclasses.replace(two_link, gravity=np.zeros(3))
    still = np.zeros((3, 2))
    ranking = rank(decompose(weightless, Trajectory(np.arange(3.0), still + 0.3, still, still)))
    assert set(ranking.verdict.values) == {"negligible"}
    assert not ranking.torque_peak.values.any()


@examples(25)
@given(motions(max_joints=5), st.floats(0.0, 0.5))
def test_all_negligible_elements_may_go_at_once(case, budget):
    """The floor's promise: what its n + 2 entries per joint lose together stays within the budget."""
    arm, motion = case
    dataset = decompose(arm, motion)
    ranking = rank(dataset, budget=budget)
    negligible = set(ranking.element.values[ranking.verdict.values == "negligible"])
    parts = tuple(part for part in parts_of(arm.n_joints) if part.element.label in negligible)
    lost = np.abs(torque_by_part(dataset, dataset.qdd.values, parts).sum(axis=0)).max(axis=1)
    peak = np.abs(dataset.torque.values).max(axis=0)
    # `rank` takes what is below 64 eps of its quantity's largest for round-off: that much may come on top,
    # times the acceleration and the n + 2 entries.
    largest = max(
        float(np.abs(dataset[name]).max()) for name in ("inertia", "coriolis_centrifugal", "gravity_loading")
    )
    noise = (arm.n_joints + 2) * 64 * EPS * largest * max(1.0, float(np.abs(motion.qdd).max()))
    assert (lost <= budget * peak + noise).all()


@examples(25)
@given(motions(max_joints=5))
def test_every_entry_is_what_it_says(case):
    arm, motion = case
    dataset = decompose(arm, motion)
    ranking = rank(dataset)
    n = arm.n_joints
    assert sorted(ranking.element.values) == sorted(e.label for e in elements(n))
    shares = ranking.torque_share.values
    finite = shares[np.isfinite(shares)]
    assert (np.diff(finite) <= 0).all()
    parts = {e.label: e for e in elements(n)}
    for k, label in enumerate(ranking.element.values):
        element = parts[str(label)]
        values = element.parts(dataset).sum(axis=0)
        factors = element.torque_factors(dataset.qdd.values).values()
        largest = max(float(np.abs(values * f).max()) for f in factors)
        assert ranking.torque_peak.values[k] <= largest
        # Zero where the parts are round-off, the element's own peak otherwise.
        assert ranking.peak.values[k] in (0.0, np.abs(values).max()) or np.abs(
            ranking.peak.values[k] - np.abs(values).max()
        ) <= 64 * EPS * float(np.abs(dataset[element.quantity]).max())


@examples(20)
@given(arms_with_states(max_joints=4))
def test_ranking_does_not_depend_on_the_order_of_set_points(case):
    arm, states = case
    time = np.arange(len(states.q)) * 1.0
    forward = rank(decompose(arm, Trajectory(time, states.q, states.qd, states.qdd)))
    backward = rank(decompose(arm, Trajectory(time, states.q[::-1], states.qd[::-1], states.qdd[::-1])))
    assert forward.verdict.sel(element=backward.element).values.tolist() == backward.verdict.values.tolist()


def test_a_joint_without_torque_gets_no_share(puma):
    """The flange turns about its own axis: at rest and level its torque is round-off, not a joint's peak."""
    arm = RobotArm(
        "level",
        (Joint("lift", "prismatic"), Joint("turn")),
        (Link("a", 1.0, np.zeros(3), np.zeros((3, 3))), Link("b", 1.0, np.zeros(3), 0.1 * np.eye(3))),
    )
    still = np.zeros((4, 2))
    ranking = rank(decompose(arm, Trajectory(np.arange(4.0), still, still, still)))
    assert ranking.sel(element="c2").verdict == "negligible"
    assert ranking.element.values[0] == "c1"
    assert ranking.sel(element="c1").torque_peak == pytest.approx(2 * 9.8062, rel=4 * EPS)


def test_verdicts_of_the_text():
    """[FGL87] Figs 3.10 and 3.11: 21 elements of D and 6 of h."""
    text = text_verdicts("puma560")
    assert text is not None
    assert len(text.verdicts) == 27
    by_verdict = {v: {k for k, w in text.verdicts.items() if w == v} for v in set(text.verdicts.values())}
    assert by_verdict["translation"] == {"D12", "D22", "D23", "D33", "D45", "D56", "h1", "h2", "h3"}
    assert by_verdict["rotation"] == {"D44", "D46", "D55", "D66", "h4"}
    assert by_verdict["both"] == {
        "D11", "D13", "D14", "D15", "D16", "D24", "D25", "D26", "D34", "D35", "D36", "h5", "h6",
    }  # fmt: skip
    assert set(text.remarks) == {"D45", "D56"}
    assert text_verdicts("two_link") is None
