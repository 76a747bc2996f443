"""Verdicts and ranking, on datasets whose answer is known by construction and on random arms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.dynamics.dominance import elements
from gd_analyze.simplification.element import parts_of, torque_by_part
from gd_analyze.types import Joint, Link
from strategies import examples, motions

EPS = float(np.finfo(float).eps)


def dataset_of(d_tran, d_rot, h_tran=0.0, h_rot=0.0, c=0.0, qdd=1.0, drive=0.0) -> xr.Dataset:
    """One joint, given numbers (or series of them), and the inertia of its drive."""
    parts = [np.atleast_1d(np.asarray(x, dtype=float)) for x in (d_tran, d_rot, h_tran, h_rot, c, qdd)]
    dt, dr, ht, hr, c, qdd = np.broadcast_arrays(*parts)
    return xr.Dataset(
        {
            "inertia": (("time", "effect", "joint", "joint_j"), np.stack([dt, dr], 1)[:, :, None, None]),
            "coriolis_centrifugal": (("time", "effect", "joint"), np.stack([ht, hr], 1)[:, :, None]),
            "centrifugal": (("time", "effect", "joint"), np.stack([ht, hr], 1)[:, :, None]),
            "coriolis": (("time", "effect", "joint"), np.zeros((len(dt), 2, 1))),
            "gravity_loading": (("time", "joint"), c[:, None]),
            "torque": (("time", "joint"), ((dt + dr + drive) * qdd + ht + hr + c)[:, None]),
            "q": (("time", "joint"), np.zeros((len(dt), 1))),
            "qd": (("time", "joint"), np.zeros((len(dt), 1))),
            "qdd": (("time", "joint"), qdd[:, None]),
        },
        coords={
            "effect": ["translation", "rotation"],
            "joint": [1],
            "joint_j": [1],
            "joint_kind": ("joint", ["revolute"]),
        },
        attrs={
            "arm": "synthetic",
            "trajectory": "synthetic",
            "torque_round_off": 0.0,
            "drive_inertia": [drive],
        },
    )


def d11(dataset: xr.Dataset, **options) -> xr.Dataset:
    return gd.rank(dataset, **options).sel(element="D11")


@pytest.mark.parametrize(
    ("translation", "rotation", "dominant"),
    [
        (1.0, 0.0, "translation"),
        (-1.0, 0.05, "translation"),
        (0.05, 1.0, "rotation"),
        (0.0, -1.0, "rotation"),
        (1.0, 0.2, "both"),
        (0.0, 0.0, "zero"),
        (1.0, 1e-17, "translation"),  # what cancellation leaves
        # Negligible on average is not enough: one set point where rotation matters makes it both.
        (1.0, [0.0, 0.3, 0.0], "both"),
    ],
)
def test_which_part_represents_the_element(translation, rotation, dominant):
    found = d11(dataset_of(translation, rotation, c=0.1))
    assert found.dominant == dominant
    assert found.verdict == dominant


def test_at_the_threshold_and_at_the_floor_themselves():
    """3/4 and 1/4 are exact in binary: at the threshold of 1/4 to the last bit, and a bit beyond."""
    for which, parts in (("translation", (0.75, 0.25)), ("rotation", (0.25, 0.75))):
        assert d11(dataset_of(*parts), threshold=0.25).dominant == which
        assert d11(dataset_of(*parts), threshold=np.nextafter(0.25, 0)).dominant == "both"
    # Peak torque 4, budget 3/4: the floor is 1 for one joint, exactly.
    dataset = dataset_of(1.0, 0.0, c=3.0)
    assert gd.rank(dataset, budget=0.75).attrs["floor"] == [1.0]
    for budget in (0.75, np.array([3.0])):
        assert d11(dataset, budget=budget).verdict == "negligible"
        assert d11(dataset, budget=np.nextafter(budget, 0)).verdict == "translation"


def test_negligible_is_about_torque_not_size():
    """The same D11 with and without an acceleration behind it."""
    assert d11(dataset_of(5.0, 5.0, c=100.0, qdd=1e-3)).verdict == "negligible"
    assert d11(dataset_of(5.0, 5.0, c=100.0, qdd=1e-3)).dominant == "both"
    assert d11(dataset_of(5.0, 5.0, c=100.0, qdd=1.0)).verdict == "both"


@pytest.mark.parametrize(
    ("parts", "drive", "verdict"),
    [
        # Peak torque 4: an element of this joint may make a third of the budget of 0.75, that is 1 N m.
        ((2.0, 0.0), 1.0, "translation"),  # the links count, with a drive or without
        ((0.0, 1.0), 2.0, "drive"),
        ((0.0, 0.0), 2.0, "drive"),
        ((0.25, 0.25), 0.5, "negligible"),
        ((0.75, 0.0), 0.5, "drive"),  # neither alone is more than 1 N m, but both together
        ((0.0, 0.0), 0.5, "negligible"),  # not zero: there is an inertia
        ((0.0, 0.0), 0.0, "zero"),
    ],
)
def test_a_drive_is_a_part_of_its_element(parts, drive, verdict):
    dataset = dataset_of(*parts, c=4.0 - sum(parts) - drive, drive=drive)
    found = d11(dataset, budget=0.75)
    assert found.verdict == verdict
    assert (found.drive, found.drive_torque_peak, found.drive_torque_share) == (drive, drive, drive / 4)
    # The budget is 3 N m; quotients of the same numbers.
    assert found.part_consequence.values.tolist() == [x / 3 for x in (*parts, drive)]
    assert found.consequence == (sum(parts) + drive) / 3
    assert found.dominant == ("zero" if not any(parts) else d11(dataset_of(*parts, c=1.0)).dominant)
    over_time = gd.tables.dominance_over_time(
        dataset.assign_coords(time=[0.0]), gd.rank(dataset, budget=0.75)
    )
    at = over_time.sel(element="D11").isel(time=0)
    assert at.drive_torque == drive
    assert gd.tables.verdicts(over_time).sel(element="D11") == verdict
    assert at.part_consequence.values.tolist() == found.part_consequence.values.tolist()


def test_shares_and_peaks_of_parts():
    found = d11(dataset_of([3.0, -3.0], [1.0, 1.0], qdd=[1.0, 2.0]))
    for names, value in (("part_peak part_rms", [3.0, 1.0]), ("part_share change_without", [0.75, 0.25])):
        assert all(found[name].values.tolist() == value for name in names.split())
    assert found.rms == pytest.approx(np.sqrt(10.0), rel=4 * EPS)  # three roundings and a root
    for name, value in (("peak", 4.0), ("torque_peak", 4.0), ("torque_joint", 1), ("torque_share", 1.0)):
        assert found[name] == value


def test_ranking_is_by_torque_share():
    ranking = gd.rank(dataset_of(1.0, 0.0, h_tran=7.0, c=2.0))
    assert ranking.element.values.tolist() == ["h1", "c1", "D11"]
    assert ranking.torque_share.values.tolist() == [0.7, 0.2, 0.1]
    # No torque is left at the joint, yet its parts are large: an infinite share, no warning, no NaN.
    cancelled = gd.rank(dataset_of(1.0, 0.0, h_tran=-1.0))
    assert cancelled.torque_share.values.tolist() == [np.inf, np.inf, 0.0]
    assert cancelled.verdict.values.tolist() == ["translation", "translation", "zero"]


def test_joints_without_torque_get_no_share(two_link):
    still = np.zeros((3, 2))
    rest = gd.Trajectory(np.arange(3.0), still, still, still)
    ranking = gd.rank(gd.decompose(dataclasses.replace(two_link, gravity_vector=np.zeros(3)), rest))
    assert set(ranking.verdict.values) == {"negligible", "zero"}
    assert not ranking.torque_peak.values.any()
    # A flange that turns about its own axis, at rest and level: its torque is round-off, not a joint's peak.
    links = [Link(name, 1.0, np.zeros(3), size * np.eye(3)) for name, size in (("a", 0.0), ("b", 0.1))]
    arm = gd.types.RobotArm("level", (Joint("lift", "prismatic"), Joint("turn")), tuple(links))
    ranking = gd.rank(gd.decompose(arm, rest))
    assert ranking.sel(element="c2").verdict == "zero"
    assert ranking.element.values[0] == "c1"
    assert ranking.sel(element="c1").torque_peak == pytest.approx(2 * 9.8062, rel=4 * EPS)


@examples(25)
@given(motions(max_joints=5), st.floats(0.0, 0.5))
def test_rankings_of_random_arms(case, budget):
    arm, motion = case
    dataset = gd.decompose(arm, motion)
    ranking, n = gd.rank(dataset, budget=budget), arm.n_joints
    peak = np.abs(dataset.torque.values).max(axis=0)
    names = ("inertia", "coriolis_centrifugal", "gravity_loading")
    largest = {name: float(np.abs(dataset[name]).max()) for name in names}

    # The floor's promise: what its n + 2 entries per joint lose together stays within the budget. What is
    # below 64 eps of its quantity's largest counts as round-off: that much may come on top, times the
    # acceleration and the n + 2 entries.
    negligible = set(ranking.element.values[np.isin(ranking.verdict.values, ["negligible", "zero"])])
    parts = tuple(part for part in parts_of(n) if part.element.label in negligible)
    lost = np.abs(torque_by_part(dataset, dataset.qdd.values, parts).sum(axis=0)).max(axis=1)
    noise = (n + 2) * 64 * EPS * max(largest.values()) * max(1.0, float(np.abs(motion.qdd).max()))
    assert (lost <= budget * peak + noise).all()

    shares = ranking.torque_share.values
    assert (np.diff(shares[np.isfinite(shares)]) <= 0).all()
    by_label = {element.label: element for element in elements(n)}
    assert sorted(ranking.element.values) == sorted(by_label)
    for k, label in enumerate(ranking.element.values):
        element = by_label[str(label)]
        values = element.parts(dataset).sum(axis=0)
        factors = element.torque_factors(dataset).values()
        assert ranking.torque_peak.values[k] <= max(float(np.abs(values * f).max()) for f in factors)
        # Zero where the parts are round-off, the element's own peak otherwise.
        off = abs(ranking.peak.values[k] - np.abs(values).max())
        assert ranking.peak.values[k] == 0.0 or off <= 64 * EPS * largest[element.quantity]


def test_verdicts_of_the_text():
    """[FGL87] Figs 3.10 and 3.11: 21 elements of D and 6 of h."""
    text = gd.tables.text_verdicts("puma560")
    by_verdict = {v: {k for k, w in text.verdicts.items() if w == v} for v in set(text.verdicts.values())}
    assert by_verdict == {
        "translation": {"D12", "D22", "D23", "D33", "D45", "D56", "h1", "h2", "h3"},
        "rotation": {"D44", "D46", "D55", "D66", "h4"},
        "both": {
            "D11", "D13", "D14", "D15", "D16", "D24", "D25", "D26", "D34", "D35", "D36", "h5", "h6",
        },
    }  # fmt: skip
    assert set(text.remarks) == {"D45", "D56"}
    assert gd.tables.text_verdicts("two_link") is None
