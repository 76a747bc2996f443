"""Parts of an arm: placements, joints, links and drives, each checked when it is made and read-only after."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import Array, FloatArray, are_possible
from gd_analyze.errors import ArmError, Location
from gd_analyze.text import LARGEST, in_python, visible

JointKind = Literal["revolute", "prismatic"]

# A rotation typed with 6 digits is orthonormal to about 1e-6; anything worse is a mistake.
ORTHONORMAL_TOLERANCE = 1e-6
# Products of inertia are typed once and mirrored; a rotation into other axes adds round-off only.
_SYMMETRY_TOLERANCE = 1e-9
# Radius of gyration of a point mass, m: moved over metres, round-off leaves a zero of 1e-8.
_POINT = 1e-6
# No column or figure has room for more characters.
_LONGEST_NAME = 200


def checked(
    values: ArrayLike, shape: tuple[int, ...], what: str, where: Location | str, *, nonnegative: bool = False
) -> FloatArray:
    """Copy numbers into a read-only array.

    Raises
    ------
    ArmError
        If something is no number, the shape differs, or a number is not finite, too large or (on request)
        negative.
    """
    given = np.array(values)
    found = in_python(given.tolist())
    if given.dtype.kind not in "fiu":
        raise ArmError(f"{what} is not made of numbers", where=where, expected="numbers", found=found)
    array = given.astype(float)
    if array.shape != shape:
        raise ArmError(
            f"{what} has the wrong shape", where=where, expected=str(shape), found=str(array.shape)
        )
    if not np.isfinite(array).all():
        raise ArmError(f"{what} is not finite", where=where, expected="finite numbers", found=found)
    if not are_possible(array):
        expected = f"numbers up to {LARGEST:g} in SI units"
        raise ArmError(f"{what} is too large for any arm", where=where, expected=expected, found=found)
    if nonnegative and (array < 0).any():
        raise ArmError(f"{what} is negative", where=where, expected="0 or more", found=found)
    array.flags.writeable = False
    return array


def _keep(
    owner: object,
    name: str,
    shape: tuple[int, ...],
    what: str,
    where: Location | str,
    nonnegative: bool = False,
) -> FloatArray:
    """Replace a field of a frozen value by its checked copy, a float where the shape is ()."""
    array = checked(getattr(owner, name), shape, what, where, nonnegative=nonnegative)
    object.__setattr__(owner, name, array if shape else float(array))
    return array


def require_name(name: object, what: str, where: Location | str) -> None:
    """Raise an ArmError unless a name is one short line of printable text."""
    if not isinstance(name, str) or visible(name) != name or len(name) > _LONGEST_NAME:
        expected = f"one line of printable text, at most {_LONGEST_NAME} characters"
        raise ArmError(f"{what} is not a name", where=where, expected=expected, found=in_python(name))


def require_sentences(texts: Iterable[object], what: str, where: Location | str) -> None:
    """Raise an ArmError unless texts of one or more lines are printable."""
    for text in texts:
        if not isinstance(text, str) or visible(" ".join(text.split())) != " ".join(text.split()):
            expected = "text without control characters"
            raise ArmError(f"{what} is not printable", where=where, expected=expected, found=in_python(text))


def symmetric_tensor(
    xx: float, yy: float, zz: float, xy: float = 0.0, xz: float = 0.0, yz: float = 0.0
) -> FloatArray:
    """Symmetric matrix of its entries, shape (3, 3)."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def of_point_mass(mass: float, place: FloatArray) -> FloatArray:
    """Inertia of a point mass about the origin: the shift of the parallel-axis (Steiner) theorem."""
    added: FloatArray = mass * ((place @ place) * np.eye(3) - np.outer(place, place))
    return added


def second_moment(inertia_com: Array) -> Array:
    """Second moment of mass, tr(I)/2 - I, about the same point as the inertia."""
    return 0.5 * np.trace(inertia_com) * np.eye(3) - inertia_com


