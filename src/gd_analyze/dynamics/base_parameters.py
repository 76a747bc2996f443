"""Inertial parameters, in which torque is linear: ten per link, and the base parameters they combine into.

The ten are a link's mass m, its first moment m r and the inertia about the origin of its frame, (xx, xy, yy,
xz, yz, zz), all along the axes of that frame. In that frame a link that moves with angular velocity w,
angular acceleration w' and acceleration a of its origin (gravity included) needs

    force     m a + (w' x + w x w x) m r
    moment    m r x a + I w' + w x I w

about its origin; virtual power carries both to the joints below. C. G. Atkeson, C. H. An, J. M. Hollerbach
(1986).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray, apply, cross, outer, rigid_acceleration
from gd_analyze.dynamics.kinematics import joint_motions, solve_kinematics
from gd_analyze.dynamics.regrouped_links import RegroupedArm, regrouped
from gd_analyze.dynamics.regrouping import (
    PARAMETER_KINDS,
    Regrouping,
    moments_of,
    outer_parameters,
    regroupings,
)
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.parts import Placement, of_point_mass, second_moment
from gd_analyze.text import html_of, joined

# Entries of a symmetric tensor in the order of the parameters.
_ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
_TENSORS = np.zeros((6, 3, 3))
for _k, (_a, _b) in enumerate(_ENTRIES):
    _TENSORS[_k, _a, _b] = _TENSORS[_k, _b, _a] = 1.0

PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
# Moments per unit of each of these, about the same origin, (10, 10).
_FROM_INERTIA = np.eye(10)
for _k, _tensor in enumerate(_TENSORS, 4):
    _FROM_INERTIA[:, _k] = moments_of(np.pad(second_moment(_tensor), (0, 1)))

# Share of the summands, some dozen numbers along the arm, that rounding stays below.
_ROUND_OFF = 1e-13


def inertial_parameters(mass: float, first_moment: FloatArray, inertia: FloatArray) -> FloatArray:
    """Put m, m r and the inertia about the frame's origin into the order of `PARAMETERS`, shape (10,)."""
    return np.array([mass, *first_moment, *(inertia[entry] for entry in _ENTRIES)])


def parameters_of(arm: RobotArm) -> FloatArray:
    """Parameters of every link of an arm, shape (n links, 10)."""
    links = zip(arm.mass, arm.com, arm.inertia_com, strict=True)
    return np.array([inertial_parameters(m, m * r, inertia + of_point_mass(m, r)) for m, r, inertia in links])


def point_masses(parameters: FloatArray) -> FloatArray:
    """Parameters of point masses with the given masses and first moments, shape (..., 10)."""
    out = parameters.copy()
    mass, first = parameters[..., :1], parameters[..., 1:4]
    x, y, z = np.moveaxis(first / np.sqrt(np.where(mass > 0.0, mass, np.inf)), -1, 0)
    out[..., 4:] = np.stack([y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y], axis=-1)
    return out


def link_regressor(arm: RobotArm, q: Array, qd: Array, qdd: Array) -> FloatArray:
    """Torque of every joint per unit of every parameter; its product with `parameters_of` is the torque.

    N m (N for a prismatic joint) per unit of each of `PARAMETERS`, shape (n joints, n links, 10, N): zero for
    joints behind the link. Only the links' frames are used.
    """
    n, count = q.shape
    kinematics = solve_kinematics(arm, q)
    revolute, prismatic = joint_motions(arm, kinematics)
    out = np.zeros((n, n, len(PARAMETERS), count))
    omega = omega_dot = np.zeros((3, count))
    acceleration = -arm.gravity_vector[:, None]
    frame_below = np.zeros((3, 1))
    for s in range(n):
        # [FGL87] Table 3.2, but for the frames' origins in place of the centres of mass.
        axis, origin = kinematics.joint_axes[s], kinematics.joint_origins[s]
        acceleration = acceleration + rigid_acceleration(omega, omega_dot, origin - frame_below)
        if arm.is_revolute[s]:
            omega_dot = omega_dot + axis * qdd[s] + cross(omega, axis * qd[s])
            omega = omega + axis * qd[s]
        else:
            acceleration = acceleration + axis * qdd[s] + 2.0 * cross(omega, axis * qd[s])
        frame_below = kinematics.link_origins[s]
        acceleration = acceleration + rigid_acceleration(omega, omega_dot, frame_below - origin)
        into_frame = np.swapaxes(kinematics.link_rotations[s], 0, 1)
        force, moment = _wrench(*(apply(into_frame, vector) for vector in (omega, omega_dot, acceleration)))
        # Angular velocity of the frame and velocity of its origin per unit velocity of each joint.
        lever = frame_below - kinematics.joint_origins[: s + 1]
        velocity = cross(revolute[: s + 1], lever) + prismatic[: s + 1]
        out[: s + 1, s] = np.einsum("ian,pan->ipn", apply(into_frame, revolute[: s + 1]), moment)
        out[: s + 1, s, :4] += np.einsum("ian,pan->ipn", apply(into_frame, velocity), force)
    return out


