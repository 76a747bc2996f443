"""Torque by what makes it: the parts, and the piles that are drawn of them, sum to the torque."""

from __future__ import annotations

import numpy as np
import xarray as xr
from hypothesis import given

from gd_analyze import Trajectory, decompose
from gd_analyze.arrays import FloatArray
from gd_analyze.figures.joints import CONTRIBUTIONS, Contributions, torque_by_cause
from gd_analyze.types import Findings, RobotArm
from strategies import examples, motions

EPS = np.finfo(float).eps


def slack(dataset: xr.Dataset) -> FloatArray:
    """What sums in another order may differ by: a rounding of their size for 2 n products and 6 sums."""
    n = dataset.sizes["joint"]
    terms = np.abs(dataset.inertia.values) * np.abs(dataset.qdd.values)[:, None, None, :]
    size = terms.sum(axis=(1, 3)) + np.abs(dataset.coriolis_centrifugal.values).sum(axis=1)
    size += np.abs(dataset.gravity_loading.values)
    if "drive_torque" in dataset:
        size += np.abs(dataset.drive_torque.values)
    return (2 * n + 6) * EPS * size


@examples(25)
@given(motions())
def test_parts_sum_to_the_torque(case: tuple[RobotArm, Trajectory]) -> None:
    dataset = decompose(*case)
    parts = torque_by_cause(dataset)
    assert {*parts} == {*CONTRIBUTIONS} - {"drives"}
    assert (np.abs(sum(parts.values()) - dataset.torque.values) <= slack(dataset)).all()


def test_drives_are_a_part_where_the_torque_has_them(puma: RobotArm, pick_and_place: Trajectory) -> None:
    dataset = decompose(puma, pick_and_place, drives=True)
    parts = torque_by_cause(dataset)
    assert {*parts} == {*CONTRIBUTIONS}
    np.testing.assert_array_equal(parts["drives"], puma.drive_inertia * pick_and_place.qdd)
    assert (np.abs(sum(parts.values()) - dataset.torque.values) <= slack(dataset)).all()


def test_piles_end_where_the_torque_is(puma_findings: Findings) -> None:
    parts = Contributions.of(puma_findings)
    mixed = 0
    for joint in range(6):
        up, down = (parts.pile(joint, upward=upward) for upward in (True, False))
        mixed += len(up.keys() & down.keys())
        for pile, sign in ((up, 1.0), (down, -1.0)):
            level = np.zeros(len(parts.time))
            for inner, outer in pile.values():
                np.testing.assert_array_equal(inner, level)
                assert (sign * (outer - inner) >= 0.0).all()
                level = outer
        ends = [[*pile.values()][-1][1] if pile else np.zeros(len(parts.time)) for pile in (up, down)]
        # Each pile sums five numbers no larger than its end: a rounding each, and those of the torque itself.
        size = ends[0] - ends[1]
        bound = (5 + 2 * 6 + 6) * EPS * size
        assert (np.abs(ends[0] + ends[1] - parts.total[:, joint]) <= bound).all()
        for name, part in parts.parts.items():
            assert (name in up) == (part[:, joint] > 0.0).any()
            assert (name in down) == (part[:, joint] < 0.0).any()
    assert mixed > 0  # parts whose sign changes are in both


def test_limits_and_drives_are_the_arm_s(puma_findings: Findings, swing_findings: Findings) -> None:
    with_drives, without = Contributions.of(puma_findings), Contributions.of(swing_findings)
    assert with_drives.limit.tolist() == [drive.torque_limit for drive in puma_findings.arm.drives]
    assert np.isnan(without.limit).all()
    assert ("drives" in with_drives.parts, "drives" in without.parts) == (True, False)
    # A long motion is split where it is drawn.
    points, _ = swing_findings.drawn
    np.testing.assert_array_equal(without.time, swing_findings.trajectory.time[points])
    np.testing.assert_array_equal(without.total, swing_findings.exact_torque[points])
