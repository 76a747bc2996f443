"""A payload of the end effector, merged into the last link."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray, array_of
from gd_analyze.errors import ArmError, GdAnalyzeWarning, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, of_point_mass, symmetric_tensor
from gd_analyze.robots.plausibility import check_payload
from gd_analyze.text import number_in


@dataclass(frozen=True, eq=False)
class Payload:
    """A rigid body held by the last link; its data are given in the last link's frame.

    Parameters
    ----------
    mass
        kg.
    position
        Its centre of mass, m, shape (3,).
    inertia
        Its inertia about its own centre of mass along the axes of the last link's frame, kg m^2: the moments
        (xx, yy, zz), or these and (xy, xz, yz) as they stand in the tensor, or the tensor itself. Stored as
        the tensor, shape (3, 3). Left out, the payload is a point mass.

    Raises
    ------
    ArmError
        If a number is not finite, the mass is negative, or the inertia is not symmetric.
    """

    mass: float
    position: FloatArray
    inertia: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self) -> None:
        body = Link("payload", self.mass, self.position, _tensor(self.inertia))
        for name, value in (("mass", body.mass), ("position", body.com), ("inertia", body.inertia_com)):
            object.__setattr__(self, name, value)


def with_payload(
    arm: RobotArm, mass: float, position: ArrayLike, inertia: ArrayLike | None = None
) -> RobotArm:
    """Merge a payload into the last link: exact mass, centre of mass and inertia of the two together.

    The payload counts as known exactly: the uncertainties stated for the link remain those of the link alone.

    Parameters
    ----------
    arm
        The arm; it stays as it is.
    mass, position, inertia
        As for `Payload`.

    Returns
    -------
    RobotArm
        The arm whose last link carries the payload, noted among its assumptions.

    Raises
    ------
    ArmError
        If a number is not finite, the mass is negative, or the inertia is not symmetric.

    Warns
    -----
    GdAnalyzeWarning
        If the payload is beyond the arm's reach, heavier than such an arm carries, or physically
        inconsistent.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> with_payload(load_arm("puma560"), 1.5, [0.0, 0.0, 0.1]).mass[-1].item()
    1.59
    """
    position = array_of(position, "the position of the payload", ArmError)
    body = Link("payload", mass, position, _tensor(inertia))
    for message in check_payload(body, arm.reach):
        warnings.warn(message, GdAnalyzeWarning, stacklevel=2)
    last = arm.links[-1]
    together = last.mass + body.mass
    com = (last.mass * last.com + body.mass * body.com) / together if together > 0 else last.com
    stated = last.uncertainty
    if stated is not None and stated.body_mass is None:
        stated = dataclasses.replace(stated, body_mass=last.mass, body_com=last.com)
    merged = dataclasses.replace(
        last,
        mass=together,
        com=com,
        inertia_com=last.inertia_com
        + of_point_mass(last.mass, last.com - com)
        + body.inertia_com
        + of_point_mass(body.mass, body.com - com),
        uncertainty=stated,
        bare=last.bare or last,
    )
    place = ", ".join(f"{x:g}" for x in body.com)
    note = f"Link {last.name} carries a payload of {body.mass:g} kg at ({place}) m in its frame."
    return dataclasses.replace(arm, links=(*arm.links[:-1], merged), assumptions=(*arm.assumptions, note))


def parse_payload(line: str) -> Payload:
    """Read a payload from one line: mass,x,y,z[,xx,yy,zz[,xy,xz,yz]].

    Parameters
    ----------
    line
        kg, m, kg m^2, separated by commas; meanings as for `Payload`.

    Raises
    ------
    UsageError
        If the line is not 4, 7 or 10 numbers.
    ArmError
        If one of them is impossible.

    Examples
    --------
    >>> parse_payload("1.5, 0,0,0.1").mass
    1.5
    """
    words = line.split(",")
    numbers = [value for word in words if (value := number_in(word)) is not None]
    if len(numbers) != len(words) or len(numbers) not in (4, 7, 10):
        wrong = next((word.strip() for word in words if number_in(word) is None), None)
        raise UsageError(
            "the payload is not 4, 7 or 10 numbers",
            where=repr(line),
            expected="mass,x,y,z in kg and m, then xx,yy,zz (and xy,xz,yz) in kg m^2 if it is no point mass",
            found=f"{len(words)} numbers" if wrong is None else repr(wrong),
        )
    return Payload(numbers[0], np.array(numbers[1:4]), _tensor(numbers[4:] or None))


def _tensor(inertia: ArrayLike | None) -> FloatArray:
    if inertia is None:
        return np.zeros((3, 3))
    given = array_of(inertia, "the inertia of the payload", ArmError)
    if given.shape in ((3,), (6,)):
        return symmetric_tensor(*given)
    if given.shape == (3, 3):
        return given
    raise ArmError(
        "the inertia of the payload has the wrong shape",
        where="payload",
        expected="3 principal moments, 6 components (xx, yy, zz, xy, xz, yz) or a 3x3 tensor",
        found=f"shape {given.shape}",
    )
