"""A robot as a tree of joints: Pinocchio's model with every joint free, and what only its file states."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.frames import RightAngles
from gd_analyze.robots.xml import Node
from gd_analyze.text import visible

MOST_NAMED = 10
# Pinocchio's kinds of joints that no arm has, by what their names begin with.
_KINDS = {
    "JointModelFreeFlyer": "floating",
    "JointModelPlanar": "planar",
    "JointModelSpherical": "spherical",
    "JointModelMimic": "mimic",
    "JointModelComposite": "composite",
    "JointModelTranslation": "translating",
    "JointModelUniversal": "universal",
}


def named(names: Iterable[str]) -> str:
    """Names; of many only the first."""
    listed = list(names)
    rest = len(listed) - MOST_NAMED
    return ", ".join(listed[:MOST_NAMED]) + (f" and {rest} more" if rest > 0 else "")


@dataclass(frozen=True)
class TreeJoint:
    """One joint of a tree; indices are Pinocchio's, from 1, and 0 is the ground."""

    index: int
    name: str
    link: str  # that moves with the joint
    parent: int
    kind: str
    axis: FloatArray  # unit vector in the joint's frame, zero where the kind has none

    @property
    def moves_simply(self) -> bool:
        """Whether it is revolute or prismatic."""
        return self.kind in ("revolute", "prismatic")


class Mimic(NamedTuple):
    """A joint that follows another: multiplier times its value plus offset."""

    master: str
    multiplier: float
    offset: float


@dataclass
class Notes:
    """What a file states besides Pinocchio's model."""

    path: str | Path
    lines: dict[tuple[str, str], Location] = field(default_factory=dict)  # of a ("joint" or "link", name)
    above: dict[str, str] = field(default_factory=dict)  # the link that each link hangs on
    mimics: dict[str, Mimic] = field(default_factory=dict)  # by the joint that follows
    loops: list[tuple[str, str, Location]] = field(default_factory=list)  # two links held together
    assumptions: list[str] = field(default_factory=list)
    doubts: list[tuple[str, str]] = field(default_factory=list)  # joint or link ("" for all), sentence
    right_angles: RightAngles = field(default_factory=RightAngles)

    def name(self, what: str, node: Node, otherwise: str = "") -> str:
        """Name of a joint or link, whose line is noted; ArmError unless it is printable and its own."""
        name = node.attributes.get("name", "") or otherwise
        while otherwise and "name" not in node.attributes and (what, name) in self.lines:
            name += "_"
        if not name.strip() or visible(name) != name:
            problem = f"a {node.tag} has no printable name"
            raise ArmError(problem, where=node.where, found=repr(name), next_step="name it")
        if (what, name) in self.lines:
            problem = f"two of <{node.tag}> have the name {name!r}"
            found = f"the other in line {self.lines[what, name].line}"
            raise ArmError(problem, where=node.where, found=found, next_step="rename one")
        self.lines[what, name] = node.where
        return name


@dataclass(frozen=True)
class Tree:
    """A robot that has been read."""

    model: Any  # pinocchio.Model
    notes: Notes
    name: str
    format: str  # URDF, MJCF, or "" of a model in memory
    gravity: FloatArray  # (3,), m/s^2

    @property
    def where(self) -> str:
        """The file, for messages."""
        return visible(str(self.notes.path))

    @cached_property
    def links(self) -> dict[str, int]:
        """All links, and the joint that each moves with."""
        links: dict[str, int] = {}
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY:
                links.setdefault(frame.name, int(frame.parentJoint))
        return links

    @cached_property
    def joints(self) -> tuple[TreeJoint, ...]:
        """Joints in Pinocchio's order: parents come first."""
        model, neutral, joints = self.model, pin.neutral(self.model), []
        first = {index: link for link, index in reversed(self.links.items())}
        for index in range(1, model.njoints):
            name, parent = model.names[index], int(model.parents[index])
            motion = _motion(model.joints[index], neutral)
            joints.append(TreeJoint(index, name, first.get(index, name), parent, *motion))
        return tuple(joints)

    def path(self, index: int) -> list[TreeJoint]:
        """Joints from the ground to one, itself included."""
        found: list[TreeJoint] = []
        while index:
            found.append(self.joints[index - 1])
            index = found[-1].parent
        return found[::-1]

    def beyond(self, indices: Iterable[int]) -> set[int]:
        """Joints that are among some or follow one of them."""
        found = set(indices)
        for joint in self.joints:
            if joint.parent in found:
                found.add(joint.index)
        return found

    def carries_mass(self, index: int) -> bool:
        """Whether a joint moves anything that has mass."""
        return any(self.model.inertias[one].mass > 0 for one in self.beyond({index}))

    def line(self, what: str, name: str) -> Location | None:
        """Where a joint or link is described; None in a model from memory."""
        return self.notes.lines.get((what, name))

    def configuration(self, held: Mapping[int, float]) -> FloatArray:
        """Pinocchio's configuration with the given joints at their values and all others at rest."""
        q: FloatArray = pin.neutral(self.model)
        for index, value in held.items():
            start, count = self.model.idx_qs[index], self.model.nqs[index]
            if count == 1:
                q[start] = value
            elif self.joints[index - 1].kind == "revolute":  # one without ends, as cosine and sine
                q[start : start + 2] = math.cos(value), math.sin(value)
        return q


def _motion(joint: Any, neutral: FloatArray) -> tuple[str, FloatArray]:
    """Kind of a joint, and its axis from the subspace of its motions."""
    if joint.nv != 1:
        name = joint.shortname()
        return next((kind for start, kind in _KINDS.items() if name.startswith(start)), "other"), np.zeros(3)
    data = joint.createData()
    joint.calc(data, neutral)
    translation, rotation = np.split(np.array(data.S, dtype=float).ravel(), 2)
    if translation.any() and rotation.any():
        return "helical", np.zeros(3)
    return ("prismatic", translation) if translation.any() else ("revolute", rotation)
