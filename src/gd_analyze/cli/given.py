"""Input of most verbs: an arm, its payload, and states of it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.log_options import log_options, read_motions
from gd_analyze.cli.options import (
    ROBOT,
    ROBOT_HELP,
    number_option,
    together,
    trajectories_argument,
    trajectory_argument,
)

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link

_WITHOUT = "Without one: states drawn from the arm's limits."
trajectory_or_states = trajectory_argument(_WITHOUT)
trajectories_or_states = trajectories_argument(_WITHOUT)

payload_option = click.option(
    "--payload",
    metavar="LIST",
    help="Load at the end effector: mass,x,y,z[,ixx,iyy,izz[,ixy,ixz,iyz]] in kg, m and kg m^2, in the last "
    "link's frame, inertia about the payload's own centre of mass.",
)

drives_option = click.option(
    "--drives/--no-drives",
    default=None,
    help="Include the drives' inertia, or take the links alone.  [default: included where there are drives]",
)

states_options = together(
    number_option("--states", 4000, "States to draw where there is no trajectory.", 1, 1_000_000),
    number_option("--seed", 0, "Seed of these states: the same seed draws the same."),
)


_picking_options = together(
    click.option(
        "--tip",
        metavar="LINK",
        help="Of URDF or MJCF: last link of the arm; joints beyond it are held.",
    ),
    click.option("--base", metavar="LINK", help="Of URDF or MJCF: first link of the arm."),
    click.option(
        "--lock",
        metavar="JOINT=VALUE",
        multiple=True,
        help="Of URDF or MJCF: hold a joint, in rad, m, or with a unit (90deg, 20mm); its links keep their "
        "mass. May be repeated.",
    ),
    click.option(
        "--limits",
        metavar="FILE|JOINT=VALUE",
        multiple=True,
        help="Add limits of acceleration, in rad/s^2, m/s^2, or with a unit: elbow=10, all=600deg, a list in "
        "the joints' order, or a YAML or TOML file such as MoveIt's joint_limits.yaml. May be repeated.",
    ),
)


@dataclass(frozen=True)
class GivenRobot:
    """An arm as words of the command: its name or file, and what is picked out of it and added to it."""

    name: str
    tip: str | None = None
    base: str | None = None
    lock: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()

    def load(self) -> gd.RobotArm:
        """Read the arm."""
        return gd.load_arm(self.name, tip=self.tip, base=self.base, lock=self.lock, limits=self.limits)


def _robot(required: bool) -> Callable[[Callable[..., None]], Callable[..., None]]:
    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def verb(robot: str | None, **words: Any) -> None:
            picked = {name: words.pop(name) for name in ("tip", "base", "lock", "limits")}
            function(robot=None if robot is None else GivenRobot(robot, **picked), **words)

        argument = click.argument("robot", type=ROBOT, required=required, help=ROBOT_HELP)
        return together(argument, _picking_options)(verb)

    return decorate


# ROBOT, --tip, --base, --lock and --limits; the verb gets a `GivenRobot`, or None without a ROBOT.
robot_given, robot_or_none = _robot(required=True), _robot(required=False)


@dataclass(frozen=True)
class Given:
    """An arm and states of it, as words of the command."""

    robot: GivenRobot
    trajectories: tuple[str, ...]
    drives: bool | None
    payload: str | None
    states: int
    seed: int

    def exact(self) -> gd.ExactDynamics:
        """Read or draw them; warns where no joint needs torque."""
        return self.exact_along()[0]

    def exact_along(self) -> tuple[gd.ExactDynamics, gd.Trajectory | None]:
        """Read or draw them, and the motion they are of, if any."""
        from gd_analyze.simplification.exact import warn_without_torque

        arm = load_arm_carrying(self.robot, self.payload)
        motion = read_motions(self.trajectories, arm) if self.trajectories else None
        states = gd.states_in_box(arm, self.states, self.seed) if motion is None else gd.states_of(motion)
        exact = gd.ExactDynamics.of(arm, states, self.drives)
        warn_without_torque(exact)
        return exact, motion


def given_dynamics(function: Callable[..., None]) -> Callable[..., None]:
    """ROBOT with its options, [TRAJECTORY]..., --[no-]drives, --payload, --states, --seed; a `Given`."""
    names = [entry.name for entry in dataclasses.fields(Given)]

    @functools.wraps(function)
    def verb(**words: Any) -> None:
        function(given=Given(**{name: words.pop(name) for name in names}), **words)

    options = (log_options, drives_option, payload_option, states_options)
    return together(robot_given, trajectories_or_states, *options)(verb)


def load_arm_carrying(robot: GivenRobot, payload: str | None) -> gd.RobotArm:
    """Load an arm and attach the payload, if any, to its end effector; its name and title say so."""
    from gd_analyze.robots.payload import parse_payload

    arm = robot.load()
    return arm if payload is None else carrying(arm, parse_payload(payload))


def carrying(arm: gd.RobotArm, body: Link) -> gd.RobotArm:
    """Attach a payload to an arm's end effector; its name has every number of it that is not zero."""
    from gd_analyze.robots.payload import with_payload

    rest = [f",{x:g}" for x in (*body.com, *body.inertia_com[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])]
    while rest and rest[-1] == ",0":
        rest.pop()
    return dataclasses.replace(
        with_payload(arm, body.mass, body.com, body.inertia_com),
        name=f"{arm.name}+{body.mass:g}kg{''.join(rest)}",
        title=f"{arm.title or arm.name} carrying {body.mass:g} kg",
    )
