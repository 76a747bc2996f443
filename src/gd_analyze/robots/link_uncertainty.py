"""How well a link's mass, centre of mass and inertia are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.constants import keep


@dataclass(frozen=True, eq=False)
class LinkUncertainty:
    """Standard uncertainties of a link's inertial parameters, each independent of all others.

    Parameters
    ----------
    mass
        Of the mass, kg; None where not stated, as below.
    com
        Of the coordinates of the centre of mass in the link frame, m, shape (3,).
    inertia
        Of the entries of the inertia tensor along the axes of the link frame, kg m^2, shape (3, 3),
        symmetric: xy and yx are one number.
    inertia_about
        The point the inertia was stated about, "com" or "origin" of the link frame. About the other point
        its error would not be independent of those of mass and centre of mass.
    body_mass, body_com
        Mass and centre of mass of the body they are of, where the link holds more than that; None where it
        is the link itself. What a link holds besides, such as a payload, counts as known exactly.

    Raises
    ------
    ArmError
        If a number is negative or not finite, or a shape is wrong.
    """

    mass: float | None = None
    com: FloatArray | None = None
    inertia: FloatArray | None = None
    inertia_about: Literal["com", "origin"] = "com"
    body_mass: float | None = None
    body_com: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, shape, what, unit in (
            ("mass", (), "the uncertainty of a link's mass", "kg"),
            ("com", (3,), "the uncertainty of a link's com", "m"),
            ("inertia", (3, 3), "the uncertainty of a link's inertia", "kg m^2"),
            ("body_mass", (), "the mass of an uncertain body", "kg"),
            ("body_com", (3,), "the com of an uncertain body", None),
        ):
            if getattr(self, name) is not None:
                keep(self, name, shape, what, "link uncertainty", nonnegative=unit)
        if self.inertia is not None and not np.array_equal(self.inertia, self.inertia.T):
            raise ArmError(
                "the uncertainty of a link's inertia is not symmetric",
                expected="xy and yx the same, and so on",
                found=str(self.inertia.tolist()),
            )
