"""A robot as a tree of joints: Pinocchio's model, and what only the file it was read from knows."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location
from gd_analyze.robots.right_angles import Straightened
from gd_analyze.text import shortened, visible

# Joints of arms do 40 rad/s and end within some turns, or 100 m on a gantry.
_NO_RATE, _NO_RANGE = 100.0, 1000.0
# Pinocchio's kinds of joints that are none of ours, by what their names begin with.
_KINDS = {
    "JointModelFreeFlyer": "floating",
    "JointModelPlanar": "planar",
    "JointModelSpherical": "spherical",
    "JointModelMimic": "mimic",
    "JointModelComposite": "composite",
    "JointModelTranslation": "translating",
    "JointModelUniversal": "universal",
}


@dataclass(frozen=True)
class TreeJoint:
    """One joint of a tree.

    Parameters
    ----------
    index
        In Pinocchio's model, from 1; 0 is the ground.
    name, link
        The joint's and that of the link which moves with it.
    parent
        Index of the joint before it.
    kind
        "revolute", "prismatic", or what it is instead.
    axis
        Unit vector in the joint's frame; zero where the kind has none.
    follows
        Whether it mimics another joint.
    """

    index: int
    name: str
    link: str
    parent: int
    kind: str
    axis: FloatArray
    follows: bool = False

    @property
    def moves_simply(self) -> bool:
        """Whether it turns or slides, and nothing else."""
        return self.kind in ("revolute", "prismatic")

    @property
    def unit(self) -> str:
        """Of its value."""
        return "rad" if self.kind == "revolute" else "m"


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: multiplier times its value plus offset."""

    master: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Loop:
    """Two links held together beside the tree, and where that is said."""

    links: tuple[str, str]
    where: Location | None


@dataclass(frozen=True)
class Limits:
    """What a file states of a joint's motion; None where it states nothing."""

    lower: float | None = None
    upper: float | None = None
    rate: float | None = None
    # What is found instead of the range that a joint of its kind has.
    unranged: str = ""

    def without_placeholders(self) -> Limits:
        """Leave out rates of 100, 1000 and so on and ranges to 1000 and so on: makers write them for none."""
        ends = [abs(end) for end in (self.lower, self.upper) if end is not None]
        has_ends = not any(_is_power_of_ten(end) and end >= _NO_RANGE for end in ends)
        has_rate = self.rate is not None and not (self.rate >= _NO_RATE and _is_power_of_ten(self.rate))
        return Limits(
            self.lower if has_ends else None,
            self.upper if has_ends else None,
            self.rate if has_rate else None,
            self.unranged,
        )


def _is_power_of_ten(number: float) -> bool:
    return number > 0 and math.log10(number).is_integer()


