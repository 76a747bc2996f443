"""Numbers that an arm can have but a person hardly means: each as a sentence that names the likely slip.

The limits are far beyond arms that exist, from 0.3 m on a desk to cranes and the Space Station's of 17 m, and
far below what the slip makes of any of them.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.mass_slips import STANDS_FOR_NONE, mass_slips
from gd_analyze.robots.parts import Joint, Link

if TYPE_CHECKING:
    from gd_analyze.robots.arm import RobotArm

_FULL_TURN = 2 * math.pi
# Ranges of real joints end within two turns, or at a number of turns, or (none meant) far out.
_MANY_TURNS, _NO_RANGE = 2 * _FULL_TURN, 720.0
_TYPED = 1e-4  # four decimals of a radian
# The fastest wrists turn at 40 rad/s; in degrees even slow joints do 60 per second.
_FASTEST = 60.0
# The longest booms between two joints have 15 m; an arm on a desk has 20 mm somewhere.
_LONGEST = 20.0
# Gantries run along 100 m.
_LONGEST_SLIDE = 100.0
# Jupiter's is 25 m/s^2; 9.81 without its point is 98.1 at least.
_HEAVIEST = 30.0
# Density of the ball of a link's mass and inertia, the smallest body that has both: 5 to 3000 kg/m^3 of real
# links, 3e7 times more with the mass in grams. Links that carry point masses are beyond osmium's 22 600, up
# to 1e7 where a hand of 0.1 kg carries 10 kg in its middle.
_DENSEST = 1e8
# Mass that industrial robots have, per cube of what they reach: 30 to 250 kg/m^3. Of turntables that reach
# nowhere this says nothing, hence at least half a metre, and only where the inertia says nothing either.
_HEAVIEST_CUBE, _LEAST_CUBE = 1000.0, 0.5
# Radius of gyration, by the arm's reach of at least 0.3 m: below 0.5 for links and turntables, and of the
# longest link of an arm 3 or more with inertias in kg cm^2, 30 in kg mm^2 or g mm^2.
_WIDEST, _LEAST_REACH = 2.0, 0.3
# A centre of mass less far out than this is one's of an arm that reaches nowhere, m.
LEAST_FAR = 0.1
# Frames at the near ends of links, as in URDF, say nothing of how long the last link is, m.
_LEAST_FAR_BEHIND = 1.0


def implausible(arm: RobotArm) -> tuple[str, ...]:
    """Say what is suspicious of an arm, such as a slip of the unit, a sentence for each."""
    return tuple(dict.fromkeys(_sentences(arm)))


def warn_of_implausible(arm: RobotArm, stacklevel: int) -> None:
    """Warn of each slip, with a GdAnalyzeWarning that points as far up the calls as `stacklevel` says."""
    for slip in implausible(arm):
        warnings.warn(slip, GdAnalyzeWarning, stacklevel=stacklevel + 1)


def _sentences(arm: RobotArm) -> Iterator[str]:
    yield from arm.doubts
    strength = float(np.linalg.norm(arm.gravity))
    if strength > _HEAVIEST:
        yield f"arm {arm.name}: gravity is {strength:g} m/s^2, more than on any planet; on Earth it is 9.81"
    for row, joint in zip(arm.dh_table, arm.joints, strict=False):
        for key, angle in (("theta", row.theta), ("alpha", row.alpha)):
            yield from _angle_slip(joint.place, key, angle)
        for key, length in (("a", row.a), ("d", row.d)):
            yield from _length_slip(joint.place, key, length, f", write {key}_mm")
    for joint, link in zip(arm.joints, arm.links, strict=True):
        if not arm.dh_table:
            for part, placement in ((joint, joint.placement), (link, link.frame)):
                yield from _length_slip(part.place, "the way", float(np.linalg.norm(placement.translation)))
        yield from _limit_slips(joint)
        # What is carried was not stated of the link.
        stated = link.bare or link
        yield from _mass_slips(stated, arm.reach)
        least = LEAST_FAR if arm.dh_table else _LEAST_FAR_BEHIND
        yield from _centre_slip(stated, max(arm.reach, least), arm.reach)
    yield from arm.impossible
    yield from mass_slips(arm)


def _length_slip(where: str, key: str, length: float, remedy: str = ", give metres") -> Iterator[str]:
    if abs(length) > _LONGEST:
        yield f"{where}: {key} is {length:g} m long; if the number is in mm{remedy}"


def _angle_slip(where: str, key: str, angle: float) -> Iterator[str]:
    if abs(angle) > _FULL_TURN + _TYPED:
        yield (
            f"{where}: {key} is {angle:g} rad, more than a full turn, which says no more than a part of one; "
            f"if it is in degrees, write {key}_deg"
        )
    typed = math.degrees(angle)
    for whole, name in ((math.pi, "pi"), (math.pi / 2, "pi/2")):
        if abs(abs(typed) - whole) < 1e-3:
            yield f"{where}: {key} is {typed:g} degrees, which is {name}; if it is in radians, write {key}"


def _limit_slips(joint: Joint) -> Iterator[str]:
    where = joint.place
    ends = [abs(end) for end in (joint.lower, joint.upper) if end is not None]
    end = max(ends, default=0.0)
    if joint.kind == "prismatic":
        if _LONGEST_SLIDE < end < math.inf and not _is_none_meant(end, joint):
            instead = _instead("range_mm", "m", joint)
            yield f"{where}: the range goes to {end:g} m; if that is in mm, {instead}"
        return
    turns = end / math.pi
    if _MANY_TURNS < end <= _NO_RANGE and (end.is_integer() or abs(turns - round(turns)) >= _TYPED):
        yield (
            f"{where}: the range goes to {end:g} rad, which is {turns / 2:.3g} turns; "
            f"if that is in degrees, {_instead('range_deg', 'rad', joint)}"
        )
    rate = joint.rate_limit
    if rate is not None and _FASTEST < rate < math.inf and not _is_none_meant(rate, joint):
        yield (
            f"{where}: the rate limit is {rate:g} rad/s, faster than any arm; "
            f"if that is in degrees per second, {_instead('rate_limit_deg', 'rad/s', joint)}"
        )


def _has_units(joint: Joint) -> bool:
    """Whether it is described where a number can be given in degrees or mm: not in URDF or MJCF."""
    return joint.source is None or Path(joint.source.path).suffix == ".toml"


def _instead(key: str, unit: str, joint: Joint) -> str:
    return f"write {key}" if _has_units(joint) else f"give {unit}"


def _is_none_meant(limit: float, joint: Joint) -> bool:
    """Whether a limit of 100, 1000 and so on stands for none, as in makers' files of fixed units."""
    return not _has_units(joint) and math.log10(limit).is_integer()


