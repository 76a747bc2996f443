"""Reads a robot from URDF: what Pinocchio passes over in silence is checked, right angles are made right.

Pinocchio sees links with their inertia and joints, nothing else: meshes, materials and simulators' tags are
never read.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gd_analyze.errors import ArmError
from gd_analyze.robots.tree import Mimic, Notes, Tree
from gd_analyze.robots.xml import Node, pinocchio_model

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_urdf(path: Path, root: Node) -> Tree:
    """Read a robot's URDF.

    Parameters
    ----------
    path
        The file, for messages and names.
    root
        Its <robot>.

    Raises
    ------
    ArmError
        If it is xacro that was not expanded, is no tree of links and joints, or holds an impossible number;
        the message names the line.
    """
    import pinocchio as pin

    _refuse_xacro(root)
    notes = Notes(path)
    links, joints = root.all("link"), root.all("joint")
    for node in links + joints:
        notes.name(node.tag, node)
    _refuse_loops(joints, notes)
    parts = [_link(node, notes) for node in links] + [_joint(node, notes) for node in joints]
    bare = Node("robot", {"name": "robot"}, root.where, parts)
    model = pinocchio_model(lambda: pin.buildModelFromXML(bare.text()), "URDF", path, notes.lines)
    notes.assumptions.append("URDF states no gravity; 9.81 m/s^2 act against z of the base.")
    name = root.attributes.get("name", "").strip() or path.stem
    return Tree(model, notes, name, "URDF", np.array([0.0, 0.0, -9.81]))


def _refuse_xacro(root: Node) -> None:
    for node in root.walk():
        macro = node.tag.startswith("xacro:")
        open_values = [v for v in node.attributes.values() if "${" in v or "$(arg" in v]
        if macro or (open_values and node.tag not in ("mesh", "texture")):
            raise ArmError(
                "the file is xacro that was not expanded",
                where=node.where,
                expected="URDF",
                found=f"<{node.tag}>" if macro else open_values[0],
                next_step="expand it first: `xacro robot.urdf.xacro > robot.urdf`",
            )


def _refuse_loops(joints: list[Node], notes: Notes) -> None:
    """Refuse links with two parents, and links that carry themselves; Pinocchio drops them in silence."""
    leads: dict[str, Node] = {}
    for joint in joints:
        child = _end(joint, "child")
        if child in leads:
            raise ArmError(
                f"link {child} closes a loop: it is the child of two joints",
                where=joint.where,
                expected="one joint that leads to each link",
                found=f"joints {leads[child].attributes['name']} and {joint.attributes['name']}",
                next_step="remove one of the joints, or the branch that closes the loop",
            )
        leads[child] = joint
        notes.above[child] = _end(joint, "parent")
    grounded: set[str] = set()
    for link in notes.above:
        way: list[str] = []
        while link in notes.above and link not in grounded:
            if link in way:
                raise ArmError(
                    f"link {link} closes a loop: it carries itself",
                    where=leads[link].where,
                    expected="a tree of links",
                    next_step="fix the parents of the joints",
                )
            way.append(link)
            link = notes.above[link]
        grounded.update(way)


def _end(joint: Node, which: str) -> str:
    """Parent or child link of a joint; "" where it has none, which Pinocchio refuses."""
    node = joint.first(which)
    return "" if node is None else node.attributes.get("link", "")


def _link(node: Node, notes: Notes) -> Node:
    """A link and its inertia, checked, and nothing else."""
    inertial = node.first("inertial")
    if inertial is None:
        return node.kept(("name",))
    name = node.attributes["name"]
    mass, inertia = inertial.first("mass"), inertial.first("inertia")
    if mass is None or inertia is None:
        raise ArmError(
            f"the inertial of link {name} lacks its " + ("mass" if mass is None else "inertia"),
            where=inertial.where,
            expected='<mass value="..."/> and <inertia ixx="..." .../>',
            next_step="add it, or remove the <inertial> of a link without mass",
        )
    value = mass.at_least_zero("value", f"the mass of link {name}")
    moments = {key: inertia.numbers(key, 1) for key in _INERTIA}
    if value == 0.0 and any(moment != [0.0] for moment in moments.values()):
        doubt = f"{inertia.where}: link {name} has inertia without mass; it counts as stated"
        notes.doubts.append((name, doubt))
    within = (_origin(inertial, name, notes), mass.kept((), {"value": value}), inertia.kept((), moments))
    return node.kept(("name",), {}, inertial.kept((), {}, *within))


def _origin(node: Node, link: str, notes: Notes) -> Node:
    """An element's <origin>, with right angles made right."""
    given = node.first("origin") or Node("origin", {}, node.where)
    right, cleaned = notes.right_angles, {}
    for key in ("xyz", "rpy"):
        given.numbers(key, 3, "0 0 0")
        words = given.attributes.get(key, "0 0 0").split()
        lengths = key == "xyz"
        cleaned[key] = " ".join(
            right.length(word, link) if lengths else right.angle(word, link, str(given.where))
            for word in words
        )
    return given.kept((), cleaned)


def _joint(node: Node, notes: Notes) -> Node:
    """A joint, checked; what acts on its motion is noted."""
    name, kind, child = node.attributes["name"], node.attributes.get("type", ""), _end(node, "child")
    ends = [end.kept(("link",)) for tag in ("parent", "child") for end in node.all(tag)]
    bare = node.kept(("name", "type"), {}, _origin(node, child, notes), *ends)
    if kind in ("fixed", "floating"):
        return bare
    limit = node.first("limit") or Node("limit", {}, node.where)
    stated = {key: limit.numbers(key, 1, "0") for key in ("lower", "upper")}
    if kind in ("revolute", "prismatic") and stated["lower"] == stated["upper"] == [0.0]:
        notes.unranged.append(name)
    for key in ("effort", "velocity"):
        stated[key] = [limit.at_least_zero(key, f"the {key} limit of joint {name}", "0")]
    bare.children += [_axis(node, name, child, notes), limit.kept((), stated)]
    dynamics = node.first("dynamics")
    if dynamics is not None:
        values = {key: dynamics.numbers(key, 1, "0") for key in ("damping", "friction")}
        bare.children.append(dynamics.kept((), values))
    mimic = node.first("mimic")
    if mimic is not None:
        multiplier, offset = mimic.numbers("multiplier", 1, "1")[0], mimic.numbers("offset", 1, "0")[0]
        notes.mimics[name] = Mimic(mimic.attributes.get("joint", ""), multiplier, offset)
    return bare


def _axis(node: Node, name: str, child: str, notes: Notes) -> Node:
    given = node.first("axis") or Node("axis", {}, node.where)
    numbers = given.numbers("xyz", 3, "1 0 0")
    if not any(numbers):
        what, next_step = f"joint {name} has no axis", "give the axis it turns about or slides along"
        raise ArmError(what, where=given.where, expected="a direction", found="0 0 0", next_step=next_step)
    return given.kept((), {"xyz": notes.right_angles.direction(numbers, child)})
