"""Plausibility of an arm: one function per check, each with its message.

The limits are far beyond arms that exist, from 0.3 m on a desk to cranes and the Space Station's of 17 m and
to some hundred chains from makers' files, and far below what a wrong unit makes of any of them.
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable, Iterator
from itertools import zip_longest
from pathlib import Path

import numpy as np

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.text import number, percent

# What a check finds: the place, and the sentence.
Findings = Iterator[tuple[str, str]]
Check = Callable[[RobotArm], Findings]
CHECKS: list[Check] = []

_FULL_TURN = 2 * math.pi
_TYPED = 1e-4  # four decimals of a radian
# A mass below stands for none, kg.
_NO_MASS = 1e-6
# A centre of mass closer than this is fine in an arm without reach, m.
_LEAST_FAR = 0.1
# Inertias measured by swinging a link are good to about 10 % (Armstrong, Khatib, Burdick 1986); rounding to 3
# digits is good to 0.1 %.
_MEASUREMENT_TOLERANCE, _ROUNDING_TOLERANCE = 0.1, 1e-3
_UNITS = "check units (cm against m) and the point the inertia is about (com or origin)"


def implausible(arm: RobotArm) -> tuple[str, ...]:
    """Suspicious numbers of an arm: doubts from its file, then what each check finds, a sentence each."""
    found = (f"{place}: {message}" for check in CHECKS for place, message in check(arm))
    return tuple(dict.fromkeys([*arm.doubts, *found]))


def warn_of_implausible(arm: RobotArm, stacklevel: int) -> None:
    """Warn of each suspicious number with a GdAnalyzeWarning that points `stacklevel` calls up."""
    for message in implausible(arm):
        warnings.warn(message, GdAnalyzeWarning, stacklevel=stacklevel + 1)


def inconsistent_inertias(arm: RobotArm) -> tuple[str, ...]:
    """Physically inconsistent inertias of an arm's links, a sentence each."""
    return tuple(f"{place}: {message}" for place, message in inertia_physically_inconsistent(arm))


def check_payload(body: Link, reach: float) -> Iterator[str]:
    """Suspicious numbers of a payload, of an arm with some reach (m)."""
    if body.mass > _heaviest(reach):
        yield f"a payload of {body.mass:g} kg is more than an arm of {reach:.3g} m reach carries; in grams?"
    if message := _inconsistency(body):
        yield f"payload: {message}"
    distance = float(np.linalg.norm(body.com))
    if body.mass > 0 and distance > max(reach, _LEAST_FAR):
        yield (
            f"a payload {distance:.3g} m from the last link's frame is beyond the arm's reach "
            f"({reach:.3g} m); are its units metres?"
        )


def _of_arm(check: Check) -> Check:
    CHECKS.append(check)
    return check


def _of_joints(find: Callable[[Joint], str | None]) -> Check:
    """Make a check of what is wrong with one joint."""

    @_of_arm
    @functools.wraps(find)
    def check(arm: RobotArm) -> Findings:
        for joint in arm.joints:
            if message := find(joint):
                yield joint.place, message

    return check


def _of_links(find: Callable[[Link, RobotArm], str | None]) -> Check:
    """Make a check of what is wrong with one link of an arm, as described, without a payload."""

    @_of_arm
    @functools.wraps(find)
    def check(arm: RobotArm) -> Findings:
        for link in arm.links:
            if message := find(link.bare or link, arm):
                yield link.place, message

    return check


@_of_arm
def gravity_too_strong(arm: RobotArm) -> Findings:
    """Jupiter's is 25 m/s^2; 9.81 without its point is 98.1 at least."""
    strength = float(np.linalg.norm(arm.gravity))
    if strength > 30.0:
        yield f"arm {arm.name}", f"gravity is {strength:g} m/s^2; on Earth it is 9.81"


@_of_arm
def angle_beyond_a_turn(arm: RobotArm) -> Findings:
    """An angle of a Denavit-Hartenberg table in degrees."""
    for place, key, angle in _angles(arm):
        if abs(angle) > _FULL_TURN + _TYPED:
            yield place, f"{key} is {angle:g} rad, more than a full turn; if in degrees, write {key}_deg"


@_of_arm
def angle_of_pi_degrees(arm: RobotArm) -> Findings:
    """An angle in radians under a key in degrees."""
    for place, key, angle in _angles(arm):
        degrees = math.degrees(angle)
        for whole, name in ((math.pi, "pi"), (math.pi / 2, "pi/2")):
            if abs(abs(degrees) - whole) < 1e-3:
                yield place, f"{key} is {degrees:g} degrees, which is {name}; if in radians, write {key}"


