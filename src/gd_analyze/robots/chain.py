"""Which joints of a tree move, and at which values the others are held: one serial chain, or why not."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from gd_analyze.errors import ArmError
from gd_analyze.robots.tree import Loop, Tree, TreeJoint

# A finger has up to four joints.
_FINGER = 4
# One of a hand with joints in between has more, and hangs on an arm of at least five.
_ARM = 5
_MOST_NAMED = 12
# Of more joints than these --tip says it shorter.
_FEW = 6


@dataclass(frozen=True)
class Pick:
    """What the user chose: links the arm begins and ends with, and joints held at a value, in rad or m."""

    tip: str | None = None
    base: str | None = None
    lock: Mapping[str, float] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return self.tip is not None or self.base is not None or bool(self.lock)


@dataclass(frozen=True)
class Chain:
    """Joints that move, from the base outwards, and the values at which all others are held."""

    moving: tuple[TreeJoint, ...]
    held: Mapping[int, float]


def chain_of(tree: Tree, pick: Pick) -> Chain:
    """Pick the serial chain out of a tree.

    Raises
    ------
    ArmError
        If a name is unknown, nothing moves, the tree branches, or a joint that moves cannot be part of an
        arm; the message has the option that settles it.
    """
    locked = {_joint(tree, name, value).index: value for name, value in pick.lock.items()}
    base = 0 if pick.base is None else _link(tree, pick.base, "--base")
    if pick.tip is None:
        free = [joint for joint in tree.joints if base in _ancestors(tree, joint)]
    else:
        free = _between(tree, base, _link(tree, pick.tip, "--tip"), pick)
    free = [joint for joint in free if joint.index not in locked]
    held = {joint.index: 0.0 for joint in tree.joints if joint not in free} | locked
    free = [joint for joint in free if not _follows_held(tree, joint, held)]
    held |= _followed(tree, [joint for joint in tree.joints if joint not in free], locked, held)
    if not free:
        raise ArmError(
            "the robot has no joint that moves",
            where=tree.where,
            expected="at least one joint that turns or slides",
            found=f"{len(tree.joints)} joints, all of them held" if tree.joints else "fixed joints alone",
            next_step="hold fewer joints" if tree.joints else "check that it is the file of an arm",
        )
    _refuse_floating(tree, free)
    _refuse_loops(tree, free)
    _refuse_branches(tree, free)
    _refuse_others(tree, free)
    return Chain(tuple(free), held)


def _ancestors(tree: Tree, joint: TreeJoint) -> list[int]:
    """Indices of the joints before one, the ground included."""
    return [0, *(one.index for one in tree.path(joint.parent))]


def _joint(tree: Tree, name: str, value: float) -> TreeJoint:
    found = next((joint for joint in tree.joints if joint.name == name), None)
    if found is None:
        raise ArmError(
            f"there is no moving joint {name!r} to lock",
            where=f"--lock {name}",
            expected=f"one of the joints that move in {tree.where}",
            found=_named(joint.name for joint in tree.joints),
            next_step=_near(name, [joint.name for joint in tree.joints]),
        )
    if value and not found.moves_simply:
        raise ArmError(
            f"joint {name} is {found.kind} and can be held at 0 only, in the pose of the file",
            where=f"--lock {name}",
            expected=f"{name}=0",
            found=f"{name}={value:g}",
            next_step="place its link in the file",
        )
    return found


def _link(tree: Tree, name: str, option: str) -> int:
    if name not in tree.links:
        raise ArmError(
            f"there is no link {name!r}",
            where=f"{option} {name}",
            expected=f"one of the links in {tree.where}",
            found=_named(tree.links),
            next_step=_near(name, list(tree.links)),
        )
    return tree.links[name]


def _near(name: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    return f"did you mean {' or '.join(near)}?" if near else "take a name of the file"


def _named(names: Iterable[str]) -> str:
    """List names; of many only the first."""
    listed = list(names)
    rest = len(listed) - _MOST_NAMED
    return ", ".join(listed[:_MOST_NAMED]) + (f" and {rest} more" if rest > 0 else "")


def _between(tree: Tree, base: int, tip: int, pick: Pick) -> list[TreeJoint]:
    path = tree.path(tip)
    before = [0, *(joint.index for joint in path)]
    if base not in before:
        raise ArmError(
            f"link {pick.tip} is not beyond link {pick.base}",
            where=f"--base {pick.base} --tip {pick.tip}",
            expected="a tip that the base carries",
            found=f"the way to {pick.tip} passes {_named(joint.link for joint in path) or 'no joint'}",
            next_step="name a base on that way, or none",
        )
    return path[before.index(base) :]


def _follows_held(tree: Tree, joint: TreeJoint, held: Mapping[int, float]) -> bool:
    """Whether a joint mimics one that is held, or moves nothing of any mass for its mimicking."""
    mimic = tree.mimics.get(joint.name)
    if mimic is None:
        return False
    master = next((one for one in tree.joints if one.name == mimic.master), None)
    return master is None or master.index in held or not tree.carries_mass(joint.index)


def _followed(
    tree: Tree, still: Sequence[TreeJoint], locked: Mapping[int, float], held: Mapping[int, float]
) -> dict[int, float]:
    """Values of held joints that mimic others, where the user gave none."""
    values = dict(held)
    of_name = {joint.name: joint.index for joint in tree.joints}
    for _ in tree.mimics:  # one may follow another that follows a third
        for joint in still:
            mimic = tree.mimics.get(joint.name)
            if mimic is not None and joint.index not in locked:
                master = values.get(of_name.get(mimic.master, -1), 0.0)
                values[joint.index] = mimic.multiplier * master + mimic.offset
    return {joint.index: values.get(joint.index, 0.0) for joint in still}


def _refuse_floating(tree: Tree, free: Sequence[TreeJoint]) -> None:
    for joint in free:
        if joint.kind == "floating":
            raise ArmError(
                f"the robot floats: joint {joint.name} lets link {joint.link} move freely",
                where=tree.line("joint", joint.name),
                expected="an arm on a fixed base",
                found="a floating joint",
                next_step=f"--base {joint.link} takes that link as fixed; or use a file with a fixed base",
            )


def _refuse_loops(tree: Tree, free: Sequence[TreeJoint]) -> None:
    for loop in tree.loops:
        between = _moving_between(tree, loop, free)
        if between:
            raise ArmError(
                f"links {loop.links[0]} and {loop.links[1]} close a loop",
                where=loop.where,
                expected="an arm whose joints are a chain without loops",
                found=f"joints that move in the loop: {_named(joint.name for joint in between)}",
                next_step=f"{_locks(between)} holds them; or --tip takes an arm without the loop",
            )


def _moving_between(tree: Tree, loop: Loop, free: Sequence[TreeJoint]) -> list[TreeJoint]:
    """Joints on the way of a loop's two links that move."""
    ways = [{joint.index for joint in tree.path(tree.links.get(link, 0))} for link in loop.links]
    apart = ways[0] ^ ways[1]
    return [joint for joint in free if joint.index in apart]


