"""One declaration validates, documents and is stored."""

from __future__ import annotations

import pytest
import xarray as xr

from gd_analyze.errors import StoreError
from gd_analyze.schema import DECOMPOSITION, REQUIRED, validate


def test_what_decompose_makes_is_valid(puma_findings, swing_dataset):
    validate(puma_findings.decomposition)
    validate(swing_dataset)


def test_every_variable_says_what_it_is():
    for name, variable in DECOMPOSITION.items():
        assert variable.name == name
        attributes = variable.attributes()
        assert attributes.keys() == {"units", "symbol", "equation", "long_name"}
        assert all(attributes.values())
        assert variable.dims[0] == "time"
    assert set(REQUIRED) <= set(DECOMPOSITION)


@pytest.mark.parametrize("name", REQUIRED)
def test_a_required_variable_must_be_there(swing_dataset, name):
    with pytest.raises(StoreError, match=f"lacks {name}"):
        validate(swing_dataset.drop_vars(name))


def test_nothing_at_all():
    with pytest.raises(StoreError) as caught:
        validate(xr.Dataset())
    assert caught.value.details["found"] == "no variables"


def test_an_unknown_variable(swing_dataset):
    with pytest.raises(StoreError, match="colour is not a variable"):
        validate(swing_dataset.assign(colour=swing_dataset.torque))


def test_other_dimensions(swing_dataset):
    turned = swing_dataset.assign(torque=swing_dataset.torque.transpose("joint", "time"))
    with pytest.raises(StoreError, match="torque has other dimensions") as caught:
        validate(turned)
    assert caught.value.details["expected"] == "('time', 'joint')"
    assert caught.value.details["found"] == "('joint', 'time')"
