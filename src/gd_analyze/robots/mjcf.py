"""Read a robot from MuJoCo's MJCF: what Pinocchio's reader ignores is read here, or refused by name.

Pinocchio gets the compiler's settings, defaults of joints and shapes, and the bodies with their joints and
inertias: named, one joint each, with exact right angles, without meshes. It assumes gravity 9.81 along z,
misreads reference values, and joins several joints of a body into one, so that these are read here.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.files import temporary_folder
from gd_analyze.robots.frames import straight
from gd_analyze.robots.text_file import Node, parsed_model
from gd_analyze.robots.tree import Mimic, Notes, Tree, some_names

_EXPANDED_BY_MUJOCO = ("include", "frame", "replicate", "attach", "composite", "flexcomp")
_OF_COMPILER = ("angle", "eulerseq", "autolimits")
_CHANGES_MASS = ("settotalmass", "boundmass", "boundinertia", "inertiafromgeom")
# Number of values of each way to place a body.
_POSE = {"pos": 3, "quat": 4, "euler": 3, "axisangle": 4, "xyaxes": 6, "zaxis": 3}
_OF_JOINT = ("type", "pos", "range", "limited", "armature", "damping", "frictionloss", "class",
             "actuatorfrcrange")  # fmt: skip
_OF_GEOM = ("class", "type", "size", "mass", "density", "fromto", "shellinertia", *_POSE)
_WITHOUT_SHAPE = ("mesh", "hfield", "plane", "sdf")


def read_mjcf(path: Path, root: Node) -> Tree:
    """Read a <mujoco>; ArmError if only MuJoCo itself can expand it, or it describes no possible robot."""
    for node in root.walk():
        if node.tag in _EXPANDED_BY_MUJOCO:
            hint = "load the file with MuJoCo and call mujoco.mj_saveLastXML('robot.xml', model)"
            hint = f'set <compiler saveinertial="true"/>, {hint}'
            raise ArmError(f"only MuJoCo can expand <{node.tag}>", where=node.where, next_step=hint)
    worlds = root.all("worldbody")
    if not worlds:
        message, hint = "the file describes no bodies", "name the robot's own file, not a scene or defaults"
        raise ArmError(message, where=root.where, expected="a <worldbody>", next_step=hint)
    world = Node(
        "worldbody", {}, worlds[0].where, [child for worldbody in worlds for child in worldbody.children]
    )
    compilers, notes = root.all("compiler"), Notes(path)
    for node in compilers:
        for key, words in (("coordinate", ("local",)), ("angle", ("degree", "radian"))):
            word = node.attributes.get(key, words[0])
            if word not in words:
                message, expected = f"<compiler {key}={word!r}> is not what MuJoCo reads", " or ".join(words)
                hint = "convert the file with MuJoCo"
                raise ArmError(message, where=node.where, expected=expected, next_step=hint)
    in_degrees = all(node.attributes.get("angle", "degree") == "degree" for node in compilers)
    bodies = _Bodies(notes, 360.0 if in_degrees else 2 * math.pi)
    bare = Node("mujoco", {"model": "robot"}, root.where)
    bare.children = [node.kept(_OF_COMPILER) for node in compilers]
    defaults = root.all("default")
    if defaults:  # several sections are merged
        inside = [child for node in defaults for child in node.children]
        bare.children.append(_defaults(Node("default", defaults[0].attributes, defaults[0].where, inside)))
    bare.children.append(world.kept((), {}, *_placed_roots(bodies.below(world, "world"))))
    with temporary_folder() as folder:
        copy = folder / "robot.xml"
        copy.write_text(bare.text(), encoding="utf-8")
        model = parsed_model(lambda: pin.buildModelFromMJCF(str(copy)), "MJCF", path, notes.lines)
    gravity = [0.0, 0.0, -9.81]
    for option in root.all("option"):
        gravity = option.numbers("gravity", 3, " ".join(map(repr, gravity)))
        if any(flag.attributes.get("gravity") == "disable" for flag in option.all("flag")):
            gravity = [0.0, 0.0, 0.0]
            notes.assumptions.append("The file switches gravity off (<flag gravity='disable'/>).")
    name = root.attributes.get("model", "").strip() or path.stem
    tree = Tree(model, notes, name, "MJCF", np.array(gravity))
    bodies.turn_back(tree)
    _note_equalities(root, bodies.sites, notes)
    for node in compilers:
        for key in _CHANGES_MASS:
            value = node.attributes.get(key, "0")
            if value not in ("0", "-1", "false", "auto"):
                doubt = f"{node.where}: <compiler {key}={value!r}> changes masses in MuJoCo, but not here"
                notes.doubts.append(("", doubt))
    _limit_efforts(root, model)
    if bodies.shaped:
        sentence = (
            f"Mass and inertia not stated, computed from primitive shapes: {some_names(bodies.shaped)}."
        )
        notes.assumptions.append(sentence)
    return tree


def _placed_roots(roots: list[Node]) -> list[Node]:
    """Bodies of the world; fixed ones get an outer body, as Pinocchio drops the pose of the first body."""
    floating = [
        body for body in roots if any(child.attributes.get("type") == "free" for child in body.children)
    ]
    fixed = [body for body in roots if body not in floating]
    if not any(_POSE.keys() & body.attributes.keys() for body in fixed):
        return roots
    return [Node("body", {"name": "world"}, fixed[0].where, fixed), *floating]


def _defaults(node: Node) -> Node:
    """Defaults of joints and shapes; ArmError if one moves every joint of a class."""
    for joint in node.all("joint"):
        if joint.is_not_zero("ref"):
            message = "a default gives joints a reference value"
            raise ArmError(message, where=joint.where, next_step="write ref at the joints themselves")
    inside = [child.kept(_OF_GEOM) for child in node.all("geom")]
    inside += [child.kept((*_OF_JOINT, "axis")) for child in node.all("joint")]
    return node.kept(("class",), {}, *inside, *(_defaults(child) for child in node.all("default")))


def _note_equalities(root: Node, sites: dict[str, str], notes: Notes) -> None:
    """Note joints that follow others, and bodies held together beside the tree."""
    for node in (child for part in root.all("equality") for child in part.children):
        attributes = node.attributes
        if attributes.get("active") == "false":
            continue
        if node.tag == "joint":
            numbers = node.numbers("polycoef", len(node.words("polycoef", "0 1")), "0 1")
            offset, multiplier = (*numbers, 0.0, 0.0)[:2]
            notes.mimics[attributes.get("joint1", "")] = Mimic(
                attributes.get("joint2", ""), multiplier, offset
            )
        elif node.tag in ("connect", "weld"):
            ends = [
                attributes.get(f"body{k}") or sites.get(attributes.get(f"site{k}", ""), "world")
                for k in (1, 2)
            ]
            notes.loops.append((ends[0], ends[1], node.where))


def _limit_efforts(root: Node, model: Any) -> None:
    """Limit a joint's effort to its actuator's, if stated there or in its class."""
    limits, classes = model.effortLimit, dict[str, Node]()
    for default in root.all("default"):
        _note_classes(default, {}, classes)
    for actuator in (child for part in root.all("actuator") for child in part.children):
        of_class = classes.get(f"{actuator.attributes.get('class', 'main')} {actuator.tag}")
        stated = actuator.attributes if of_class is None else of_class.attributes | actuator.attributes
        node = Node(actuator.tag, stated, actuator.where)
        name = node.attributes.get("joint", "")
        key = next((key for key in ("forcerange", "ctrlrange") if key in node.attributes), None)
        if key is None or (key == "ctrlrange" and node.tag != "motor") or not model.existJointName(name):
            continue
        at = model.idx_vs[model.getJointId(name)]
        gear = node.numbers("gear", max(1, len(node.words("gear", "1"))), "1")[0]
        most = max(abs(value) for value in node.numbers(key, 2)) * abs(gear)
        limits[at] = min(limits[at], most) if limits[at] > 0 else most
    model.effortLimit = limits


def _note_classes(default: Node, above: dict[str, dict[str, str]], classes: dict[str, Node]) -> None:
    """Collect the actuator defaults of every class, including those inherited from the outer class."""
    name, stated = default.attributes.get("class", "main"), dict(above)
    for node in default.children:
        if node.tag != "default":
            stated[node.tag] = stated.get(node.tag, {}) | node.attributes
    classes |= {f"{name} {tag}": Node(tag, attributes, default.where) for tag, attributes in stated.items()}
    for inner in default.all("default"):
        _note_classes(inner, stated, classes)


class _Bodies:
    """Bodies prepared for Pinocchio."""

    def __init__(self, notes: Notes, turn: float) -> None:
        self.notes = notes
        self.turn = turn  # full turn in the file's unit of angles
        self.references: dict[str, float] = {}  # values of joints in the file's pose
        self.sites: dict[str, str] = {}  # the body of each site
        self.shaped: list[str] = []  # bodies whose mass comes from primitive shapes

    def below(self, node: Node, name: str) -> list[Node]:
        """Bodies within a body, or within the world."""
        return [self._body(child, name) for child in node.all("body")]

    def turn_back(self, tree: Tree) -> None:
        """Place joints so that their variables have the reference values in the file's pose."""
        for joint in tree.joints:
            reference = self.references.get(joint.name)
            if reference is None:
                continue
            if joint.kind == "revolute":
                angle = reference * (2 * math.pi / self.turn)
                back = pin.SE3(straight(np.array(pin.exp3(-angle * joint.axis))), np.zeros(3))
            else:
                back = pin.SE3(np.eye(3), -reference * joint.axis)
            tree.model.jointPlacements[joint.index] = tree.model.jointPlacements[joint.index] * back

    def _body(self, node: Node, parent: str) -> Node:
        name = self.notes.name("link", node, f"body_{node.where.line}")
        self.notes.above[name] = parent
        for site in node.all("site"):
            self.sites[site.attributes.get("name", "")] = name
        if node.is_not_zero("gravcomp"):
            self._doubt(node, name, f"MuJoCo compensates the weight of body {name} (gravcomp); here not")
        joints = [self._joint(child, name) for child in node.all("joint", "freejoint")]
        within = [*self._inertia(node, name), *self.below(node, name)]
        pose = node.kept(("childclass",), {"name": name} | self._pose(node, name)).attributes
        # The first of several joints is next to the parent; each gets a body, the last the real one.
        body = Node("body", pose, node.where, [*joints[-1:], *within])
        for joint in reversed(joints[:-1]):
            body.attributes = {"name": body.attributes["name"]}
            moved = f"{name}:{joint.attributes['name']}"
            self.notes.lines["link", moved] = node.where
            body = Node("body", pose | {"name": moved}, node.where, [joint, body])
        return body

    def _doubt(self, node: Node, about: str, sentence: str) -> None:
        self.notes.doubts.append((about, f"{node.where}: {sentence}"))

    def _pose(self, node: Node, link: str) -> dict[str, Any]:
        """Position and orientation, cleaned."""
        right, pose = self.notes.right_angles, dict[str, Any]()
        for key in (key for key in _POSE if key in node.attributes):
            numbers, words = node.numbers(key, _POSE[key]), node.words(key)
            if key == "pos":
                pose[key] = " ".join(right.length(word, link) for word in words)
            elif key == "quat":
                if not any(numbers):
                    raise ArmError(f"the quat of {link} is 0", where=node.where, expected="a rotation")
                pose[key] = self._quaternion(np.array(numbers), words, link, node)
            elif key == "euler":
                pose[key] = " ".join(right.angle(word, link, node.where, self.turn) for word in words)
            elif key == "axisangle":
                axis = " ".join(map(repr, right.direction(numbers[:3], link).tolist()))
                pose[key] = f"{axis} {right.angle(words[3], link, node.where, self.turn)}"
            else:
                pose[key] = node.attributes[key]
        return pose

    def _quaternion(self, quaternion: FloatArray, words: list[str], link: str, node: Node) -> FloatArray:
        """Quaternion (w, x, y, z) of the cleaned rotation."""
        quaternion = quaternion / np.abs(quaternion).max()  # whose square might overflow
        w, x, y, z = quaternion / np.linalg.norm(quaternion)
        rotation = np.array(pin.Quaternion(w, x, y, z).toRotationMatrix())
        x, y, z, w = pin.Quaternion(
            self.notes.right_angles.rotation(rotation, words, link, node.where)
        ).coeffs()
        return np.array([w, x, y, z])

    def _inertia(self, node: Node, name: str) -> list[Node]:
        """Mass and inertia as stated, or else the shapes of the body."""
        inertial = node.first("inertial")
        if inertial is not None:
            inertial.numbers("mass", 1, least=0)
            for key, count in (("diaginertia", 3), ("fullinertia", 6)):
                if key in inertial.attributes:
                    inertial.numbers(key, count)
            return [inertial.kept(("mass", "diaginertia", "fullinertia"), self._pose(inertial, name))]
        geoms = node.all("geom")
        shapes = [geom for geom in geoms if not _is_mesh(geom)]
        if any(_is_mesh(geom) and geom.attributes.get("mass") != "0" for geom in geoms):
            unknown = f"body {name} states no <inertial>; the mass of its meshes is not known here"
            self._doubt(node, name, unknown)
        if shapes:
            self.shaped.append(name)
        return [geom.kept(_OF_GEOM) for geom in shapes]

    def _joint(self, node: Node, body: str) -> Node:
        name = self.notes.name("joint", node, f"{body}_joint")
        if node.tag == "freejoint":
            return Node("joint", {"name": name, "type": "free"}, node.where)
        added: dict[str, Any] = {"name": name}
        if "axis" in node.attributes:
            numbers = node.numbers("axis", 3)
            if not any(numbers):
                raise ArmError(f"joint {name} has no axis", where=node.where, found="0 0 0")
            added["axis"] = self.notes.right_angles.direction(numbers, body)
        if "ref" in node.attributes:
            (self.references[name],) = node.numbers("ref", 1)
        for key in ("stiffness", "springdamper"):
            if node.is_not_zero(key):
                self._doubt(node, name, f"joint {name} has a spring ({key}), which is ignored")
        unlimited = node.attributes.get("limited") == "false"  # which Pinocchio ignores
        return node.kept(tuple(key for key in _OF_JOINT if key != "range" or not unlimited), added)


def _is_mesh(geom: Node) -> bool:
    return "mesh" in geom.attributes or geom.attributes.get("type") in _WITHOUT_SHAPE
