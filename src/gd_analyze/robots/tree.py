"""A robot as a tree of joints, from Pinocchio's model and its file, and the serial chain that is the arm."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, BranchError, Location, argument
from gd_analyze.robots.frames import RightAngles
from gd_analyze.robots.text_file import Node
from gd_analyze.text import visible
from gd_analyze.units import Quantity, joint_units

# Names listed in a message, at most.
_MOST_NAMED = 10
# With more joints to hold, `tip` is shorter.
_MOST_LOCKED = 6
# Pinocchio's kinds of joints that arms do not have, by the prefix of their names.
_KINDS = {
    "JointModelFreeFlyer": "floating",
    "JointModelPlanar": "planar",
    "JointModelSpherical": "spherical",
    "JointModelMimic": "mimic",
    "JointModelComposite": "composite",
    "JointModelTranslation": "translating",
    "JointModelUniversal": "universal",
}


def some_names(names: Iterable[str]) -> str:
    """Names as a list; of many only the first."""
    listed = list(names)
    n_more = len(listed) - _MOST_NAMED
    return ", ".join(listed[:_MOST_NAMED]) + (f" and {n_more} more" if n_more > 0 else "")


@dataclass(frozen=True)
class TreeJoint:
    """One joint of a tree; indices are Pinocchio's, from 1, and 0 is the ground."""

    index: int
    name: str
    link: str  # moves with the joint
    parent: int
    kind: str
    axis: FloatArray  # unit vector in the joint's frame, zero if the kind has none

    @property
    def moves_simply(self) -> bool:
        """Whether it is revolute or prismatic."""
        return self.kind in ("revolute", "prismatic")


class Mimic(NamedTuple):
    """A joint that follows another one's value by a polynomial; a constant if there is no other."""

    master: str
    polynomial: Polynomial

    @property
    def text(self) -> str:
        """The polynomial in words."""
        offset, *factors = self.polynomial.coef
        if len(factors) == 1:
            return f"{factors[0]:g} times {self.master} plus {offset:g}"
        return f"a polynomial of {self.master}" if factors else f"{offset:g}"


class Tie(NamedTuple):
    """Joints, or links, that cannot move independently of each other."""

    sentence: str
    where: Location
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()


class Told(NamedTuple):
    """A joint, link or other thing of which a sentence is told, and the joints or links that it acts on."""

    name: str
    where: Location
    acts_on: tuple[str, ...]  # "" for all


@dataclass
class Notes:
    """Further content of a file beside Pinocchio's model."""

    path: str | Path
    lines: dict[tuple[str, str], Location] = field(default_factory=dict)  # by ("joint" or "link", name)
    above: dict[str, str] = field(default_factory=dict)  # parent of each link
    mimics: dict[str, Mimic] = field(default_factory=dict)  # by the following joint
    ties: list[Tie] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)
    told: dict[str, list[Told]] = field(default_factory=dict)  # by the sentence that names them
    doubts: list[tuple[str, str]] = field(default_factory=list)  # joint or link ("" for all), sentence
    right_angles: RightAngles = field(default_factory=RightAngles)

    def tell(self, sentence: str, name: str, where: Location, *acts_on: str) -> None:
        """Note that a sentence is told of something, if it acts on the arm: by default on itself."""
        self.told.setdefault(sentence, []).append(Told(name, where, acts_on or (name,)))

    def name(self, kind: str, node: Node, otherwise: str = "") -> str:
        """Name of a joint or link, whose line is noted; ArmError unless it is printable and unique."""
        name = node.attributes.get("name", "") or otherwise
        while otherwise and "name" not in node.attributes and (kind, name) in self.lines:
            name += "_"
        if not name.strip() or visible(name) != name:
            problem = f"a {node.tag} has no printable name"
            raise ArmError(problem, where=node.where, found=repr(name), next_step="name it")
        if (kind, name) in self.lines:
            problem = f"two <{node.tag}> elements have the name {name!r}"
            place_text = f"the other in line {self.lines[kind, name].line}"
            raise ArmError(problem, where=node.where, found=place_text, next_step="rename one")
        self.lines[kind, name] = node.where
        return name


