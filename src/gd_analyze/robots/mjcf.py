"""Read a robot from MuJoCo's MJCF into Pinocchio's model; what it has beside D, h and c is told, or refused.

Pinocchio's own reader loses masses that defaults state, limits, gravity, reference values and equalities.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from gd_analyze.errors import ArmError
from gd_analyze.robots.frames import straight
from gd_analyze.robots.mjcf_bodies import Compiler, merged
from gd_analyze.robots.mjcf_elements import refuse_unknown, told, with_defaults
from gd_analyze.robots.text_file import Node
from gd_analyze.robots.tree import Mimic, Notes, Tie, Tree, some_names

_KINDS = ("hinge", "slide", "ball", "free")
_ONE_TO_ONE = (0.0, 1.0, 0.0, 0.0, 0.0)  # coefficients of an equality that states none


@dataclass
class _Body:
    """A body with the joints that move it, the first one next to the body it stands in."""

    name: str
    parent: str
    node: Node
    place: pin.SE3  # in the parent
    joints: list[tuple[str, Node]]
    inertia: pin.Inertia
    made_from: str  # "stated", "shapes" or "meshes"


def read_mjcf(path: Path, root: Node) -> Tree:
    """Read a <mujoco>; ArmError if only MuJoCo itself can expand it, or it describes no possible robot."""
    refuse_unknown(root)
    root = with_defaults(root)
    worlds = root.all("worldbody")
    if not worlds:
        message, hint = "the file describes no bodies", "name the robot's own file, not a scene or defaults"
        raise ArmError(message, where=root.where, expected="a <worldbody>", next_step=hint)
    notes = Notes(path, {("link", "world"): worlds[0].where})  # no body may have its name
    compiler = Compiler(root.all("compiler"), notes.right_angles)
    bodies = [body for world in worlds for body in _bodies(world, "world", compiler, notes)]
    total, sum_of_masses = compiler.setting("settotalmass"), sum(body.inertia.mass for body in bodies)
    if total > 0 and sum_of_masses > 0:
        for body in bodies:
            mass, com = body.inertia.mass * total / sum_of_masses, body.inertia.lever
            body.inertia = pin.Inertia(mass, com, body.inertia.inertia * total / sum_of_masses)
    model = pin.Model()
    for body in bodies:
        _add(model, body, compiler, notes)
    options = root.all("option")
    option, flags = merged(options), merged(flag for node in options for flag in node.all("flag"))
    gravity = np.array(option.numbers("gravity", 3, "0 0 -9.81"))
    if flags.attributes.get("gravity") == "disable":
        gravity = np.zeros(3)
        notes.assumptions.append("The file switches gravity off (<flag gravity='disable'/>).")
    _tell(option, "option", path.name, notes, "")
    if not any(flags.attributes.get(key) == "disable" for key in ("equality", "constraint")):
        _note_equalities(root, bodies, compiler, notes)
    for tendon in (child for part in root.all("tendon") for child in part.children):
        joints = [part.attributes.get("joint", "") for part in tendon.all("joint")]
        _tell(tendon, "tendon", tendon.attributes.get("name", "?"), notes, *(joints or [""]))
    for flex in (child for part in root.all("deformable") for child in part.all("flex")):
        for name in flex.words("body") + flex.words("node"):
            notes.tell("forces of flexes are ignored, on body", name, flex.where)
    _add_actuators(root, model, notes)
    shaped = [body.name for body in bodies if body.made_from != "stated" and body.inertia.mass > 0]
    if shaped:
        names = some_names(shaped)
        notes.assumptions.append(f"Mass and inertia not stated, computed from primitive shapes: {names}.")
    return Tree(model, notes, root.attributes.get("model", "").strip() or path.stem, "MJCF", gravity)


def _tell(node: Node, kind: str, name: str, notes: Notes, *acts_on: str) -> None:
    """Tell what an element states beside D, h and c, and of which joints or links."""
    for key, text in told(node, kind).items():
        notes.tell(f"{text} ({key}) is ignored, of {kind}", name, node.where, *acts_on)


def _bodies(node: Node, parent: str, compiler: Compiler, notes: Notes) -> Iterator[_Body]:
    """Bodies within a body or the world, each before those within it."""
    for child in node.all("body"):
        name = notes.name("link", child, f"body_{child.where.line}")
        notes.above[name] = parent
        place = compiler.pose(child, name)
        joints = [
            (notes.name("joint", each, f"{name}_joint"), each) for each in child.all("joint", "freejoint")
        ]
        inertia, made_from = compiler.inertia(child, name, place)
        if made_from == "meshes":
            states = "no <inertial>" if child.first("inertial") is None else "inertiafromgeom"
            notes.tell(f"{states}, and meshes of unknown mass, in body", name, child.where)
        _tell(child, "body", name, notes)
        for plugin in child.all("plugin"):
            notes.tell("forces of plugins are ignored, of body", name, plugin.where)
        for joint, each in joints:
            if each.tag == "joint":
                _tell(each, "joint", joint, notes)
        yield _Body(name, parent, child, place, joints, inertia, made_from)
        yield from _bodies(child, name, compiler, notes)


def _add(model: pin.Model, body: _Body, compiler: Compiler, notes: Notes) -> None:
    """Add a body and its joints to Pinocchio's model. Several joints have massless links between them."""
    frame = 0 if body.parent == "world" else model.getFrameId(body.parent, pin.FrameType.BODY)
    outer = model.frames[frame]
    place = outer.placement * body.place  # of what follows, in the joint so far
    joint_id, name = outer.parentJoint, body.name
    for name, node in body.joints:
        anchor = pin.SE3(np.eye(3), np.array(node.numbers("pos", 3, "0 0 0")))
        joint_id = _add_joint(model, joint_id, place * anchor, name, node, body.name, compiler)
        frame = model.addJointFrame(joint_id, frame)
        place = anchor.inverse()
        if name != body.joints[-1][0]:
            moved = f"{body.name}:{name}"
            notes.lines["link", moved] = body.node.where
            frame = model.addBodyFrame(moved, joint_id, place, frame)
    if body.joints:
        model.appendBodyToJoint(joint_id, body.inertia, place)
    else:  # a tab, as no joint has such a name
        fixed = pin.Frame(f"\t{name}", joint_id, frame, place, pin.FrameType.FIXED_JOINT, body.inertia)
        frame = model.addFrame(fixed)
    model.addBodyFrame(body.name, joint_id, place, frame)


