"""A declaration describes a table, whatever the kinds of the arm's joints."""

from __future__ import annotations

from gd_analyze.schema import GROUPS, table


def test_units_follow_the_joints():
    assert GROUPS["decomposition"]["inertia"].attributes([False, False])["units"] == "kg"
    values = {name: [[0.0, 0.0]] for name in ("q", "qd", "qdd")}
    described = dict.fromkeys(["name", "origin", "velocities", "fingerprint"], "")
    mixed = table("trajectory", values, [True, False], {"time": [0.0]}, described)
    assert mixed.qd.attrs["units_in"] == "velocity_unit"
    assert mixed.velocity_unit.values.tolist() == ["rad/s", "m/s"]
