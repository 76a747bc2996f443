"""The arm of a URDF or MJCF file or of a `pinocchio.Model`: one chain, all other joints held."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.bodies import NO_MASS
from gd_analyze.robots.frames import straight, without_round_off
from gd_analyze.robots.mjcf import read_mjcf
from gd_analyze.robots.parts import Drive, Joint, Link, Placement, checked
from gd_analyze.robots.text_file import read_xml
from gd_analyze.robots.tree import Notes, Tree, TreeJoint, chain_of, some_names
from gd_analyze.robots.urdf import read_urdf
from gd_analyze.text import LARGEST, shortened, visible
from gd_analyze.units import Quantity

# Humanoids with both hands have 200.
_MOST_LINKS = 2000
# A velocity limit of 100, 1000 and so on, per s, means no limit: arms reach 40 rad/s.
_NO_VELOCITY_LIMIT = 100.0
# An end of a range of 1000, 10000 and so on means no limit: arms reach a few turns, or 100 m on a gantry.
_NO_RANGE_LIMIT = 1000.0


def arm_of_robot(
    source: Path | pin.Model, tip: str | None, base: str | None, lock: Mapping[str, Quantity]
) -> RobotArm:
    """Arm of a file or model; ArmError if it is invalid, or its chain is ambiguous."""
    if isinstance(source, Path):
        tree = _read(source)
    else:
        gravity = np.array(source.gravity.linear)
        tree = Tree(source, Notes("the Pinocchio model"), source.name, "", gravity)
    return _arm_of_chain(tree, *chain_of(tree, tip, base, lock), tip)


def _read(path: Path) -> Tree:
    root = read_xml(path)
    links = sum(node.tag in ("link", "body") for node in root.walk())
    if links > _MOST_LINKS:
        message, expected = "the robot has too many links", f"at most {_MOST_LINKS}"
        raise ArmError(message, where=root.where, expected=expected, found=str(links))
    if root.tag not in ("robot", "mujoco"):
        expected = "<robot> (URDF) or <mujoco> (MJCF) as the outermost element"
        hint = "convert it to URDF or MJCF"
        if root.tag == "sdf":
            hint = "name the URDF that it was made from, if any; else `sdf2mjcf robot.sdf robot.xml`"
            hint += " writes MJCF (`pip install sdformat-mjcf`, which needs Gazebo's sdformat)"
        message, tag_text = "the XML does not describe a robot", f"<{root.tag}>"
        raise ArmError(message, where=root.where, expected=expected, found=tag_text, next_step=hint)
    return read_urdf(path, root) if root.tag == "robot" else read_mjcf(path, root)


def _arm_of_chain(
    tree: Tree, moving: Sequence[TreeJoint], held_values: Mapping[int, float], tip: str | None
) -> RobotArm:
    """The arm of the moving joints; links of held joints are merged, so that no mass is lost."""
    model, notes = pin.Model(tree.model), tree.notes
    for frame in model.frames:  # Pinocchio searches joints among all names, and a link may have the same name
        if frame.type not in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT):
            frame.name = f"link {frame.name}"
    reduced = pin.buildReducedModel(model, sorted(held_values), tree.configuration(held_values))
    bodies = list(zip(moving, reduced.jointPlacements[1:], reduced.inertias[1:], strict=True))
    end = pin.SE3.Identity() if tip is None else reduced.frames[reduced.getFrameId(f"link {tip}")].placement
    carried = tree.beyond(joint.index for joint in moving)
    arms_links = {link for link, index in tree.links.items() if index in carried}
    inboard = set[str]()
    link = notes.above.get(moving[0].link, "")
    while link and link not in inboard:
        inboard.add(link)
        link = notes.above.get(link, "")
    left_out = ", ".join(joint.name for joint in moving if _limits(tree.model, joint.index)[1])
    read_by = f"Pinocchio {pin.__version__}"
    source = f"{visible(Path(notes.path).name)}: {tree.format}, "
    source += f"read by {read_by}." if tree.format == "URDF" else "with masses as MuJoCo compiles them."
    return RobotArm(
        name=_identifier(tree.name, Path(notes.path).stem if tree.format else "robot"),
        title=shortened(visible(tree.name), 120),
        gravity_vector=tree.gravity,
        joints=tuple(_joint(tree, joint, place) for joint, place, _ in bodies),
        links=tuple(_link(tree, joint, body) for joint, _, body in bodies),
        drives=_drives(tree, moving),
        sources=(source if tree.format else f"A model in memory of {read_by}.",),
        assumptions=(
            *notes.assumptions,
            *notes.right_angles.assumptions(arms_links | inboard),
            *([f"Limits of 100, 1000 and so on are read as no limit: joint {left_out}."] if left_out else []),
            *_held_sentence(tree, moving, held_values),
        ),
        doubts=tuple(_doubts(tree, moving, arms_links, inboard)),
        tip=tip or "",
        tip_frame=Placement(straight(np.array(end.rotation)), without_round_off(np.array(end.translation))),
        ends=tuple(_ends(tree, moving[-1], tree.configuration(held_values))),
    )


def _ends(tree: Tree, last: TreeJoint, q: FloatArray) -> Iterator[Link]:
    """Bodies with mass beyond the last joint, each with all that it carries, in that joint's frame."""
    model = tree.model
    frames, data = model.frames, model.createData()
    pin.forwardKinematics(model, data, q)
    bodies = [
        k
        for k, frame in enumerate(frames)
        if frame.type == pin.FrameType.BODY and frame.parentJoint in tree.beyond({last.index})
    ]
    fixed = [frame for frame in frames if frame.type == pin.FrameType.FIXED_JOINT]
    inertia_of, above = {}, {}
    for k in bodies:
        attached = frames[frames[k].parentFrame]
        joint, above[k] = attached.parentJoint, attached.parentFrame
        if attached.type == pin.FrameType.FIXED_JOINT:
            inertia, place = attached.inertia, data.oMi[joint] * attached.placement
        else:
            inertia, place = model.inertias[joint], data.oMi[joint]
            for frame in fixed:
                if frame.parentJoint == joint:
                    inertia = inertia - frame.placement.act(frame.inertia)
        inertia_of[k] = (data.oMi[last.index].inverse() * place).act(inertia)
    for k in bodies:
        if frames[k].name == last.link or inertia_of[k].mass <= NO_MASS:
            continue
        carried, total = {k}, inertia_of[k]
        for body in bodies:  # parents come first
            if above[body] in carried:
                carried.add(body)
                total = total + inertia_of[body]
        inertia = np.array(total.inertia)
        yield Link(
            frames[k].name,
            float(total.mass),
            np.array(total.lever),
            (inertia + inertia.T) / 2,
            source=tree.line("link", frames[k].name),
        )


