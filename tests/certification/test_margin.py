"""Margins: how they are written, and how large they are along a motion."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest

from gd_analyze.certification.tube import Margin
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.catalogue import load_arm


@pytest.mark.parametrize(
    ("text", "margin"),
    [
        ("1deg,1mm,qd=2%,qdd=5%", Margin()),
        ("0.5deg", Margin(revolute=math.radians(0.5))),
        (" 0.02 rad , 0.002 m", Margin(revolute=0.02, prismatic=0.002)),
        ("qdd=10%,qd=0%", Margin(velocity=0.0, acceleration=0.1)),
    ],
)
def test_what_is_read(text: str, margin: Margin) -> None:
    assert Margin.parse(text) == margin
    # Twelve digits are written.
    assert astuple(Margin.parse(str(margin))) == pytest.approx(astuple(margin), rel=1e-11)


@pytest.mark.parametrize(
    "text",
    ["", "1", "2%", "deg", "-1deg", "nan deg", "1deg,,1mm", "qd=1deg", "q=2%", "qd=2", "1deg,2deg", "1m,1mm"],
)
def test_what_is_no_margin(text: str) -> None:
    with pytest.raises(UsageError, match="margin") as caught:
        Margin.parse(text)
    assert "--margin" in str(caught.value)


@pytest.mark.parametrize("values", [{"velocity": -0.1}, {"revolute": math.nan}, {"prismatic": math.inf}])
def test_what_a_margin_cannot_be(values: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="a margin cannot be that"):
        Margin(**values)


def test_rates_and_accelerations_have_shares_of_their_largest() -> None:
    """Joint 3 of the Stanford arm slides; joint 1 is held still and has a margin of position alone."""
    arm = load_arm("stanford")
    still, one = np.zeros((3, 6)), np.ones((3, 6))
    velocities, accelerations = one * [0, 1, -2, 3, 4, 5], -2 * one * [0, 1, -2, 3, 4, 5]
    motion = Trajectory(np.arange(3.0), still, velocities, accelerations)
    position, velocity, acceleration = Margin().along(arm, motion)
    np.testing.assert_allclose(position, np.radians([1, 1, np.degrees(1e-3), 1, 1, 1]))
    np.testing.assert_allclose(velocity, 0.02 * np.abs(velocities[0]))
    np.testing.assert_allclose(acceleration, 0.05 * np.abs(accelerations[0]))


def test_in_words_of_the_arms_joints() -> None:
    assert Margin().in_words(load_arm("stanford")).startswith("1 degree or 1 mm, ")
    assert "mm" not in Margin(revolute=math.radians(2)).in_words(load_arm("puma560"))
