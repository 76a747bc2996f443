"""The parts an arm is made of: placements, joints, links and drives, each valid once it exists."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.constants import keep
from gd_analyze.robots.link_uncertainty import LinkUncertainty
from gd_analyze.robots.names import require_name
from gd_analyze.text import in_python

JointKind = Literal["revolute", "prismatic"]

# A rotation typed with 6 digits is orthonormal to about 1e-6; anything worse is a mistake.
ORTHONORMAL_TOLERANCE = 1e-6
# Inertias measured by swinging a link are good to about 10 % (Armstrong, Khatib, Burdick 1986), so a triangle
# inequality broken by less is a measurement's error, not an impossible link; rounding to 3 digits is neither.
MEASUREMENT_TOLERANCE = 0.1
ROUNDING_TOLERANCE = 1e-3
# Products of inertia are typed once and mirrored; a rotation into other axes adds round-off only.
SYMMETRY_TOLERANCE = 1e-9
# Radius of gyration of what is no body but a point, m: moved over metres, round-off leaves a zero of 1e-8.
_POINT = 1e-6


@dataclass(frozen=True, eq=False)
class Placement:
    """A constant rigid displacement: x_parent = rotation @ x_child + translation (m)."""

    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    translation: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        rotation = keep(self, "rotation", (3, 3), "the rotation of a placement", "placement")
        if (
            np.abs(rotation.T @ rotation - np.eye(3)).max() > ORTHONORMAL_TOLERANCE
            or np.linalg.det(rotation) < 0
        ):
            raise ArmError("the rotation of a placement is not a rotation", found=str(rotation.tolist()))
        keep(self, "translation", (3,), "the translation of a placement", "placement")


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of one degree of freedom.

    Parameters
    ----------
    name
        Shown in tables and messages.
    kind
        "revolute" (turns, rad) or "prismatic" (slides, m).
    placement
        The joint frame in the previous link's frame; its origin is p_{i-1}.
    axis
        Unit vector z_{i-1} in the joint frame.
    lower, upper, rate_limit, acceleration_limit
        Limits in rad, rad/s, rad/s^2 (m, m/s, m/s^2); None where unknown.
    source
        Where the joint is described, for messages.
    """

    name: str
    kind: JointKind = "revolute"
    placement: Placement = field(default_factory=Placement)
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    lower: float | None = None
    upper: float | None = None
    rate_limit: float | None = None
    acceleration_limit: float | None = None
    source: Location | None = None

    def __post_init__(self) -> None:
        where = self.place
        require_name(self.name, "a joint's name", where)
        if self.kind not in ("revolute", "prismatic"):
            raise ArmError(
                f"joint {self.name} is of an unknown kind",
                where=where,
                expected="revolute or prismatic",
                found=in_python(self.kind),
            )
        keep(self, "axis", (3,), f"the axis of joint {self.name}", where)
        length = float(np.linalg.norm(self.axis))
        if abs(length - 1) > ORTHONORMAL_TOLERANCE:
            raise ArmError(
                f"the axis of joint {self.name} is not a unit vector",
                where=where,
                expected="length 1",
                found=f"length {length:g}",
            )
        for limit in ("lower", "upper", "rate_limit", "acceleration_limit"):
            given = getattr(self, limit)
            if given is not None and not (isinstance(given, float) and math.isinf(given)):
                what = f"the {limit.replace('_', ' ')} of joint {self.name}"
                keep(self, limit, (), what, where)
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            raise ArmError(
                f"the range of joint {self.name} is empty",
                where=where,
                expected="lower < upper",
                found=f"{self.lower:g} .. {self.upper:g}",
            )
        for kind, value in (("rate", self.rate_limit), ("acceleration", self.acceleration_limit)):
            if value is not None and not value > 0:
                raise ArmError(
                    f"the {kind} limit of joint {self.name} is not positive",
                    where=where,
                    expected="a positive number",
                    found=f"{value:g}",
                )

    @property
    def place(self) -> str:
        """Where the joint is described, or else which one it is."""
        return str(self.source or f"joint {self.name}")

    @property
    def unit(self) -> str:
        """Unit of the joint variable: rad or m."""
        return "rad" if self.kind == "revolute" else "m"

    @property
    def limits_told(self) -> tuple[str, str]:
        """Range, in degrees where it turns, and rate limit with units; a dash where unknown."""
        turns = self.kind == "revolute"
        ends = [end for end in (self.lower, self.upper) if end is not None and math.isfinite(end)]
        scale, unit = (180 / math.pi, "°") if turns else (1.0, "m")
        within = " .. ".join(f"{scale * end:.4g}" for end in ends)
        rate = self.rate_limit
        is_known = rate is not None and math.isfinite(rate)
        return f"{within} {unit}" if len(ends) == 2 else "–", f"{rate:.4g} {self.unit}/s" if is_known else "–"

    @property
    def effort_unit(self) -> str:
        """Unit of the generalized torque: N m or N."""
        return "N m" if self.kind == "revolute" else "N"


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid link; its data are given in link frame s.

    Parameters
    ----------
    name
        Shown in tables and messages.
    mass
        m_s, kg.
    com
        Centre of mass in link frame s, m.
    inertia_com
        I_s about the centre of mass along the axes of link frame s, kg m^2, shape (3, 3).
    frame
        Link frame s in the joint frame after the joint's motion.
    as_measured
        The inertia is a measurement kept as published: breaking the triangle inequality by up to 10 % of
        the largest principal moment is not worth a warning then.
    axial_only
        Only the moment about the joint's axis is known, and only it acts: allowed for the first link of
        an arm whose first joint turns; such an inertia need not satisfy the triangle inequality.
    uncertainty
        Stated standard uncertainties of mass, centre of mass and inertia; None where none is stated.
    source
        Where the link is described, for messages.
    bare
        The link without a payload that is merged into it: what a person stated of it.

    Raises
    ------
    ArmError
        If a number is not finite, the mass is negative or the inertia is not symmetric.

    Notes
    -----
    No body has principal moments that are negative, or one that is more than the other two together; yet
    dynamics can be computed with them, and `gd_analyze.robots.slips.implausible` says of how far off they
    are.
    """

    name: str
    mass: float
    com: FloatArray
    inertia_com: FloatArray
    frame: Placement = field(default_factory=Placement)
    as_measured: bool = False
    axial_only: bool = False
    uncertainty: LinkUncertainty | None = None
    source: Location | None = None
    bare: Link | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        where = self.place
        require_name(self.name, "a link's name", where)
        keep(self, "mass", (), f"the mass of link {self.name}", where, nonnegative="kg")
        keep(self, "com", (3,), f"the com of link {self.name}", where)
        inertia = keep(self, "inertia_com", (3, 3), f"the inertia of link {self.name}", where)
        scale = float(np.abs(inertia).max())
        if np.abs(inertia - inertia.T).max() > SYMMETRY_TOLERANCE * scale:
            raise ArmError(
                f"the inertia of link {self.name} is not symmetric",
                where=where,
                expected="I = I^T",
                found=str(inertia.tolist()),
            )

    @property
    def place(self) -> str:
        """Where the link is described, or else which one it is."""
        return str(self.source or f"link {self.name}")

    @property
    def is_point(self) -> bool:
        """Whether it has no inertia, or what round-off leaves of one that was moved from place to place."""
        return bool(np.abs(self.inertia_com).max() <= self.mass * _POINT**2)

    @property
    def principal_moments(self) -> FloatArray:
        """Of inertia about the centre of mass, ascending, kg m^2, shape (3,)."""
        return np.linalg.eigvalsh(self.inertia_com).astype(float)

    @property
    def excess(self) -> float:
        """Share of the largest principal moment by which it is more than the other two: 0 of any body."""
        least, middle, most = self.principal_moments.tolist()
        return 0.0 if self.axial_only else self._share(most - least - middle)

    @property
    def deficit(self) -> float:
        """Share of the largest principal moment by which the smallest is negative: 0 of any body."""
        return self._share(-float(self.principal_moments[0]))

    def _share(self, missing: float) -> float:
        """Share of the largest principal moment; 0 where it is what rounding to 3 digits leaves."""
        largest = float(np.abs(self.principal_moments).max())
        return missing / largest if missing > ROUNDING_TOLERANCE * largest and not self.is_point else 0.0


def moments_told(values: FloatArray) -> str:
    """Write moments of inertia."""
    return ", ".join(f"{value:.4g}" for value in values) + " kg m^2"


@dataclass(frozen=True)
class Drive:
    """One joint's drive; not part of FGL87's D, added only on request.

    Parameters
    ----------
    inertia
        Inertia of motor and gears seen at the joint, kg m^2 (kg for a prismatic joint).
    inertia_uncertainty
        Its stated standard uncertainty, same unit; None where not stated.
    gear_ratio
        Motor turns per joint turn, signed.
    viscous
        Viscous friction at the motor, N m s.
    coulomb
        Coulomb friction at the motor for positive and negative motion, N m.
    torque_limit
        Largest torque at the joint, N m.
    """

    inertia: float = 0.0
    inertia_uncertainty: float | None = None
    gear_ratio: float = 1.0
    viscous: float = 0.0
    coulomb: tuple[float, float] = (0.0, 0.0)
    torque_limit: float | None = None

    def __post_init__(self) -> None:
        keep(self, "inertia", (), "the inertia of a drive", "drive", nonnegative="kg m^2")
        keep(self, "gear_ratio", (), "the gear ratio of a drive", "drive")
        keep(self, "viscous", (), "the viscous friction of a drive", "drive", nonnegative="N m s")
        coulomb = keep(self, "coulomb", (2,), "the Coulomb friction of a drive", "drive")
        object.__setattr__(self, "coulomb", tuple(coulomb.tolist()))
        if self.torque_limit is not None:
            keep(self, "torque_limit", (), "the torque limit of a drive", "drive", nonnegative="N m")
        if self.inertia_uncertainty is not None:
            what = "the uncertainty of a drive's inertia"
            keep(self, "inertia_uncertainty", (), what, "drive", nonnegative="kg m^2")


@dataclass(frozen=True)
class DHRow:
    """One row of a Denavit-Hartenberg table, SI and radians; the joint variable adds to theta or d."""

    theta: float
    d: float
    a: float
    alpha: float

    def __post_init__(self) -> None:
        for name in ("theta", "d", "a", "alpha"):
            keep(self, name, (), f"{name} of a Denavit-Hartenberg row", "dh_table")