def _wrench(omega: Array, omega_dot: Array, acceleration: Array) -> tuple[Array, Array]:
    """Force of the first four parameters (4, 3, N) and moment of all (10, 3, N), in the link frame."""
    count = omega.shape[-1]
    turning = outer(omega, omega)
    speed = np.einsum("an,an->n", omega, omega)
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turning[a, a] -= speed
        turning[a, b] -= omega_dot[c]
        turning[b, a] += omega_dot[c]
    force = np.concatenate([acceleration[None], np.swapaxes(turning, 0, 1)])
    spin = np.einsum("pab,bn->pan", _TENSORS, omega)
    of_inertia = np.einsum("pab,bn->pan", _TENSORS, omega_dot) + cross(omega, spin)
    of_first = cross(np.eye(3)[:, :, None], acceleration)
    return force, np.concatenate([np.zeros((1, 3, count)), of_first, of_inertia])


class Share(NamedTuple):
    """A link's parameter in a combination."""

    coefficient: float  # unit: the power of m by which the kinds differ
    # "m" is the link's mass, "mx", "my" and "mz" its first moments, and "Pxx", "Pxy", ... "Pzz" its second
    # ones, the sums of mass times x x, x y and so on, all in its frame on the joint's axis; its inertia about
    # the origin of that is Ixx = Pyy + Pzz, Ixy = -Pxy. "J" is the inertia of its drive
    kind: str
    link: int  # from 1