@_of_arm
def length_in_millimetres(arm: RobotArm) -> Findings:
    """The longest booms between two joints have 15 m; an arm on a desk has 20 mm somewhere."""
    for joint, link, row in zip_longest(arm.joints, arm.links, arm.dh_table):
        offsets = [(part.place, float(np.linalg.norm(frame.translation)))
                   for part, frame in ((joint, joint.placement), (link, link.frame))]  # fmt: skip
        lengths = [(place, "the offset", length, "give metres") for place, length in offsets]
        if row is not None:
            lengths = [(joint.place, key, abs(getattr(row, key)), f"write {key}_mm") for key in ("a", "d")]
        for place, key, length, instead in lengths:
            if length > 20.0:
                yield place, f"{key} is {length:g} m long; if in mm, {instead}"


@_of_joints
def prismatic_range_in_millimetres(joint: Joint) -> str | None:
    """Gantries run along 100 m."""
    end = _end(joint)
    if joint.kind != "prismatic" or not 100.0 < end < math.inf or _stands_for_none(end, joint):
        return None
    return f"the range goes to {end:g} m; if in mm, {_in_unit('range_mm', 'm', joint)}"


@_of_joints
def revolute_range_in_degrees(joint: Joint) -> str | None:
    """Ranges of real joints end within two turns, at a number of half turns, or (none meant) far out."""
    end = _end(joint)
    half_turns = end / math.pi
    if joint.kind != "revolute" or not 2 * _FULL_TURN < end <= 720.0:
        return None
    if not end.is_integer() and abs(half_turns - round(half_turns)) < _TYPED:
        return None
    instead = _in_unit("range_deg", "rad", joint)
    return f"the range goes to {end:g} rad, which is {half_turns / 2:.3g} turns; if in degrees, {instead}"


@_of_joints
def velocity_in_degrees(joint: Joint) -> str | None:
    """The fastest wrists turn at 40 rad/s; in degrees even slow joints do 60 per second."""
    limit = joint.velocity_limit or 0.0
    if joint.kind != "revolute" or not 60.0 < limit < math.inf or _stands_for_none(limit, joint):
        return None
    instead = _in_unit("velocity_limit_deg", "rad/s", joint)
    return f"the velocity limit is {limit:g} rad/s, faster than any arm; if in degrees per second, {instead}"


@_of_links
def inertia_wider_than_the_arm(link: Link, arm: RobotArm) -> str | None:
    """Radii of gyration: below 0.5 reaches; of an arm's longest link 3 and more in kg cm^2, 30 in kg mm^2."""
    if not _is_wide(link, arm.reach):
        return None
    return (
        f"with a mass of {link.mass:g} kg the inertia is that of a body {2 * _gyration(link):.3g} m wide, "
        f"of an arm that reaches {arm.reach:.3g} m; is it in kg cm^2, kg mm^2 or g mm^2? It is read in kg m^2"
    )


@_of_links
def mass_too_large_for_reach(link: Link, arm: RobotArm) -> str | None:
    """Where the inertia says nothing about the mass, the reach does."""
    says_nothing = link.is_point or _is_wide(link, arm.reach)
    if not _weighs(link) or not says_nothing or link.mass <= _heaviest(arm.reach):
        return None
    return f"a mass of {link.mass:g} kg is more than an arm that reaches {arm.reach:.3g} m has; in grams?"


@_of_links
def mass_too_dense(link: Link, arm: RobotArm) -> str | None:
    """Density of the smallest ball with a link's mass and inertia: 5 to 3000 kg/m^3, 3e7 times more in grams.

    Links that carry point masses reach 1e7, where an end effector of 0.1 kg carries 10 kg in its middle.
    """
    if not _weighs(link) or link.is_point:
        return None
    # A ball has the least inertia of all bodies of its mass and density: 3/5 m r^2, half the trace.
    volume = 4 / 3 * math.pi * (5 / 3 * _gyration(link) ** 2) ** 1.5
    if link.mass <= 1e8 * volume:
        return None
    return f"with a mass of {link.mass:g} kg no material is dense enough for so small an inertia; in grams?"


@_of_links
def centre_of_mass_beyond_reach(link: Link, arm: RobotArm) -> str | None:
    """A centre of mass in mm. Frames at the near ends of links do not tell the last link's length."""
    distance = float(np.linalg.norm(link.com))
    if link.mass <= 0 or distance <= max(arm.reach, _LEAST_FAR if arm.dh_table else 1.0):
        return None
    return (
        f"the centre of mass of link {link.name} is {distance:.3g} m from the link frame, farther than the "
        f"arm reaches ({arm.reach:.3g} m); are its units metres?"
    )


@_of_links
def inertia_physically_inconsistent(link: Link, arm: RobotArm) -> str | None:
    """Negative principal moments, or one that is more than the other two together."""
    return _inconsistency(link)


