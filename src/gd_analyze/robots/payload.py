"""A payload of the end effector, merged into the last link."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import array_of
from gd_analyze.errors import ArmError, UsageError, warn_caller
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.parts import Link, entries_of, of_point_mass, symmetric_tensor
from gd_analyze.robots.plausibility import check_payload
from gd_analyze.text import number_in


def with_payload(
    arm: RobotArm | str | Path, mass: float, position: ArrayLike, inertia: ArrayLike | None = None
) -> RobotArm:
    """Merge a payload into the last link: exact mass, centre of mass and inertia of both together.

    Parameters
    ----------
    arm
        The arm, the name of a built-in one, or the path of its file. Stated uncertainties remain those of
        the last link alone.
    mass
        Mass of the payload, kg.
    position
        Its centre of mass, m, shape (3,), in the frame of the arm's tip, if one was asked for, else of the
        last link.
    inertia
        About its centre of mass, kg m^2, axes parallel to that frame: (xx, yy, zz), these and (xy, xz, yz),
        or a tensor, shape (3, 3). By default a point mass.

    Returns
    -------
    RobotArm
        The arm that carries it.

    Raises
    ------
    ArmError
        If numbers are missing, not finite or negative, or no body has this inertia.

    Warns
    -----
    GdAnalyzeWarning
        If the payload is implausible for this arm, such as one in grams.
    """
    arm = arm_of(arm)
    load, turn = payload(mass, position, inertia), arm.tip_frame.rotation
    com = turn @ load.com + arm.tip_frame.translation
    body = dataclasses.replace(load, com=com, inertia_com=turn @ load.inertia_com @ turn.T)
    for message in check_payload(body, arm.reach):
        warn_caller(message)
    last = arm.links[-1]
    together = last.mass + body.mass
    com = (last.mass * last.com + body.mass * body.com) / together if together > 0 else last.com
    about_com = [part.inertia_com + of_point_mass(part.mass, part.com - com) for part in (last, body)]
    merged = dataclasses.replace(
        last,
        mass=together,
        com=com,
        inertia_com=about_com[0] + about_com[1],
        bare=last.bare or last,
    )
    place = ", ".join(f"{x:g}" for x in load.com)
    frame = f"the frame of {arm.tip}" if arm.tip else "its frame"
    note = f"Link {last.name} carries a payload of {body.mass:g} kg at ({place}) m in {frame}."
    return dataclasses.replace(arm, links=(*arm.links[:-1], merged), assumptions=(*arm.assumptions, note))


def carrying(arm: RobotArm, body: Link) -> RobotArm:
    """Attach a payload to an arm's end effector; the arm's name lists the payload's nonzero numbers."""
    numbers = [f",{x:g}" for x in (*body.com, *entries_of(body.inertia_com).values())]
    while numbers and numbers[-1] == ",0":
        numbers.pop()
    return dataclasses.replace(
        with_payload(arm, body.mass, body.com, body.inertia_com),
        name=f"{arm.name}+{body.mass:g}kg{''.join(numbers)}",
        title=f"{arm.title or arm.name} carrying {body.mass:g} kg",
    )


def payload(mass: float, position: ArrayLike, inertia: ArrayLike | None = None) -> Link:
    """A body held by the last link: kg, m and kg m^2 in that link's frame.

    The inertia about the payload's centre of mass is (xx, yy, zz), these and (xy, xz, yz), a tensor, or None.
    """
    com = array_of(position, "the position of the payload", ArmError)
    moments = array_of(np.zeros(3) if inertia is None else inertia, "the inertia of the payload", ArmError)
    if moments.shape not in ((3,), (6,), (3, 3)):
        message, shape_text = "the inertia of the payload has the wrong shape", f"shape {moments.shape}"
        expected = "3 principal moments, 6 components (xx, yy, zz, xy, xz, yz) or a 3x3 tensor"
        raise ArmError(message, where="payload", expected=expected, found=shape_text)
    return Link("payload", mass, com, moments if moments.ndim == 2 else symmetric_tensor(*moments))


def parse_payload(line: str) -> Link:
    """Payload of a line mass,x,y,z[,xx,yy,zz[,xy,xz,yz]]; UsageError unless 4, 7 or 10 numbers."""
    words = line.split(",")
    values = [number_in(word) for word in words]
    numbers = [value for value in values if value is not None]
    if len(numbers) != len(words) or len(numbers) not in (4, 7, 10):
        wrong = next((word.strip() for word in words if number_in(word) is None), None)
        line_text = f"{len(words)} numbers" if wrong is None else repr(wrong)
        expected = "mass,x,y,z in kg and m, then xx,yy,zz (and xy,xz,yz) in kg m^2 unless it is a point mass"
        raise UsageError(
            "the payload is not 4, 7 or 10 numbers", where=repr(line), expected=expected, found=line_text
        )
    return payload(numbers[0], numbers[1:4], numbers[4:] or None)
