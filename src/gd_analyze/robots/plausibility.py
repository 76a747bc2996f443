"""Plausibility checks of an arm: a function per check, with its message.

The limits are far beyond existing arms, from 0.3 m on a desk to cranes and some hundred chains from makers'
files, and far below the values that a wrong unit gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import accumulate, zip_longest

import numpy as np

from gd_analyze.errors import warn_caller
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.bodies import (
    MOST_JOINTS_WITH_TERMS,
    NO_MASS,
    PlacedFindings,
    ball_density,
    centres_fit_another_reading,
    described_links,
    gyration,
    inertials_of_other_links,
    inertias_about_the_joints,
    inertias_too_small,
    lighter_than_its_neighbours,
    weighs,
)
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.text import number, percent

_FULL_TURN = 2 * math.pi
# Angles are typed with four decimals of a radian.
_TYPED_ANGLE_TOLERANCE = 1e-4
# Distance of a centre of mass that is plausible in an arm without reach, m.
_LEAST_FAR_METRES = 0.1
# Inertias measured by swinging a link are good to about 10 % (Armstrong, Khatib, Burdick 1986).
_MEASUREMENT_TOLERANCE = 0.1
# Numbers rounded to 3 digits are good to 0.1 %.
_ROUNDING_TOLERANCE = 1e-3
# Findings of one check up to which each is told.
_MOST_FINDINGS_TOLD = 3
_CHECK = "check the signs of its products, units (cm or m) and reference point (com or origin)"


def implausible(arm: RobotArm) -> tuple[str, ...]:
    """Suspicious numbers of an arm, a sentence each: doubts from its file, then findings of the checks.

    A check that faults many links or joints, as a unit of all inertias does, tells the first two and
    counts the rest.
    """
    sentences = list(arm.doubts)
    for check in CHECKS:
        findings = [f"{place}: {message}" for place, message in check(arm)]
        if len(findings) > _MOST_FINDINGS_TOLD:
            findings[2:] = [
                f"arm {arm.name}: {len(findings) - 2} more links or joints have numbers like these"
            ]
        sentences += findings
    return tuple(dict.fromkeys(sentences))


def warn_of_implausible(arm: RobotArm) -> None:
    """Warn of each suspicious number."""
    for message in implausible(arm):
        warn_caller(message)


def inconsistent_inertias(arm: RobotArm) -> tuple[str, ...]:
    """Physically inconsistent inertias of an arm's links, a sentence each."""
    return tuple(f"{place}: {message}" for place, message in inertia_physically_inconsistent(arm))


def check_payload(body: Link, reach: float) -> Iterator[str]:
    """Suspicious numbers of a payload, for an arm with this reach, m."""
    of_arm, distance = f"an arm that reaches {reach:.3g} m", float(np.linalg.norm(body.com))
    if body.mass > _heaviest(reach):
        yield f"a payload of {body.mass:g} kg is more than {of_arm} carries; in grams?"
    if message := _inconsistency(body):
        yield f"payload: {message}"
    if body.mass > 0 and distance > max(reach, _LEAST_FAR_METRES):
        yield f"a payload {distance:.3g} m from its frame is too far away for {of_arm}; is it in metres?"


def gravity_too_strong(arm: RobotArm) -> PlacedFindings:
    """Gravity on Jupiter is 25 m/s^2; 9.81 with a misplaced decimal point is at least 98.1."""
    strength = float(np.linalg.norm(arm.gravity_vector))
    if strength > 30.0:
        yield f"arm {arm.name}", f"gravity is {strength:g} m/s^2; on Earth it is 9.81"


def angle_beyond_a_turn(arm: RobotArm) -> PlacedFindings:
    """An angle of a Denavit-Hartenberg table in degrees."""
    for place, key, angle in _angles(arm):
        if abs(angle) > _FULL_TURN + _TYPED_ANGLE_TOLERANCE:
            yield place, f"{key} is {angle:g} rad, more than a full turn; if in degrees, write {key}_deg"


def angle_of_pi_degrees(arm: RobotArm) -> PlacedFindings:
    """An angle in radians under a key in degrees."""
    for place, key, angle in _angles(arm):
        degrees = math.degrees(angle)
        for whole, name in ((math.pi, "pi"), (math.pi / 2, "pi/2")):
            if abs(abs(degrees) - whole) < 1e-3:
                yield place, f"{key} is {degrees:g} degrees, which is {name}; if in radians, write {key}"


