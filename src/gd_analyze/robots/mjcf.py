"""Reads a robot from MuJoCo's MJCF: what Pinocchio's reader passes over is read here, or refused by name.

Pinocchio sees the compiler's settings, defaults of joints and shapes, and the bodies with their joints and
inertias. It knows no gravity but 9.81 along z, mistakes reference values, and joins several joints of a body
into one, so that these are taken from the text.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.mjcf_bodies import Bodies, defaults, kept
from gd_analyze.robots.quiet_parser import parsed
from gd_analyze.robots.right_angles import straight
from gd_analyze.robots.tree import Loop, Mimic, Tree, identifier, joints_of, limits_of, title_of
from gd_analyze.robots.xml_nodes import Node
from gd_analyze.text import visible

_EXPANDED_BY_MUJOCO = ("include", "frame", "replicate", "attach", "composite", "flexcomp")
_OF_COMPILER = ("angle", "eulerseq", "autolimits")
_CHANGES_MASS = ("settotalmass", "boundmass", "boundinertia", "inertiafromgeom")
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
    compilers = root.all("compiler")
    in_degrees = all(node.attributes.get("angle", "degree") == "degree" for node in compilers)
    bodies = Bodies(360.0 if in_degrees else 2 * math.pi)
    bare = Node("mujoco", {"model": "robot"}, root.where)
    bare.children = [kept(node, _OF_COMPILER) for node in compilers]
    bare.children += [defaults(node) for node in root.all("default")]
    bare.children.append(Node("worldbody", {}, world.where, bodies.below(world)))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "robot.xml"
        copy.write_text(bare.text(), encoding="utf-8")
        model = parsed(lambda: pin.buildModelFromMJCF(str(copy)), Location(path), "MJCF")
    return _tree(path, root, model, bodies)


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


def _tree(path: Path, root: Node, model: Any, bodies: Bodies) -> Tree:
    import pinocchio as pin

    mimics, loops = _equalities(root, bodies.sites)
    joints, links = joints_of(model, mimics)
    for joint in joints:
        if joint.name in bodies.references:
            unit = 2 * math.pi / bodies.turn if joint.kind == "revolute" else 1.0
            _turn_back(model, joint.index, joint.axis, joint.kind, bodies.references[joint.name] * unit)
    name = root.attributes.get("model", "").strip() or path.stem
    doubts = [*bodies.doubts, *_compiler_doubts(root)]
    if not any(inertia.mass > 0 for inertia in model.inertias):
        doubts.append(("", f"{path}: no body has any mass"))
    assumptions = []
    if bodies.shaped:
        rest = len(bodies.shaped) - _MOST_NAMED
        told = ", ".join(bodies.shaped[:_MOST_NAMED]) + (f" and {rest} more" if rest > 0 else "")
        assumptions.append(f"Mass and inertia from primitive shapes, as none are stated: {told}.")
    _limit_efforts(root, model)
    return Tree(
        model=model,
        name=identifier(name, path.stem),
        title=title_of(name),
        convention="placements from MJCF",
        where=visible(str(path)),
        joints=joints,
        links=links,
        gravity=_gravity(root),
        lines=bodies.lines,
        mimics=mimics,
        loops=loops,
        limits={joint.name: limits_of(model, joint.index) for joint in joints if joint.moves_simply},
        sources=(f"{visible(path.name)}: MJCF, read by Pinocchio {pin.__version__}.",),
        assumptions=tuple(assumptions),
        doubts=tuple(doubts),
        straightened=bodies.straightened,
        above=bodies.above,
    )


def _turn_back(model: Any, index: int, axis: FloatArray, kind: str, reference: float) -> None:
    """Place a joint so that its variable has the reference value in the pose that is written down."""
    import pinocchio as pin

    if kind == "revolute":
        back = pin.SE3(straight(np.array(pin.exp3(-reference * axis))), np.zeros(3))
    else:
        back = pin.SE3(np.eye(3), -reference * axis)
    model.jointPlacements[index] = model.jointPlacements[index] * back


def _gravity(root: Node) -> FloatArray:
    gravity = [0.0, 0.0, -9.81]
    for option in root.all("option"):
        if "gravity" in option.attributes:
            gravity = option.numbers("gravity", 3)
    return np.array(gravity)


def _compiler_doubts(root: Node) -> list[tuple[str, str]]:
    """Say which settings would change masses in MuJoCo, and do not here."""
    return [
        (
            "",
            f"{node.where}: <compiler {key}={node.attributes[key]!r}> changes masses, but not here",
        )
        for node in root.all("compiler")
        for key in _CHANGES_MASS
        if node.attributes.get(key, "0") not in ("0", "-1", "false", "auto")
    ]


def _equalities(root: Node, sites: dict[str, str]) -> tuple[dict[str, Mimic], tuple[Loop, ...]]:
    """Joints that follow others, and bodies held together beside the tree."""
    mimics: dict[str, Mimic] = {}
    loops = []
    for node in (child for part in root.all("equality") for child in part.children):
        given = node.attributes
        if given.get("active") == "false":
            continue
        if node.tag == "joint":
            numbers = node.numbers("polycoef", len(given.get("polycoef", "0 1").split()), "0 1")
            offset, multiplier = (*numbers, 0.0, 0.0)[:2]
            mimics[given.get("joint1", "")] = Mimic(given.get("joint2", ""), multiplier, offset)
        elif node.tag in ("connect", "weld"):
            ends = [given.get(f"body{k}") or sites.get(given.get(f"site{k}", ""), "world") for k in (1, 2)]
            loops.append(Loop((ends[0], ends[1]), node.where))
    return mimics, tuple(loops)


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
