"""Masses that sit where no arm has them: in a point, outside of their link, or heavier than what holds them.

The limits are beyond all of some hundred chains from makers' files.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.robots.parts import Link
from gd_analyze.text import number

if TYPE_CHECKING:
    from gd_analyze.robots.arm import RobotArm

# A mass below stands for none, kg.
STANDS_FOR_NONE = 1e-6
# Beyond both joints of a link its centre of mass is by less than half of the arm's reach; of arms that reach
# nowhere, such as fingers, this says nothing, m.
_OUTSIDE, _LEAST_OUTSIDE = 0.6, 0.1
# The last two links of arms of five joints and more have up to 0.31 of the mass before them, a leg's third
# from its end 0.73. A finger's first links are as light as its last.
_LAST, _HEAVIEST_LAST, _HEAVIEST, _LEAST_JOINTS = 2, 0.5, 1.0, 5


def mass_slips(arm: RobotArm) -> Iterator[str]:
    """Say which links of an arm have their mass where no arm has it, a sentence for each."""
    # What is carried was not stated of the link.
    links = [link.bare or link for link in arm.links]
    # An arm of nothing but point masses is drawn on paper.
    if any(not link.is_point for link in links):
        for link in links:
            if link.is_point and link.mass >= STANDS_FOR_NONE and not link.axial_only:
                yield (
                    f"{link.place}: link {link.name} has a mass of {number(link.mass)} kg and no inertia, as "
                    "if it were a point; other links have one"
                )
    yield from _outside(arm, links)
    if arm.n_joints >= _LEAST_JOINTS:
        yield from _heavy(links)


def _outside(arm: RobotArm, links: list[Link]) -> Iterator[str]:
    """Of the last link it is not known how far it reaches."""
    farthest = max(_OUTSIDE * arm.reach, _LEAST_OUTSIDE)
    for link, beyond in zip(links, arm.joints[1:], strict=False):
        behind, turn = link.frame.translation, link.frame.rotation
        centre = turn @ link.com + behind
        ends = (np.zeros(3), turn @ beyond.placement.translation + behind)
        off = min(float(np.linalg.norm(centre - end)) for end in ends)
        # Beyond the whole arm's reach its units are told.
        if link.mass > 0 and farthest < off and float(np.linalg.norm(link.com)) <= arm.reach:
            yield (
                f"{link.place}: the centre of mass of link {link.name} is {number(off)} m from both joints "
                f"of the link, of an arm that reaches {number(arm.reach)} m; is it given in another frame?"
            )


def _heavy(links: list[Link]) -> Iterator[str]:
    before = 0.0
    for index, link in enumerate(links):
        is_last = index >= len(links) - _LAST
        most = _HEAVIEST_LAST if is_last else _HEAVIEST
        if 2 * index >= len(links) and link.mass > max(most * before, STANDS_FOR_NONE):
            than = "more than half of" if is_last else "more than"
            yield (
                f"{link.place}: link {link.name} has a mass of {number(link.mass)} kg, {than} all links "
                f"before it together ({number(before)} kg): real arms get lighter towards the hand"
            )
        before += link.mass