def length_in_millimetres(arm: RobotArm) -> PlacedFindings:
    """The longest booms between two joints have 15 m; an arm on a desk has some length of 20 mm."""
    for joint, link, row in zip_longest(arm.joints, arm.links, arm.dh_table):
        if row is not None:
            lengths = [(joint.place, key, abs(getattr(row, key)), f"write {key}_mm") for key in ("a", "d")]
        else:
            parts = (joint.place, joint.placement), (link.place, link.frame)
            offsets = [(place, float(np.linalg.norm(frame.translation))) for place, frame in parts]
            lengths = [(place, "the offset", length, "give metres") for place, length in offsets]
        for place, key, length, advice in lengths:
            if length > 20.0:
                yield place, f"{key} is {length:g} m long; if in mm, {advice}"


def offset_far_beyond_the_others(arm: RobotArm) -> PlacedFindings:
    """A misplaced decimal point: the longest offset of real arms is at most the sum of all others, or 3 m."""
    offsets = [
        (place, float(np.linalg.norm(frame.translation)))
        for joint, link in zip(arm.joints, arm.links, strict=True)
        for place, frame in ((joint.place, joint.placement), (link.place, link.frame))
    ]
    place, longest = max(offsets, key=lambda offset: offset[1])
    sum_of_others = sum(length for _, length in offsets) - longest
    if longest > max(3.0, 3.0 * sum_of_others) and sum_of_others > 0.0:
        text = f"an offset of {longest:.4g} m; all others add up to {sum_of_others:.3g} m"
        yield place, f"{text}: is the decimal point right?"


def more_joints_than_have_terms(arm: RobotArm) -> PlacedFindings:
    """Not a fault of the arm, but what it cannot have here is best known at once."""
    if arm.n_joints > MOST_JOINTS_WITH_TERMS:
        limit = f"terms are ranked and chosen for up to {MOST_JOINTS_WITH_TERMS} joints"
        hint = "hold some by --lock or --tip (URDF and MJCF), or expect elements only"
        yield f"arm {arm.name}", f"{arm.n_joints} joints, but {limit}; {hint}"


def massless_among_bodies(arm: RobotArm) -> PlacedFindings:
    """A link without stated mass between links with mass."""
    stated = described_links(arm)
    heavy = [k for k, (_, link) in enumerate(stated) if weighs(link)]
    for k, (place, link) in enumerate(stated):
        is_nothing = link.mass < NO_MASS and not link.inertia_com.any()
        # Several joints of one body have links of nothing between them.
        is_within = heavy and heavy[0] < k < heavy[-1] and stated[k + 1][0] != place
        if is_nothing and is_within:
            yield place, f"link {link.name} has no mass, but links before and after it have; is it missing?"


def prismatic_range_in_millimetres(arm: RobotArm) -> PlacedFindings:
    """Gantries run along 100 m."""
    for joint in arm.joints:
        end = _end(joint)
        if joint.kind == "prismatic" and end > 100.0:
            yield joint.place, f"the range goes to {end:g} m; if in mm, give m, or range_mm in TOML"


def revolute_range_in_degrees(arm: RobotArm) -> PlacedFindings:
    """Ranges of real joints end within two turns, at a multiple of half a turn, or far out (no limit)."""
    for joint in arm.joints:
        end = _end(joint)
        turns = end / _FULL_TURN
        if joint.kind != "revolute" or not 2 * _FULL_TURN < end <= 720.0:
            continue
        if end.is_integer() or abs(2 * turns - round(2 * turns)) >= _TYPED_ANGLE_TOLERANCE:
            advice = "if in degrees, give rad, or range_deg in TOML"
            yield joint.place, f"the range goes to {end:g} rad, which is {turns:.3g} turns; {advice}"


def velocity_in_degrees(arm: RobotArm) -> PlacedFindings:
    """The fastest wrists turn at 40 rad/s; even slow joints reach 60 degrees per second."""
    for joint in arm.joints:
        limit = joint.velocity_limit or 0.0
        if joint.kind == "revolute" and limit > 60.0:
            advice = "if in degrees per second, give rad/s, or velocity_limit_deg in TOML"
            yield joint.place, f"the velocity limit is {limit:g} rad/s, faster than any arm; {advice}"


def velocity_in_turns_per_minute(arm: RobotArm) -> PlacedFindings:
    """Stretched out, arms reach 6 m/s at their end, and the fastest humanoid's 29 m/s."""
    lengths = _lengths_beyond(arm)
    for joint, length in zip(arm.joints, lengths, strict=True):
        speed = (joint.velocity_limit or 0.0) * length
        if joint.kind == "revolute" and speed > 30.0:
            limit = f"the velocity limit is {joint.velocity_limit:g} rad/s"
            yield joint.place, f"{limit}, {speed:.3g} m/s at the end of the stretched arm; is it in 1/min?"
            return