def _doubts(tree: Tree, moving: Sequence[TreeJoint], links: set[str], inboard: set[str]) -> Iterator[str]:
    """Doubts about the arm's joints and links, and about angles that place them."""
    notes = tree.notes
    about = {"", *links, *(joint.name for joint in moving)}
    yield from (text for name, text in notes.doubts if name in about)
    for sentence, told in notes.told.items():
        lines = [f"{name} (line {where.line})" for name, where, acts_on in told if about & {*acts_on}]
        if lines:
            yield f"{tree.where}: {sentence} {some_names(lines)}"
    yield from (text for link, text in notes.right_angles.suspects if link in links | inboard)
    if not any(inertia.mass > 0 for inertia in tree.model.inertias):
        yield f"{tree.where}: no link has any mass; is the file stripped, or xacro expanded in part?"


def _limits(model: Any, index: int) -> tuple[list[float | None], bool]:
    """Lower, upper and velocity limit of a joint as stated, and whether others mean no limit."""
    at, velocity = model.idx_qs[index], float(model.velocityLimit[model.idx_vs[index]])
    ends = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
    has_range = model.nqs[index] == 1 and np.isfinite(ends).all() and ends != (0.0, 0.0)
    is_endless = has_range and any(_is_power_of_ten(abs(end), _NO_RANGE_LIMIT) for end in ends)
    is_fast = velocity < math.inf and _is_power_of_ten(velocity, _NO_VELOCITY_LIMIT)
    stated: list[float | None] = [*ends] if has_range and not is_endless else [None, None]
    stated.append(velocity if 0 < velocity < math.inf and not is_fast else None)
    return stated, is_endless or is_fast


def _is_power_of_ten(number: float, least: float) -> bool:
    return number >= least and math.log10(number).is_integer()


def _joint(tree: Tree, joint: TreeJoint, moved: Any) -> Joint:
    lower, upper, velocity = _limits(tree.model, joint.index)[0]
    where = tree.place("joint", joint.name)
    place = checked(moved.translation, (3,), f"the place of joint {joint.name}", where)
    return Joint(
        joint.name,
        "revolute" if joint.kind == "revolute" else "prismatic",
        Placement(straight(np.array(moved.rotation)), without_round_off(place)),
        joint.axis,
        lower,
        upper,
        velocity,
        source=tree.line("joint", joint.name),
    )


def _link(tree: Tree, joint: TreeJoint, body: Any) -> Link:
    """Link of a joint with everything fixed to it, in the joint's frame, which is the link's."""
    mass, inertia = float(body.mass), np.array(body.inertia)
    return Link(
        joint.link,
        mass,
        without_round_off(np.array(body.lever)) if mass else np.zeros(3),
        without_round_off((inertia + inertia.T) / 2, float(np.abs(inertia).max())),
        source=tree.line("link", joint.link),
    )


def _drives(tree: Tree, moving: Sequence[TreeJoint]) -> tuple[Drive, ...]:
    """Drives as the model states them, seen at the joint; empty if it states none."""
    model, drives = tree.model, []
    stated = {"armature": model.armature, "damping": model.damping, "friction": model.friction}
    for joint in moving:
        at, where = model.idx_vs[joint.index], tree.place("joint", joint.name)
        inertia, viscous, friction = (
            float(checked(values[at], (), f"the {quantity} of joint {joint.name}", where, nonnegative=True))
            for quantity, values in stated.items()
        )
        effort = float(model.effortLimit[at])
        limit = effort if 0 < effort <= LARGEST else None
        drives.append(Drive(inertia, viscous=viscous, coulomb=(friction, 0.0 - friction), torque_limit=limit))
    return tuple(drives) if any(drive != Drive() for drive in drives) else ()


def _held_sentence(
    tree: Tree, moving: Sequence[TreeJoint], held_values: Mapping[int, float]
) -> Iterator[str]:
    """Held joints attached to the arm or placing its base, and their values."""
    near = tree.beyond(joint.index for joint in moving)
    near |= {joint.index for joint in tree.path(moving[0].index)}
    units = {"revolute": " rad", "prismatic": " m"}
    values = [
        f"{joint.name} at {held_values[joint.index]:g}{units.get(joint.kind, '')}"
        for joint in tree.joints
        if joint.index in held_values and joint.index in near
    ]
    if values:
        yield f"Held, with the bodies they carry: {some_names(values)}."


def _identifier(name: str, stem: str) -> str:
    """A robot's name as a folder name: "my robot (v2)" becomes my_robot_v2."""
    cleaned = (re.sub(r"[^A-Za-z0-9_.-]+", "_", text).strip("_.-") for text in (name, stem))
    return next((identifier[:100] for identifier in cleaned if identifier), "robot")
