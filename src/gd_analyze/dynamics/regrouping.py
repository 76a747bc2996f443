"""Which changes of a link's parameters no torque tells from a change of the link before.

Kinetic energy is a sum of q'_j q'_k tr(X_j P X_k^T), P the link's second moment (4x4, mass and first moment
in it) and X_j the motion that joint j makes of the link, a 4x4 matrix in the link's frame; the torque of
gravity is the same with the motion of the base along gravity in place of one of the two. So a change of P in
link i acts as one of link i-1 where two things hold:

    - nothing of it is in the products of joint i's own motion with any motion that reaches the link,
    - what is in the products of two earlier ones is the same for every q_i,

and only there, as link i is the last that q_i and q'_i move. All these products are polynomials of degree 2
in cos q_i and sin q_i, or in a prismatic q_i, and what they span is spanned at five or three values of it. No
torque is evaluated, and no state drawn. Every link's changes that the link before takes over, from the tip to
the base, are all there are, and what remains is a minimal set: M. Gautier and W. Khalil (1990) find most of
it link by link, and this the rest, which parallel axes, prismatic joints and gravity along an axis leave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray, homogeneous, skew
from gd_analyze.dynamics.regrouped_links import RegroupedArm, RegroupedLink

# A link's mass, its first and second moments, and its drive's inertia.
KINDS = ("m", "mx", "my", "mz", "Pxx", "Pxy", "Pyy", "Pxz", "Pyz", "Pzz", "J")
# Where the ten stand in the 4x4 matrix of moments.
_ENTRIES = tuple(tuple("xyz".find(axis) % 4 for axis in f"{kind[1:]:m<2}") for kind in KINDS[:-1])
# Directions are told from round-off where they stand out by this share: what is known to eps is then known
# to eps over it, which is less again. Lengths are in the arm's own, so that shares mean something.
_STANDS_OUT = 1e-7
# A drive's inertia is counted to its link wherever that can be, so that it may be left away; then what comes
# first leaves, if it is at least this share of what any other would be: solving for it loses a digit at most.
_DRIVE = KINDS.index("J")
_LEAVES_FIRST = tuple(
    KINDS.index(kind) for kind in ("m", "mz", "Pzz", "Pxz", "Pyz", "Pxy", "Pyy", "my", "mx", "Pxx")
)
_AS_GOOD = 0.1


@dataclass(frozen=True, eq=False)
class Regrouping:
    """What one link passes to the link before."""

    gone: tuple[int, ...]  # which of `KINDS` it loses
    # What a unit of each of those is beside itself: it acts as minus this of the kinds that stay, and as the
    # body of all of it carried by the link before; shape (gone, 11)
    instead: FloatArray

    @property
    def kept(self) -> tuple[int, ...]:
        """Which of `KINDS` stay: the link's base parameters."""
        return tuple(kind for kind in range(len(KINDS)) if kind not in self.gone)


def regroupings(arm: RegroupedArm) -> tuple[Regrouping, ...]:
    """Find what every link passes on, from base to tip; the values of its parameters do not matter."""
    length = max((float(np.linalg.norm(link.translation)) for link in arm.links), default=0.0) or 1.0
    strength = float(np.linalg.norm(arm.gravity)) or 1.0
    motions = _motion(np.zeros(3), arm.gravity / strength)[None]
    products = np.zeros((0, 4, 4))
    out = []
    for link in arm.links:
        places = _places(link, length)
        back = np.linalg.inv(places)
        # What earlier joints do to this link, at every place of its own.
        motions = _span((back[:, None] @ motions @ places[:, None]).reshape(-1, 4, 4))
        earlier = np.swapaxes(places, 1, 2)[:, None] @ products @ places[:, None]
        still, z = np.zeros(3), np.array([0.0, 0.0, 1.0])
        own = _motion(z, still) if link.prismatic is None else _motion(still, link.prismatic)
        mixed = own.T @ motions
        mixed = 0.5 * (mixed + np.swapaxes(mixed, 1, 2))
        alone = own.T @ own
        # The drive's inertia acts in the square of the joint's own velocity, and nowhere else.
        told = [*((form, 0.0) for form in (*mixed, *np.concatenate(earlier[1:] - earlier[0]))), (alone, 1.0)]
        functionals = np.array([[*(_BODIES * form).sum(axis=(1, 2)), drive] for form, drive in told])
        scale = length ** np.array([*_LENGTHS, 2 if link.prismatic is None else 0])
        # Changes that none of the functionals tells, orthonormal, a row each.
        _, sizes, directions = np.linalg.svd(functionals)
        untold = directions[np.count_nonzero(sizes > _STANDS_OUT * sizes[0]) :]
        out.append(_leaving(untold, scale))
        motions = _span(np.concatenate([motions, own[None]]))
        products = _span(np.concatenate([*earlier, mixed, alone[None]]))
    return tuple(out)


def carried(rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """The ten in one frame from those in another that stands so in it, (10, 10)."""
    place = homogeneous(rotation, translation)
    return np.column_stack([moments_of(place @ body @ place.T) for body in _BODIES])


def moments_of(body: FloatArray) -> FloatArray:
    """Mass, first and second moments, (10,), from [[second, first], [first, mass]], (4, 4)."""
    return np.array([body[entry] for entry in _ENTRIES])


_BODIES = np.zeros((10, 4, 4))
for _k, _entry in enumerate(_ENTRIES):
    _BODIES[(_k, *_entry)] = _BODIES[(_k, *_entry[::-1])] = 1.0
_LENGTHS = tuple(len(kind) - 1 for kind in KINDS[:-1])


def _motion(angular: FloatArray, linear: FloatArray) -> FloatArray:
    """Matrix of a motion: a point's velocity from its place."""
    return np.vstack([np.column_stack([skew(angular), linear]), np.zeros(4)])


def _places(link: RegroupedLink, length: float) -> FloatArray:
    """The link's frame in the one before, lengths in units of one, at values of q that tell all others."""
    lever = link.translation / length
    if link.prismatic is not None:
        levers = [lever + slid * link.prismatic for slid in (0.0, -1.0, 1.0)]
        return np.array([homogeneous(link.rotation, each) for each in levers])
    return np.array([homogeneous(link.turned(angle), lever) for angle in 2 * math.pi / 5 * np.arange(5)])


def _span(matrices: FloatArray) -> FloatArray:
    """Orthonormal matrices that some matrices are made of."""
    _, sizes, directions = np.linalg.svd(matrices.reshape(-1, 16), full_matrices=False)
    return directions[sizes > _STANDS_OUT * max(sizes[0], np.finfo(float).tiny)].reshape(-1, 4, 4)


def _leaving(changes: FloatArray, scale: FloatArray) -> Regrouping:
    """Choose as many kinds to leave as there are changes, and write each change by the one that leaves."""
    gone: list[int] = []
    rest = changes
    while len(gone) < len(changes):
        # What of each kind is left beside those chosen.
        sizes = np.linalg.norm(rest, axis=0)
        best = next(kind for kind in _LEAVES_FIRST if sizes[kind] >= _AS_GOOD * sizes[:_DRIVE].max())
        gone.append(_DRIVE if sizes[_DRIVE] > _STANDS_OUT else best)
        direction = rest[:, gone[-1]] / sizes[gone[-1]]
        rest = rest - np.outer(direction, direction @ rest)
    instead = np.linalg.solve(changes[:, gone], changes)
    instead[np.abs(instead) < _STANDS_OUT] = 0.0
    # A unit of a kind in the arm's own length is scale units of it.
    return Regrouping(tuple(gone), np.asarray(instead * scale / scale[gone, None], dtype=float))
