"""One declaration validates, documents and is stored."""

from __future__ import annotations

import pytest
import xarray as xr

from gd_analyze.errors import StoreError
from gd_analyze.schema import GROUPS, OPTIONAL, table, unit_of, validate

BOTH_TURN = (True, True)
REQUIRED = [name for name in GROUPS["decomposition"] if name not in OPTIONAL["decomposition"]]


def test_what_is_made_is_valid(puma_findings, swing_dataset):
    for group, made in puma_findings.tables.items():
        validate(made, group, puma_findings.arm.is_revolute)
    validate(swing_dataset, "decomposition", BOTH_TURN)


@pytest.mark.parametrize("group", GROUPS)
def test_every_variable_says_what_it_is(group):
    for name, variable in GROUPS[group].items():
        assert variable.name == name
        attributes = variable.attributes([True, True])
        assert attributes["long_name"]
        assert variable.dims
        assert not {"units", "units_in"} <= attributes.keys()


def test_units_follow_the_joints():
    assert unit_of("inertia", True, True) == "kg m^2"
    assert unit_of("inertia", True, False) == "kg m"
    assert unit_of("christoffel", False, False, False) == "kg/m"
    assert GROUPS["decomposition"]["inertia"].attributes([False, False])["units"] == "kg"
    values = {name: [[0.0, 0.0]] for name in ("q", "qd", "qdd")}
    described = dict.fromkeys(["name", "origin", "velocities", "fingerprint"], "")
    mixed = table("trajectory", values, [True, False], {"time": [0.0]}, described)
    assert mixed.qd.attrs["units_in"] == "velocity_unit"
    assert mixed.velocity_unit.values.tolist() == ["rad/s", "m/s"]


@pytest.mark.parametrize("name", REQUIRED)
def test_a_required_variable_must_be_there(swing_dataset, name):
    with pytest.raises(StoreError, match=f"lacks the variable {name}"):
        validate(swing_dataset.drop_vars(name), "decomposition", BOTH_TURN)


def test_nothing_at_all():
    with pytest.raises(StoreError) as caught:
        validate(xr.Dataset(), "decomposition", BOTH_TURN)
    assert caught.value.details["found"] == "no variables"


def test_an_unknown_variable(swing_dataset):
    with pytest.raises(StoreError, match="colour is not a variable"):
        validate(swing_dataset.assign(colour=swing_dataset.torque), "decomposition", BOTH_TURN)


def test_other_dimensions(swing_dataset):
    turned = swing_dataset.assign(torque=swing_dataset.torque.transpose("joint", "time"))
    with pytest.raises(StoreError, match="torque of decomposition has other dimensions") as caught:
        validate(turned, "decomposition", BOTH_TURN)
    assert caught.value.details["expected"] == "('time', 'joint')"
    assert caught.value.details["found"] == "('joint', 'time')"
