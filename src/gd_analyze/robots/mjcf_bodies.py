"""MJCF's bodies as Pinocchio shall see them: named, one joint each, right angles exact, no meshes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.right_angles import Straightened
from gd_analyze.robots.xml_nodes import Node
from gd_analyze.text import visible

_POSE = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_OF_INERTIAL = ("mass", "diaginertia", "fullinertia")
_OF_JOINT = ("type", "pos", "range", "limited", "armature", "damping", "frictionloss", "class",
             "actuatorfrcrange")  # fmt: skip
_OF_GEOM = ("class", "type", "size", "mass", "density", "fromto", "pos", *_POSE, "shellinertia")
_WITHOUT_SHAPE = ("mesh", "hfield", "plane", "sdf")


@dataclass
class Bodies:
    """What is found out on the way through the bodies.

    Parameters
    ----------
    turn
        A full turn in the file's unit of angles.
    lines
        Where each ("joint" or "link", name) stands.
    references
        Values of joints in the pose that is written down, where not 0, in the file's units.
    sites
        The body that each site belongs to.
    shaped
        Bodies whose mass comes from primitive shapes.
    above
        The body that each body is in.
    doubts
        Sentences and the joint or link that each is about.
    """

    turn: float
    straightened: Straightened = field(default_factory=Straightened)
    lines: dict[tuple[str, str], Location] = field(default_factory=dict)
    references: dict[str, float] = field(default_factory=dict)
    sites: dict[str, str] = field(default_factory=dict)
    shaped: list[str] = field(default_factory=list)
    above: dict[str, str] = field(default_factory=dict)
    doubts: list[tuple[str, str]] = field(default_factory=list)

    def below(self, node: Node, name: str = "world") -> list[Node]:
        """Bodies within a body, or within the world."""
        return [self._body(child, name) for child in node.all("body")]

    def _named(self, node: Node, what: str, otherwise: str) -> str:
        """Name of a body or joint, or one that is made up."""
        name = node.attributes.get("name") or otherwise
        if visible(name) != name:
            raise ArmError(
                f"the name of a {node.tag} holds signs that do not show",
                where=node.where,
                found=visible(name),
                next_step="retype the name",
            )
        while (what, name) in self.lines and "name" not in node.attributes:
            name += "_"
        if (what, name) in self.lines:
            raise ArmError(
                f"there are two {'bodies' if what == 'link' else 'joints'} {name!r}",
                where=node.where,
                expected=f"another name than in line {self.lines[what, name].line}",
                next_step="rename one",
            )
        self.lines[what, name] = node.where
        return name

    def _body(self, node: Node, parent: str) -> Node:
        name = self._named(node, "link", f"body_{node.where.line}")
        self.above[name] = parent
        for site in node.all("site"):
            self.sites[site.attributes.get("name", "")] = name
        if node.is_not_zero("gravcomp"):
            self.doubts.append(
                (name, f"{node.where}: MuJoCo takes weight off body {name} (gravcomp); here not")
            )
        joints = [self._joint(child, name) for child in node.children if child.tag in ("joint", "freejoint")]
        within = [*self._inertia(node, name), *self.below(node, name)]
        kept = {"name": name} | self._pose(node, name)
        if "childclass" in node.attributes:
            kept["childclass"] = node.attributes["childclass"]
        # The first of several joints is next to the parent; each gets a body, the last one the real body.
        before, last = joints[:-1], joints[-1:]
        body = Node("body", kept, node.where, [*last, *within])
        for joint in reversed(before):
            inner, pose = {"name": body.attributes["name"]}, body.attributes
            body.attributes = inner
            moved = f"{name}:{joint.attributes['name']}"
            self.lines["link", moved] = node.where
            body = Node("body", pose | {"name": moved}, node.where, [joint, body])
        return body

    def _pose(self, node: Node, link: str) -> dict[str, str]:
        """Position and orientation, cleaned."""
        straight, found = self.straightened, {}
        if "pos" in node.attributes:
            node.numbers("pos", 3)
            found["pos"] = " ".join(straight.length(text, link) for text in node.attributes["pos"].split())
        if "quat" in node.attributes:
            quaternion = np.array(node.numbers("quat", 4))
            if not quaternion.any():
                raise ArmError(f"the quat of {link} is 0", where=node.where, expected="a rotation")
            found["quat"] = " ".join(repr(float(x)) for x in self._quaternion(quaternion, link))
        if "euler" in node.attributes:
            node.numbers("euler", 3)
            texts, place = node.attributes["euler"].split(), str(node.where)
            found["euler"] = " ".join(straight.angle(text, link, place, self.turn) for text in texts)
        if "axisangle" in node.attributes:
            numbers = node.numbers("axisangle", 4)
            axis = " ".join(repr(float(x)) for x in straight.direction(numbers[:3], link))
            angle = node.attributes["axisangle"].split()[3]
            found["axisangle"] = f"{axis} {straight.angle(angle, link, str(node.where), self.turn)}"
        for key, count in (("xyaxes", 6), ("zaxis", 3)):
            if key in node.attributes:
                node.numbers(key, count)
                found[key] = node.attributes[key]
        return found

    def _quaternion(self, quaternion: FloatArray, link: str) -> FloatArray:
        """Quaternion (w, x, y, z) of the cleaned rotation."""
        import pinocchio as pin

        quaternion = quaternion / np.abs(quaternion).max()  # whose square might overflow
        w, x, y, z = quaternion / np.linalg.norm(quaternion)
        rotation = np.array(pin.Quaternion(w, x, y, z).toRotationMatrix())
        x, y, z, w = pin.Quaternion(self.straightened.rotation(rotation, link)).coeffs()
        return np.array([w, x, y, z])

    def _inertia(self, node: Node, name: str) -> list[Node]:
        """What a body is stated to weigh; else the shapes it is made of."""
        inertial = node.first("inertial")
        if inertial is not None:
            (mass,) = inertial.numbers("mass", 1)
            if mass < 0:
                raise ArmError(
                    f"the mass of body {name} is negative",
                    where=inertial.where,
                    expected="0 or more",
                    found=f"{mass:g} kg",
                    next_step="mend the mass",
                )
            for key, count in (("diaginertia", 3), ("fullinertia", 6)):
                if key in inertial.attributes:
                    inertial.numbers(key, count)
            return [kept(inertial, _OF_INERTIAL, self._pose(inertial, name))]
        geoms = node.all("geom")
        shapes = [geom for geom in geoms if not _is_mesh(geom)]
        if any(_is_mesh(geom) and geom.attributes.get("mass") != "0" for geom in geoms):
            told = f"{node.where}: body {name} states no <inertial>; the mass of its meshes is not known here"
            self.doubts.append((name, told))
        if shapes:
            self.shaped.append(name)
        return [kept(geom, _OF_GEOM) for geom in shapes]

    def _joint(self, node: Node, body: str) -> Node:
        name = self._named(node, "joint", f"{body}_joint")
        if node.tag == "freejoint":
            return Node("joint", {"name": name, "type": "free"}, node.where)
        added = {"name": name}
        if "axis" in node.attributes:
            numbers = node.numbers("axis", 3)
            if not any(numbers):
                raise ArmError(f"joint {name} has no axis", where=node.where, found="0 0 0")
            axis = self.straightened.direction(numbers, body)
            added["axis"] = " ".join(repr(float(x)) for x in axis)
        if "ref" in node.attributes:
            (self.references[name],) = node.numbers("ref", 1)
        for key, what in (("stiffness", "a spring"), ("springdamper", "a spring")):
            if node.is_not_zero(key):
                self.doubts.append(
                    (name, f"{node.where}: joint {name} has {what} ({key}), which is not counted")
                )
        unlimited = node.attributes.get("limited") == "false"  # which Pinocchio passes over
        return kept(node, tuple(key for key in _OF_JOINT if key != "range" or not unlimited), added)


def defaults(node: Node) -> Node:
    """Take defaults of joints and shapes.

    Raises
    ------
    ArmError
        If a default turns every joint of a class.
    """
    for joint in node.all("joint"):
        if joint.is_not_zero("ref"):
            raise ArmError(
                "a default gives joints a reference value",
                where=joint.where,
                expected="ref at the joints themselves",
                next_step="write it there",
            )
    inside = [kept(child, _OF_GEOM) for child in node.all("geom")]
    inside += [kept(child, (*_OF_JOINT, "axis")) for child in node.all("joint")]
    inside += [defaults(child) for child in node.all("default")]
    return kept(node, ("class",), within=inside)


def kept(node: Node, keys: tuple[str, ...], added: dict[str, str] | None = None,
         within: list[Node] | None = None) -> Node:  # fmt: skip
    """Take an element with some of its attributes, and others in the place of theirs."""
    stated = {key: value for key, value in node.attributes.items() if key in keys}
    return Node(node.tag, stated | (added or {}), node.where, within or [])


def _is_mesh(geom: Node) -> bool:
    return "mesh" in geom.attributes or geom.attributes.get("type") in _WITHOUT_SHAPE
