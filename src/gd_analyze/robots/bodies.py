"""Plausibility checks of links as bodies between their joints: masses, centres of mass, inertias.

A link's *line* is the segment between its joints. Real centres of mass lie near it. Where another reading of
the file's numbers brings them much nearer, it is probably what was meant. Limits come from 200 chains of
makers' files: arms, legs and hands.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, Placement, second_moment
from gd_analyze.text import number

# Findings of a check: place and sentence.
PlacedFindings = Iterator[tuple[str, str]]

# Mass below which a link counts as massless, kg.
NO_MASS = 1e-6
# Most joints of an arm whose terms are ranked and chosen: identifying its exact form takes a second.
MOST_JOINTS_WITH_TERMS = 8


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


# Another reading is suspected if it brings centres of mass nearer to their lines by these factors: all of an
# arm's (makers' files have 0.94 at least), all of a chain of fewer than five joints (0.76), one of an arm's
# (0.64).
_FACTOR_OF_ALL = 0.75
_FACTOR_OF_FEW = 0.5
_FACTOR_OF_ONE = 0.5


def centres_fit_another_reading(arm: RobotArm) -> PlacedFindings:
    """Centres of mass that lie near the lines with another sign or in another frame: all of them, or one."""
    links, lines = described_links(arm)[:-1], _lines(arm)
    heavy = np.array([link.mass >= NO_MASS for _, link in links])
    if heavy.sum() < 2 or arm.reach <= 0.0:
        return
    distances = _distances([link.com for _, link in links], lines)
    readings = {name: _distances(places, lines) for name, places in _readings(arm).items()}
    factor = _FACTOR_OF_ALL if arm.n_joints >= 5 else _FACTOR_OF_FEW
    if names := _nearest(readings, heavy, arm, factor * _misfit(distances[heavy], arm)):
        distance, new_distance = (number(_rms(x[heavy])) for x in (distances, readings[names[0]]))
        text = f"the centres of mass are {distance} m off the lines between the joints"
        reading = f"{new_distance} m if they are {' or '.join(names)}"
        yield f"arm {arm.name}", f"{text}, {reading}; check the frame and the signs of all"
        return
    for k in np.flatnonzero(heavy) if arm.n_joints >= 5 else ():
        of_one_link = {
            name: np.where(np.arange(len(distances)) == k, read, distances) for name, read in readings.items()
        }
        below = _FACTOR_OF_ONE * _misfit(distances[heavy], arm)
        if names := _nearest(of_one_link, heavy, arm, below):
            place, link = links[k]
            distance, new_distance = number(distances[k]), number(readings[names[0]][k])
            text = f"the centre of mass of link {link.name} is {distance} m off the line between its joints"
            reading = f"{new_distance} m if it is {' or '.join(names)}"
            yield place, f"{text}, {reading}; check its frame and its signs"


# Inertials are suspected to be shifted by a link if this brings centres of mass nearer to their lines by this
# factor: makers' files have 0.65 at least.
_FACTOR_OF_SHIFTED = 0.5


def inertials_of_other_links(arm: RobotArm) -> PlacedFindings:
    """Centres of mass that lie near the lines of the next links, or of those before."""
    links, lines = [link for _, link in described_links(arm)], _lines(arm)
    if arm.n_joints < 5 or any(link.mass < NO_MASS for link in links) or arm.reach <= 0.0:
        return
    coms = [link.com for link in links]
    distances = _distances(coms[:-1], lines)
    neighbours = {
        "after": (_distances(coms[:-2], lines[1:]), distances[1:]),
        "before": (_distances(coms[1:], lines), distances),
    }
    shares = {name: _misfit(read, arm) / _misfit(stated, arm) for name, (read, stated) in neighbours.items()}
    neighbour = min(shares, key=lambda name: shares[name])
    if shares[neighbour] < _FACTOR_OF_SHIFTED:
        new_distance, distance = (number(_rms(values)) for values in neighbours[neighbour])
        text = f"the centres of mass are {distance} m off the lines between the joints"
        reading = f"{new_distance} m if each belongs to the link {neighbour} its own"
        yield f"arm {arm.name}", f"{text}, {reading}; is every inertial shifted by one link?"


# A centre of mass and its link's frame are apart from this distance on, in reaches.
_APART_REACHES = 0.08
# About its frame, a link's second moment along the centre of mass is at most this factor times m c^2,
_LARGEST_MOMENT_RATIO = 2.5
# and what m c c^T leaves over is not negative, but for this share: inertias have three digits.
_MOMENT_TOLERANCE = 1e-3


def inertias_about_the_joints(arm: RobotArm) -> PlacedFindings:
    """Inertias about the links' frames, given as about the centres of mass.

    About its frame a link has at least the second moment of its mass at its centre, m c c^T: a rod 4/3 of
    it, a thick link up to 2.5. About its centre a rod has a third.
    """
    ratios, smallest_shares = [], []
    for _, link in described_links(arm):
        distance = float(np.linalg.norm(link.com))
        if link.mass >= NO_MASS and distance > _APART_REACHES * arm.reach:
            along, of_point = link.com / distance, link.mass * distance**2
            moment = second_moment(link.inertia_com)
            smallest = np.linalg.eigvalsh(moment - of_point * np.outer(along, along))[0]
            ratios.append(float(along @ moment @ along) / of_point)
            smallest_shares.append(float(smallest) / of_point)
    if len(ratios) < 2:
        return
    if min(smallest_shares) > -_MOMENT_TOLERANCE and max(ratios) < _LARGEST_MOMENT_RATIO:
        text = f"the inertias of all {len(ratios)} links with a centre of mass off their frame"
        yield f"arm {arm.name}", f"{text} are as large as about the frame; are they about the centre of mass?"


# Density of the median link, kg/m^3, from which on inertias are too small. Makers' files have 20 to 2000, and
# 3e4 times more in g m^2; beyond the largest another check tells of masses in grams.
_LEAST_SUSPECT_DENSITY = 2e5
_LARGEST_SUSPECT_DENSITY = 1e8


def inertias_too_small(arm: RobotArm) -> PlacedFindings:
    """Inertias in g m^2: half of the links are far denser than in makers' files."""
    densities = [ball_density(link) for _, link in described_links(arm) if weighs(link) and not link.is_point]
    if len(densities) < 3:
        return
    median = float(np.median(densities))
    if _LEAST_SUSPECT_DENSITY < median < _LARGEST_SUSPECT_DENSITY:
        text = f"with these inertias half of the links are denser than {median:.0e} kg/m^3 (steel: 7900)"
        yield f"arm {arm.name}", f"{text}; are they in kg m^2, and the masses in kg?"


