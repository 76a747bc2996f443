"""Plausibility checks of links as bodies: masses, centres of mass and inertias against the joints they lie between.

A link's *line* is the segment between its joints. Real centres of mass lie near it, so that another reading of
the file's numbers, under which they lie much nearer, is what was probably meant. Limits come from 200 chains of
makers' files: arms, legs and hands.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, Placement, second_moment
from gd_analyze.text import number

# Findings of a check: place and sentence.
Findings = Iterator[tuple[str, str]]

# Mass below which a link counts as massless, kg.
NO_MASS = 1e-6
# Factor by which centres of mass must lie nearer in another reading: all of an arm's, of a chain of fewer than five
# joints, one of them, and those of shifted inertials. In makers' files they are 0.94, 0.76, 0.64 and 0.65 at least.
_ALL, _OF_FEW, _ONE, _SHIFTED = 0.75, 0.5, 0.5, 0.5
# Distance from its line, in reaches, that says nothing.
_NEAR = 0.01
# Distance of a centre of mass from its joint, in reaches, from which the joint is another point than the centre.
_APART = 0.08


class _Reading(NamedTuple):
    """Another meaning of the centres of mass, and their places in the links' frames then."""

    name: str
    places: list[FloatArray]


def described_links(arm: RobotArm) -> list[tuple[str, Link]]:
    """Places of links, and the links as described, without payload."""
    return [(link.place, link.bare or link) for link in arm.links]


def weighs(link: Link) -> bool:
    """Whether a link has mass, and an inertia that says where."""
    return link.mass >= NO_MASS and not link.axial_only


def gyration(link: Link) -> float:
    """Radius of gyration: root of half the trace of the inertia per mass, m."""
    return math.sqrt(max(0.0, float(np.trace(link.inertia_com))) / 2 / link.mass)


def ball_density(link: Link) -> float:
    """Density of the smallest ball with a link's mass and inertia, kg/m^3; infinite without inertia.

    A ball has the least inertia of all bodies of its mass and density: 3/5 m r^2, half the trace.
    """
    volume = 4 / 3 * math.pi * (5 / 3 * gyration(link) ** 2) ** 1.5
    return link.mass / volume if volume > 0.0 else math.inf


def centres_fit_another_reading(arm: RobotArm) -> Findings:
    """Centres of mass that lie near the lines with another sign or in another frame: all of them, or one."""
    links, lines = described_links(arm)[:-1], _lines(arm)
    heavy = np.array([link.mass >= NO_MASS for _, link in links])
    if heavy.sum() < 2 or arm.reach <= 0.0:
        return
    near = _NEAR * arm.reach
    given = _distances([link.com for _, link in links], lines)
    readings = [(reading, _distances(reading.places, lines)) for reading in _readings(arm)]
    misfits = [_misfit(read[heavy], near) for _, read in readings]
    if best := _best(misfits, _misfit(given[heavy], near), _ALL if arm.n_joints >= 5 else _OF_FEW):
        ifs = " or ".join(f"they are {readings[k][0].name}" for k in best)
        off = f"{number(_misfit(given[heavy]))} m off the lines between the joints"
        text = f"the centres of mass are {off}, {number(_misfit(readings[best[0]][1][heavy]))} m if {ifs}"
        yield f"arm {arm.name}", f"{text}; check the frame and the signs in which they are given"
        return
    for k in np.flatnonzero(heavy) if arm.n_joints >= 5 else ():
        misfits = [
            _misfit(np.where(np.arange(len(given)) == k, read, given)[heavy], near) for _, read in readings
        ]
        if best := _best(misfits, _misfit(given[heavy], near), _ONE):
            place, link = links[k]
            ifs = " or ".join(f"it is {readings[j][0].name}" for j in best)
            off = f"{number(given[k])} m off the line between its joints"
            text = f"the centre of mass of link {link.name} is {off}, {number(readings[best[0]][1][k])} m if {ifs}"
            yield place, f"{text}; check its frame and its signs"


def inertials_of_other_links(arm: RobotArm) -> Findings:
    """Centres of mass that lie near the lines of the next links, or of those before."""
    links, lines = [link for _, link in described_links(arm)], _lines(arm)
    if arm.n_joints < 5 or any(link.mass < NO_MASS for link in links) or arm.reach <= 0.0:
        return
    coms, near = [link.com for link in links], _NEAR * arm.reach
    given = _distances(coms[:-1], lines)
    neighbours = {
        "after": (_distances(coms[:-2], lines[1:]), given[1:]),
        "before": (_distances(coms[1:], lines), given),
    }
    share, neighbour = min(
        (_misfit(read, near) / _misfit(of, near), name) for name, (read, of) in neighbours.items()
    )
    if share < _SHIFTED:
        read, of = map(_misfit, neighbours[neighbour])
        off = f"{number(of)} m off the lines between the joints, {number(read)} m"
        text = f"the centres of mass are {off} if each belongs to the link {neighbour} its own"
        yield f"arm {arm.name}", f"{text}; is every inertial shifted by one link?"


