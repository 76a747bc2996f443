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
# Factors by which centres of mass must be nearer in another reading.
_ALL = 0.75  # all of an arm's; makers' files have 0.94 at least
_OF_FEW = 0.5  # all of a chain of fewer than five joints; makers' files have 0.76 at least
_ONE = 0.5  # one of an arm's; makers' files have 0.64 at least
_SHIFTED = 0.5  # those of shifted inertials; makers' files have 0.65 at least
# Distance from its line, in reaches, that says nothing.
_NEAR = 0.01
# Distance of a centre of mass from its link's frame, in reaches, from which on they count as apart.
_APART = 0.08


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


def centres_fit_another_reading(arm: RobotArm) -> PlacedFindings:
    """Centres of mass that lie near the lines with another sign or in another frame: all of them, or one."""
    links, lines = described_links(arm)[:-1], _lines(arm)
    heavy = np.array([link.mass >= NO_MASS for _, link in links])
    if heavy.sum() < 2 or arm.reach <= 0.0:
        return
    distances = _distances([link.com for _, link in links], lines)
    readings = {name: _distances(places, lines) for name, places in _readings(arm).items()}
    factor = _ALL if arm.n_joints >= 5 else _OF_FEW
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
        if names := _nearest(of_one_link, heavy, arm, _ONE * _misfit(distances[heavy], arm)):
            place, link = links[k]
            distance, new_distance = number(distances[k]), number(readings[names[0]][k])
            text = f"the centre of mass of link {link.name} is {distance} m off the line between its joints"
            yield (
                place,
                f"{text}, {new_distance} m if it is {' or '.join(names)}; check its frame and its signs",
            )


def inertials_of_other_links(arm: RobotArm) -> PlacedFindings:
    """Centres of mass that lie near the lines of the next links, or of those before."""
    links, lines = [link for _, link in described_links(arm)], _lines(arm)
    if arm.n_joints < 5 or any(link.mass < NO_MASS for link in links) or arm.reach <= 0.0:
        return
    coms = [link.com for link in links]
    own_distances = _distances(coms[:-1], lines)
    neighbours = {
        "after": (_distances(coms[:-2], lines[1:]), own_distances[1:]),
        "before": (_distances(coms[1:], lines), own_distances),
    }
    shares = {name: _misfit(read, arm) / _misfit(stated, arm) for name, (read, stated) in neighbours.items()}
    neighbour = min(shares, key=lambda name: shares[name])
    if shares[neighbour] < _SHIFTED:
        new_distance, distance = (number(_rms(distances)) for distances in neighbours[neighbour])
        text = f"the centres of mass are {distance} m off the lines between the joints"
        reading = f"{new_distance} m if each belongs to the link {neighbour} its own"
        yield f"arm {arm.name}", f"{text}, {reading}; is every inertial shifted by one link?"


def inertias_about_the_joints(arm: RobotArm) -> PlacedFindings:
    """Inertias about the links' frames, given as about the centres of mass.

    About its frame a link has at least the second moment of its mass at its centre, m c c^T: a rod 4/3 of
    it, a thick link up to 2.5. About its centre a rod has a third.
    """
    ratios, smallest_shares = [], []
    for _, link in described_links(arm):
        distance = float(np.linalg.norm(link.com))
        if link.mass >= NO_MASS and distance > _APART * arm.reach:
            along, of_point = link.com / distance, link.mass * distance**2
            moment = second_moment(link.inertia_com)
            smallest = np.linalg.eigvalsh(moment - of_point * np.outer(along, along))[0]
            ratios.append(float(along @ moment @ along) / of_point)
            smallest_shares.append(float(smallest) / of_point)
    if (
        len(smallest_shares) >= 2 and min(smallest_shares) > -1e-3 and max(ratios) < 2.5
    ):  # with inertias of three digits
        text = f"the inertias of all {len(smallest_shares)} links with a centre of mass off their frame"
        yield f"arm {arm.name}", f"{text} are as large as about the frame; are they about the centre of mass?"


def inertias_too_small(arm: RobotArm) -> PlacedFindings:
    """Half of the links denser than 2e5 kg/m^3; makers' files have 20 to 2000, 3e4 times more in g m^2."""
    densities = [ball_density(link) for _, link in described_links(arm) if weighs(link) and not link.is_point]
    if len(densities) < 3:
        return
    median = float(np.median(densities))
    if 2e5 < median < 1e8:
        text = f"with these inertias half of the links are denser than {median:.0e} kg/m^3 (steel: 7900)"
        yield f"arm {arm.name}", f"{text}; are they in kg m^2, and the masses in kg?"


def lighter_than_its_neighbours(arm: RobotArm) -> PlacedFindings:
    """Inertials of two links swapped near the end: the third link from the end is the lightest by far."""
    masses = [link.mass for _, link in described_links(arm)]
    if arm.n_joints < 5 or masses[-3] < NO_MASS:
        return
    around = (masses[-4], masses[-2], masses[-1])
    if masses[-3] < 0.3 * min(around):
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


def _misfit(distances: FloatArray, arm: RobotArm) -> float:
    """Root mean square of distances in reaches, each at least about `_NEAR`."""
    return math.hypot(_rms(distances) / arm.reach, _NEAR)


def _nearest(readings: Mapping[str, FloatArray], heavy: FloatArray, arm: RobotArm, below: float) -> list[str]:
    """Names of the readings with about the least misfit, if it is below a bound."""
    misfits = {name: _misfit(read[heavy], arm) for name, read in readings.items()}
    least = min(misfits.values())
    return [name for name, misfit in misfits.items() if misfit <= 1.2 * least] if least < below else []


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