def second_moment_about_origin(mass: float, com: Array, inertia_com: Array) -> Array:
    """Second moment of mass about the origin that `com` is measured from, shape (3, 3)."""
    return second_moment(inertia_com) + mass * np.outer(com, com)


@dataclass(frozen=True, eq=False)
class Placement:
    """A constant rigid displacement: x_parent = rotation @ x_child + translation (m)."""

    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    translation: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        rotation = _keep(self, "rotation", (3, 3), "the rotation of a placement", "placement")
        off = np.abs(rotation.T @ rotation - np.eye(3)).max()
        if off > ORTHONORMAL_TOLERANCE or np.linalg.det(rotation) < 0:
            raise ArmError("the rotation of a placement is not a rotation", found=str(rotation.tolist()))
        _keep(self, "translation", (3,), "the translation of a placement", "placement")


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of one degree of freedom.

    Parameters
    ----------
    name
        Shown in tables and messages.
    kind
        "revolute" (rad) or "prismatic" (m).
    placement
        The joint frame in the previous link's frame; its origin is p_{i-1}.
    axis
        Unit vector z_{i-1} in the joint frame.
    lower, upper, velocity_limit, acceleration_limit
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
    velocity_limit: float | None = None
    acceleration_limit: float | None = None
    source: Location | None = None

    def __post_init__(self) -> None:
        where = self.place
        require_name(self.name, "a joint's name", where)
        if self.kind not in ("revolute", "prismatic"):
            expected, found = "revolute or prismatic", in_python(self.kind)
            what = f"joint {self.name} is of an unknown kind"
            raise ArmError(what, where=where, expected=expected, found=found)
        length = float(np.linalg.norm(_keep(self, "axis", (3,), f"the axis of joint {self.name}", where)))
        if abs(length - 1) > ORTHONORMAL_TOLERANCE:
            what = f"the axis of joint {self.name} is not a unit vector"
            raise ArmError(what, where=where, expected="length 1", found=f"length {length:g}")
        for limit in ("lower", "upper", "velocity_limit", "acceleration_limit"):
            given = getattr(self, limit)
            what = f"the {limit.replace('_', ' ')} of joint {self.name}"
            if given is not None and not (isinstance(given, float) and math.isinf(given)):
                _keep(self, limit, (), what, where)
            if given is not None and limit.endswith("limit") and not given > 0:
                expected, found = "a positive number", f"{given:g}"
                raise ArmError(f"{what} is not positive", where=where, expected=expected, found=found)
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            what, found = f"the range of joint {self.name} is empty", f"{self.lower:g} .. {self.upper:g}"
            raise ArmError(what, where=where, expected="lower < upper", found=found)

    @property
    def place(self) -> str:
        """Where the joint is described, or else which one it is."""
        return str(self.source or f"joint {self.name}")

    @property
    def unit(self) -> str:
        """Unit of the joint variable: rad or m."""
        return "rad" if self.kind == "revolute" else "m"

    @property
    def effort_unit(self) -> str:
        """Unit of the generalized torque: N m or N."""
        return "N m" if self.kind == "revolute" else "N"


