"""What a verb is about: an arm, what it carries, and states of it."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.options import (
    number_option,
    robot_argument,
    together,
    trajectories_argument,
    trajectory_argument,
)

if TYPE_CHECKING:
    from gd_analyze.robots import Payload

_WITHOUT = "Without one: states drawn from the arm's limits."
trajectory_or_states = trajectory_argument(_WITHOUT)
trajectories_or_states = trajectories_argument(_WITHOUT)

payload_option = click.option(
    "--payload",
    metavar="LIST",
    help="What the hand carries: mass,x,y,z[,ixx,iyy,izz[,ixy,ixz,iyz]] in kg, m and kg m^2, in the last "
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


@dataclass(frozen=True)
class Given:
    """An arm and states of it, as words of the command."""

    robot: str
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
        from gd_analyze.levels import warn_without_torque

        arm = load_arm_carrying(self.robot, self.payload)
        motion = read_motions(self.trajectories, arm) if self.trajectories else None
        states = gd.states_in_box(arm, self.states, self.seed) if motion is None else gd.states_of(motion)
        exact = gd.ExactDynamics.of(arm, states, self.drives)
        warn_without_torque(exact)
        return exact, motion


def given_dynamics(function: Callable[..., None]) -> Callable[..., None]:
    """ROBOT, [TRAJECTORY]..., --[no-]drives, --payload, --states and --seed; the verb gets a `Given`."""
    names = [entry.name for entry in dataclasses.fields(Given)]

    @functools.wraps(function)
    def verb(**words: Any) -> None:
        function(given=Given(**{name: words.pop(name) for name in names}), **words)

    return together(robot_argument, trajectories_or_states, drives_option, payload_option, states_options)(
        verb
    )


def load_arm_carrying(robot: str, payload: str | None) -> gd.RobotArm:
    """Load an arm and put the payload, if any, into its hand; its name and title say so."""
    from gd_analyze.robots import parse_payload

    arm = gd.load_arm(robot)
    return arm if payload is None else carrying(arm, parse_payload(payload))


def read_motions(words: tuple[str, ...], arm: gd.RobotArm) -> gd.Trajectory:
    """Read the motions that words stand for, several of them as one trajectory."""
    from gd_analyze.trajectories import trajectory_of

    return trajectory_of(words, arm)


def carrying(arm: gd.RobotArm, body: Payload) -> gd.RobotArm:
    """Put a payload into an arm's hand; its name and title say so, the name with all that is not zero."""
    from gd_analyze.robots import with_payload

    rest = [f",{x:g}" for x in (*body.position, *body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])]
    while rest and rest[-1] == ",0":
        rest.pop()
    return dataclasses.replace(
        with_payload(arm, body.mass, body.position, body.inertia),
        name=f"{arm.name}+{body.mass:g}kg{''.join(rest)}",
        title=f"{arm.title or arm.name} carrying {body.mass:g} kg",
    )
