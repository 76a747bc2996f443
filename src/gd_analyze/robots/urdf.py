"""Read a robot from URDF: what Pinocchio ignores silently is checked, and right angles are made exact.

Pinocchio gets only links with inertia, and joints. Shapes are read for their outlines alone, simulators' tags
for joints that close loops, materials not at all.
"""

from __future__ import annotations

import difflib
from graphlib import CycleError, TopologicalSorter
from html import escape
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from gd_analyze.errors import ArmError
from gd_analyze.robots.outlines import outline
from gd_analyze.robots.text_file import Node, parsed_model
from gd_analyze.robots.tree import Mimic, Notes, Tie, Tree
from gd_analyze.text import number, number_in

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_urdf(path: Path, root: Node) -> Tree:
    """Read a <robot>; ArmError with the line if it is xacro, not a tree, or contains an impossible number."""
    for node in root.walk():
        unexpanded = [value for value in node.attributes.values() if "${" in value or "$(arg" in value]
        if node.tag.startswith("xacro:") or (unexpanded and node.tag not in ("mesh", "texture")):
            node_text = unexpanded[0] if unexpanded else f"<{node.tag}>"
            message, hint = "the file is unexpanded xacro", "`xacro robot.urdf.xacro > robot.urdf`"
            raise ArmError(message, where=node.where, found=node_text, next_step=hint)
    notes = Notes(path)
    links, joints = root.all("link"), root.all("joint")
    for node in links + joints:
        notes.name(node.tag, node)
    _refuse_undeclared_links(links, joints)
    _refuse_loops(joints, notes)
    _note_ties(root, notes)
    _note_motor_inertias(root, notes)
    parts = [_link(node, notes) for node in links] + [_joint(node, notes) for node in joints]
    bare = Node("robot", {"name": "robot"}, root.where, parts)
    model = parsed_model(lambda: pin.buildModelFromXML(bare.text()), path, notes.lines)
    notes.assumptions.append("URDF states no gravity; 9.81 m/s^2 along -z of the base are assumed.")
    name = root.attributes.get("name", "").strip() or path.stem
    return Tree(model, notes, name, "URDF", np.array([0.0, 0.0, -9.81]))


def _refuse_undeclared_links(links: list[Node], joints: list[Node]) -> None:
    """Refuse a joint between links that are not all in the file."""
    names = [node.attributes["name"] for node in links]
    for joint in joints:
        for end in ("parent", "child"):
            link = _end(joint, end)
            if link and link not in names:
                near = difflib.get_close_matches(link, names, n=1, cutoff=0.8)
                hint = f"name {near[0]}, or add" if near else "add"
                name = joint.attributes["name"]
                message = f"the {end} of joint {name} is a link that the file does not declare"
                next_step = f'{hint} <link name="{escape(link)}"/>'
                raise ArmError(message, where=joint.where, found=repr(link), next_step=next_step)


def _note_ties(root: Node, notes: Notes) -> None:
    """Note links that joints beside the tree hold together: simulators' own, and <loop_joint>."""
    for joint in (child for part in root.all("gazebo") for child in part.all("joint")):
        ends = tuple(node.content.strip() for node in joint.all("parent", "child"))
        notes.ties.append(Tie(f"links {' and '.join(ends)} close a loop", joint.where, links=ends))
    for joint in root.all("loop_joint"):
        ends = tuple(node.attributes.get("link", "") for node in joint.all("link1", "link2"))
        notes.ties.append(Tie(f"links {' and '.join(ends)} close a loop", joint.where, links=ends))


def _note_motor_inertias(root: Node, notes: Notes) -> None:
    """Note motors' inertias, which at the joint are larger by the square of the reduction."""
    for transmission in root.all("transmission"):
        inside = {node.tag.rpartition(":")[2]: node for node in transmission.walk()}
        values = [
            number_in(inside[tag].content or inside[tag].attributes.get("value", ""))
            if tag in inside
            else None
            for tag in ("motorInertia", "rotor_inertia", "mechanicalReduction", "gear_ratio")
        ]
        inertia, ratio = values[0] or values[1], values[2] or values[3]
        joint = transmission.first("joint")
        if inertia and joint is not None:
            at_joint = f"times the reduction squared is {number(inertia * (ratio or 1.0) ** 2)} kg m^2"
            text = f"a motor inertia of {number(inertia)} kg m^2 is not read; {at_joint} for --drive-inertia"
            notes.doubts.append((joint.attributes.get("name", ""), f"{transmission.where}: {text}"))


