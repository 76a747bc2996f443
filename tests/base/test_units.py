"""Every unit that a result states can be read by a parser, and is the right one, row by row."""

from __future__ import annotations

import dataclasses

import numpy as np
import pint
import pytest

import gd_analyze as gd
from few_tries import few_tries
from gd_analyze.schema import GROUPS
from gd_analyze.types import Drive
from parallel_axes import arm_of
from recordings import swinging

UNITS = pint.UnitRegistry()


def parsed(unit: str) -> pint.Unit:
    return UNITS.parse_units(unit)


@pytest.fixture(scope="module")
@few_tries()
def mixed_findings():
    """An arm of which the third joint slides, with everything that can be asked for."""
    arm = arm_of(["askew", "same", "slides"], np.random.default_rng(1))
    arm = dataclasses.replace(arm, drives=tuple(map(Drive, (0.1, 0.2, 0.3))))
    motion = swinging(arm, 9)
    return gd.analyze(arm, motion, drives=True, by_link=True, terms=True)


def units_of_rows(table, array) -> list[str]:
    """All units that the numbers of a variable are in."""
    if "units" in array.attrs:
        assert "units_in" not in array.attrs
        return [array.attrs["units"]]
    units = table[array.attrs["units_in"]]
    assert set(units.dims) <= set(array.dims)
    unknown = units.broadcast_like(array).values == ""
    assert np.isnan(array.values[unknown]).all()
    return [unit for unit in np.unique(units.values).tolist() if unit]


def test_every_number_has_a_unit_that_parses_and_every_variable_an_equation(puma_findings, mixed_findings):
    for group, table in (*puma_findings.tables.items(), *mixed_findings.tables.items()):
        assert set(table.data_vars) <= set(GROUPS[group])
        for name, array in table.data_vars.items():
            assert all(array.attrs[word] for word in ("equation", "long_name")), (group, name)
            if array.dtype.kind not in "fi":
                assert not {"units", "units_in"} & array.attrs.keys(), (group, name)
                continue
            assert [parsed(unit) for unit in units_of_rows(table, array)]
        if "time" in table.coords:
            assert table.time.attrs["units"] == "s"


def test_units_of_a_mixed_arm_balance(mixed_findings):
    """D qdd, h_ijk qd qd, h, c and tau of a row are all in the unit of the row, by a parser's arithmetic."""
    kinds = ("effort", "velocity", "acceleration", "inertia", "christoffel")
    effort, velocity, acceleration, inertia, christoffel = (
        np.vectorize(parsed, otypes=[object])(mixed_findings.decomposition[f"{kind}_unit"].values)
        for kind in kinds
    )
    of_inertia = inertia * acceleration / effort[:, None]
    of_velocities = christoffel * np.multiply.outer(velocity, velocity) / effort[:, None, None]
    assert all((1 * share).check("[]") for share in (*of_inertia.flat, *of_velocities.flat))


def test_no_force_is_said_to_be_a_torque(mixed_findings):
    for group in ("simplified_model", "beyond", "decomposition"):
        assert mixed_findings.tables[group].effort_unit.values.tolist() == ["N m"] * 2 + ["N"]
    columns = (
        mixed_findings.dominance[name].values for name in ("element", "unit", "torque_joint", "torque_unit")
    )
    for label, unit, joint, torque in zip(*columns, strict=True):
        slides = label[1:].count("3")
        assert unit == (("kg m^2", "kg m", "kg")[slides] if label[0] == "D" else ("N m", "N")[slides])
        assert torque == ("N" if joint == 3 else "N m")


def test_a_weight_times_what_it_stands_with_is_a_torque(mixed_findings):
    arm, table = mixed_findings.arm, mixed_findings.tables["terms"]
    seen = set()
    for term, unit in zip(mixed_findings.ranked_terms, table.weight_unit.values.tolist(), strict=True):
        made = 1 * parsed(unit)
        for rate in term.velocities:
            made *= parsed(f"{arm.joints[rate.joint].unit}/s^{rate.order}")
        for factor in term.monomial:
            made *= parsed("m") if factor.kind == "power" else 1
        assert (made / parsed(arm.joints[term.row].effort_unit)).check("[]"), (term, unit)
        seen.add(unit)
    assert {"kg m^2", "kg m", "kg", "N m", "N"} <= seen


def test_differences_from_pinocchio_are_told_apart_by_unit(mixed_findings, puma_findings):
    table = mixed_findings.tables["cross_check"]
    found = list(zip(table.quantity.values, table.unit.values, strict=True))
    efforts = ["coriolis_centrifugal", "gravity_loading", "torque"]
    assert found == [
        *(("inertia", unit) for unit in ("kg m^2", "kg m", "kg")),
        *((name, unit) for name in efforts for unit in ("N m", "N")),
    ]
    assert puma_findings.tables["cross_check"].unit.values.tolist() == ["kg m^2", "N m", "N m", "N m"]
    assert mixed_findings.round_off == float(table.round_off_bound.sel(comparison="torque, N"))