def _locks(joints: Iterable[TreeJoint]) -> str:
    return " ".join(f"--lock {joint.name}=0" for joint in joints)


def _refuse_branches(tree: Tree, free: Sequence[TreeJoint]) -> None:
    """Refuse a tree that is no chain, with the locks or the tips that make it one."""
    moving = _Moving.of(tree, free)
    stem: list[TreeJoint] = []
    at = moving.after[0]
    while len(at) == 1:
        stem.append(at[0])
        at = moving.after[at[0].index]
    if not at:
        return
    fork = stem[-1].link if stem else "the base"
    branches = [moving.branch(joint) for joint in at]
    second, first = sorted(moving.depth[joint.index] for joint in at)[-2:]
    if first <= min(_FINGER, len(stem)) and first - second <= 1:
        held = [one for branch in branches for one in branch if not one.follows]
        way = f"--tip {fork} holds what branches off, with its mass"
        if len(held) <= _FEW:
            way = f"{_locks(held)} holds what branches off, with its mass; --tip {fork} does the same"
    else:
        tips = sorted(
            moving.ends(at, len(stem)),
            key=lambda one: (not moving.after[one.index], -len(tree.path(one.index))),
        )
        way = "name the arm's last link, " + " or ".join(f"--tip {tip.link}" for tip in tips[:_MOST_NAMED])
    names = (branch[0].name + (f" with {len(branch) - 1} more" if branch[1:] else "") for branch in branches)
    raise ArmError(
        f"the robot branches at link {fork}" if stem else "the robot branches at its base",
        where=tree.line("link", fork) if stem else tree.where,
        expected="one chain of moving joints",
        found=f"{len(at)} branches: {_named(names)}",
        next_step=way,
    )


