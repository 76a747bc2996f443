"""An arm written down and read back, and the fingerprint of what acts."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
from hypothesis import given
from made_links import link

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import arm_from_description, describe, fingerprint
from gd_analyze.robots.parts import Drive, Joint, LinkUncertainty
from gd_analyze.robots.payload import with_payload
from strategies import arms, examples


@examples(20)
@given(arms())
def test_description_round_trip(arm):
    text = json.dumps(describe(arm), allow_nan=False)
    again = arm_from_description(json.loads(text))
    assert fingerprint(again) == fingerprint(arm)
    assert describe(again) == describe(arm)


def test_description_keeps_what_is_known_of_the_uncertainties(puma):
    stated = LinkUncertainty(0.1, np.array([0.01, 0.02, 0.03]), 0.004 * np.eye(3), "origin")
    carried = with_payload(
        dataclasses.replace(puma, links=(*puma.links[:-1], link(uncertainty=stated))), 1.0, [0, 0, 0.1]
    )
    bare = dataclasses.replace(puma, links=(*puma.links[:-1], link()))
    for arm in (puma, carried, bare):
        again = arm_from_description(json.loads(json.dumps(describe(arm))))
        assert describe(again) == describe(arm)
        assert [drive.inertia_uncertainty for drive in again.drives] == [
            drive.inertia_uncertainty for drive in puma.drives
        ]
    found = arm_from_description(describe(carried)).links[-1].uncertainty
    assert (found.mass, found.inertia_about, found.body_mass) == (0.1, "origin", 1.0)
    np.testing.assert_array_equal(found.com, stated.com)
    np.testing.assert_array_equal(found.inertia, stated.inertia)
    np.testing.assert_array_equal(found.body_com, np.zeros(3))


def test_uncertainties_are_no_part_of_the_fingerprint():
    """What acts on torque is; how well it is known changes no result that was made for the arm."""
    plain = RobotArm("a", (Joint("1"),), (link(),), drives=(Drive(1.0),))
    stated = RobotArm(
        "a",
        (Joint("1"),),
        (link(uncertainty=LinkUncertainty(0.1, 0.01 * np.ones(3), 0.001 * np.eye(3))),),
        drives=(Drive(1.0, 0.1),),
    )
    assert fingerprint(stated, drives=True) == fingerprint(plain, drives=True)
    # As it was before arms could state uncertainties: model files name arms by it.
    assert fingerprint(plain) == "e2d53fe166ba8618a5c5d9d0ef23435d8285b50c9e8f86a907855992e3ab1eb6"


def leaves(value, keys=()):
    """Places of all numbers and words in nested JSON values."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*keys, key))
    elif isinstance(value, list):
        for key, inner in enumerate(value):
            yield from leaves(inner, (*keys, key))
    else:
        yield keys, value


ACTING = {"gravity", "kind", "placement", "axis", "mass", "com", "inertia_com", "frame"}


def test_fingerprint_changes_with_every_number_that_acts_and_with_nothing_else(puma):
    """Through the fingerprint of an edited description, where that still describes a possible arm."""
    before = fingerprint(puma)
    changed = unchanged = 0
    for keys, value in leaves(describe(puma)):
        edited = json.loads(json.dumps(describe(puma)))
        inner = edited
        for key in keys[:-1]:
            inner = inner[key]
        if isinstance(value, bool) or value is None:
            continue
        # The smallest change there is; numbers of rotations and inertias stay within what is possible.
        inner[keys[-1]] = value + "x" if isinstance(value, str) else float(np.nextafter(value, 2.0))
        if keys[-1] == "kind":
            inner[keys[-1]] = "prismatic"
        if "axial_only" in str(keys):
            continue
        try:
            after = fingerprint(arm_from_description(edited))
        except ArmError:
            continue  # e.g. an inertia edited on one side of its diagonal
        if ACTING & set(keys) and "uncertainty" not in keys:
            assert after != before, keys
            changed += 1
        else:
            assert after == before, keys
            unchanged += 1
    assert changed > 150
    assert unchanged > 30


def test_fingerprint_of_drives_on_request(puma):
    other = dataclasses.replace(puma, drives=(Drive(9.0), *puma.drives[1:]))
    assert fingerprint(other) == fingerprint(puma)
    assert fingerprint(other, drives=True) != fingerprint(puma, drives=True)


def test_fingerprint_does_not_care_how_a_number_was_typed():
    one = RobotArm("a", (Joint("1"),), (link(mass=2),))
    same = RobotArm("b", (Joint("other name"),), (link(mass=np.float32(2.0), name="x"),))
    assert fingerprint(one) == fingerprint(same)
