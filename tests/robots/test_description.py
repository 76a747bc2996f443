"""An arm written down and read back, and the fingerprint of what acts."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
from arm_files import link
from hypothesis import given

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import arm_from_description, describe, fingerprint
from gd_analyze.robots.parts import Drive, Joint, LinkUncertainty
from gd_analyze.robots.payload import with_payload
from strategies import arms, examples


@examples(20)
@given(arms())
def test_description_round_trip(arm):
    again = arm_from_description(json.loads(json.dumps(describe(arm), allow_nan=False)))
    assert fingerprint(again) == fingerprint(arm)
    assert describe(again) == describe(arm)


def test_description_keeps_what_is_known_of_the_uncertainties(puma):
    stated = LinkUncertainty(0.1, np.array([0.01, 0.02, 0.03]), 0.004 * np.eye(3), "origin")
    carried = with_payload(
        dataclasses.replace(puma, links=(*puma.links[:-1], link(uncertainty=stated))), 1.0, [0, 0, 0.1]
    )
    assert describe(carried)["links"][-1]["uncertainty"]["body_mass"] == 1.0
    for arm in (puma, carried):
        again = arm_from_description(json.loads(json.dumps(describe(arm))))
        assert describe(again) == describe(arm)


def test_uncertainties_are_no_part_of_the_fingerprint():
    """What acts on torque is; how well it is known changes no result that was made for the arm."""
    plain = RobotArm("a", (Joint("1"),), (link(),), drives=(Drive(1.0),))
    known = link(name="x", mass=np.float32(1), uncertainty=LinkUncertainty(0.1))
    stated = RobotArm("b", (Joint("2"),), (known,), drives=(Drive(1.0, 0.1),))
    assert fingerprint(stated, drives=True) == fingerprint(plain, drives=True)
    # Stored models name their arms by it.
    assert fingerprint(plain) == "e2d53fe166ba8618a5c5d9d0ef23435d8285b50c9e8f86a907855992e3ab1eb6"
    assert fingerprint(plain, drives=True) != fingerprint(
        dataclasses.replace(plain, drives=(Drive(2.0),)), True
    )


def leaves(value, keys=()):
    """Places of all numbers and words in nested JSON values."""
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(inner, (*keys, key))
    else:
        yield keys, value


ACTING = {"gravity", "kind", "placement", "axis", "mass", "com", "inertia_com", "frame"}


def test_fingerprint_changes_with_every_number_that_acts_and_with_nothing_else(puma):
    """Through the fingerprint of an edited description, where that still describes a possible arm."""
    before, counts = fingerprint(puma), {True: 0, False: 0}
    for keys, value in leaves(describe(puma)):
        if isinstance(value, bool) or value is None:
            continue
        edited = inner = json.loads(json.dumps(describe(puma)))
        for key in keys[:-1]:
            inner = inner[key]
        # The smallest change there is; numbers of rotations and inertias stay within what is possible.
        inner[keys[-1]] = value + "x" if isinstance(value, str) else float(np.nextafter(value, 2.0))
        if keys[-1] == "kind":
            inner[keys[-1]] = "prismatic"
        try:
            after = fingerprint(arm_from_description(edited))
        except ArmError:
            continue  # e.g. an inertia edited on one side of its diagonal
        acts = bool(ACTING & set(keys)) and "uncertainty" not in keys
        assert (after != before) == acts, keys
        counts[acts] += 1
    assert counts[True] > 150
    assert counts[False] > 30