def torque_limit_in_newton_millimetres(arm: RobotArm) -> PlacedFindings:
    """Drives of desk arms hold 75 times the weight beyond their joint, those of larger arms 40 times.

    Legs and fingers below 1 kg state limits of some thousand times their weight.
    """
    links = [link for _, link in described_links(arm)]
    if not arm.drives or sum(link.mass for link in links) < 1.0:
        return
    lengths = _lengths_beyond(arm)
    # Above the weight's torque about a joint: each link's weight at its farthest.
    torques = []
    for i, length in enumerate(lengths):
        pairs = zip(links[i:], lengths[i:], strict=True)
        levers = [(link.mass, length - beyond + float(np.linalg.norm(link.com))) for link, beyond in pairs]
        torques.append(sum(9.81 * mass * lever for mass, lever in levers))
    for joint, drive, torque in zip(arm.joints, arm.drives, torques, strict=True):
        limit = drive.torque_limit or 0.0
        if joint.kind == "revolute" and torque > 0.2 * max(torques) and 150.0 * torque < limit:
            weight = f"{number(torque)} N m, the stretched arm's weight"
            yield joint.place, f"the torque limit is {limit:g} N m beside {weight}; in N mm, or is it none?"


def inertia_wider_than_the_arm(arm: RobotArm) -> PlacedFindings:
    """Radii of gyration are below 0.5 reaches; in kg cm^2 the longest link has 3 or more, in kg mm^2 30."""
    for place, link in described_links(arm):
        if _is_wide(link, arm.reach):
            width = f"the inertia is that of a body {2 * gyration(link):.3g} m wide, {_reaching(arm)}"
            yield place, f"with {link.mass:g} kg {width}; is it in kg cm^2, kg mm^2 or g mm^2, not kg m^2?"


def mass_too_large_for_reach(arm: RobotArm) -> PlacedFindings:
    """The reach limits the mass where the inertia does not."""
    for place, link in described_links(arm):
        says_nothing = link.is_point or _is_wide(link, arm.reach)
        if says_nothing and weighs(link) and link.mass > _heaviest(arm.reach):
            yield place, f"a mass of {link.mass:g} kg is too much {_reaching(arm)}; in grams?"


def masses_too_small_for_reach(arm: RobotArm) -> PlacedFindings:
    """All links together, in tonnes: desk arms, the lightest, have 4 kg per cubic metre of reach."""
    whole, least = sum(link.mass for _, link in described_links(arm)), 0.03 * arm.reach**3
    # Sliding joints have a long reach.
    if NO_MASS < whole < least and all(arm.is_revolute):
        yield f"arm {arm.name}", f"all links together have {whole:.3g} kg, {_reaching(arm)}; in tonnes?"


def mass_too_dense(arm: RobotArm) -> PlacedFindings:
    """Density of the smallest ball with a link's mass and inertia: 5 to 3000 kg/m^3, 3e7 times more in grams.

    Links with point masses reach 1e7, as an end effector of 0.1 kg with 10 kg in its middle.
    """
    for place, link in described_links(arm):
        # Of an inertia with a negative moment another check says what is wrong.
        if link.is_point or not weighs(link) or _inconsistency(link):
            continue
        if ball_density(link) > 1e8:
            yield place, f"no material is dense enough for {link.mass:g} kg with this inertia; in grams?"


def centre_of_mass_beyond_reach(arm: RobotArm) -> PlacedFindings:
    """A centre of mass in mm. Frames at the near ends of links do not show the last link's length."""
    for place, link in described_links(arm):
        distance = float(np.linalg.norm(link.com))
        if link.mass > 0 and distance > max(arm.reach, _LEAST_FAR_METRES if arm.dh_table else 1.0):
            position = f"{distance:.3g} m from the link frame, {_reaching(arm)}"
            yield place, f"the centre of mass of link {link.name} is {position}; are its units metres?"


def inertia_physically_inconsistent(arm: RobotArm) -> PlacedFindings:
    """A negative principal moment, or one larger than the sum of the other two."""
    for place, link in described_links(arm):
        message = _inconsistency(link)
        if message:
            yield place, message


def point_mass_among_bodies(arm: RobotArm) -> PlacedFindings:
    """A link without inertia; an arm of point masses alone is a textbook model."""
    are_points = all(link.is_point for _, link in described_links(arm))
    for place, link in described_links(arm):
        if link.is_point and weighs(link) and not are_points:
            mass = f"a mass of {number(link.mass)} kg"
            yield place, f"link {link.name} has {mass} but no inertia, which other links have"