@dataclass(frozen=True, eq=False)
class LinkUncertainty:
    """Standard uncertainties of a link's inertial parameters, independent of each other.

    Parameters
    ----------
    mass
        Of the mass, kg; None where not stated, as below.
    com
        Of the centre of mass in the link frame, m, shape (3,).
    inertia
        Of the entries of the inertia tensor along the axes of the link frame, kg m^2, shape (3, 3),
        symmetric: xy and yx are one number.
    inertia_about
        Point the inertia was stated about, "com" or "origin" of the link frame. About the other point its
        error would depend on those of mass and centre of mass.
    body_mass, body_com
        Mass and centre of mass of the link without its payload, which counts as known exactly; None where
        the link carries none.
    """

    mass: float | None = None
    com: FloatArray | None = None
    inertia: FloatArray | None = None
    inertia_about: Literal["com", "origin"] = "com"
    body_mass: float | None = None
    body_com: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, shape, what in (
            ("mass", (), "the uncertainty of a link's mass"),
            ("com", (3,), "the uncertainty of a link's com"),
            ("inertia", (3, 3), "the uncertainty of a link's inertia"),
            ("body_mass", (), "the mass of an uncertain body"),
            ("body_com", (3,), "the com of an uncertain body"),
        ):
            if getattr(self, name) is not None:
                _keep(self, name, shape, what, "link uncertainty", nonnegative=name != "body_com")
        if self.inertia is not None and not np.array_equal(self.inertia, self.inertia.T):
            found = str(self.inertia.tolist())
            raise ArmError("the uncertainty of a link's inertia is not symmetric", found=found)


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
        I_s about the centre of mass along the axes of link frame s, kg m^2, shape (3, 3). It may be
        physically inconsistent, as published measurements are; `plausibility.py` reports by how much.
    frame
        Link frame s in the joint frame after the joint's motion.
    as_measured
        The inertia is a measurement kept as published: a triangle inequality violated by up to 10 % of the
        largest principal moment gives no warning then.
    axial_only
        Only the moment about the joint's axis is known, and only it acts: allowed for the first link of
        an arm whose first joint is revolute.
    uncertainty
        Stated standard uncertainties; None where none is stated.
    source
        Where the link is described, for messages.
    bare
        The link as described, without the payload that is merged into it.
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
        _keep(self, "mass", (), f"the mass of link {self.name}", where, nonnegative=True)
        _keep(self, "com", (3,), f"the com of link {self.name}", where)
        inertia = _keep(self, "inertia_com", (3, 3), f"the inertia of link {self.name}", where)
        if np.abs(inertia - inertia.T).max() > _SYMMETRY_TOLERANCE * np.abs(inertia).max():
            what = f"the inertia of link {self.name} is not symmetric"
            raise ArmError(what, where=where, expected="I = I^T", found=str(inertia.tolist()))

    @property
    def place(self) -> str:
        """Where the link is described, or else which one it is."""
        return str(self.source or f"link {self.name}")

    @property
    def is_point(self) -> bool:
        """Whether it has no inertia, or what round-off leaves of one that was moved."""
        return bool(np.abs(self.inertia_com).max() <= self.mass * _POINT**2)

    @property
    def principal_moments(self) -> FloatArray:
        """Of inertia about the centre of mass, ascending, kg m^2, shape (3,)."""
        return np.linalg.eigvalsh(self.inertia_com).astype(float)

    @property
    def moments_text(self) -> str:
        """Principal moments with their unit."""
        return ", ".join(f"{value:.4g}" for value in self.principal_moments) + " kg m^2"


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
        for name, what in (
            ("inertia", "the inertia of a drive"),
            ("inertia_uncertainty", "the uncertainty of a drive's inertia"),
            ("gear_ratio", "the gear ratio of a drive"),
            ("viscous", "the viscous friction of a drive"),
            ("torque_limit", "the torque limit of a drive"),
        ):
            if getattr(self, name) is not None:
                _keep(self, name, (), what, "drive", nonnegative=name != "gear_ratio")
        coulomb = _keep(self, "coulomb", (2,), "the Coulomb friction of a drive", "drive")
        object.__setattr__(self, "coulomb", tuple(coulomb.tolist()))


@dataclass(frozen=True)
class DHRow:
    """One row of a Denavit-Hartenberg table, SI and radians; the joint variable adds to theta or d."""

    theta: float
    d: float
    a: float
    alpha: float

    def __post_init__(self) -> None:
        for name in ("theta", "d", "a", "alpha"):
            _keep(self, name, (), f"{name} of a Denavit-Hartenberg row", "dh_table")
