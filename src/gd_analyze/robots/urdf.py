"""Reads a robot from URDF: checked element by element, right angles made right, then given to Pinocchio.

Pinocchio sees links with their inertia and joints, nothing else: meshes, materials and simulators' tags are
never read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.quiet_parser import parsed
from gd_analyze.robots.right_angles import Straightened
from gd_analyze.robots.tree import Limits, Mimic, Tree, identifier, joints_of, title_of
from gd_analyze.robots.urdf_structure import end_of, name_of, refuse_xacro, require_tree
from gd_analyze.robots.xml_nodes import Node
from gd_analyze.text import visible

_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass
class _Reading:
    """What is found out on the way through a file."""

    straightened: Straightened = field(default_factory=Straightened)
    lines: dict[tuple[str, str], Location] = field(default_factory=dict)
    mimics: dict[str, Mimic] = field(default_factory=dict)
    limits: dict[str, Limits] = field(default_factory=dict)
    above: dict[str, str] = field(default_factory=dict)


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

    refuse_xacro(root)
    links, joints, reading = root.all("link"), root.all("joint"), _Reading()
    for what, nodes in (("link", links), ("joint", joints)):
        for node in nodes:
            name = name_of(node)
            if (what, name) in reading.lines:
                raise ArmError(
                    f"there are two {what}s {name!r}",
                    where=node.where,
                    expected=f"another name than the {what} in line {reading.lines[what, name].line}",
                    next_step="rename one, and what refers to it",
                )
            reading.lines[what, name] = node.where
    require_tree(root, links, joints)
    name = root.attributes.get("name", "").strip() or path.stem
    bare = Node("robot", {"name": "robot"}, root.where)
    bare.children = [_link(node, reading) for node in links] + [_joint(node, reading) for node in joints]
    model = parsed(lambda: pin.buildModelFromXML(bare.text()), Location(path), "URDF")
    return _tree(path, name, model, reading)


def _tree(path: Path, name: str, model: Any, reading: _Reading) -> Tree:
    import pinocchio as pin

    tree_joints, tree_links = joints_of(model, reading.mimics)
    has_mass = any(inertia.mass > 0 for inertia in model.inertias)
    massless = f"{path}: no link has any mass; is the file stripped, or xacro that was expanded in part?"
    return Tree(
        model=model,
        name=identifier(name, path.stem),
        title=title_of(name),
        convention="placements from URDF",
        where=visible(str(path)),
        joints=tree_joints,
        links=tree_links,
        gravity=np.array([0.0, 0.0, -9.81]),
        lines=reading.lines,
        mimics=reading.mimics,
        limits=reading.limits,
        sources=(f"{visible(path.name)}: URDF, read by Pinocchio {pin.__version__}.",),
        assumptions=("URDF states no gravity; 9.81 m/s^2 act against z of the base.",),
        doubts=() if has_mass else (("", massless),),
        straightened=reading.straightened,
        above=reading.above,
    )


def _link(node: Node, reading: _Reading) -> Node:
    """Take a link and its inertia, checked, and nothing else."""
    name = name_of(node)
    bare = Node("link", {"name": name}, node.where)
    inertial = node.first("inertial")
    if inertial is None:
        return bare
    kept = Node("inertial", {}, inertial.where)
    mass_node, inertia_node = inertial.first("mass"), inertial.first("inertia")
    if mass_node is None or inertia_node is None:
        raise ArmError(
            f"the inertial of link {name} lacks its " + ("mass" if mass_node is None else "inertia"),
            where=inertial.where,
            expected='<mass value="..."/> and <inertia ixx="..." .../>',
            next_step="add it, or remove the <inertial> of a link without mass",
        )
    (mass,) = mass_node.numbers("value", 1)
    if mass < 0:
        raise ArmError(
            f"the mass of link {name} is negative",
            where=mass_node.where,
            expected="0 or more",
            found=f"{mass:g} kg",
            next_step="mend the mass",
        )
    moments = {key: repr(inertia_node.numbers(key, 1)[0]) for key in _INERTIA}
    kept.children = [
        _origin(inertial, name, reading),
        Node("mass", {"value": repr(mass)}, mass_node.where),
        Node("inertia", moments, inertia_node.where),
    ]
    bare.children = [kept]
    return bare


def _origin(node: Node, link: str, reading: _Reading) -> Node:
    """Take an element's <origin>, with right angles made right."""
    given = node.first("origin") or Node("origin", {}, node.where)
    straight, place = reading.straightened, str(given.where)
    for key in ("xyz", "rpy"):
        given.numbers(key, 3, "0 0 0")
    xyz = [straight.length(text, link) for text in given.attributes.get("xyz", "0 0 0").split()]
    rpy = [straight.angle(text, link, place) for text in given.attributes.get("rpy", "0 0 0").split()]
    return Node("origin", {"xyz": " ".join(xyz), "rpy": " ".join(rpy)}, given.where)


