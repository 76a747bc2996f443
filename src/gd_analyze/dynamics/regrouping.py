"""Changes of a link's parameters that act on torque like changes of the previous link.

Kinetic energy is a sum of q'_j q'_k tr(X_j P X_k^T), with the link's second moment P (4x4, including mass and
first moment) and the motion X_j of the link by joint j, a 4x4 matrix in the link's frame; the torque of
gravity has the motion of the base along gravity in place of one of the two. So a change of P in link i acts
like one in link i-1 under two conditions:

    - it does not affect products of joint i's own motion with any motion that reaches the link,
    - its effect on products of two earlier motions is the same for every q_i,

and only then, as link i is the last that q_i and q'_i move. All these products are polynomials of degree 2 in
cos q_i and sin q_i, or in a prismatic q_i, so that five or three values of it span them. No torque is
evaluated, and no state drawn. Moving all such changes to the previous link, from tip to base, leaves a
minimal set. M. Gautier and W. Khalil (1990) find most of it link by link; this finds the rest, from parallel
axes, prismatic joints and gravity along an axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray, homogeneous, skew
from gd_analyze.dynamics.regrouped_links import RegroupedArm, RegroupedLink

# A link's mass, its first and second moments, and its drive's inertia.
PARAMETER_KINDS = ("m", "mx", "my", "mz", "Pxx", "Pxy", "Pyy", "Pxz", "Pyz", "Pzz", "J")
# Places of the ten in the 4x4 matrix of moments.
_ENTRIES = tuple(tuple("xyz".find(axis) % 4 for axis in f"{kind[1:]:m<2}") for kind in PARAMETER_KINDS[:-1])
# Directions larger than this share are not round-off: their relative error, eps over it, is smaller again.
# Lengths are in units of the arm's, which gives shares a meaning.
_ROUND_OFF_SHARE = 1e-7
# A drive's inertia is added to its link if possible, so that it may be omitted; then the first kind leaves
# whose pivot is at least this share of the largest: solving for it loses at most a digit.
_DRIVE = PARAMETER_KINDS.index("J")
_LEAVES_FIRST = tuple(
    PARAMETER_KINDS.index(kind) for kind in ("m", "mz", "Pzz", "Pxz", "Pyz", "Pxy", "Pyy", "my", "mx", "Pxx")
)
_LEAST_SHARE_OF_LARGEST = 0.1


@dataclass(frozen=True, eq=False)
class Regrouping:
    """Parameters that one link passes to the previous link."""

    gone: tuple[int, ...]  # kinds of `PARAMETER_KINDS` that it loses
    # A row per lost kind, shape (gone, 11). The kind acts as minus these coefficients of the kinds that stay,
    # plus the body of all of them, carried by the previous link
    coefficients: FloatArray

    @property
    def kept(self) -> tuple[int, ...]:
        """Kinds of `PARAMETER_KINDS` that stay: the link's base parameters."""
        return tuple(kind for kind in range(len(PARAMETER_KINDS)) if kind not in self.gone)


def regroupings(arm: RegroupedArm) -> tuple[Regrouping, ...]:
    """Find what every link passes on, from base to tip; the parameters' values do not matter."""
    length = max((float(np.linalg.norm(link.translation)) for link in arm.links), default=0.0) or 1.0
    strength = float(np.linalg.norm(arm.gravity)) or 1.0
    motions = _motion(np.zeros(3), arm.gravity / strength)[None]
    products = np.zeros((0, 4, 4))
    out = []
    for link in arm.links:
        places = _places(link, length)
        back = np.linalg.inv(places)
        # Motions of this link by earlier joints, at every position of its own joint.
        motions = _span((back[:, None] @ motions @ places[:, None]).reshape(-1, 4, 4))
        earlier = np.swapaxes(places, 1, 2)[:, None] @ products @ places[:, None]
        still, z = np.zeros(3), np.array([0.0, 0.0, 1.0])
        joint_motion = _motion(z, still) if link.prismatic is None else _motion(still, link.prismatic)
        mixed = joint_motion.T @ motions
        mixed = 0.5 * (mixed + np.swapaxes(mixed, 1, 2))
        alone = joint_motion.T @ joint_motion
        # The drive's inertia acts in the square of the joint's own velocity, and nowhere else.
        visible = [
            *((form, 0.0) for form in (*mixed, *np.concatenate(earlier[1:] - earlier[0]))),
            (alone, 1.0),
        ]
        functionals = np.array([[*(UNIT_BODIES * form).sum(axis=(1, 2)), drive] for form, drive in visible])
        scale = length ** np.array([*_LENGTHS, 2 if link.prismatic is None else 0])
        # Changes invisible to all functionals, orthonormal rows.
        _, sizes, directions = np.linalg.svd(functionals)
        invisible = directions[np.count_nonzero(sizes > _ROUND_OFF_SHARE * sizes[0]) :]
        out.append(_leaving(invisible, scale))
        motions = _span(np.concatenate([motions, joint_motion[None]]))
        products = _span(np.concatenate([*earlier, mixed, alone[None]]))
    return tuple(out)