def _add_joint(
    model: pin.Model, parent: int, place: pin.SE3, name: str, node: Node, link: str, compiler: Compiler
) -> int:
    """Add a joint at a place in the joint before; in the file's pose it has its reference value."""
    kind = "free" if node.tag == "freejoint" else node.attributes.get("type", "hinge")
    if kind not in _KINDS:
        message, where = f"joint {name} is of no known type", node.places.get("type", node.where)
        raise ArmError(message, where=where, expected=", ".join(_KINDS), found=repr(kind))
    if kind in ("free", "ball"):
        joint = pin.JointModelFreeFlyer() if kind == "free" else pin.JointModelSpherical()
        return int(model.addJoint(parent, joint, place, name))
    numbers = node.numbers("axis", 3, "0 0 1")
    if not any(numbers):
        raise ArmError(f"joint {name} has no axis", where=node.places.get("axis", node.where), found="0 0 0")
    axis = compiler.right.direction(numbers, link)
    unit = 2 * math.pi / compiler.turn if kind == "hinge" else 1.0
    reference = _reference(node, compiler)
    if kind == "hinge":
        joint = pin.JointModelRevoluteUnaligned(axis)
        back = pin.SE3(straight(np.array(pin.exp3(-reference * axis))), np.zeros(3))
    else:
        joint, back = pin.JointModelPrismaticUnaligned(axis), pin.SE3(np.eye(3), -reference * axis)
    effort = np.abs(_limits(node, "actuatorfrcrange", compiler)).max()
    limits = (effort, math.inf, *(end * unit for end in _limits(node, "range", compiler)))
    index = int(model.addJoint(parent, joint, place * back, name, *(np.full(1, limit) for limit in limits)))
    for values, key in (
        (model.armature, "armature"),
        (model.damping, "damping"),
        (model.friction, "frictionloss"),
    ):
        values[model.idx_vs[index]] = _first(node, key, 0.0)
    return index


def _limits(node: Node, key: str, compiler: Compiler) -> list[float]:
    """Both ends of a range, infinite where it does not hold."""
    switch = {"range": "limited", "actuatorfrcrange": "actuatorfrclimited"}[key]
    limited = node.attributes.get(switch, "auto")
    if limited == "auto":
        limited = compiler.word("autolimits", "true") if key in node.attributes else "false"
    return node.numbers(key, 2, "0 0") if limited == "true" else [-math.inf, math.inf]


