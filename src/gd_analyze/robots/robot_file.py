"""Robots from files and values that hold a tree: URDF, MJCF and Pinocchio's own models."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError
from gd_analyze.robots.mjcf import read_mjcf
from gd_analyze.robots.tree import Tree, identifier, joints_of, limits_of, title_of
from gd_analyze.robots.urdf import read_urdf
from gd_analyze.robots.xml_nodes import read_nodes, text_of_xml

# Humanoids with both hands have 200.
_MOST_LINKS = 2000
_SUFFIXES = (".urdf", ".xml", ".mjcf", ".xacro", ".sdf")


def is_xml(path: Path) -> bool:
    """Whether a file is meant to be XML, by its suffix or its first sign."""
    if path.suffix.lower() in _SUFFIXES:
        return True
    try:
        with path.open("rb") as file:
            start = file.read(512)
    except OSError:
        return False
    return start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<")


def read_tree(path: Path) -> Tree:
    """Read the tree of joints and links of an XML file.

    Raises
    ------
    ArmError
        If it is not XML, neither URDF nor MJCF, or no possible robot.
    """
    root = read_nodes(path, text_of_xml(path))
    links = sum(node.tag in ("link", "body") for node in root.walk())
    if links > _MOST_LINKS:
        raise ArmError(
            "the robot has more links than any",
            where=root.where,
            expected=f"at most {_MOST_LINKS}",
            found=str(links),
            next_step="name the file of the robot alone",
        )
    if root.tag == "robot":
        return read_urdf(path, root)
    if root.tag == "mujoco":
        return read_mjcf(path, root)
    raise ArmError(
        "the XML is no robot that is read",
        where=root.where,
        expected="<robot> (URDF) or <mujoco> (MJCF) as the outermost element",
        found=f"<{root.tag}>",
        next_step="convert it to URDF" + (", for which SDF has tools" if root.tag == "sdf" else ""),
    )


def is_pinocchio_model(given: object) -> bool:
    """Whether a value is a `pinocchio.Model`, without importing Pinocchio."""
    return type(given).__module__.partition(".")[0] == "pinocchio" and hasattr(given, "jointPlacements")


def tree_of_model(model: Any) -> Tree:
    """Take a Pinocchio model from memory, as it is."""
    import pinocchio as pin

    joints, links = joints_of(model)
    limits = {joint.name: limits_of(model, joint.index) for joint in joints if joint.moves_simply}
    return Tree(
        model=model,
        name=identifier(model.name, "robot"),
        title=title_of(model.name),
        convention="placements from a Pinocchio model",
        where="the Pinocchio model",
        joints=joints,
        links=links,
        gravity=np.array(model.gravity.linear),
        limits=limits,
        sources=(f"A model in memory of Pinocchio {pin.__version__}.",),
    )
