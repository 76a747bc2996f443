"""Reads a robot from MuJoCo's MJCF: what Pinocchio's reader passes over is read here, or refused by name.

Pinocchio sees the compiler's settings, defaults of joints and shapes, and the bodies with their joints and
inertias: named, one joint each, right angles exact, no meshes. It knows no gravity but 9.81 along z, mistakes
reference values, and joins several joints of a body into one, so that these are taken from the text.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.right_angles import straight
from gd_analyze.robots.tree import Mimic, Notes, Tree
from gd_analyze.robots.xml import Node, pinocchio_model

_EXPANDED_BY_MUJOCO = ("include", "frame", "replicate", "attach", "composite", "flexcomp")
_OF_COMPILER = ("angle", "eulerseq", "autolimits")
_CHANGES_MASS = ("settotalmass", "boundmass", "boundinertia", "inertiafromgeom")
_POSE = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_OF_INERTIAL = ("mass", "diaginertia", "fullinertia")
_OF_JOINT = ("type", "pos", "range", "limited", "armature", "damping", "frictionloss", "class",
             "actuatorfrcrange")  # fmt: skip
_OF_GEOM = ("class", "type", "size", "mass", "density", "fromto", "pos", *_POSE, "shellinertia")
_WITHOUT_SHAPE = ("mesh", "hfield", "plane", "sdf")
_MOST_NAMED = 8


def read_mjcf(path: Path, root: Node) -> Tree:
    """Read a robot's MJCF.

    Parameters
    ----------
    path
        The file, for messages and names.
    root
        Its <mujoco>.

    Raises
    ------
    ArmError
        If it uses what only MuJoCo itself can expand, or describes no possible robot.
    """
    import pinocchio as pin

    _refuse_unexpanded(root)
    world = root.first("worldbody")
    if world is None:
        raise ArmError(
            "the file describes no bodies",
            where=root.where,
            expected="a <worldbody>",
            next_step="name the robot's own file, not that of a scene or of defaults",
        )
    compilers, notes = root.all("compiler"), Notes(path)
    in_degrees = all(node.attributes.get("angle", "degree") == "degree" for node in compilers)
    bodies = _Bodies(notes, 360.0 if in_degrees else 2 * math.pi)
    bare = Node("mujoco", {"model": "robot"}, root.where)
    bare.children = [node.kept(_OF_COMPILER) for node in compilers]
    bare.children += [_defaults(node) for node in root.all("default")]
    bare.children.append(world.kept((), {}, *_placed_roots(bodies.below(world))))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "robot.xml"
        copy.write_text(bare.text(), encoding="utf-8")
        model = pinocchio_model(lambda: pin.buildModelFromMJCF(str(copy)), "MJCF", path, notes.lines)
    gravity = [0.0, 0.0, -9.81]
    for option in root.all("option"):
        if "gravity" in option.attributes:
            gravity = option.numbers("gravity", 3)
    name = root.attributes.get("model", "").strip() or path.stem
    tree = Tree(model, notes, name, "MJCF", np.array(gravity))
    bodies.turn_back(tree)
    _note_equalities(root, bodies.sites, notes)
    _note_compiler(root, notes)
    _limit_efforts(root, model)
    if bodies.shaped:
        more = f" and {len(bodies.shaped) - _MOST_NAMED} more" if len(bodies.shaped) > _MOST_NAMED else ""
        names = ", ".join(bodies.shaped[:_MOST_NAMED])
        notes.assumptions.append(
            f"Mass and inertia from primitive shapes, as none are stated: {names}{more}."
        )
    return tree


def _refuse_unexpanded(root: Node) -> None:
    for node in root.walk():
        if node.tag in _EXPANDED_BY_MUJOCO:
            raise ArmError(
                f"the file uses <{node.tag}>, which is not read",
                where=node.where,
                expected="MJCF in one file, with its bodies written out",
                next_step='let MuJoCo write it out: set <compiler saveinertial="true"/>, load the file, and '
                "call mujoco.mj_saveLastXML('robot.xml', model)",
            )


def _placed_roots(roots: list[Node]) -> list[Node]:
    """Bodies of the world, fixed ones within one more body: Pinocchio drops the pose of the first body."""
    floating = [body for body in roots if any(one.attributes.get("type") == "free" for one in body.children)]
    fixed = [body for body in roots if body not in floating]
    is_placed = any(key in body.attributes for body in fixed for key in ("pos", *_POSE))
    return [Node("body", {"name": "world"}, fixed[0].where, fixed), *floating] if is_placed else roots


def _defaults(node: Node) -> Node:
    """Defaults of joints and shapes; ArmError if one moves every joint of a class."""
    for joint in node.all("joint"):
        if joint.is_not_zero("ref"):
            what, expected = "a default gives joints a reference value", "ref at the joints themselves"
            raise ArmError(what, where=joint.where, expected=expected, next_step="write it there")
    inside = [child.kept(_OF_GEOM) for child in node.all("geom")]
    inside += [child.kept((*_OF_JOINT, "axis")) for child in node.all("joint")]
    return node.kept(("class",), {}, *inside, *(_defaults(child) for child in node.all("default")))


def _note_compiler(root: Node, notes: Notes) -> None:
    """Doubt settings that change masses in MuJoCo, and do not here."""
    for node in root.all("compiler"):
        for key in _CHANGES_MASS:
            value = node.attributes.get(key, "0")
            if value not in ("0", "-1", "false", "auto"):
                doubt = f"{node.where}: <compiler {key}={value!r}> changes masses in MuJoCo, but not here"
                notes.doubts.append(("", doubt))


def _note_equalities(root: Node, sites: dict[str, str], notes: Notes) -> None:
    """Note joints that follow others, and bodies held together beside the tree."""
    for node in (child for part in root.all("equality") for child in part.children):
        given = node.attributes
        if given.get("active") == "false":
            continue
        if node.tag == "joint":
            numbers = node.numbers("polycoef", len(given.get("polycoef", "0 1").split()), "0 1")
            offset, multiplier = (*numbers, 0.0, 0.0)[:2]
            notes.mimics[given.get("joint1", "")] = Mimic(given.get("joint2", ""), multiplier, offset)
        elif node.tag in ("connect", "weld"):
            ends = [given.get(f"body{k}") or sites.get(given.get(f"site{k}", ""), "world") for k in (1, 2)]
            notes.loops.append((ends[0], ends[1], node.where))


def _limit_efforts(root: Node, model: Any) -> None:
    """Limit a joint's effort to what its actuator gives, where that is stated at the actuator."""
    for node in (child for part in root.all("actuator") for child in part.children):
        name = node.attributes.get("joint", "")
        key = next((key for key in ("forcerange", "ctrlrange") if key in node.attributes), None)
        if key is None or (key == "ctrlrange" and node.tag != "motor") or not model.existJointName(name):
            continue
        at = model.idx_vs[model.getJointId(name)]
        gear = node.numbers("gear", max(1, len(node.attributes.get("gear", "1").split())), "1")[0]
        most = max(abs(value) for value in node.numbers(key, 2)) * abs(gear)
        limits = model.effortLimit
        limits[at] = min(limits[at], most) if limits[at] > 0 else most
        model.effortLimit = limits