def _refuse_loops(joints: list[Node], notes: Notes) -> None:
    """Refuse links with two parents, and cycles of links; Pinocchio drops them silently."""
    leads: dict[str, Node] = {}
    for joint in joints:
        child = _end(joint, "child")
        if child in leads:
            joint_text = f"joints {leads[child].attributes['name']} and {joint.attributes['name']}"
            message = f"link {child} closes a loop: it is the child of two joints"
            raise ArmError(message, where=joint.where, found=joint_text, next_step="remove one of the joints")
        leads[child] = joint
        notes.above[child] = _end(joint, "parent")
    try:
        TopologicalSorter({child: [parent] for child, parent in notes.above.items()}).prepare()
    except CycleError as error:
        link = error.args[1][0]
        message, next_step = f"link {link} closes a loop: it is its own ancestor", "fix the joints' parents"
        raise ArmError(message, where=leads[link].where, next_step=next_step) from None


def _end(joint: Node, end: str) -> str:
    """Parent or child link of a joint; "" if it has none, which Pinocchio refuses."""
    node = joint.first(end)
    return "" if node is None else node.attributes.get("link", "")


def _link(node: Node, notes: Notes) -> Node:
    """A link and its inertia, checked, and nothing else."""
    inertial = node.first("inertial")
    if inertial is None:
        return node.kept(("name",))
    name = node.attributes["name"]
    mass, inertia = inertial.first("mass"), inertial.first("inertia")
    if mass is None or inertia is None:
        message = f"the inertial of link {name} lacks its <{'mass' if mass is None else 'inertia'}>"
        hint = "add it, or remove the <inertial> of a link without mass"
        raise ArmError(message, where=inertial.where, next_step=hint)
    (value,) = mass.numbers("value", 1, least=0)
    moments = {key: inertia.numbers(key, 1) for key in _INERTIA}
    if value == 0.0 and any(moment != [0.0] for moment in moments.values()):
        doubt = f"{inertia.where}: link {name} has inertia without mass; it is used as stated"
        notes.doubts.append((name, doubt))
    if value == 1.0 and [moments[key] for key in ("ixx", "iyy", "izz")] == [[1.0]] * 3:
        doubt = f"{inertia.where}: link {name} has exporters' defaults, 1 kg and 1 kg m^2; state real values"
        notes.doubts.append((name, doubt))
    origin = _origin(inertial, name, notes)
    box = outline(node, Path(notes.path))
    if box is not None:
        com = np.array(origin.numbers("xyz", 3))
        trace = sum(moments[key][0] for key in ("ixx", "iyy", "izz"))
        for contradiction in box.contradictions(value, com, trace):
            notes.doubts.append((name, f"{inertial.where}: link {name}: {contradiction}"))
    within = (origin, mass.kept((), {"value": value}), inertia.kept((), moments))
    return node.kept(("name",), {}, inertial.kept((), {}, *within))


def _origin(node: Node, link: str, notes: Notes) -> Node:
    """An element's <origin>, with right angles made exact."""
    origin, right = node.first("origin") or Node("origin", {}, node.where), notes.right_angles
    for key in ("xyz", "rpy"):
        origin.numbers(key, 3, "0 0 0")
    lengths = (right.length(word, link) for word in origin.words("xyz", "0 0 0"))
    angles = (right.angle(word, link, origin.where) for word in origin.words("rpy", "0 0 0"))
    return origin.kept((), {"xyz": " ".join(lengths), "rpy": " ".join(angles)})


def _joint(node: Node, notes: Notes) -> Node:
    """A joint, checked; mimicking and doubts are noted."""
    name, kind, child = node.attributes["name"], node.attributes.get("type", ""), _end(node, "child")
    ends = [end.kept(("link",)) for end in node.all("parent", "child")]
    bare = node.kept(("name", "type"), {}, _origin(node, child, notes), *ends)
    if kind in ("fixed", "floating"):
        return bare
    axis = node.first("axis") or Node("axis", {}, node.where)
    direction = axis.numbers("xyz", 3, "1 0 0")
    if not any(direction):
        next_step = "give the axis of rotation or translation"
        raise ArmError(f"joint {name} has no axis", where=axis.where, found="0 0 0", next_step=next_step)
    limit = node.first("limit") or Node("limit", {}, node.where)
    stated = {key: limit.numbers(key, 1, "0") for key in ("lower", "upper")}
    if kind in ("revolute", "prismatic") and stated["lower"] == stated["upper"] == [0.0]:
        notes.tell("no range stated for joint", name, limit.where)
    stated |= {key: limit.numbers(key, 1, "0", least=0) for key in ("effort", "velocity")}
    along = axis.kept((), {"xyz": notes.right_angles.direction(direction, child)})
    bare.children += [along, limit.kept((), stated)]
    for dynamics in node.all("dynamics")[:1]:
        values = {key: dynamics.numbers(key, 1, "0") for key in ("damping", "friction")}
        bare.children.append(dynamics.kept((), values))
    for mimic in node.all("mimic")[:1]:
        (multiplier,), (offset,) = mimic.numbers("multiplier", 1, "1"), mimic.numbers("offset", 1, "0")
        notes.mimics[name] = Mimic(mimic.attributes.get("joint", ""), Polynomial([offset, multiplier]))
    return bare
