"""One declaration validates, documents and is stored."""

from __future__ import annotations

import pytest
import xarray as xr

from gd_analyze.errors import StoreError
from gd_analyze.schema import GROUPS, OPTIONAL, table, validate

BOTH_TURN = (True, True)


def test_what_is_made_is_valid(puma_findings, swing_dataset):
    for group, made in puma_findings.tables.items():
        validate(made, group, puma_findings.arm.is_revolute)
    validate(swing_dataset, "decomposition", BOTH_TURN)


def test_units_follow_the_joints():
    assert GROUPS["decomposition"]["inertia"].attributes([False, False])["units"] == "kg"
    values = {name: [[0.0, 0.0]] for name in ("q", "qd", "qdd")}
    described = dict.fromkeys(["name", "origin", "velocities", "fingerprint"], "")
    mixed = table("trajectory", values, [True, False], {"time": [0.0]}, described)
    assert mixed.qd.attrs["units_in"] == "velocity_unit"
    assert mixed.velocity_unit.values.tolist() == ["rad/s", "m/s"]


def spoiled(dataset):
    """Tables that are none, and what is said of each."""
    for name in GROUPS["decomposition"].keys() - OPTIONAL["decomposition"]:
        yield dataset.drop_vars(name), f"lacks the variable {name}"
    yield xr.Dataset(), "lacks the variable"
    yield dataset.assign(colour=dataset.torque), "colour is not a variable"
    turned = dataset.assign(torque=dataset.torque.transpose("joint", "time"))
    yield turned, "torque of decomposition has other dimensions"
    yield dataset.assign(torque=dataset.torque.astype(int)), "torque of decomposition"
    grams = dataset.torque.assign_attrs(units="g")
    yield dataset.assign(torque=grams), "other units"
    yield dataset.assign_coords(joint=[2, 1]), "joint of decomposition is not in order"


def test_what_is_not_as_declared_is_refused(swing_dataset):
    for table_, says in spoiled(swing_dataset):
        with pytest.raises(StoreError, match=says):
            validate(table_, "decomposition", BOTH_TURN)
