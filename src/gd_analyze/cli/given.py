"""Input of most verbs: an arm, its payload, and states of it."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.log_options import log_options, read_motions
from gd_analyze.cli.options import DRAWN, ROBOT, together
from gd_analyze.errors import BranchError, UsageError, warn_caller
from gd_analyze.units import Quantity

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link

_picking_options = together(
    click.option(
        "--tip",
        metavar="LINK",
        help="URDF or MJCF: last link of the arm; joints beyond it are held.",
    ),
    click.option("--base", metavar="LINK", help="URDF or MJCF: first link of the arm."),
    click.option(
        "--lock",
        metavar="JOINT=VALUE",
        multiple=True,
        help="URDF or MJCF: hold a joint at a value (rad, m, 90deg, 20mm); its links keep their mass. May be "
        "repeated.",
    ),
    click.option(
        "--limits",
        metavar="FILE|JOINT=VALUE",
        multiple=True,
        help="Acceleration limits: elbow=10, all=600deg, a list in the joints' order, or a file such as "
        "MoveIt's joint_limits.yaml. May be repeated.",
    ),
    click.option("--gravity", metavar="LIST", help="Gravity in the base frame, m/s^2: 0,0,-9.81."),
    click.option(
        "--drive-inertia",
        metavar="LIST|FILE",
        help="Drive inertia at each joint, kg m^2 (prismatic: kg); or a TOML file of [[drives]] tables.",
    ),
)


@dataclass(frozen=True)
class GivenRobot:
    """An arm as given on the command line: its name or file, and what options select from it or add to it."""

    name: str
    tip: str | None = None
    base: str | None = None
    lock: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    gravity: str | None = None
    drive_inertia: str | None = None

    @property
    def words(self) -> list[str]:
        """Its name and options as they are typed."""
        from gd_analyze.motions.corrections import as_options

        stated = {key: value for key, value in vars(self).items() if key != "name" and value}
        lists = {key: list(value) if isinstance(value, tuple) else value for key, value in stated.items()}
        return [self.name, *as_options(lists)]

    def load(
        self, payload: Link | None = None, logs: Sequence[str] = (), *, masses: bool = True
    ) -> gd.types.RobotArm:
        """Read the arm with its payload, if any; of a branching robot, the arm whose joints the logs name.

        With `masses`, one without any is refused.
        """
        words = {key: value for key, value in vars(self).items() if key != "name"}
        try:
            arm = gd.load_arm(self.name, **words)
        except BranchError as error:
            from gd_analyze.motions.read import last_link

            tip = last_link(logs[0], error.paths) if logs else None
            if tip is None:
                raise
            message = (
                f"{error.what}: the arm is assumed to end at link {tip}, after the last joint in the log"
            )
            warn_caller(f"{message}; --tip chooses another")
            arm = gd.load_arm(self.name, **words | {"tip": tip})
        if masses:
            from gd_analyze.robots.catalogue import arm_with_masses

            arm_with_masses(arm)
        if payload is None:
            return arm
        from gd_analyze.robots.payload import carrying

        return carrying(arm, payload)


def joint_values(arm: gd.types.RobotArm, listed: str, option: str) -> list[float]:
    """Comma-separated degrees (m of prismatic joints), or values with a unit, as rad (m)."""
    entries = [entry.strip() for entry in listed.split(",")]
    if len(entries) != arm.n_joints:
        raise UsageError(
            f"{option} has the wrong number of joint values",
            where=option,
            expected=f"{arm.n_joints} values for {arm.name}, comma-separated",
            found=f"{len(entries)}: {listed!r}",
        )
    values = []
    for column, (entry, joint) in enumerate(zip(entries, arm.joints, strict=True), start=1):
        quantity, revolute = Quantity.parse(entry), joint.kind == "revolute"
        kinds = ("", "angle" if revolute else "length")
        if quantity is None or quantity.kind not in kinds or not math.isfinite(quantity.si):
            raise UsageError(
                f"{option} contains a word that is not a number",
                where=f"{option}, value {column}",
                expected="degrees" if revolute else "metres",
                found=repr(entry),
            )
        in_degrees = revolute and not quantity.kind
        values.append(math.radians(quantity.si) if in_degrees else quantity.si)
    return values


def _robot(required: bool) -> Callable[[Callable[..., None]], Callable[..., None]]:
    names = [entry.name for entry in dataclasses.fields(GivenRobot)][1:]

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def verb(robot: str | None, **words: Any) -> None:
            picked = {name: words.pop(name) for name in names}
            function(robot=None if robot is None else GivenRobot(robot, **picked), **words)

        words = "Built-in arm (see `gd-analyze arms`), or path of an arm's URDF, MJCF or TOML file."
        argument = click.argument("robot", type=ROBOT, required=required, help=words)
        return together(argument, _picking_options)(verb)

    return decorate


# ROBOT and its options; the verb gets a `GivenRobot`, or None without a ROBOT.
robot_given, robot_or_none = _robot(required=True), _robot(required=False)


@dataclass(frozen=True)
class Given:
    """An arm and its states, as given on the command line."""

    robot: GivenRobot
    trajectories: tuple[str, ...]
    drives: bool | None
    payload: Link | None
    states: int
    seed: int

    def exact(self, progress: gd.types.Progress) -> tuple[gd.types.ExactDynamics, gd.Trajectory | None]:
        """Read or draw the states, with their motion, if any; warn where torques look wrong."""
        from gd_analyze.motions.states import states_in_box, states_of
        from gd_analyze.simplification.exact_dynamics import ExactDynamics, warn_of_torques

        arm = self.robot.load(self.payload, self.trajectories)
        motion = read_motions(self.trajectories, arm, progress) if self.trajectories else None
        states = states_in_box(arm, self.states, self.seed) if motion is None else states_of(motion)
        exact = ExactDynamics.of(arm, states, self.drives)
        warn_of_torques(exact)
        return exact, motion


def given_dynamics(function: Callable[..., None]) -> Callable[..., None]:
    """ROBOT with its options, [TRAJECTORY]..., --[no-]drives, --payload, --states, --seed; a `Given`."""
    names = [entry.name for entry in dataclasses.fields(Given)]

    @functools.wraps(function)
    def verb(**words: Any) -> None:
        function(inputs=Given(**{name: words.pop(name) for name in names}), **words)

    shared = (log_options, options.drives, options.payload, options.states)
    return together(robot_given, options.trajectories(DRAWN), *shared)(verb)
