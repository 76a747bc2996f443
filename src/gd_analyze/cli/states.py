"""States that a verb is about: a trajectory's set points, or states drawn from the arm's limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from gd_analyze.cli.options import TRAJECTORY, TRAJECTORY_HELP, F

if TYPE_CHECKING:
    from gd_analyze.robots import RobotArm
    from gd_analyze.states import States


def states_options(function: F) -> F:
    """[TRAJECTORY], --states and --seed."""
    for option in (
        click.option(
            "--seed",
            type=click.IntRange(min=0),
            default=0,
            show_default=True,
            metavar="NUMBER",
            help="Seed of these states: the same seed draws the same.",
        ),
        click.option(
            "--states",
            type=click.IntRange(1, 1_000_000),
            default=4000,
            show_default=True,
            metavar="NUMBER",
            help="States to draw where there is no trajectory.",
        ),
    ):
        function = option(function)
    return function


trajectory_argument = click.argument(
    "trajectory",
    type=TRAJECTORY,
    required=False,
    help=f"{TRAJECTORY_HELP} Without one: states drawn from the arm's limits.",
)


def states_given(arm: RobotArm, trajectory: str | None, states: int, seed: int) -> States:
    """Read or draw them."""
    from gd_analyze.states import states_in_box, states_of
    from gd_analyze.trajectories import read_trajectory

    if trajectory is None:
        return states_in_box(arm, states, seed)
    return states_of(read_trajectory(trajectory, arm))


def described(states: Mapping[str, str | int]) -> str:
    """Where states come from, in words."""
    if "trajectory" in states:
        return f"{states['set_points']} set points of {states['trajectory']}"
    return f"{states['states']} states drawn from {states['box']}, seed {states['seed']}"