def outer_parameters(rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """Matrix (10, 10) from the ten parameters in a frame, placed by this, to those in the outer frame."""
    place = homogeneous(rotation, translation)
    return np.column_stack([moments_of(place @ body @ place.T) for body in UNIT_BODIES])


def moments_of(body: FloatArray) -> FloatArray:
    """Mass, first and second moments, (10,), from [[second, first], [first, mass]], (4, 4)."""
    return np.array([body[entry] for entry in _ENTRIES])


UNIT_BODIES = np.zeros((10, 4, 4))
for _k, _entry in enumerate(_ENTRIES):
    UNIT_BODIES[(_k, *_entry)] = UNIT_BODIES[(_k, *_entry[::-1])] = 1.0
_LENGTHS = tuple(len(kind) - 1 for kind in PARAMETER_KINDS[:-1])


def _motion(angular: FloatArray, linear: FloatArray) -> FloatArray:
    """Matrix of a motion: a point's velocity from its position."""
    return np.vstack([np.column_stack([skew(angular), linear]), np.zeros(4)])


def _places(link: RegroupedLink, length: float) -> FloatArray:
    """The link's frame in the previous one, lengths in units of `length`, at sufficient values of q."""
    lever = link.translation / length
    if link.prismatic is not None:
        levers = [lever + slid * link.prismatic for slid in (0.0, -1.0, 1.0)]
        return np.array([homogeneous(link.rotation, vector) for vector in levers])
    return np.array([homogeneous(link.turned(angle), lever) for angle in 2 * math.pi / 5 * np.arange(5)])


def _span(matrices: FloatArray) -> FloatArray:
    """Orthonormal basis of the span of some matrices."""
    _, sizes, directions = np.linalg.svd(matrices.reshape(-1, 16), full_matrices=False)
    return directions[sizes > _ROUND_OFF_SHARE * max(sizes[0], np.finfo(float).tiny)].reshape(-1, 4, 4)


def _leaving(changes: FloatArray, scale: FloatArray) -> Regrouping:
    """Choose one kind to leave for every change, and express each change by it."""
    lost: list[int] = []
    remainder = changes
    while len(lost) < len(changes):
        # Remainder of each kind after those chosen.
        sizes = np.linalg.norm(remainder, axis=0)
        least = _LEAST_SHARE_OF_LARGEST * sizes[:_DRIVE].max()
        best = next(kind for kind in _LEAVES_FIRST if sizes[kind] >= least)
        lost.append(_DRIVE if sizes[_DRIVE] > _ROUND_OFF_SHARE else best)
        direction = remainder[:, lost[-1]] / sizes[lost[-1]]
        remainder = remainder - np.outer(direction, direction @ remainder)
    coefficients = np.linalg.solve(changes[:, lost], changes)
    coefficients[np.abs(coefficients) < _ROUND_OFF_SHARE] = 0.0
    # A unit of a kind in the arm's own length is scale units of it.
    return Regrouping(tuple(lost), np.asarray(coefficients * scale / scale[lost, None], dtype=float))