@dataclass(frozen=True)
class Tree:
    """A robot that has been read.

    Parameters
    ----------
    model
        Pinocchio's, with every joint free.
    name, title, convention
        As `RobotArm` has them.
    where
        The file, for messages.
    joints
        In Pinocchio's order: parents come first.
    links
        Names of all links, and the joint that each moves with.
    lines
        Where the file describes a ("joint" or "link", name).
    mimics, loops, limits
        By joint's name where it is about a joint.
    gravity
        In the base frame, m/s^2.
    sources, assumptions
        Sentences for the arm.
    doubts
        Sentences, and the joint or link each is about: told where the arm has it.
    straightened
        Which numbers were made right, by link.
    above
        The link that each link hangs on.
    """

    model: Any
    name: str
    title: str
    convention: str
    where: Location | str
    joints: tuple[TreeJoint, ...]
    links: Mapping[str, int]
    gravity: FloatArray
    lines: Mapping[tuple[str, str], Location] = field(default_factory=dict)
    mimics: Mapping[str, Mimic] = field(default_factory=dict)
    loops: tuple[Loop, ...] = ()
    limits: Mapping[str, Limits] = field(default_factory=dict)
    sources: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    doubts: tuple[tuple[str, str], ...] = ()
    straightened: Straightened = field(default_factory=Straightened)
    above: Mapping[str, str] = field(default_factory=dict)

    def joint(self, index: int) -> TreeJoint:
        """Joint by Pinocchio's index, from 1."""
        return self.joints[index - 1]

    def path(self, index: int) -> list[TreeJoint]:
        """Joints from the ground to one, itself included."""
        found: list[TreeJoint] = []
        while index:
            found.append(self.joint(index))
            index = found[-1].parent
        return found[::-1]

    def carried(self, moving: Sequence[TreeJoint]) -> set[str]:
        """Links that a chain of joints moves."""
        moved = self.beyond({joint.index for joint in moving})
        return {link for link, index in self.links.items() if index in moved}

    def inboard(self, joint: TreeJoint) -> set[str]:
        """Links that a joint's link hangs on."""
        found: set[str] = set()
        link = self.above.get(joint.link)
        while link is not None and link not in found:
            found.add(link)
            link = self.above.get(link)
        return found

    def line(self, what: str, name: str) -> Location | str:
        """Where a joint or link is described, for messages."""
        return self.lines.get((what, name), f"{self.where}, {what} {name}")

    def mass(self, index: int) -> float:
        """Mass that moves with one joint itself, kg."""
        return float(self.model.inertias[index].mass)

    def carries_mass(self, index: int) -> bool:
        """Whether a joint moves anything that has mass."""
        return any(self.mass(one) > 0 for one in self.beyond({index}))

    def beyond(self, indices: set[int]) -> set[int]:
        """Joints that are among some or follow one of them."""
        found = set(indices)
        for joint in self.joints:  # parents come first
            if joint.parent in found:
                found.add(joint.index)
        return found


def joints_of(model: Any, mimics: Collection[str] = ()) -> tuple[tuple[TreeJoint, ...], dict[str, int]]:
    """Joints of a Pinocchio model, and its links by name with the joint that each moves with."""
    import pinocchio as pin

    links: dict[str, int] = {}
    first: dict[int, str] = {}
    for frame in model.frames:
        if frame.type == pin.FrameType.BODY:
            links.setdefault(frame.name, int(frame.parentJoint))
            first.setdefault(int(frame.parentJoint), frame.name)
    neutral = pin.neutral(model)
    joints = []
    for index in range(1, model.njoints):
        kind, axis = _motion(model.joints[index], neutral)
        name = model.names[index]
        joints.append(
            TreeJoint(
                index, name, first.get(index, name), int(model.parents[index]), kind, axis, name in mimics
            )
        )
    return tuple(joints), links


def _motion(joint: Any, neutral: FloatArray) -> tuple[str, FloatArray]:
    """Kind of a joint, and its axis from the subspace of its motions."""
    if joint.nv != 1:
        named = joint.shortname()
        kind = next((kind for start, kind in _KINDS.items() if named.startswith(start)), "other")
        return kind, np.zeros(3)
    data = joint.createData()
    joint.calc(data, neutral)
    slides, turns = np.split(np.array(data.S, dtype=float).ravel(), 2)
    if slides.any() and turns.any():
        return "helical", np.zeros(3)
    return ("prismatic", slides) if slides.any() else ("revolute", turns)


def limits_of(model: Any, index: int) -> Limits:
    """What a model states of the limits of a joint of one degree of freedom."""
    at_q, at_v = model.idx_qs[index], model.idx_vs[index]
    rate = float(model.velocityLimit[at_v])
    lower, upper = float(model.lowerPositionLimit[at_q]), float(model.upperPositionLimit[at_q])
    has_range = model.nqs[index] == 1 and np.isfinite((lower, upper)).all() and (lower, upper) != (0.0, 0.0)
    return Limits(
        lower if has_range else None,
        upper if has_range else None,
        rate if 0 < rate < np.inf else None,
    )


def title_of(name: str) -> str:
    """Make a name for people out of a robot's."""
    return shortened(visible(name), 120)


def identifier(name: str, stem: str) -> str:
    """Make a name for folders out of a robot's.

    Examples
    --------
    >>> identifier("my robot (v2)", "file")
    'my_robot_v2'
    """
    for given in (name, stem):
        found = re.sub(r"[^A-Za-z0-9_.-]+", "_", given).strip("_.-")
        if found:
            return found[:100]
    return "robot"