@dataclass(frozen=True)
class Tree:
    """A robot that has been read."""

    model: Any  # pinocchio.Model
    notes: Notes
    name: str
    format: str  # URDF, MJCF, or "" for a model in memory
    gravity: FloatArray  # (3,), m/s^2

    @property
    def where(self) -> str:
        """The file, for messages."""
        return visible(str(self.notes.path))

    @cached_property
    def links(self) -> dict[str, int]:
        """All links, each with the joint that moves it."""
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
        joints: list[TreeJoint] = []
        while index:
            joints.append(self.joints[index - 1])
            index = joints[-1].parent
        return joints[::-1]

    def beyond(self, indices: Iterable[int]) -> set[int]:
        """The given joints and all beyond them."""
        reached = set(indices)
        for joint in self.joints:
            if joint.parent in reached:
                reached.add(joint.index)
        return reached

    def carried_mass(self, joint: TreeJoint) -> float:
        """Mass of the links that a joint and all joints beyond it move, kg."""
        return sum(float(self.model.inertias[index].mass) for index in self.beyond({joint.index}))

    def line(self, kind: str, name: str) -> Location | None:
        """Line of a joint or link; None for a model in memory."""
        return self.notes.lines.get((kind, name))

    def place(self, kind: str, name: str) -> Location | str:
        """Line of a joint or link, or else the model, for messages."""
        return self.line(kind, name) or self.where

    def configuration(self, held_values: Mapping[int, float]) -> FloatArray:
        """Pinocchio's configuration with the given joints at their values and all others at rest."""
        q: FloatArray = pin.neutral(self.model)
        for index, value in held_values.items():
            start, count = self.model.idx_qs[index], self.model.nqs[index]
            if count == 1:
                q[start] = value
            elif self.joints[index - 1].kind == "revolute":  # a continuous joint, as cosine and sine
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


def chain_of(
    tree: Tree, tip: str | None, base: str | None, lock: Mapping[str, Quantity]
) -> tuple[list[TreeJoint], dict[int, float]]:
    """Joints that move, from the base outwards, and the values of all others by Pinocchio's index.

    If this is not a chain of revolute and prismatic joints, the ArmError names the argument that helps.
    """
    joints = tree.joints
    locked = dict(_locked(tree, name, value) for name, value in lock.items())
    _refuse_circles(tree, locked)
    start = 0 if base is None else tree.links[_known("link", base, "base", tree, tree.links)]
    if tip is None:
        free = [joint for joint in joints if start in _ancestors(tree, joint)]
    else:
        path = tree.path(tree.links[_known("link", tip, "tip", tree, tree.links)])
        before = [0, *(joint.index for joint in path)]
        if start not in before:
            detail = f"the path to {tip} passes {some_names(joint.link for joint in path) or 'no joint'}"
            message, where = (
                f"link {tip} is not beyond link {base}",
                f"{argument('base', base)} {argument('tip', tip)}",
            )
            raise ArmError(message, where=where, found=detail, next_step="name a base on that path, or none")
        free = path[before.index(start) :]
    free = [joint for joint in free if joint.index not in locked]
    moving, names = {joint.index for joint in free}, {joint.name for joint in free}
    led_from_aside = [joint for joint in free if _is_led_from_aside(tree, joint, moving, locked)]
    free = [joint for joint in free if not _follows_held(tree, joint, moving)]
    held_values = {joint.index: 0.0 for joint in joints if joint not in free} | locked
    index_of = {joint.name: joint.index for joint in joints}
    for _ in tree.notes.mimics:  # a joint may follow one that follows another
        for name, mimic in tree.notes.mimics.items():
            follower = index_of.get(name)
            if follower in held_values and follower not in locked:
                master = held_values.get(index_of.get(mimic.master, -1), 0.0)
                held_values[follower] = float(mimic.polynomial(master))
    if not free:
        detail = f"{len(joints)} joints, all of them held" if joints else "only fixed joints"
        hint = "hold fewer joints" if joints else "check that the file describes an arm"
        raise ArmError("the robot has no joint that moves", where=tree.where, found=detail, next_step=hint)
    _refuse_floating_and_ties(tree, free)
    _refuse_branches(tree, free, locked)
    _refuse_follower(tree, _follower(tree, names, locked))
    for joint in led_from_aside:
        leader = tree.notes.mimics[joint.name].master
        message = f"joint {joint.name} follows joint {leader}, which is not on the way to the tip"
        hint = f"{_locks([leader])} holds both of them"
        text = tree.notes.mimics[joint.name].text
        raise ArmError(message, where=tree.place("joint", joint.name), found=text, next_step=hint)
    _refuse_other_kinds(tree, free)
    return free, held_values


def _ancestors(tree: Tree, joint: TreeJoint) -> list[int]:
    return [0, *(ancestor.index for ancestor in tree.path(joint.parent))]