def centre_of_mass_outside_link(arm: RobotArm) -> PlacedFindings:
    """A centre of mass lies within half the reach of a joint of its link; the last link's end is unknown."""
    farthest = max(0.6 * arm.reach, _LEAST_FAR_METRES)
    for (place, link), beyond in zip(described_links(arm), arm.joints[1:], strict=False):
        offset, turn = link.frame.translation, link.frame.rotation
        centre, end = turn @ link.com + offset, turn @ beyond.placement.translation + offset
        distance = min(float(np.linalg.norm(centre)), float(np.linalg.norm(centre - end)))
        if link.mass > 0 and distance > farthest and float(np.linalg.norm(link.com)) <= arm.reach:
            position = f"{number(distance)} m from both of its joints, {_reaching(arm)}"
            yield (
                place,
                f"the centre of mass of link {link.name} is {position}; is it given in another frame?",
            )


def heavier_than_links_before(arm: RobotArm) -> PlacedFindings:
    """In arms of five or more joints each of the last two links has up to 0.31 of the mass before it.

    The third link from the end of a leg has 0.73. A finger's first links are as light as its last.
    """
    stated, n = described_links(arm), arm.n_joints
    for index in range((n + 1) // 2, n) if n >= 5 else ():
        (place, link), before = stated[index], sum(previous.mass for _, previous in stated[:index])
        share, than = (0.35, "a third of all links") if index >= n - 2 else (1.0, "all links")
        if link.mass > max(share * before, NO_MASS):
            mass = f"{number(link.mass)} kg, more than {than} before it together ({number(before)} kg)"
            yield place, f"link {link.name} has {mass}: real arms get lighter towards the end effector"


CHECKS: tuple[Callable[[RobotArm], PlacedFindings], ...] = (
    more_joints_than_have_terms,
    gravity_too_strong, angle_beyond_a_turn, angle_of_pi_degrees, length_in_millimetres,
    offset_far_beyond_the_others, massless_among_bodies,
    prismatic_range_in_millimetres, revolute_range_in_degrees, velocity_in_degrees,
    velocity_in_turns_per_minute, torque_limit_in_newton_millimetres,
    inertia_wider_than_the_arm, mass_too_large_for_reach, masses_too_small_for_reach, mass_too_dense,
    centre_of_mass_beyond_reach,
    inertia_physically_inconsistent, point_mass_among_bodies, centre_of_mass_outside_link,
    heavier_than_links_before,
    centres_fit_another_reading, inertials_of_other_links, inertias_about_the_joints, inertias_too_small,
    lighter_than_its_neighbours,
)  # fmt: skip


def _inconsistency(link: Link) -> str | None:
    """Physical inconsistency of an inertia; None for a consistent one and published measurements near one."""
    least, middle, most = link.principal_moments.tolist()
    largest = max(abs(least), abs(most))
    negative, excess = -least, 0.0 if link.axial_only else most - least - middle
    if link.is_point or max(negative, excess) <= _ROUNDING_TOLERANCE * largest:
        return None
    moments, inertia = f"({link.moments_text})", f"the inertia of link {link.name}"
    if negative > _ROUNDING_TOLERANCE * largest:
        by = f"by {percent(negative / largest)} of the largest {moments}"
        fault = f"physically inconsistent: its smallest principal moment is negative, {by}"
        return f"{inertia} is {fault}; {_CHECK}"
    share = f"{percent(excess / largest)} of its largest principal moment {moments}"
    violated = f"{inertia} violates the triangle inequality by {share}"
    if excess > _MEASUREMENT_TOLERANCE * largest:
        return f"{violated}: physically inconsistent; {_CHECK}"
    advice = "if it is a measurement, state as_measured = true in a TOML file"
    return None if link.as_measured else f"{violated}; {advice}"


def _reaching(arm: RobotArm) -> str:
    return f"for an arm that reaches {arm.reach:.3g} m"


def _angles(arm: RobotArm) -> Iterator[tuple[str, str, float]]:
    for joint, row in zip(arm.joints, arm.dh_table, strict=False):
        yield joint.place, "theta", row.theta
        yield joint.place, "alpha", row.alpha


def _lengths_beyond(arm: RobotArm) -> list[float]:
    """Length of the stretched arm from each joint to the last link frame, m."""
    steps = [float(np.linalg.norm(link.frame.translation)) for link in arm.links]
    between = [float(np.linalg.norm(joint.placement.translation)) for joint in arm.joints[1:]]
    pieces = [step + after for step, after in zip(steps, [*between, 0.0], strict=True)]
    return list(accumulate(reversed(pieces)))[::-1]


def _end(joint: Joint) -> float:
    return max((abs(end) for end in (joint.lower, joint.upper) if end is not None), default=0.0)


def _is_wide(link: Link, reach: float) -> bool:
    return weighs(link) and gyration(link) > 2.0 * max(reach, 0.3)


def _heaviest(reach: float) -> float:
    """Mass beyond any arm's, kg: industrial robots have 30 to 250 kg per cubic metre of reach."""
    return 1000.0 * max(reach, 0.5) ** 3
