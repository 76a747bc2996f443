"""An arm written as TOML reads back as the same arm, to the last bit."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.robots.catalogue import builtin_arms, load_arm
from gd_analyze.robots.description import describe_in_full, fingerprint
from gd_analyze.robots.parts import Drive, Joint, Link, LinkUncertainty, Placement
from gd_analyze.robots.payload import with_payload
from strategies import arms, examples, random_states


def read_back(arm: RobotArm, folder: Path) -> RobotArm:
    path = folder / "written.toml"
    path.write_text(toml_of(arm), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return read_arm(path)


def same_but_for(arm: RobotArm, again: RobotArm, *names: str) -> None:
    before, after = describe_in_full(arm), describe_in_full(again)
    for name in names:
        del before[name], after[name]
    assert after == before


@st.composite
def dressed_arms(draw: st.DrawFn) -> RobotArm:
    """Arms of every make with limits, drives and uncertainties, some of them unknown."""
    arm = draw(arms(max_joints=6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))

    def perhaps(value):
        return value if rng.random() < 0.6 else None

    def symmetric() -> np.ndarray:
        return np.abs(np.cov(rng.normal(size=(3, 5))))

    joints = tuple(
        dataclasses.replace(
            joint,
            lower=perhaps(-rng.uniform(0.1, 3.0)),
            upper=perhaps(np.radians(rng.integers(1, 180))),
            velocity_limit=perhaps(rng.uniform(0.1, 3.0)),
            acceleration_limit=perhaps(rng.uniform(0.1, 30.0)),
        )
        for joint in arm.joints
    )
    links = tuple(
        dataclasses.replace(
            link,
            as_measured=bool(rng.random() < 0.3),
            axial_only=bool(i == 0 and joints[0].kind == "revolute" and rng.random() < 0.3),
            uncertainty=LinkUncertainty(
                rng.uniform(),
                perhaps(rng.uniform(size=3)),
                perhaps(symmetric()),
                rng.choice(["com", "origin"]),
            )
            if rng.random() < 0.5
            else None,
        )
        for i, link in enumerate(arm.links)
    )
    drives = tuple(
        Drive(
            rng.uniform(),
            perhaps(rng.uniform()),
            perhaps(-rng.uniform(1.0, 100.0)) or 1.0,
            rng.uniform(),
            (rng.uniform(), -rng.uniform()),
            perhaps(rng.uniform(1.0, 100.0)),
        )
        for _ in joints
    )
    has_drives = draw(st.booleans())
    return dataclasses.replace(arm, joints=joints, links=links, drives=drives if has_drives else ())


@examples(40)
@given(dressed_arms())
def test_any_arm_reads_back_to_the_last_bit(tmp_path_factory, arm):
    again = read_back(arm, tmp_path_factory.mktemp("arm"))
    assert fingerprint(again, drives=True) == fingerprint(arm, drives=True)
    for link, read in zip(arm.links, again.links, strict=True):
        if link.uncertainty is not None and link.uncertainty.inertia is None:
            object.__setattr__(read, "uncertainty", link.uncertainty)  # its point is then of no inertia
    same_but_for(arm, again, "title", "convention")
    states = random_states(arm.n_joints, 5, seed=1)
    drives = bool(arm.drives)
    np.testing.assert_array_equal(
        torque_of(again, states, drives=drives), torque_of(arm, states, drives=drives)
    )


@pytest.mark.parametrize("name", builtin_arms())
def test_built_in_arms_keep_their_table(name, tmp_path):
    arm = load_arm(name)
    again = read_back(arm, tmp_path)
    assert again.dh_table == arm.dh_table
    same_but_for(arm, again)


QUARTER = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def placed(**changes) -> RobotArm:
    """One joint that stands on its side, and a link with a frame of its own."""
    joint = Joint(
        "shoulder", placement=Placement(QUARTER, np.array([0.0, 0.1, 0.0])), axis=np.array([0, 1.0, 0])
    )
    link = Link("arm", 1.0, np.zeros(3), np.diag([0.1, 0.1, 0.05]), Placement(QUARTER.T))
    return RobotArm(**{"name": "placed", "joints": (joint,), "links": (link,)} | changes)


def test_a_right_angle_is_one_for_people_too(tmp_path):
    text = toml_of(placed())
    assert 'convention = "placement"' in text
    assert "xyz = [0.0, 0.1, 0.0]  # m" in text
    assert "\nrpy_deg = [90.0, 0.0, 0.0]  # degrees" in text
    assert "frame_rpy_deg = [-90.0, 0.0, 0.0]" in text
    assert "axis = [0.0, 1.0, 0.0]" in text
    assert "rotation" not in text
    assert fingerprint(read_back(placed(), tmp_path)) == fingerprint(placed())


def test_texts_and_names_come_back(tmp_path):
    arm = placed(
        name="my arm / 2",
        sources=('A "quoted" \\ source\nof two lines', "é"),
        assumptions=("none",),
        doubts=("its base is moved",),
    )
    again = read_back(arm, tmp_path)
    assert (again.name, again.title) == ("my_arm___2", "my arm / 2")
    assert (again.sources, again.assumptions) == (arm.sources, arm.assumptions)
    assert again.doubts == arm.doubts
    with pytest.warns(GdAnalyzeWarning, match="its base is moved"):
        read_arm(tmp_path / "written.toml")


def test_an_unknown_end_of_a_range_stays_unknown(tmp_path):
    joint = Joint("1", "prismatic", lower=0.5, upper=np.inf)
    arm = placed(joints=(joint,))
    assert "range = [0.5, inf]" in toml_of(arm)
    again = read_back(arm, tmp_path).joints[0]
    assert (again.lower, again.upper) == (0.5, None)


def test_a_payload_is_written_with_its_link_but_not_with_uncertainties(puma, tmp_path):
    with pytest.raises(ArmError, match="link 6 carries a payload") as caught:
        toml_of(with_payload(puma, 1.0, [0.0, 0.0, 0.1]))
    assert "without its payload" in caught.value.details["next"]
    bare = dataclasses.replace(
        puma, links=tuple(dataclasses.replace(x, uncertainty=None) for x in puma.links)
    )
    carrying = with_payload(bare, 1.0, [0.0, 0.0, 0.1])
    assert fingerprint(read_back(carrying, tmp_path)) == fingerprint(carrying)