def _locked(tree: Tree, name: str, quantity: Quantity) -> tuple[int, float]:
    """Index of a joint to lock, and its value, rad or m."""
    by_name = {joint.name: joint for joint in reversed(tree.joints)}
    joint = by_name[_known("moving joint", name, "lock", tree, [joint.name for joint in tree.joints])]
    if quantity.si and not joint.moves_simply:
        message = f"joint {name} is {joint.kind} and can be held only at 0, in the pose of the file"
        raise ArmError(
            message, where=argument("lock", f"{name}={quantity.si:g}"), next_step="place its link in the file"
        )
    turns = joint.kind == "revolute"
    value = quantity.of_joint(turns) if joint.moves_simply else 0.0
    if value is None:
        message = f"this is no value of joint {name}, which {'turns' if turns else 'slides'}"
        expected, hint = (
            joint_units(turns),
            f"{argument('lock', f'{name}=90deg' if turns else f'{name}=20mm')} states the unit",
        )
        raise ArmError(
            message, where=argument("lock", name), expected=expected, found=str(quantity), next_step=hint
        )
    return joint.index, value


def _known(kind: str, name: str, argument_name: str, tree: Tree, names: Collection[str]) -> str:
    """The name of a link or joint; ArmError if the tree does not have it."""
    if name in names:
        return name
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else "choose a name from the file"
    message, expected = f"there is no {kind} {name!r} in {tree.where}", some_names(names)
    raise ArmError(message, where=argument(argument_name, name), expected=expected, next_step=hint)


def _follows_held(tree: Tree, joint: TreeJoint, moving: Collection[int]) -> bool:
    """Whether a mimic joint follows a held joint, or moves no mass."""
    mimic = tree.notes.mimics.get(joint.name)
    if mimic is None:
        return False
    if tree.format == "URDF" and ("joint", mimic.master) not in tree.notes.lines:
        message, master_text = f"joint {joint.name} mimics a joint that does not exist", repr(mimic.master)
        hint = f"name a joint of the file, or hold it: {_locks([joint.name])}"
        raise ArmError(message, where=tree.line("joint", joint.name), found=master_text, next_step=hint)
    masters = [candidate.index for candidate in tree.joints if candidate.name == mimic.master]
    return not masters or masters[0] not in moving or not tree.carried_mass(joint)


def _is_led_from_aside(tree: Tree, joint: TreeJoint, moving: Collection[int], locked: Container[int]) -> bool:
    """Whether a joint on the way to the tip follows one that is not, and that nobody locked."""
    leader = _leader(tree, joint, locked)
    return leader is not None and leader.index not in moving


def _refuse_circles(tree: Tree, locked: Container[int]) -> None:
    """Refuse joints that follow each other in a circle, unless one of them is locked."""
    index_of, mimics = {joint.name: joint.index for joint in tree.joints}, tree.notes.mimics
    for name in mimics:
        followed, at = list[str](), name
        while at in mimics and at not in followed and index_of.get(at) not in locked:
            followed.append(at)
            at = mimics[at].master
        if at in followed:
            circle = followed[followed.index(at) :]
            message = "joints follow each other in a circle, so that none of them leads"
            hint = f"let one of them lead, or hold it: {_locks([at])}"
            raise ArmError(
                message, where=tree.place("joint", at), found=" follows ".join([*circle, at]), next_step=hint
            )


def _leader(tree: Tree, joint: TreeJoint, locked: Container[int]) -> TreeJoint | None:
    """Joint that another one follows in the end, over others; None if it follows none, or a locked one."""
    by_name = {candidate.name: candidate for candidate in tree.joints}
    mimics, followed = tree.notes.mimics, list[TreeJoint]()
    at: TreeJoint | None = joint
    while at is not None and at not in followed and at.index not in locked:
        if at.name not in mimics:
            return at if followed else None
        followed.append(at)
        at = by_name.get(mimics[at.name].master)
    return None


def _follower(
    tree: Tree, moving: Container[str], locked: Container[int]
) -> tuple[TreeJoint, TreeJoint] | None:
    """A joint that carries mass and moves whenever a moving joint does, and that joint.

    Which of two joints follows the other says nothing in MJCF, where an equality binds both.
    """
    for joint in tree.joints:
        leader = _leader(tree, joint, locked)
        if leader is None:
            continue
        for follower, mover in [(joint, leader), (leader, joint)][: 2 if tree.format == "MJCF" else 1]:
            if mover.name in moving and tree.carried_mass(follower) > 0:
                return follower, mover
    return None


