"""How well a link's mass, centre of mass and inertia are known."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gd_analyze.errors import ArmError
from gd_analyze.robots.constants import constant
from gd_analyze.vectors import FloatArray


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
        self._keep("mass", (), "the uncertainty of a link's mass", nonnegative=True)
        self._keep("com", (3,), "the uncertainty of a link's com", nonnegative=True)
        self._keep("inertia", (3, 3), "the uncertainty of a link's inertia", nonnegative=True)
        self._keep("body_mass", (), "the mass of an uncertain body", nonnegative=True)
        self._keep("body_com", (3,), "the com of an uncertain body")
        if self.inertia is not None and not np.array_equal(self.inertia, self.inertia.T):
            raise ArmError(
                "the uncertainty of a link's inertia is not symmetric",
                expected="xy and yx the same, and so on",
                found=str(self.inertia.tolist()),
            )

    def _keep(self, name: str, shape: tuple[int, ...], what: str, nonnegative: bool = False) -> None:
        """Check what is given and keep a copy of it that cannot change."""
        if getattr(self, name) is None:
            return
        value = constant(getattr(self, name), shape, what, "link uncertainty")
        if nonnegative and (value < 0).any():
            raise ArmError(f"{what} is negative", expected="0 or more", found=str(value.tolist()))
        object.__setattr__(self, name, value if shape else float(value))

    def of_body(self, mass: float, com: FloatArray) -> LinkUncertainty:
        """Keep to the body of given mass and centre of mass, whatever its link holds besides from now on."""
        if self.body_mass is not None:
            return self
        return dataclasses.replace(self, body_mass=mass, body_com=com)