@dataclass(frozen=True)
class BaseParameter:
    """A base parameter: a number in which torque is linear.

    Parameters
    ----------
    symbol
        Kind of the first share in capitals, and its link: PXX4.
    link, kind
        Link (from 1) and kind of that share.
    unit
        kg, kg m or kg m^2.
    number
        Value in this arm.
    translation, rotation, drive
        Summands of the value: masses at their centres, inertias about these, and drives.
    combination
        All shares: the naming one first, then link by link.
    """

    symbol: str
    link: int
    kind: str
    unit: str
    number: float
    translation: float
    rotation: float
    drive: float
    combination: tuple[Share, ...]


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """The base parameters of an arm; iterable, and indexed by symbol.

    Parameters
    ----------
    arm, drives
        The arm, and whether drives are included.
    parameters
        The parameters, from base to tip.
    frames
        Frame of every link's parameters in that link's own frame; z is the axis of a revolute joint.
    matrix
        Base parameters per unit of `parameters_of`, in the links' own frames, without drives: shape (base
        parameters, n, 10).
    """

    arm: RobotArm
    drives: bool
    parameters: tuple[BaseParameter, ...]
    frames: tuple[Placement, ...]
    matrix: FloatArray

    def __len__(self) -> int:
        return len(self.parameters)

    def __iter__(self) -> Iterator[BaseParameter]:
        return iter(self.parameters)

    def __getitem__(self, symbol: str) -> BaseParameter:
        return {parameter.symbol: parameter for parameter in self.parameters}[symbol]

    def __repr__(self) -> str:
        return f"BaseParameters({self.arm.name!r}, {len(self)} of {len(self.original)})"

    def _repr_html_(self) -> str:
        """One row each, for a notebook."""
        rows = [
            [
                parameter.symbol,
                *(f"{x:.3g}" for x in (parameter.number, parameter.translation, parameter.rotation)),
                parameter.unit,
            ]
            for parameter in self.parameters
        ]
        headings = ["symbol", "number", "translation", "rotation", "unit"]
        return html_of(f"Base parameters of {self.arm.title or self.arm.name}", headings, rows, repr(self))

    @property
    def original(self) -> tuple[tuple[str, int], ...]:
        """Kind and link of all original parameters: ten per link, and drive inertias if included."""
        kinds = PARAMETER_KINDS if self.drives else PARAMETER_KINDS[:-1]
        return tuple((kind, link) for link in range(1, self.arm.n_joints + 1) for kind in kinds)

    @cached_property
    def never_acting(self) -> tuple[tuple[str, int], ...]:
        """Original parameters on which no torque depends."""
        acting = {
            (share.kind, share.link) for parameter in self.parameters for share in parameter.combination
        }
        return tuple(parameter for parameter in self.original if parameter not in acting)

    @cached_property
    def acting_alone(self) -> tuple[tuple[str, int], ...]:
        """Original parameters that are base parameters by themselves; the others act only in combination."""
        alone = [parameter.combination[0] for parameter in self.parameters if len(parameter.combination) == 1]
        shared = [share[1:] for parameter in self.parameters for share in parameter.combination]
        return tuple(share[1:] for share in alone if shared.count(share[1:]) == 1)


@strict
def base_parameters(arm: RobotArm | str | Path, drives: bool | None = None) -> BaseParameters:
    """Regroup the ten parameters of every link into the minimal set that torque is linear in.

    The frames are those of the recursion written for the arm (`regrouped_links`). The combinations depend
    only on geometry, gravity's direction and the kinds of the joints; see `regrouping`. Parameters that are
    zero in the arm are included; their base parameter may be zero.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    drives
        Include the drives' inertia; by default if the arm describes drives.

    Returns
    -------
    BaseParameters
        Value, unit and combination of every parameter, kg, kg m and kg m^2.

    Raises
    ------
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> base = gd.base_parameters("two_link")
    >>> base
    BaseParameters('two_link', 6 of 20)
    >>> base["PXX2"].combination
    (Share(coefficient=1.0, kind='Pxx', link=2), Share(coefficient=1.0, kind='Pyy', link=2))
    """
    arm = arm_of(arm)
    drives = arm.counts_drives(drives)
    rewritten = regrouped(arm)
    frames, (link_kinds, matrix) = _frames(arm, rewritten), _combined(rewritten, regroupings(rewritten))
    effects = _by_effect(arm, frames)
    if not drives:
        matrix, effects = (
            matrix[[PARAMETER_KINDS[kind] != "J" for _, kind in link_kinds], :, :10],
            effects[..., :10],
        )
        link_kinds = [(link, kind) for link, kind in link_kinds if PARAMETER_KINDS[kind] != "J"]
    parameters = []
    for (link, kind), row in zip(link_kinds, matrix, strict=True):
        # The naming share comes first, then link by link.
        order = sorted(np.argwhere(row).tolist(), key=lambda place: place != [link, kind])
        name = PARAMETER_KINDS[kind]
        symbol, number = f"{name.upper()}{joined((link,))}", _added(row * effects)
        if name == "m" or (name == "J" and not arm.is_revolute[link]):
            unit = "kg"
        else:
            unit = "kg m" if name[0] == "m" else "kg m^2"
        translation, rotation, drive = (_added(row * effect) for effect in effects)
        shares = tuple(Share(float(row[s, k]), PARAMETER_KINDS[k], s + 1) for s, k in order)
        parameter = BaseParameter(symbol, link + 1, name, unit, number, translation, rotation, drive, shares)
        parameters.append(parameter)
    into = [
        np.linalg.solve(outer_parameters(frame.rotation, frame.translation), _FROM_INERTIA)
        for frame in frames
    ]
    in_links = np.einsum("ksp,spo->kso", matrix[:, :, :10], np.array(into))
    return BaseParameters(arm, drives, tuple(parameters), frames, in_links)


