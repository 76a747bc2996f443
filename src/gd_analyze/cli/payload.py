"""`--payload`: what the hand carries, for every verb that computes an arm's dynamics."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from gd_analyze.robots import Payload, RobotArm

F = TypeVar("F", bound=Callable[..., Any])


def payload_option(function: F) -> F:
    """--payload."""
    return click.option(
        "--payload",
        metavar="LIST",
        help="What the hand carries: mass,x,y,z[,ixx,iyy,izz[,ixy,ixz,iyz]] in kg, m and kg m^2, in the last "
        "link's frame, inertia about the payload's own centre of mass.",
    )(function)


def load_arm_carrying(robot: str, payload: str | None) -> RobotArm:
    """Load an arm and put the payload, if any, into its hand; its name and title say so."""
    from gd_analyze.robots import load_arm, parse_payload

    arm = load_arm(robot)
    return arm if payload is None else carrying(arm, parse_payload(payload))


def carrying(arm: RobotArm, body: Payload) -> RobotArm:
    """Put a payload into an arm's hand; its name and title say so."""
    from gd_analyze.robots import with_payload

    return dataclasses.replace(
        with_payload(arm, body.mass, body.position, body.inertia),
        name=f"{arm.name}+{body.mass:g}kg",
        title=f"{arm.title or arm.name} carrying {body.mass:g} kg",
    )
