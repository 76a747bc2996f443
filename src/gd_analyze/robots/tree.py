"""A robot as a tree of joints: Pinocchio's model with what only its file states, and the arm of one chain."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Drive, Joint, Link, Placement, checked
from gd_analyze.robots.right_angles import RightAngles, straight, without_round_off
from gd_analyze.robots.xml import Node
from gd_analyze.text import LARGEST, shortened, visible

# From here on 100, 1000 and so on stand for no limit: joints of arms do 40 rad/s and end within some turns,
# or 100 m on a gantry.
_NO_VELOCITY, _NO_RANGE = 100.0, 1000.0
_MOST_NAMED = 8
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


@dataclass(frozen=True)
class TreeJoint:
    """One joint of a tree.

    `index` and `parent` are Pinocchio's, from 1; 0 is the ground. `link` moves with the joint. `axis` is a
    unit vector in the joint's frame, zero where the kind has none.
    """

    index: int
    name: str
    link: str
    parent: int
    kind: str
    axis: FloatArray

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
    """What a file states besides Pinocchio's model.

    Parameters
    ----------
    path
        The file.
    lines
        Where it describes a ("joint" or "link", name).
    above
        The link that each link hangs on.
    mimics
        By the name of the joint that follows.
    loops
        Two links held together beside the tree, and where.
    unranged
        Joints that should state a range and do not.
    assumptions
        Sentences for the arm.
    doubts
        The joint or link that each is about ("" for all), and a sentence.
    right_angles
        What was made right.
    """

    path: str | Path
    lines: dict[tuple[str, str], Location] = field(default_factory=dict)
    above: dict[str, str] = field(default_factory=dict)
    mimics: dict[str, Mimic] = field(default_factory=dict)
    loops: list[tuple[str, str, Location]] = field(default_factory=list)
    unranged: list[str] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)
    doubts: list[tuple[str, str]] = field(default_factory=list)
    right_angles: RightAngles = field(default_factory=RightAngles)

    def name(self, what: str, node: Node, otherwise: str = "") -> str:
        """Name of a joint or link, whose line is noted.

        Raises
        ------
        ArmError
            If it has none, another has the same, or the name is not printable.
        """
        name = node.attributes.get("name", "") or otherwise
        while otherwise and "name" not in node.attributes and (what, name) in self.lines:
            name += "_"
        if not name.strip() or visible(name) != name:
            expected = f'<{node.tag} name="..."> of printable text'
            message = f"a {node.tag} has no printable name"
            raise ArmError(
                message, where=node.where, expected=expected, found=repr(name), next_step="name it"
            )
        if (what, name) in self.lines:
            expected = f"another name than in line {self.lines[what, name].line}"
            message = f"two of <{node.tag}> have the name {name!r}"
            raise ArmError(message, where=node.where, expected=expected, next_step="rename one")
        self.lines[what, name] = node.where
        return name


@dataclass(frozen=True)
class Tree:
    """A robot that has been read: Pinocchio's model with every joint free, and notes on its file."""

    model: Any
    notes: Notes
    name: str
    format: str
    gravity: FloatArray

    @property
    def where(self) -> str:
        """The file, for messages."""
        return visible(str(self.notes.path))

    @cached_property
    def links(self) -> dict[str, int]:
        """All links, and the joint that each moves with."""
        import pinocchio as pin

        links: dict[str, int] = {}
        for frame in self.model.frames:
            if frame.type == pin.FrameType.BODY:
                links.setdefault(frame.name, int(frame.parentJoint))
        return links

    @cached_property
    def joints(self) -> tuple[TreeJoint, ...]:
        """Joints in Pinocchio's order: parents come first."""
        import pinocchio as pin

        model, neutral, joints = self.model, pin.neutral(self.model), []
        first = {index: link for link, index in reversed(self.links.items())}
        for index in range(1, model.njoints):
            name = model.names[index]
            kind, axis = _motion(model.joints[index], neutral)
            joints.append(
                TreeJoint(index, name, first.get(index, name), int(model.parents[index]), kind, axis)
            )
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

    def line(self, what: str, name: str) -> Location | str:
        """Where a joint or link is described, for messages."""
        return self.notes.lines.get((what, name), f"{self.where}, {what} {name}")


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