def _frames(arm: RobotArm, rewritten: RegroupedArm) -> tuple[Placement, ...]:
    """The recursion's frame of every link, in the link's own frame."""
    kinematics = solve_kinematics(arm, np.zeros((arm.n_joints, 1)))
    rotation, origin = rewritten.rotation, rewritten.origin
    out = []
    for i, link in enumerate(rewritten.links):
        origin = origin + rotation @ link.translation
        rotation = rotation @ link.turned(0.0)
        into_link = kinematics.link_rotations[i, :, :, 0].T
        position = into_link @ (origin - kinematics.link_origins[i, :, 0])
        out.append(Placement(_rounded(into_link @ rotation), _rounded(position, arm.reach)))
    return tuple(out)


def _combined(arm: RegroupedArm, passed: tuple[Regrouping, ...]) -> tuple[list[tuple[int, int]], FloatArray]:
    """Link and kind of every base parameter, and its share of every link's parameters, (k, n, 11)."""
    n = len(arm.links)
    link_kinds: list[tuple[int, int]] = []
    rows: list[FloatArray] = []
    arriving = np.zeros((len(PARAMETER_KINDS), n, len(PARAMETER_KINDS)))
    for i in reversed(range(n)):
        regrouping, link = passed[i], arm.links[i]
        arriving[:, i] += np.eye(len(PARAMETER_KINDS))
        link_kinds = [(i, kind) for kind in regrouping.kept] + link_kinds
        lost_rows = arriving[list(regrouping.gone)]
        rows = [
            arriving[kind] - np.tensordot(regrouping.coefficients[:, kind], lost_rows, 1)
            for kind in regrouping.kept
        ] + rows
        body = np.tensordot(regrouping.coefficients[:, :10].T, lost_rows, 1)
        arriving = np.zeros_like(arriving)
        arriving[:10] = np.tensordot(outer_parameters(link.turned(0.0), link.translation), body, 1)
    matrix = np.array(rows).reshape(-1, n, len(PARAMETER_KINDS))
    # Most of them are exactly 0, 1 or -1.
    whole, sizes = np.rint(matrix), np.abs(matrix).max(axis=(1, 2), keepdims=True, initial=0.0)
    return link_kinds, np.where(np.abs(matrix - whole) <= _ROUND_OFF * sizes, whole + 0.0, matrix)


def _by_effect(arm: RobotArm, frames: tuple[Placement, ...]) -> FloatArray:
    """Parameters of links in these frames by origin, (3, n, 11): masses, inertias, drives."""
    out = np.zeros((3, arm.n_joints, len(PARAMETER_KINDS)))
    for i, frame in enumerate(frames):
        turned = frame.rotation.T
        com = _rounded(turned @ (arm.com[i] - frame.translation), arm.reach + np.abs(arm.com[i]).max())
        mass, inertia = arm.mass[i], turned @ arm.inertia_com[i] @ frame.rotation
        homogeneous_com = np.append(com, 1.0)
        out[0, i, :10] = moments_of(mass * np.outer(homogeneous_com, homogeneous_com))
        out[1, i, :10] = moments_of(np.pad(second_moment(inertia), (0, 1)))
    if arm.drives:
        out[2, :, 10] = arm.drive_inertia
    return out


def _added(values: FloatArray) -> float:
    """Sum of values that may cancel; exactly zero if they cancel up to round-off."""
    total = float(values.sum())
    return total if abs(total) > _ROUND_OFF * float(np.abs(values).sum()) else 0.0


def _rounded(values: FloatArray, size: float = 1.0) -> FloatArray:
    return np.where(np.abs(values) <= _ROUND_OFF * size, 0.0, values)
