"""What to type where a log has fewer joints than the robot's file: arguments that hold the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.mapping import NamedLog
from gd_analyze.motions.names import are_of_set_points
from gd_analyze.robots.catalogue import arguments_to_hold


def ways_to_hold(log: NamedLog, columns: Mapping[int, Sequence[int]]) -> list[str]:
    """Arguments that hold the joints that the log leaves out, each behind what must be true of them."""
    ways = []
    for joints in _held(log, columns):
        hold = arguments_to_hold(log.arm, joints)
        if hold:
            listed = ", ".join(log.arm.joints[joint].name for joint in joints)
            ways.append(f"{listed} {'rest' if len(joints) > 1 else 'rests'} at 0: {hold}")
    return ways


def _held(log: NamedLog, columns: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Joints that the log may leave out, the likeliest first, such that its columns are all others.

    These are the joints without columns. Where the log only counts its joints, it may count those that turn.
    """
    arm, all_joints = log.arm, range(log.arm.n_joints)
    lacking = [joint for joint in all_joints if joint not in columns]
    sliding = [joint for joint in all_joints if not arm.is_revolute[joint]]
    names = [log.names[column] for of_joint in columns.values() for column in of_joint]
    numbers = {k: n.number for k, n in enumerate(names) if n.joint is None and n.number is not None}
    in_order = are_of_set_points(log.table.names)
    counts = len(numbers) == len(names) and (in_order or log.joints.label is None)
    choices = [lacking]
    if counts and len(sliding) == len(lacking) and sliding != lacking:
        choices.insert(0, sliding)
    held = []
    for joints in choices:
        moving = [arm.joints[joint].name for joint in all_joints if joint not in joints]
        counted = JointNames.of([str(k + 1) for k in range(len(moving))] if in_order else moving)
        # The log's numbers must be those of the joints that move.
        if None not in counted.numbered(numbers).values():
            held.append(joints)
    return held