def _refuse_follower(tree: Tree, pair: tuple[TreeJoint, TreeJoint] | None) -> None:
    if pair is None:
        return
    follower, leader = pair
    mass = f"{tree.carried_mass(follower):g} kg"
    message = f"joint {follower.name} mimics joint {leader.name}, which moves, and loads it with {mass}"
    detail = "only serial chains can be modelled"
    mimic = tree.notes.mimics.get(follower.name)
    if mimic is not None:
        detail = f"{mimic.text}; {detail}"
    hint = f"{_locks([follower.name])} holds it, {_locks([leader.name])} both of them"
    raise ArmError(message, where=tree.place("joint", follower.name), found=detail, next_step=hint)


def _locks(names: Iterable[str]) -> str:
    locks = [f"{name}=0" for name in names]
    return argument("lock", locks if len(locks) > 1 else locks[0])


def _refuse_floating_and_ties(tree: Tree, free: Sequence[TreeJoint]) -> None:
    for joint in free:
        if joint.kind == "floating":
            message = f"the robot floats: joint {joint.name} lets link {joint.link} move freely"
            hint = f"{argument('base', joint.link)} fixes that link; or use a file with a fixed base"
            raise ArmError(message, where=tree.place("joint", joint.name), next_step=hint)
    for tie in tree.notes.ties:
        ways = [{joint.index for joint in tree.path(tree.links.get(link, 0))} for link in tie.links]
        apart = set[int]().union(*ways) - ways[0].intersection(*ways) if ways else set()
        between = [joint for joint in free if joint.index in apart or joint.name in tie.joints]
        if between:
            detail = f"joints that move with each other: {some_names(joint.name for joint in between)}"
            hint = (
                f"{_locks(joint.name for joint in between)} holds them; or `tip` selects an arm without them"
            )
            raise ArmError(tie.sentence, where=tie.where, found=detail, next_step=hint)


def _refuse_other_kinds(tree: Tree, free: Sequence[TreeJoint]) -> None:
    for joint in free:
        if not joint.moves_simply:
            where = tree.place("joint", joint.name)
            message = f"joint {joint.name} is {joint.kind}, neither revolute nor prismatic"
            hint = f"{_locks([joint.name])} holds it; or select an arm without it by `base` and `tip`"
            raise ArmError(message, where=where, next_step=hint)


def _refuse_branches(tree: Tree, free: Sequence[TreeJoint], locked: Container[int]) -> None:
    """Refuse a branching tree, with the locks or tips that make it a chain; or a lever that makes it none."""
    after: dict[int, list[TreeJoint]] = {0: [], **{joint.index: [] for joint in free}}
    for joint in free:
        after[next(index for index in reversed(_ancestors(tree, joint)) if index in after)].append(joint)
    stem: list[TreeJoint] = []
    at = after[0]
    while len(at) == 1:
        stem, at = [*stem, at[0]], after[at[0].index]
    if not at:
        return
    fork, beyond = stem[-1].link if stem else "the base", [joint for joint in free if joint not in stem]
    branches = [[member for member in free if member.index in tree.beyond({joint.index})] for joint in at]
    if len(beyond) <= len(stem):
        to_hold = [joint for joint in beyond if joint.name not in tree.notes.mimics]
        hint = f"{argument('tip', fork)} holds the branches, with their mass"
        if len(to_hold) <= _MOST_LOCKED:
            held = _locks(joint.name for joint in to_hold)
            hint = f"{held} holds the branches, with their mass; {argument('tip', fork)} does the same"
    else:
        moving = [{member.name for member in tree.path(joint.index)} for joint in beyond]
        ends = [
            joint
            for joint, names in zip(beyond, moving, strict=True)
            if len(after[joint.index]) != 1
            and names.isdisjoint(tree.notes.mimics)
            and _follower(tree, names, locked) is None
        ]
        if not ends:
            _refuse_follower(tree, _follower(tree, {joint.name for joint in free}, locked))
        ends.sort(key=lambda joint: (not after[joint.index], -len(tree.path(joint.index))))
        tips = [joint.link for joint in (*stem[-1:], *ends)]
        hint = "name the arm's last link, " + " or ".join(argument("tip", tip) for tip in tips[:_MOST_NAMED])
    names = (branch[0].name + (f" with {len(branch) - 1} more" if branch[1:] else "") for branch in branches)
    message = f"the robot branches at link {fork}" if stem else "the robot branches at its base"
    where = (tree.line("link", fork) if stem else None) or tree.where
    error = BranchError(
        message, where=where, found=f"{len(at)} branches: {some_names(names)}", next_step=hint
    )
    error.paths = {joint.link: [member.name for member in tree.path(joint.index)] for joint in free}
    raise error