def tree_of_model(model: Any) -> Tree:
    """A Pinocchio model from memory, as it is."""
    return Tree(model, Notes("the Pinocchio model"), model.name, "", np.array(model.gravity.linear))


def arm_of_chain(tree: Tree, moving: Sequence[TreeJoint], held: Mapping[int, float]) -> RobotArm:
    """The arm of a chain: all other joints held at their values, their links merged, no mass lost.

    Raises
    ------
    ArmError
        If a number of it is impossible.
    """
    import pinocchio as pin

    model, notes = pin.Model(tree.model), tree.notes
    for frame in model.frames:  # Pinocchio looks joints up among all names, and a link may have the same
        if frame.type not in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT):
            frame.name = f"link {frame.name}"
    reduced = pin.buildReducedModel(model, sorted(held), configuration(tree, held))
    joints, placeholders = [], []
    for index, joint in enumerate(moving, start=1):
        limits = _limits(tree.model, joint.index)
        joints.append(_joint(tree, joint, reduced.jointPlacements[index], limits))
        if limits[3]:
            placeholders.append(joint.name)
    carried = {link for link, index in tree.links.items() if index in tree.beyond(j.index for j in moving)}
    placed = carried | _inboard(notes, moving[0].link)
    about = {"", *carried, *(joint.name for joint in moving)}
    none = f"Limits of 100, 1000 and so on stand for none: joint {', '.join(placeholders)}."
    unranged = [joint.name for joint in moving if joint.name in notes.unranged]
    doubts = [text for name, text in notes.doubts if name in about]
    if unranged:
        doubts.insert(0, f"{tree.line('joint', unranged[0])}: no range stated for {', '.join(unranged)}")
    doubts += [text for link, text in notes.right_angles.suspects if link in placed]
    if not any(inertia.mass > 0 for inertia in tree.model.inertias):
        doubts.append(f"{tree.where}: no link has any mass; is the file stripped, or xacro expanded in part?")
    version = f"Pinocchio {pin.__version__}"
    source = f"{visible(Path(notes.path).name)}: {tree.format}, read by {version}."
    stem = Path(notes.path).stem if tree.format else "robot"
    return RobotArm(
        name=_identifier(tree.name, stem),
        title=shortened(visible(tree.name), 120),
        gravity=tree.gravity,
        joints=tuple(joints),
        links=tuple(_link(tree, joint, reduced.inertias[i]) for i, joint in enumerate(moving, start=1)),
        drives=_drives(tree, moving),
        convention=f"placements from {tree.format or 'a Pinocchio model'}",
        sources=(source if tree.format else f"A model in memory of {version}.",),
        assumptions=(
            *notes.assumptions,
            *notes.right_angles.assumptions(placed),
            *([none] if placeholders else []),
            *_held_sentence(tree, moving, held),
        ),
        doubts=tuple(doubts),
    )


def configuration(tree: Tree, held: Mapping[int, float]) -> FloatArray:
    """Pinocchio's configuration with the given joints at their values and all others at rest."""
    import pinocchio as pin

    q: FloatArray = pin.neutral(tree.model)
    for index, value in held.items():
        start, count = tree.model.idx_qs[index], tree.model.nqs[index]
        if count == 1:
            q[start] = value
        elif tree.joints[index - 1].kind == "revolute":  # one without ends, as cosine and sine
            q[start : start + 2] = math.cos(value), math.sin(value)
    return q


def _inboard(notes: Notes, link: str) -> set[str]:
    """Links that a link hangs on."""
    found: set[str] = set()
    while (link := notes.above.get(link, "")) and link not in found:
        found.add(link)
    return found


_Limits = tuple[float | None, float | None, float | None, bool]