def inertias_about_the_joints(arm: RobotArm) -> Findings:
    """Inertias about the links' frames, given as about the centres of mass.

    About its frame a link has at least the second moment of its mass at its centre, m c c^T; a rod has 4/3 of it
    and a thick link up to 2.5. About its centre a rod has a third.
    """
    ratios, rests = [], []
    for _, link in described_links(arm):
        distance = float(np.linalg.norm(link.com))
        if link.mass >= NO_MASS and distance > _APART * arm.reach:
            along, of_point = link.com / distance, link.mass * distance**2
            moment = second_moment(link.inertia_com)
            rest = np.linalg.eigvalsh(moment - of_point * np.outer(along, along))[0]
            ratios.append(float(along @ moment @ along) / of_point)
            rests.append(float(rest) / of_point)
    if len(rests) >= 2 and min(rests) > -1e-3 and max(ratios) < 2.5:  # with inertias of three digits
        text = f"the inertias of all {len(rests)} links with a centre of mass off their frame"
        yield f"arm {arm.name}", f"{text} are as large as about the frame; are they about the centre of mass?"


def inertias_too_small(arm: RobotArm) -> Findings:
    """Half of the links denser than 2e5 kg/m^3, as balls; in makers' files 2e1 to 2e3, in g m^2 500 000 and more."""
    densities = [ball_density(link) for _, link in described_links(arm) if weighs(link) and not link.is_point]
    if len(densities) >= 3 and 2e5 < (middle := float(np.median(densities))) < 1e8:
        text = f"with these inertias half of the links are denser than {middle:.0e} kg/m^3 (steel: 7900)"
        yield f"arm {arm.name}", f"{text}; are they in kg m^2, and the masses in kg?"


def lighter_than_its_neighbours(arm: RobotArm) -> Findings:
    """Inertials of two links swapped near the end: the third link from the end is the lightest by far."""
    masses = [link.mass for _, link in described_links(arm)]
    if arm.n_joints < 5 or masses[-3] < NO_MASS:
        return
    around = (masses[-4], masses[-2], masses[-1])
    if masses[-3] < 0.3 * min(around):
        place, link = described_links(arm)[-3]
        text = f"link {link.name} has {number(link.mass)} kg, less than a third of each of its neighbours and the last"
        yield place, f"{text} link ({', '.join(map(number, around))} kg); are two links swapped?"


def _lines(arm: RobotArm) -> list[tuple[FloatArray, FloatArray]]:
    """Ends of the links' lines in their frames; where the last link ends is unknown."""
    near = [-link.frame.translation @ link.frame.rotation for link in arm.links[:-1]]
    return list(zip(near, [joint.placement.translation for joint in arm.joints[1:]], strict=True))


def _distances(places: Sequence[FloatArray], lines: Sequence[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """Distance of each place from its line, m."""
    distances = []
    for place, (near, far) in zip(places, lines, strict=True):
        along, length = far - near, float((far - near) @ (far - near))
        share = min(1.0, max(0.0, float((place - near) @ along) / length)) if length > 0.0 else 0.0
        distances.append(float(np.linalg.norm(place - near - share * along)))
    return np.array(distances)


def _misfit(distances: FloatArray, near: float = 0.0) -> float:
    """Root mean square of distances, each at least about `near`."""
    return math.sqrt(float((distances**2).mean()) + near**2)


def _best(misfits: Sequence[float], given: float, nearer: float) -> list[int]:
    """The best readings, if they are nearer by this factor than what is given."""
    least = min(misfits)
    return [k for k, misfit in enumerate(misfits) if misfit <= 1.2 * least] if least < nearer * given else []


def _readings(arm: RobotArm) -> list[_Reading]:
    """Other meanings of the centres of mass, all but the last, with the joints at 0."""
    coms = [link.com for _, link in described_links(arm)][:-1]
    parts = zip(arm.joints, arm.links, strict=True)
    steps = [_matrix(joint.placement) @ _matrix(link.frame) for joint, link in parts]
    back = [np.linalg.inv(pose) for pose in accumulate(steps, np.matmul)]
    frames = {
        "in the base's frame": back[:-1],
        "in the next link's frame": steps[1:],
        "in the frame of the link before": [np.linalg.inv(step) for step in steps[:-1]],
    }
    readings = [_Reading("of the opposite sign", [-com for com in coms])]
    for name, poses in frames.items():
        moved = [pose[:3, :3] @ com + pose[:3, 3] for pose, com in zip(poses, coms, strict=True)]
        readings.append(_Reading(name, moved))
    return readings


def _matrix(placement: Placement) -> FloatArray:
    """A placement as a homogeneous matrix."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = placement.rotation, placement.translation
    return matrix
