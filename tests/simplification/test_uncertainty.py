"""Torque uncertainty: every parameter moved in turn, Monte Carlo, closed forms, and what must add up."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_link
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.robots.parts import LinkUncertainty
from gd_analyze.tables import states_in_box, states_of, torque_uncertainty
from gd_analyze.types import Drive, Joint, Link, Placement, RobotArm, States
from strategies import arms_with_states, examples

EPS = float(np.finfo(float).eps)


def torque(arm: RobotArm, states) -> FloatArray:
    return newton_euler_link.torque(arm, states.q.T, states.qd.T, states.qdd.T).T


def with_link(arm: RobotArm, link: int, **changes) -> RobotArm:
    """The arm with another link (from 0)."""
    links = list(arm.links)
    links[link] = dataclasses.replace(links[link], **changes)
    return dataclasses.replace(arm, links=tuple(links))


def steiner(mass: float, com: FloatArray) -> FloatArray:
    return mass * ((com @ com) * np.eye(3) - np.outer(com, com))


def moved(link: Link, about: str, mass: float, com: FloatArray, inertia: FloatArray) -> dict[str, object]:
    """What a link is when its mass, centre of mass and inertia about the stated point are off by this."""
    new_mass, new_com = link.mass + mass, link.com + com
    known = link.inertia_com + inertia
    if about == "origin":
        known = known + steiner(link.mass, link.com) - steiner(new_mass, new_com)
    return {"mass": new_mass, "com": new_com, "inertia_com": known}


def parameters(uncertainty: LinkUncertainty) -> list[tuple[float, FloatArray, FloatArray]]:
    """Each parameter's own change by one standard uncertainty."""
    out = [(uncertainty.mass, np.zeros(3), np.zeros((3, 3)))]
    out += [(0.0, step, np.zeros((3, 3))) for step in np.diag(uncertainty.com)]
    for a, b in zip(*np.triu_indices(3), strict=True):
        entry = np.zeros((3, 3))
        entry[a, b] = entry[b, a] = uncertainty.inertia[a, b]
        out.append((0.0, np.zeros(3), entry))
    return out


def small(rng: np.random.Generator, about: str) -> LinkUncertainty:
    """So small that a moved link of `strategies.arms` is still a possible one."""
    inertia = rng.uniform(0, 1e-3, (3, 3))
    return LinkUncertainty(rng.uniform(0, 1e-3), rng.uniform(0, 1e-3, 3), inertia + inertia.T, about)


@pytest.mark.parametrize("about", ["com", "origin"])
@examples(16)
@given(case=arms_with_states(max_joints=5, massive=True), seed=st.integers(0, 2**32 - 1))
def test_it_is_the_root_of_the_squares_of_what_each_parameter_does(case, about, seed):
    """Half of what moving a parameter to both sides does is of first order: torque is quadratic in it."""
    arm, states = case
    rng = np.random.default_rng(seed)
    squares = np.zeros(states.q.shape)
    uncertain = arm
    for s, link in enumerate(arm.links):
        uncertainty = small(rng, about)
        uncertain = with_link(uncertain, s, uncertainty=uncertainty)
        for change in parameters(uncertainty):
            there, back = (
                torque(with_link(arm, s, **moved(link, about, *(sign * part for part in change))), states)
                for sign in (1.0, -1.0)
            )
            squares += (0.5 * (there - back)) ** 2
    found = torque_uncertainty(uncertain, states)
    assert found is not None
    # Differences of torques leave their round-off behind: as many parameters as the arm has, in the root.
    bound = round_off_bounds(arm, *states.arrays)["torque"]
    assert np.abs(found - np.sqrt(squares)).max() <= 2 * bound * np.sqrt(10 * arm.n_joints)


def pendulum(uncertainty: LinkUncertainty) -> RobotArm:
    """A rod of 2 kg, hanging in a vertical plane, com at 0.4 m of 1 m from the joint."""
    link = Link(
        "rod",
        2.0,
        np.array([-0.6, 0.0, 0.0]),
        np.diag([0.1, 0.3, 0.3]),
        Placement(np.eye(3), np.array([1.0, 0.0, 0.0])),
        uncertainty=uncertainty,
    )
    return RobotArm("pendulum", (Joint("1"),), (link,), np.array([0.0, -9.8062, 0.0]))


ANGLE, RATE, ACCELERATION = (np.array([[0.3], [-2.0], [1.1]]) for _ in range(3))
STATES = States(ANGLE, RATE, ACCELERATION)


@pytest.mark.parametrize(
    ("uncertainty", "effect"),
    [
        # tau = (I + m (x^2 + y^2)) qdd + m g (x cos q - y sin q); from the joint, com is at x = 0.4 m, y = 0.
        (LinkUncertainty(mass=0.1), 0.1 * (0.16 * ACCELERATION + 9.8062 * 0.4 * np.cos(ANGLE))),
        (LinkUncertainty(com=np.array([0.0, 0.01, 0.0])), 0.01 * 2.0 * 9.8062 * np.sin(ANGLE)),
        (LinkUncertainty(inertia=np.diag([0.01, 0.02, 0.03])), 0.03 * ACCELERATION),
        # About the frame's origin I_o = I + m 0.6^2 stays, so that I + m x^2 = I_o + m (0.4^2 - 0.6^2).
        (
            LinkUncertainty(mass=0.1, inertia_about="origin"),
            0.1 * ((0.16 - 0.36) * ACCELERATION + 9.8062 * 0.4 * np.cos(ANGLE)),
        ),
    ],
)
def test_closed_forms_of_a_pendulum(uncertainty, effect):
    found = torque_uncertainty(pendulum(uncertainty), STATES)
    # Some ten products of numbers of order 1, and a root of their squares.
    np.testing.assert_allclose(found, np.abs(effect), rtol=0, atol=40 * EPS)


def test_drives_count_where_they_are_part_of_the_torque(puma):
    silent = dataclasses.replace(
        puma, links=tuple(dataclasses.replace(link, uncertainty=None) for link in puma.links)
    )
    states = states_in_box(puma, 20)
    assert torque_uncertainty(silent, states, drives=False) is None
    of_drives = torque_uncertainty(silent, states)
    expected = np.abs(states.qdd) * [drive.inertia_uncertainty for drive in puma.drives]
    # A product, its square and the root.
    np.testing.assert_allclose(of_drives, expected, rtol=4 * EPS)
    of_links = torque_uncertainty(puma, states, drives=False)
    # Variances add up; a handful of roundings each.
    np.testing.assert_allclose(
        torque_uncertainty(puma, states) ** 2, of_drives**2 + of_links**2, rtol=16 * EPS
    )


def test_nothing_stated_is_not_zero_stated(two_link, swing):
    states = states_of(swing)
    assert torque_uncertainty(two_link, states) is None
    assert torque_uncertainty(two_link, states, drives=True) is None
    nothing = LinkUncertainty(0.0, np.zeros(3), np.zeros((3, 3)))
    known = with_link(two_link, 1, uncertainty=nothing)
    assert not torque_uncertainty(known, states).any()
    assert torque_uncertainty(known, states).shape == swing.q.shape
    known = dataclasses.replace(two_link, drives=(Drive(1.0, 0.0), Drive(1.0)))
    assert torque_uncertainty(known, states, drives=False) is None
    assert not torque_uncertainty(known, states, drives=True).any()