def _note_equalities(root: Node, bodies: list[_Body], compiler: Compiler, notes: Notes) -> None:
    """Note joints that follow others, and joints and links that are tied beside the tree."""
    joints = {name: node for body in bodies for name, node in body.joints}
    links = ["world", *(body.name for body in bodies)]
    tendons = {
        tendon.attributes.get("name", ""): tendon for part in root.all("tendon") for tendon in part.children
    }
    holders = [(world, "world") for world in root.all("worldbody")]
    holders += [(body.node, body.name) for body in bodies]
    link_of = {
        (part.tag, part.attributes.get("name", "")): link
        for holder, link in holders
        for part in holder.all("site", "geom")
    }
    sites = {name: link for (tag, name), link in link_of.items() if tag == "site"}
    for node in (child for part in root.all("equality") for child in part.children):
        if node.attributes.get("active") == "false":
            continue
        if node.tag in ("connect", "weld"):
            ends = [
                sites[_named(node, f"site{k}", sites)]
                if f"site{k}" in node.attributes
                else _named(node, f"body{k}", links, "world")
                for k in (1, 2)
            ]
            sentence = f"links {ends[0]} and {ends[1]} close a loop"
            notes.ties.append(Tie(sentence, node.where, links=tuple(ends)))
        elif node.tag == "tendon":
            tied = [_named(node, key, tendons) for key in ("tendon1", "tendon2") if key in node.attributes]
            parts = [
                (part.tag, part.attributes.get(part.tag, ""))
                for tendon in tied
                for part in tendons[tendon].children
            ]
            sentence = f"an equality of tendon {' and '.join(tied)} ties joints to each other"
            of_joints = tuple(name for tag, name in parts if tag == "joint")
            of_links = tuple(link_of.get(part, "world") for part in parts if part[0] in ("site", "geom"))
            notes.ties.append(Tie(sentence, node.where, of_joints, of_links))
        else:
            _note_mimic(node, joints, compiler, notes)


def _note_mimic(node: Node, joints: dict[str, Node], compiler: Compiler, notes: Notes) -> None:
    """Note that a joint follows another, or stands still; if it follows one already, that it is tied."""
    follower, leader = node.attributes.get("joint1", ""), node.attributes.get("joint2", "")
    rest = [
        _reference(joints[_named(node, key, joints)], compiler) if key in node.attributes else 0.0
        for key in ("joint1", "joint2")
    ]
    stated = node.numbers("polycoef", len(node.words("polycoef"))) if node.words("polycoef") else []
    coefficients = [*stated, *_ONE_TO_ONE[len(stated) :]]
    if follower in notes.mimics:
        sentence = f"joint {follower} follows {notes.mimics[follower].master or 'nothing'} already"
        notes.ties.append(Tie(sentence, node.where, (follower, leader)))
        return
    # The polynomial is of deviations from the reference values.
    of_variable = Polynomial(coefficients)(Polynomial([-rest[1], 1.0])) + rest[0]
    notes.mimics[follower] = Mimic(leader, of_variable if leader else Polynomial([rest[0] + coefficients[0]]))


def _reference(node: Node, compiler: Compiler) -> float:
    """Value of a joint in the file's pose, rad or m."""
    turn = 1.0 if node.attributes.get("type") == "slide" else 2 * math.pi / compiler.turn
    return node.numbers("ref", 1, "0")[0] * turn


def _named(node: Node, key: str, names: Collection[str], default: str = "") -> str:
    """The name that an attribute states; ArmError unless the file has it."""
    name = node.attributes.get(key, default)
    if name in names:
        return name
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    message, hint = f"{key} of <{node.tag}> names nothing in the file", "fix the name"
    hint = f"did you mean {' or '.join(near)}?" if near else hint
    raise ArmError(message, where=node.where, found=repr(name), next_step=hint)


def _add_actuators(root: Node, model: pin.Model, notes: Notes) -> None:
    """Add the inertia and friction of actuators to their joints, and limit the joints' efforts."""
    limits, armature, damping = model.effortLimit, model.armature, model.damping
    for node in (child for part in root.all("actuator") for child in part.children):
        name = node.attributes.get("joint", node.attributes.get("jointinparent", ""))
        joint = model.getJointId(name) if name and model.existJointName(name) else 0
        if joint == 0 or model.nvs[joint] != 1:
            _tell(node, "actuator", node.attributes.get("name", "?"), notes, "")
            continue
        at, gear = model.idx_vs[joint], abs(_first(node, "gear", 1.0))
        armature[at] += gear**2 * _first(node, "armature", 0.0)
        damping[at] += gear**2 * _first(node, "damping", 0.0)
        key = "forcerange" if "forcerange" in node.attributes else "ctrlrange"
        switch = node.attributes.get(key.replace("range", "limited"), "auto")
        if key in node.attributes and switch != "false" and (key == "forcerange" or node.tag == "motor"):
            most = max(abs(value) for value in node.numbers(key, 2)) * gear
            limits[at] = min(limits[at], most) if limits[at] > 0 else most


def _first(node: Node, key: str, default: float) -> float:
    """First number of an attribute."""
    words = node.words(key)
    return node.numbers(key, len(words))[0] if words else default