@dataclass
class _Bodies:
    """Bodies on their way to Pinocchio.

    `turn` is a full turn in the file's unit of angles, `references` the values of joints in the pose that is
    written down, `sites` the body of each site, `shaped` the bodies whose mass comes from primitive shapes.
    """

    notes: Notes
    turn: float
    references: dict[str, float] = field(default_factory=dict)
    sites: dict[str, str] = field(default_factory=dict)
    shaped: list[str] = field(default_factory=list)

    def below(self, node: Node, name: str = "world") -> list[Node]:
        """Bodies within a body, or within the world."""
        return [self._body(child, name) for child in node.all("body")]

    def turn_back(self, tree: Tree) -> None:
        """Place joints so that their variables have the reference values in the pose that is written down."""
        import pinocchio as pin

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
            doubt = f"{node.where}: MuJoCo compensates the weight of body {name} (gravcomp); here not"
            self.notes.doubts.append((name, doubt))
        joints = [self._joint(child, name) for child in node.children if child.tag in ("joint", "freejoint")]
        within = [*self._inertia(node, name), *self.below(node, name)]
        pose = node.kept(("childclass",), {"name": name} | self._pose(node, name)).attributes
        # The first of several joints is next to the parent; each gets a body, the last one the real body.
        body = Node("body", pose, node.where, [*joints[-1:], *within])
        for joint in reversed(joints[:-1]):
            body.attributes = {"name": body.attributes["name"]}
            moved = f"{name}:{joint.attributes['name']}"
            self.notes.lines["link", moved] = node.where
            body = Node("body", pose | {"name": moved}, node.where, [joint, body])
        return body

    def _pose(self, node: Node, link: str) -> dict[str, Any]:
        """Position and orientation, cleaned."""
        right, where, found = self.notes.right_angles, str(node.where), dict[str, Any]()
        for key, count in (
            ("pos", 3),
            ("quat", 4),
            ("euler", 3),
            ("axisangle", 4),
            ("xyaxes", 6),
            ("zaxis", 3),
        ):
            if key not in node.attributes:
                continue
            numbers, texts = node.numbers(key, count), node.attributes[key].split()
            if key == "pos":
                found[key] = " ".join(right.length(text, link) for text in texts)
            elif key == "quat":
                if not any(numbers):
                    raise ArmError(f"the quat of {link} is 0", where=node.where, expected="a rotation")
                found[key] = self._quaternion(np.array(numbers), link)
            elif key == "euler":
                found[key] = " ".join(right.angle(text, link, where, self.turn) for text in texts)
            elif key == "axisangle":
                axis = " ".join(repr(float(x)) for x in right.direction(numbers[:3], link))
                found[key] = f"{axis} {right.angle(texts[3], link, where, self.turn)}"
            else:
                found[key] = node.attributes[key]
        return found

    def _quaternion(self, quaternion: FloatArray, link: str) -> FloatArray:
        """Quaternion (w, x, y, z) of the cleaned rotation."""
        import pinocchio as pin

        quaternion = quaternion / np.abs(quaternion).max()  # whose square might overflow
        w, x, y, z = quaternion / np.linalg.norm(quaternion)
        rotation = np.array(pin.Quaternion(w, x, y, z).toRotationMatrix())
        x, y, z, w = pin.Quaternion(self.notes.right_angles.rotation(rotation, link)).coeffs()
        return np.array([w, x, y, z])

    def _inertia(self, node: Node, name: str) -> list[Node]:
        """Mass and inertia as stated, or else the shapes that the body is made of."""
        inertial = node.first("inertial")
        if inertial is not None:
            inertial.at_least_zero("mass", f"the mass of body {name}")
            for key, count in (("diaginertia", 3), ("fullinertia", 6)):
                if key in inertial.attributes:
                    inertial.numbers(key, count)
            return [inertial.kept(_OF_INERTIAL, self._pose(inertial, name))]
        geoms = node.all("geom")
        shapes = [geom for geom in geoms if not _is_mesh(geom)]
        if any(_is_mesh(geom) and geom.attributes.get("mass") != "0" for geom in geoms):
            doubt = (
                f"{node.where}: body {name} states no <inertial>; the mass of its meshes is not known here"
            )
            self.notes.doubts.append((name, doubt))
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
                doubt = f"{node.where}: joint {name} has a spring ({key}), which is not counted"
                self.notes.doubts.append((name, doubt))
        unlimited = node.attributes.get("limited") == "false"  # which Pinocchio passes over
        return node.kept(tuple(key for key in _OF_JOINT if key != "range" or not unlimited), added)


def _is_mesh(geom: Node) -> bool:
    return "mesh" in geom.attributes or geom.attributes.get("type") in _WITHOUT_SHAPE