@dataclass(frozen=True)
class _Moving:
    """Moving joints that follow each one and the ground, and how deep they go, mimicking ones apart."""

    after: Mapping[int, list[TreeJoint]]
    depth: Mapping[int, int]

    @classmethod
    def of(cls, tree: Tree, free: Sequence[TreeJoint]) -> _Moving:
        """Leave out the held joints in between."""
        after: dict[int, list[TreeJoint]] = {0: [], **{joint.index: [] for joint in free}}
        for joint in free:
            before = next((index for index in reversed(_ancestors(tree, joint)) if index in after), 0)
            after[before].append(joint)
        depth: dict[int, int] = {}
        for joint in reversed(free):  # parents come first
            beyond = max((depth[one.index] for one in after[joint.index]), default=0)
            depth[joint.index] = beyond + (0 if joint.follows else 1)
        return cls(after, depth)

    def branch(self, joint: TreeJoint) -> list[TreeJoint]:
        """Take a joint and all beyond it."""
        found, waiting = [], [joint]
        while waiting:
            found.append(waiting.pop())
            waiting.extend(reversed(self.after[found[-1].index]))
        return found

    def ends(self, forked: Sequence[TreeJoint], before: int) -> list[TreeJoint]:
        """Joints at which the arms end that part at a fork behind some joints.

        A hand's fingers do not count as arms; a long arm that parts may end at its fork, or at a finger.
        """
        deepest = max(self.depth[joint.index] for joint in forked)
        found = []
        for joint in forked:
            if self.depth[joint.index] <= _FINGER < deepest:
                continue
            length = before + 1
            while len(self.after[joint.index]) == 1:
                joint = self.after[joint.index][0]
                length += 1
            beyond = self.after[joint.index]
            is_hand = all(self.depth[one.index] <= _FINGER for one in beyond)
            if is_hand or length >= _ARM:
                found.append(joint)
            if not is_hand:
                found += self.ends(beyond, length)
        return found


def _refuse_others(tree: Tree, free: Sequence[TreeJoint]) -> None:
    for joint in free:
        where = tree.line("joint", joint.name)
        mimic = tree.mimics.get(joint.name)
        if mimic is not None:
            raise ArmError(
                f"joint {joint.name} mimics joint {mimic.master} and moves mass",
                where=where,
                expected="joints that move independently",
                found=f"{mimic.multiplier:g} times {mimic.master} plus {mimic.offset:g}",
                next_step=f"--lock {joint.name}=0 holds it, --lock {mimic.master}=0 both of them",
            )
        if not joint.moves_simply:
            raise ArmError(
                f"joint {joint.name} is {joint.kind}, which no joint of an arm is here",
                where=where,
                expected="joints that turn about or slide along one axis",
                found=f"a {joint.kind} joint" if joint.kind != "other" else "another kind of joint",
                next_step=f"--lock {joint.name}=0 holds it; or pick an arm without it by --base and --tip",
            )