def _joint(node: Node, reading: _Reading) -> Node:
    """Take a joint, checked; what acts on its motion is noted."""
    name, kind = name_of(node), node.attributes.get("type", "")
    if kind not in _KINDS:
        raise ArmError(
            f"joint {name} is of an unknown type",
            where=node.where,
            expected=", ".join(_KINDS),
            found=repr(kind),
            next_step="mend its type",
        )
    bare = Node("joint", {"name": name, "type": kind}, node.where)
    ends = [Node(end, {"link": end_of(node, end)}, node.where) for end in ("parent", "child")]
    child = end_of(node, "child")
    reading.above[child] = end_of(node, "parent")
    bare.children = [_origin(node, child, reading), *ends]
    if kind in ("fixed", "floating"):
        return bare
    bare.children += [_axis(node, reading), *_dynamics(node)]
    limit = node.first("limit") or Node("limit", {}, node.where)
    stated = {key: limit.numbers(key, 1, "0")[0] for key in ("lower", "upper", "effort", "velocity")}
    for key in ("effort", "velocity"):
        if stated[key] < 0:
            raise ArmError(
                f"the {key} limit of joint {name} is negative",
                where=limit.where,
                expected="a positive number, or 0 where it is unknown",
                found=f"{stated[key]:g}",
                next_step="mend the limit",
            )
    bare.children.append(Node("limit", {key: repr(value) for key, value in stated.items()}, limit.where))
    lower, upper = stated["lower"], stated["upper"]
    has_range = kind in ("revolute", "prismatic") and (lower, upper) != (0.0, 0.0)
    unranged = ""
    if kind in ("revolute", "prismatic") and not has_range:
        states_it = "lower" in limit.attributes or "upper" in limit.attributes
        unranged = "a range of 0 .. 0" if states_it else "no range"
    reading.limits[name] = Limits(
        lower if has_range else None, upper if has_range else None, stated["velocity"] or None, unranged
    )
    _note_mimic(node, name, reading)
    return bare


def _axis(node: Node, reading: _Reading) -> Node:
    given = node.first("axis") or Node("axis", {}, node.where)
    numbers = given.numbers("xyz", 3, "1 0 0")
    if not any(numbers):
        raise ArmError(
            f"joint {name_of(node)} has no axis",
            where=given.where,
            expected="a direction",
            found="0 0 0",
            next_step="give the axis it turns about or slides along",
        )
    axis = reading.straightened.direction(numbers, end_of(node, "child"))
    return Node("axis", {"xyz": " ".join(repr(float(x)) for x in axis)}, given.where)


def _dynamics(node: Node) -> list[Node]:
    given = node.first("dynamics")
    if given is None:
        return []
    values = {key: repr(given.numbers(key, 1, "0")[0]) for key in ("damping", "friction")}
    return [Node("dynamics", values, given.where)]


def _note_mimic(node: Node, name: str, reading: _Reading) -> None:
    mimic = node.first("mimic")
    if mimic is not None:
        reading.mimics[name] = Mimic(
            mimic.attributes.get("joint", ""),
            mimic.numbers("multiplier", 1, "1")[0],
            mimic.numbers("offset", 1, "0")[0],
        )
