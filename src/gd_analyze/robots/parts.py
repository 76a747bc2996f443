"""Parts of an arm: placements, joints, links and drives, checked when created, and read-only."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arguments import require_flags_of
from gd_analyze.arrays import Array, FloatArray, are_possible
from gd_analyze.errors import ArmError, Location
from gd_analyze.text import LARGEST, in_python, visible

JointKind = Literal["revolute", "prismatic"]

# A rotation typed with 6 digits is orthonormal to about 1e-6; anything worse is a mistake.
ORTHONORMAL_TOLERANCE = 1e-6
# Products of inertia are typed once and mirrored; a rotation into other axes adds only round-off.
_SYMMETRY_TOLERANCE = 1e-9
# Radius of gyration of a point mass, m: moved by metres, a zero becomes round-off of 1e-8.
_POINT_GYRATION_METRES = 1e-6
# Columns and figures have no room for more characters.
_LONGEST_NAME = 200


def checked(
    values: ArrayLike,
    shape: tuple[int, ...],
    quantity: str,
    where: Location | str,
    *,
    nonnegative: bool = False,
) -> FloatArray:
    """Read-only copy of numbers; ArmError unless all are finite, possible and have this shape."""
    try:
        numbers = np.array(values)
    except ValueError:  # rows of different lengths
        numbers = np.array(None)
    if numbers.dtype.kind not in "fiu":
        problem, expected = "is not made of numbers", "numbers"
    elif numbers.shape != shape:
        problem, expected = "has the wrong shape", f"shape {shape}"
    elif not np.isfinite(numbers).all():
        problem, expected = "is not finite", "finite numbers"
    elif not are_possible(numbers):
        problem, expected = "is too large for any arm", f"numbers up to {LARGEST:g} in SI units"
    elif nonnegative and (numbers < 0).any():
        problem, expected = "is negative", "0 or more"
    else:
        array = numbers.astype(float)
        array.flags.writeable = False
        return array
    value_text = in_python(numbers.tolist() if numbers.dtype.kind in "fiu" else values)
    raise ArmError(f"{quantity} {problem}", where=where, expected=expected, found=value_text)


def _check(
    owner: object,
    subject: str,
    where: Location | str,
    nonnegative: Container[str] = (),
    **shapes: tuple[int, ...],
) -> None:
    """Replace fields of a frozen value by checked copies, floats if the shape is (); None stays."""
    for name, shape in shapes.items():
        value = getattr(owner, name)
        if value is not None or getattr(type(owner), name, ...) is not None:
            array = checked(value, shape, f"{name} of {subject}", where, nonnegative=name in nonnegative)
            object.__setattr__(owner, name, array if shape else float(array))


def is_rotation(matrix: ArrayLike) -> bool:
    """Whether three rows are orthonormal and right-handed."""
    rows = np.asarray(matrix)
    deviation = np.abs(rows.T @ rows - np.eye(3)).max()
    return bool(deviation <= ORTHONORMAL_TOLERANCE and np.linalg.det(rows) > 0)


def is_name(text: object) -> bool:
    """Whether a text is one short line of printable characters."""
    return isinstance(text, str) and visible(text) == text and len(text) <= _LONGEST_NAME


def is_sentence(text: object) -> bool:
    """Whether a text of one or more lines is printable."""
    return isinstance(text, str) and all(visible(word) == word for word in text.split())


def require_name(name: object, description: str, where: Location | str) -> None:
    """Raise an ArmError unless `is_name`."""
    if not is_name(name):
        expected = f"one line of printable text, at most {_LONGEST_NAME} characters"
        raise ArmError(f"{description} is not a name", where=where, expected=expected, found=in_python(name))


def symmetric_tensor(
    xx: float, yy: float, zz: float, xy: float = 0.0, xz: float = 0.0, yz: float = 0.0
) -> FloatArray:
    """Symmetric matrix of its entries, shape (3, 3)."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def entries_of(tensor: FloatArray) -> dict[str, float]:
    """Entries of a symmetric matrix, for `symmetric_tensor`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = tensor.tolist()
    return {"xx": xx, "yy": yy, "zz": zz, "xy": xy, "xz": xz, "yz": yz}


def of_point_mass(mass: float, place: FloatArray) -> FloatArray:
    """Inertia of a point mass about the origin: the shift of the parallel-axis (Steiner) theorem."""
    added: FloatArray = mass * ((place @ place) * np.eye(3) - np.outer(place, place))
    return added


def second_moment(inertia_com: Array) -> Array:
    """Second moment of mass, tr(I)/2 - I, about the same point as the inertia."""
    return 0.5 * np.trace(inertia_com) * np.eye(3) - inertia_com


def pseudo_inertia(mass: float, com: Array, inertia_com: Array) -> Array:
    """Matrix [[second, first], [first, mass]] of moments of mass about the origin of `com`, shape (4, 4)."""
    first = mass * com
    second = second_moment(inertia_com) + mass * np.outer(com, com)
    return np.block([[second, first[:, None]], [first, mass]])


@dataclass(frozen=True, eq=False)
class Placement:
    """A constant rigid displacement: x_parent = rotation @ x_child + translation (m)."""

    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    translation: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        _check(self, "a placement", "placement", rotation=(3, 3), translation=(3,))
        if not is_rotation(self.rotation):
            matrix_text = str(self.rotation.tolist())
            raise ArmError("rotation of a placement is not a rotation", where="placement", found=matrix_text)


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of one degree of freedom; limits are None if unknown, and infinite ones become None."""

    name: str
    kind: JointKind = "revolute"
    placement: Placement = field(default_factory=Placement)  # of the joint frame in the previous link's
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))  # unit z_{i-1}, joint frame
    lower: float | None = None  # rad or m
    upper: float | None = None
    velocity_limit: float | None = None  # rad/s or m/s
    acceleration_limit: float | None = None  # rad/s^2 or m/s^2
    source: Location | None = None  # where the joint is described, for messages

    def __post_init__(self) -> None:
        joint, where = f"joint {self.name}", self.place
        require_name(self.name, "a joint's name", where)
        if self.kind not in ("revolute", "prismatic"):
            expected, kind = "revolute or prismatic", in_python(self.kind)
            raise ArmError(f"{joint} has an unknown kind", where=where, expected=expected, found=kind)
        _check(self, joint, where, axis=(3,))
        length = float(np.linalg.norm(self.axis))
        if abs(length - 1) > ORTHONORMAL_TOLERANCE:
            message = f"axis of {joint} is not a unit vector"
            raise ArmError(message, where=where, expected="length 1", found=f"length {length:g}")
        for limit in ("lower", "upper", "velocity_limit", "acceleration_limit"):
            value, unknown = getattr(self, limit), -math.inf if limit == "lower" else math.inf
            if isinstance(value, float) and value == unknown:
                object.__setattr__(self, limit, None)
                continue
            _check(self, joint, where, **{limit: ()})
            if value is not None and limit.endswith("limit") and not value > 0:
                message = f"{limit} of {joint} is not positive"
                raise ArmError(message, where=where, expected="a positive number", found=f"{value:g}")
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            range_text = f"{self.lower:g} .. {self.upper:g}"
            raise ArmError(
                f"range of {joint} is empty", where=where, expected="lower < upper", found=range_text
            )

    @property
    def place(self) -> str:
        """Place in the file, or else the joint's name."""
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
    """Standard uncertainties of a link's inertial parameters, independent of each other; None if not stated.

    A payload is taken as exactly known: they are those of the link without it.
    """

    mass: float | None = None  # kg
    com: FloatArray | None = None  # (3,), m, in the link frame
    inertia: FloatArray | None = None  # (3, 3), kg m^2, of the entries: xy and yx are the same number
    inertia_about: Literal["com", "origin"] = "com"  # reference point of the stated inertia

    def __post_init__(self) -> None:
        subject, where = "a link's uncertainty", "link uncertainty"
        _check(self, subject, where, ("mass", "com", "inertia"), mass=(), com=(3,), inertia=(3, 3))
        if self.inertia is not None and not np.array_equal(self.inertia, self.inertia.T):
            tensor_text = str(self.inertia.tolist())
            raise ArmError(f"inertia of {subject} is not symmetric", where=where, found=tensor_text)


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid link; its data are given in link frame s.

    The inertia may be physically inconsistent, as published measurements are; `plausibility.py` reports that.
    """

    name: str
    mass: float  # m_s, kg
    com: FloatArray  # (3,), m
    inertia_com: FloatArray  # I_s about the centre of mass, (3, 3), kg m^2
    frame: Placement = field(default_factory=Placement)  # of link frame s in the moved joint frame
    as_measured: bool = False  # triangle inequality violated by up to 10 %: no warning
    axial_only: bool = False  # only the moment about the joint's axis is known, and only it matters
    uncertainty: LinkUncertainty | None = None
    source: Location | None = None  # where the link is described, for messages
    bare: Link | None = field(default=None, repr=False)  # the link without the payload merged into it

    def __post_init__(self) -> None:
        require_flags_of(self)
        link, where = f"link {self.name}", self.place
        require_name(self.name, "a link's name", where)
        _check(self, link, where, ("mass",), mass=(), com=(3,), inertia_com=(3, 3))
        inertia = self.inertia_com
        if np.abs(inertia - inertia.T).max() > _SYMMETRY_TOLERANCE * np.abs(inertia).max():
            message, tensor_text = f"inertia_com of {link} is not symmetric", str(inertia.tolist())
            raise ArmError(message, where=where, expected="I = I^T", found=tensor_text)
        # Rotations leave round-off between the halves.
        object.__setattr__(self, "inertia_com", checked((inertia + inertia.T) / 2, (3, 3), link, where))

    @property
    def place(self) -> str:
        """Place in the file, or else the link's name."""
        return str(self.source or f"link {self.name}")

    @property
    def is_point(self) -> bool:
        """Whether it has no inertia, up to round-off of moving it."""
        return bool(np.abs(self.inertia_com).max() <= self.mass * _POINT_GYRATION_METRES**2)

    @property
    def principal_moments(self) -> FloatArray:
        """Principal moments of inertia about the centre of mass, ascending, kg m^2, shape (3,)."""
        return np.linalg.eigvalsh(self.inertia_com).astype(float)

    @property
    def moments_text(self) -> str:
        """Principal moments with their unit."""
        return ", ".join(f"{value:.4g}" for value in self.principal_moments) + " kg m^2"