@_of_links
def point_mass_among_bodies(link: Link, arm: RobotArm) -> str | None:
    """A link without inertia; an arm of point masses alone is drawn on paper."""
    if not link.is_point or not _weighs(link) or all((one.bare or one).is_point for one in arm.links):
        return None
    return f"link {link.name} has a mass of {number(link.mass)} kg and no inertia; other links have one"


@_of_arm
def centre_of_mass_outside_link(arm: RobotArm) -> Findings:
    """A centre of mass is within half the reach of a joint of its link; the last link's end is unknown."""
    farthest = max(0.6 * arm.reach, _LEAST_FAR)
    for link, beyond in zip(_stated(arm), arm.joints[1:], strict=False):
        offset, turn = link.frame.translation, link.frame.rotation
        centre = turn @ link.com + offset
        ends = (np.zeros(3), turn @ beyond.placement.translation + offset)
        distance = min(float(np.linalg.norm(centre - end)) for end in ends)
        if link.mass > 0 and distance > farthest and float(np.linalg.norm(link.com)) <= arm.reach:
            yield (
                link.place,
                f"the centre of mass of link {link.name} is {number(distance)} m from both of its joints, of "
                f"an arm that reaches {number(arm.reach)} m; is it given in another frame?",
            )


@_of_arm
def heavier_than_links_before(arm: RobotArm) -> Findings:
    """The last two links of arms of five joints and more have up to 0.31 of the mass before them.

    A leg's third from its end has 0.73. A finger's first links are as light as its last.
    """
    links = _stated(arm)
    for index in range((len(links) + 1) // 2, len(links)) if len(links) >= 5 else ():
        link, before = links[index], sum(one.mass for one in links[:index])
        share, than = (0.5, "half of all links") if index >= len(links) - 2 else (1.0, "all links")
        if link.mass > max(share * before, _NO_MASS):
            yield (
                link.place,
                f"link {link.name} has a mass of {number(link.mass)} kg, more than {than} before it together "
                f"({number(before)} kg): real arms get lighter towards the end effector",
            )


def _inconsistency(link: Link) -> str | None:
    """How far an inertia is from that of any body; None for bodies and published measurements near one."""
    least, middle, most = link.principal_moments.tolist()
    largest = max(abs(least), abs(most))
    negative, excess = -least, 0.0 if link.axial_only else most - least - middle
    if link.is_point or max(negative, excess) <= _ROUNDING_TOLERANCE * largest:
        return None
    if negative > _ROUNDING_TOLERANCE * largest:
        return (
            f"the inertia of link {link.name} is physically inconsistent: its smallest principal moment is "
            f"negative, by {percent(negative / largest)} of the largest ({link.moments_text}); check the "
            f"signs of the products of inertia, and {_UNITS}"
        )
    violated = (
        f"the inertia of link {link.name} violates the triangle inequality by {percent(excess / largest)} of "
        f"its largest principal moment ({link.moments_text})"
    )
    if excess > _MEASUREMENT_TOLERANCE * largest:
        return f"{violated}: physically inconsistent; {_UNITS}"
    if link.as_measured:
        return None
    return f"{violated}; if it is a measurement, as_measured = true in a TOML file says so"


def _stated(arm: RobotArm) -> list[Link]:
    """Links as described, without a payload."""
    return [link.bare or link for link in arm.links]


def _weighs(link: Link) -> bool:
    return link.mass >= _NO_MASS and not link.axial_only


def _angles(arm: RobotArm) -> Iterator[tuple[str, str, float]]:
    for joint, row in zip(arm.joints, arm.dh_table, strict=False):
        yield joint.place, "theta", row.theta
        yield joint.place, "alpha", row.alpha


def _end(joint: Joint) -> float:
    return max((abs(end) for end in (joint.lower, joint.upper) if end is not None), default=0.0)


def _gyration(link: Link) -> float:
    return math.sqrt(max(0.0, float(np.trace(link.inertia_com))) / 2 / link.mass)


def _is_wide(link: Link, reach: float) -> bool:
    return _weighs(link) and _gyration(link) > 2.0 * max(reach, 0.3)


def _heaviest(reach: float) -> float:
    """Mass, kg, beyond any arm: industrial robots have 30 to 250 kg per cubic metre of reach."""
    return 1000.0 * max(reach, 0.5) ** 3


def _has_units(joint: Joint) -> bool:
    """Whether its file can give a number in degrees or mm: not URDF and MJCF."""
    return joint.source is None or Path(joint.source.path).suffix == ".toml"


def _in_unit(key: str, unit: str, joint: Joint) -> str:
    return f"write {key}" if _has_units(joint) else f"give {unit}"


def _stands_for_none(limit: float, joint: Joint) -> bool:
    """Whether a limit of 100, 1000 and so on stands for none, as in makers' files of fixed units."""
    return not _has_units(joint) and math.log10(limit).is_integer()
