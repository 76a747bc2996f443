"""The arm that a tree is with all joints held but those of one chain: links merged, no mass lost."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.chain import Chain, Pick, chain_of
from gd_analyze.robots.parts import Drive, Joint, Link, Placement, checked
from gd_analyze.robots.right_angles import straight, without_round_off
from gd_analyze.robots.tree import Limits, Tree, TreeJoint
from gd_analyze.text import LARGEST

_MOST_NAMED = 8


def arm_of_tree(tree: Tree, pick: Pick) -> RobotArm:
    """Make the arm of the chain that is picked out of a tree.

    Raises
    ------
    ArmError
        If there is no such chain, or a number of it is impossible.
    """
    import pinocchio as pin

    chain = chain_of(tree, pick)
    model = pin.Model(tree.model)
    for frame in model.frames:  # Pinocchio looks joints up among all names, and a link may be called the same
        if frame.type not in (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT):
            frame.name = f"link {frame.name}"
    reduced = pin.buildReducedModel(model, sorted(chain.held), configuration(tree, chain.held))
    joints, links = [], []
    for index, joint in enumerate(chain.moving, start=1):
        place = _placement(reduced.jointPlacements[index], joint.name, tree.line("joint", joint.name))
        joints.append(_joint(tree, joint, place))
        links.append(_link(tree, joint, reduced.inertias[index]))
    carried = tree.carried(chain.moving)
    placed = carried | tree.inboard(chain.moving[0])
    about = {"", *carried, *(joint.name for joint in chain.moving)}
    return RobotArm(
        name=tree.name,
        title=tree.title,
        gravity=tree.gravity,
        joints=tuple(joints),
        links=tuple(links),
        drives=_drives(tree, chain.moving),
        convention=tree.convention,
        sources=tree.sources,
        assumptions=(
            *tree.assumptions,
            *tree.straightened.told(placed),
            *_none_told(tree, chain),
            *_held_told(tree, chain),
        ),
        doubts=(
            *_unranged_told(tree, chain),
            *(told for name, told in tree.doubts if name in about),
            *(told for link, told in tree.straightened.suspects if link in placed),
        ),
    )


def configuration(tree: Tree, held: Any) -> FloatArray:
    """Pinocchio's configuration with the given joints at their values and all others at rest."""
    import pinocchio as pin

    q: FloatArray = pin.neutral(tree.model)
    for index, value in held.items():
        start, count = tree.model.idx_qs[index], tree.model.nqs[index]
        if count == 1:
            q[start] = value
        elif tree.joint(index).kind == "revolute":  # one without ends, as cosine and sine
            q[start : start + 2] = math.cos(value), math.sin(value)
    return q


def _placement(moved: Any, name: str, where: Location | str) -> Placement:
    translation = checked(moved.translation, (3,), f"the place of joint {name}", where)
    size = max(1.0, float(np.abs(translation).max()))
    return Placement(straight(np.array(moved.rotation)), without_round_off(translation, size))


def _joint(tree: Tree, joint: TreeJoint, placement: Placement) -> Joint:
    limits = tree.limits.get(joint.name, Limits()).without_placeholders()
    return Joint(
        name=joint.name,
        kind="revolute" if joint.kind == "revolute" else "prismatic",
        placement=placement,
        axis=joint.axis,
        lower=limits.lower,
        upper=limits.upper,
        velocity_limit=limits.rate,
        source=_source(tree.line("joint", joint.name)),
    )


def _link(tree: Tree, joint: TreeJoint, body: Any) -> Link:
    """Link of a joint with all that is fixed to it, in the joint's frame, which is the link's."""
    mass, com, inertia = float(body.mass), np.array(body.lever), np.array(body.inertia)
    inertia = (inertia + inertia.T) / 2
    largest = float(np.abs(inertia).max())
    return Link(
        name=joint.link,
        mass=mass,
        com=without_round_off(com, max(1.0, float(np.abs(com).max()))) if mass else np.zeros(3),
        inertia_com=without_round_off(inertia, largest),
        source=_source(tree.line("link", joint.link)),
    )


def _source(place: Location | str) -> Location | None:
    return place if isinstance(place, Location) else None


def _drives(tree: Tree, moving: Sequence[TreeJoint]) -> tuple[Drive, ...]:
    """What the model states of each joint's drive, seen at the joint; nothing where it states nothing."""
    model, drives = tree.model, []
    for joint in moving:
        at, where = model.idx_vs[joint.index], tree.line("joint", joint.name)
        stated = {"armature": model.armature, "damping": model.damping, "friction": model.friction}
        for what, values in stated.items():
            checked(values[at], (), f"the {what} of joint {joint.name}", where, nonnegative=True)
        inertia, viscous, friction = (float(values[at]) for values in stated.values())
        effort = float(model.effortLimit[at])
        drives.append(
            Drive(
                inertia=inertia,
                viscous=viscous,
                coulomb=(friction, 0.0 - friction),
                torque_limit=effort if 0 < effort <= LARGEST else None,
            )
        )
    return tuple(drives) if any(drive != Drive() for drive in drives) else ()


def _none_told(tree: Tree, chain: Chain) -> tuple[str, ...]:
    """Say whose limits are so far out that they stand for none."""
    limits = {joint.name: tree.limits.get(joint.name, Limits()) for joint in chain.moving}
    names = [name for name, stated in limits.items() if stated != stated.without_placeholders()]
    if not names:
        return ()
    return (f"Limits of 100, 1000 and so on stand for none: joint {', '.join(names)}.",)


def _unranged_told(tree: Tree, chain: Chain) -> Iterator[str]:
    """Say which joints should state a range and do not, in one sentence for all that state the same."""
    alike: dict[tuple[str, str], list[str]] = {}
    for joint in chain.moving:
        instead = tree.limits.get(joint.name, Limits()).unranged
        if instead:
            alike.setdefault((joint.kind, instead), []).append(joint.name)
    for (kind, instead), names in alike.items():
        *first, last = names
        who = f"joints {', '.join(first)} and {last} are" if first else f"joint {last} is"
        states = "state" if first else "states"
        where = tree.line("joint", names[0])
        yield f"{where}: {who} {kind} and {states} {instead}, which is taken as unknown"


def _held_told(tree: Tree, chain: Chain) -> tuple[str, ...]:
    """Say which held joints hang on the arm, or place its base, and where they are held."""
    hanging = tree.beyond({joint.index for joint in chain.moving})
    inboard = {joint.index for joint in tree.path(chain.moving[0].index)}
    said = [
        f"{joint.name} at {chain.held[joint.index]:g}" + (f" {joint.unit}" if joint.moves_simply else "")
        for joint in tree.joints
        if joint.index in chain.held and joint.index in inboard | hanging
    ]
    if not said:
        return ()
    more = f" and {len(said) - _MOST_NAMED} more" if len(said) > _MOST_NAMED else ""
    return (f"Held, with what they carry: {', '.join(said[:_MOST_NAMED])}{more}.",)