def _limits(model: Any, index: int) -> _Limits:
    """Range and velocity limit of a joint, and whether placeholders were left out of them."""
    at_q, velocity = model.idx_qs[index], float(model.velocityLimit[model.idx_vs[index]])
    ends = (float(model.lowerPositionLimit[at_q]), float(model.upperPositionLimit[at_q]))
    has_range = model.nqs[index] == 1 and np.isfinite(ends).all() and ends != (0.0, 0.0)
    has_velocity = 0 < velocity < math.inf
    none_meant = has_range and any(_is_power_of_ten(abs(end), _NO_RANGE) for end in ends)
    no_velocity_meant = has_velocity and _is_power_of_ten(velocity, _NO_VELOCITY)
    lower, upper = ends if has_range and not none_meant else (None, None)
    return (
        lower,
        upper,
        velocity if has_velocity and not no_velocity_meant else None,
        none_meant or no_velocity_meant,
    )


def _is_power_of_ten(number: float, least: float) -> bool:
    return number >= least and math.log10(number).is_integer()


def _joint(tree: Tree, joint: TreeJoint, moved: Any, limits: _Limits) -> Joint:
    where = tree.line("joint", joint.name)
    place = checked(moved.translation, (3,), f"the place of joint {joint.name}", where)
    place = without_round_off(place, max(1.0, float(np.abs(place).max())))
    return Joint(
        joint.name,
        "revolute" if joint.kind == "revolute" else "prismatic",
        Placement(straight(np.array(moved.rotation)), place),
        joint.axis,
        *limits[:3],
        source=where if isinstance(where, Location) else None,
    )


def _link(tree: Tree, joint: TreeJoint, body: Any) -> Link:
    """Link of a joint with all that is fixed to it, in the joint's frame, which is the link's."""
    mass, com, inertia = float(body.mass), np.array(body.lever), np.array(body.inertia)
    inertia = (inertia + inertia.T) / 2
    com = without_round_off(com, max(1.0, float(np.abs(com).max()))) if mass else np.zeros(3)
    where = tree.line("link", joint.link)
    return Link(
        joint.link,
        mass,
        com,
        without_round_off(inertia, float(np.abs(inertia).max())),
        source=where if isinstance(where, Location) else None,
    )


def _drives(tree: Tree, moving: Sequence[TreeJoint]) -> tuple[Drive, ...]:
    """Drives as the model states them, seen at the joint; none where it states nothing."""
    model, drives = tree.model, []
    for joint in moving:
        at, where = model.idx_vs[joint.index], tree.line("joint", joint.name)
        stated = {"armature": model.armature, "damping": model.damping, "friction": model.friction}
        inertia, viscous, friction = (
            float(checked(values[at], (), f"the {what} of joint {joint.name}", where, nonnegative=True))
            for what, values in stated.items()
        )
        effort = float(model.effortLimit[at])
        limit = effort if 0 < effort <= LARGEST else None
        drives.append(Drive(inertia, viscous=viscous, coulomb=(friction, 0.0 - friction), torque_limit=limit))
    return tuple(drives) if any(drive != Drive() for drive in drives) else ()


def _held_sentence(tree: Tree, moving: Sequence[TreeJoint], held: Mapping[int, float]) -> Iterator[str]:
    """Held joints that hang on the arm, or place its base, and their values."""
    near = {joint.index for joint in tree.path(moving[0].index)} | tree.beyond(
        joint.index for joint in moving
    )
    units = {"revolute": " rad", "prismatic": " m"}
    values = [
        f"{joint.name} at {held[joint.index]:g}{units.get(joint.kind, '')}"
        for joint in tree.joints
        if joint.index in held and joint.index in near
    ]
    if values:
        more = f" and {len(values) - _MOST_NAMED} more" if len(values) > _MOST_NAMED else ""
        yield f"Held, with what they carry: {', '.join(values[:_MOST_NAMED])}{more}."


def _identifier(name: str, stem: str) -> str:
    """A name for folders out of a robot's: "my robot (v2)" becomes my_robot_v2."""
    cleaned = (re.sub(r"[^A-Za-z0-9_.-]+", "_", given).strip("_.-") for given in (name, stem))
    return next((found[:100] for found in cleaned if found), "robot")