# Share of its neighbours' masses below which a link near the end may have been swapped.
_SWAPPED_MASS_SHARE = 0.3


def lighter_than_its_neighbours(arm: RobotArm) -> PlacedFindings:
    """Inertials of two links swapped near the end: the third link from the end is the lightest by far."""
    masses = [link.mass for _, link in described_links(arm)]
    if arm.n_joints < 5 or masses[-3] < NO_MASS:
        return
    around = (masses[-4], masses[-2], masses[-1])
    if masses[-3] < _SWAPPED_MASS_SHARE * min(around):
        place, link = described_links(arm)[-3]
        text = f"link {link.name} has {number(link.mass)} kg, less than a third of the links around it"
        yield place, f"{text} ({', '.join(map(number, around))} kg); are two links swapped?"


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


def _rms(distances: FloatArray) -> float:
    return math.sqrt(float((distances**2).mean()))


# Distance from its line, in reaches, that says nothing.
_NEAR_REACHES = 0.01


def _misfit(distances: FloatArray, arm: RobotArm) -> float:
    """Root mean square of distances in reaches, each at least about the distance that says nothing."""
    return math.hypot(_rms(distances) / arm.reach, _NEAR_REACHES)


# Readings within this factor of the least misfit are told together.
_AS_GOOD_FACTOR = 1.2


def _nearest(readings: Mapping[str, FloatArray], heavy: FloatArray, arm: RobotArm, below: float) -> list[str]:
    """Names of the readings with about the least misfit, if it is below a bound."""
    misfits = {name: _misfit(read[heavy], arm) for name, read in readings.items()}
    least = min(misfits.values())
    if least >= below:
        return []
    return [name for name, misfit in misfits.items() if misfit <= _AS_GOOD_FACTOR * least]


def _readings(arm: RobotArm) -> dict[str, list[FloatArray]]:
    """Places of the centres of mass, all but the last, in their links' frames if they mean something else."""
    coms = [link.com for _, link in described_links(arm)][:-1]
    parts = zip(arm.joints, arm.links, strict=True)
    steps = [_matrix(joint.placement) @ _matrix(link.frame) for joint, link in parts]
    poses = {
        "in the base's frame": [np.linalg.inv(pose) for pose in accumulate(steps, np.matmul)][:-1],
        "in the next link's frame": steps[1:],
        "in the frame of the link before": [np.linalg.inv(step) for step in steps[:-1]],
    }
    return {"of the opposite sign": [-com for com in coms]} | {
        name: [pose[:3, :3] @ com + pose[:3, 3] for pose, com in zip(frames, coms, strict=True)]
        for name, frames in poses.items()
    }


def _matrix(placement: Placement) -> FloatArray:
    """A placement as a homogeneous matrix."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = placement.rotation, placement.translation
    return matrix