@dataclass(frozen=True)
class Drive:
    """One joint's drive; not part of FGL87's D."""

    inertia: float = 0.0  # of motor and gears, seen at the joint, kg m^2 (kg if prismatic)
    inertia_uncertainty: float | None = None  # standard uncertainty, same unit
    gear_ratio: float = 1.0  # motor turns per joint turn, signed
    viscous: float = 0.0  # friction at the motor, N m s
    coulomb: tuple[float, float] = (0.0, 0.0)  # friction at the motor, positive and negative motion, N m
    torque_limit: float | None = None  # at the joint, N m (N)

    def __post_init__(self) -> None:
        positive = {"inertia": (), "inertia_uncertainty": (), "viscous": (), "torque_limit": ()}
        _check(self, "a drive", "drive", positive, **positive, gear_ratio=(), coulomb=(2,))
        object.__setattr__(self, "coulomb", tuple(np.array(self.coulomb).tolist()))


@dataclass(frozen=True)
class DHRow:
    """One row of a Denavit-Hartenberg table, rad and m; the joint variable adds to theta or d."""

    theta: float
    d: float
    a: float
    alpha: float

    def __post_init__(self) -> None:
        _check(self, "a Denavit-Hartenberg row", "dh_table", theta=(), d=(), a=(), alpha=())
