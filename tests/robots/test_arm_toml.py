"""An arm written as TOML reads back as the same arm, to the last bit."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pytest
from arm_files import link
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.robots.description import describe_in_full, fingerprint
from gd_analyze.robots.parts import Drive, Joint, LinkUncertainty, Placement
from gd_analyze.robots.payload import with_payload
from strategies import arms, examples


def read_back(arm: RobotArm, folder: Path) -> RobotArm:
    path = folder / "written.toml"
    path.write_text(toml_of(arm), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return gd.load_arm(path)


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
            one,
            as_measured=bool(rng.random() < 0.3),
            axial_only=bool(i == 0 and joints[0].kind == "revolute" and rng.random() < 0.3),
            uncertainty=perhaps(
                LinkUncertainty(
                    rng.uniform(),
                    perhaps(rng.uniform(size=3)),
                    np.abs(np.cov(rng.normal(size=(3, 5)))),
                    rng.choice(["com", "origin"]),
                )
            ),
        )
        for i, one in enumerate(arm.links)
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
    return dataclasses.replace(arm, joints=joints, links=links, drives=drives if draw(st.booleans()) else ())


@examples(40)
@given(dressed_arms())
def test_any_arm_reads_back_to_the_last_bit(tmp_path_factory, arm):
    again = read_back(arm, tmp_path_factory.mktemp("arm"))
    assert fingerprint(again, drives=True) == fingerprint(arm, drives=True)
    same_but_for(arm, again, "title", "convention")


@pytest.mark.parametrize("name", gd.builtin_arms())
def test_built_in_arms_keep_their_table(name, tmp_path):
    arm = gd.load_arm(name)
    again = read_back(arm, tmp_path)
    assert again.dh_table == arm.dh_table
    same_but_for(arm, again)


QUARTER = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def placed(**changes) -> RobotArm:
    """One joint that stands on its side, and a link with a frame of its own."""
    before = Placement(QUARTER, np.array([0.0, 0.1, 0.0]))
    joint = Joint("shoulder", placement=before, axis=np.array([0, 1.0, 0]))
    return RobotArm(
        **{"name": "placed", "joints": (joint,), "links": (link(frame=Placement(QUARTER.T)),)} | changes
    )


def test_a_right_angle_is_one_for_people_too(tmp_path):
    text = toml_of(placed())
    assert "\nrpy_deg = [90.0, 0.0, 0.0]" in text
    assert "frame_rpy_deg = [-90.0, 0.0, 0.0]" in text
    assert fingerprint(read_back(placed(), tmp_path)) == fingerprint(placed())


def test_texts_names_and_unknown_ends_come_back(tmp_path):
    arm = placed(
        name="my arm / 2",
        joints=(Joint("1", "prismatic", lower=0.5, upper=np.inf),),
        sources=('A "quoted" \\ source\nof two lines', "é"),
        assumptions=("none",),
        doubts=("its base is moved",),
    )
    again = read_back(arm, tmp_path)
    assert (again.name, again.title) == ("my_arm___2", "my arm / 2")
    assert (again.sources, again.assumptions, again.doubts) == (arm.sources, arm.assumptions, arm.doubts)
    assert (again.joints[0].lower, again.joints[0].upper) == (0.5, None)
    with pytest.warns(GdAnalyzeWarning, match="its base is moved"):
        gd.load_arm(tmp_path / "written.toml")


def test_a_payload_is_written_with_its_link_but_not_with_uncertainties(puma, tmp_path):
    with pytest.raises(ArmError, match="link 6 carries a payload"):
        toml_of(with_payload(puma, 1.0, [0.0, 0.0, 0.1]))
    bare = dataclasses.replace(
        puma, links=tuple(dataclasses.replace(x, uncertainty=None) for x in puma.links)
    )
    carrying = with_payload(bare, 1.0, [0.0, 0.0, 0.1])
    assert fingerprint(read_back(carrying, tmp_path)) == fingerprint(carrying)