def _mass_slips(link: Link, reach: float) -> Iterator[str]:
    if link.mass < STANDS_FOR_NONE or link.axial_only:
        return
    where, mass = link.place, f"a mass of {link.mass:g} kg"
    gyration = math.sqrt(max(0.0, float(np.trace(link.inertia_com))) / 2 / link.mass)
    is_wide = gyration > _WIDEST * max(reach, _LEAST_REACH)
    if is_wide:
        yield (
            f"{where}: with {mass} the inertia is that of a body {2 * gyration:.3g} m wide, of an arm that "
            f"reaches {reach:.3g} m; is it in kg cm^2, kg mm^2 or g mm^2? It is read in kg m^2"
        )
    if (is_wide or link.is_point) and link.mass > heaviest_carried(reach):
        yield f"{where}: {mass} is more than an arm that reaches {reach:.3g} m has; is it in grams?"
    # A ball has the least inertia of all bodies of its mass and density: 3/5 m r^2, half the trace.
    volume = 4 / 3 * math.pi * (5 / 3 * gyration**2) ** 1.5
    if not link.is_point and link.mass > _DENSEST * volume:
        yield f"{where}: with {mass} no material is dense enough for so small an inertia; is it in grams?"


def _centre_slip(link: Link, most: float, reach: float) -> Iterator[str]:
    distance = float(np.linalg.norm(link.com))
    if link.mass > 0 and distance > most:
        yield (
            f"{link.place}: the centre of mass of link {link.name} is {distance:.3g} m from the link "
            f"frame, farther than the whole arm reaches ({reach:.3g} m); are its units metres?"
        )


def heaviest_carried(reach: float) -> float:
    """Mass, kg, beyond that of any link or payload of an arm that reaches so far, m."""
    return _HEAVIEST_CUBE * max(reach, _LEAST_CUBE) ** 3
