"""The exact form of an arm's dynamics, found from numeric values.

Every element of D is a polynomial of degree 2 in (cos q_k, sin q_k) of each revolute and in q_k of each
prismatic joint; the potential energy has degree 1. The values on a tensor grid of 5 (3) angles per revolute
and 3 (2) places per prismatic joint determine such a function, and a discrete Fourier (Vandermonde) transform
along each axis gives its harmonics. No computer algebra is involved, and effects stay separate.

Link s contributes to D_ij (i <= j <= s) a function of q_{i+1} .. q_s only, so its grid has these axes only.
Separate treatment of every link costs little more, as the last link's grid is by far the largest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ArmError
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.text import joined
from gd_analyze.threads import one_thread

# Largest table of a row of D on a grid. Ten general revolute joints take 0.3 GB and 120 s, eleven 1.7 GB.
MOST_BYTES = 1e9


@dataclass(frozen=True, eq=False)
class Harmonics:
    """An arm's exact dynamics as trigonometric polynomials."""

    arm: RobotArm
    velocities: AbsoluteVelocities
    # Contribution of link s to D_ij, i <= j <= s, by (s, i, j) from 0: translation, rotation.
    inertia_by_link: dict[tuple[int, int, int], TrigonometricPolynomial]
    potential_by_link: TrigonometricPolynomial  # one per link, J, up to a constant
    cut: tuple[float, float]  # largest amplitude from round-off, in D (kg m^2) and potential (J)
    left_out: float  # largest amplitude left out as a structural zero, over `cut`; at most 1

    def __repr__(self) -> str:
        return f"Harmonics({self.arm!r})"

    @property
    def noise(self) -> tuple[float, float]:
        """Largest coefficient of a product of sines and cosines from round-off, like `cut`.

        A product of sines and cosines of r runs is a sum of 2^(r-1) harmonics with 2^(1-r) of its size. With
        r runs of revolute joints, the cut drops no harmonic of a product above the noise, and harmonics up to
        the cut form no product above it.
        """
        revolute = sum(self.arm.is_revolute[run[0]] for run in self.velocities.runs)
        of_inertia, of_potential = (cut * 2.0 ** (max(revolute, 1) - 1) for cut in self.cut)
        return of_inertia, of_potential

    @property
    def gap(self) -> float:
        """Smallest amplitude kept over the largest left out: how clear the cut is."""
        families = [(part, self.cut[0]) for part in self.inertia_by_link.values()]
        families.append((self.potential_by_link, self.cut[1]))
        sizes = [np.abs(part.coefficients[part.coefficients != 0.0]) / cut for part, cut in families if cut]
        smallest = min((float(size.min(initial=np.inf)) for size in sizes), default=np.inf)
        return smallest / self.left_out if self.left_out > 0.0 else np.inf

    @cached_property
    def inertia(self) -> dict[tuple[int, int], TrigonometricPolynomial]:
        """D_ij for i <= j, joints from 0; two polynomials: translation, rotation."""
        n = self.arm.n_joints
        # Contributions of links may cancel up to round-off.
        return {
            (i, j): TrigonometricPolynomial.summed(
                [self.inertia_by_link[s, i, j] for s in range(j, n)]
            ).above(self.cut[0])
            for i in range(n)
            for j in range(i, n)
            if (j, i, j) in self.inertia_by_link
        }

    def whole_inertia(
        self, drive_inertia: FloatArray | None = None
    ) -> dict[tuple[int, int], TrigonometricPolynomial]:
        """D_ij, i <= j, with both effects, and with the drives' inertia (n,) on the diagonal if given."""
        whole = {key: parts.total() for key, parts in self.inertia.items()}
        for i, added in enumerate(() if drive_inertia is None else drive_inertia):
            whole[i, i] += TrigonometricPolynomial.constant(whole[i, i].prismatic, added)
        return whole

    @cached_property
    def potential(self) -> TrigonometricPolynomial:
        """Potential energy, J, up to a constant; c_i is its derivative by q_i."""
        return self.potential_by_link.total().above(self.cut[1])

    @cached_property
    def gravity_loading(self) -> tuple[TrigonometricPolynomial, ...]:
        """c_i, N m."""
        return tuple(self.potential.derivative(i) for i in range(self.arm.n_joints))

    def christoffel(self, i: int, j: int, k: int) -> TrigonometricPolynomial:
        """h_ijk, symmetric in j and k, by exact differentiation of D; two polynomials by effect."""
        return christoffel_polynomial(self.inertia, i, j, k).above(DEGREE * self.cut[0])


def christoffel_polynomial(
    inertia: Mapping[tuple[int, int], TrigonometricPolynomial], i: int, j: int, k: int
) -> TrigonometricPolynomial:
    """Christoffel symbol (dD_ij/dq_k + dD_ik/dq_j - dD_jk/dq_i) / 2 of D_ij, i <= j."""
    return TrigonometricPolynomial.summed(inertia_slopes(inertia, i, j, k))


def inertia_slopes(
    inertia: Mapping[tuple[int, int], TrigonometricPolynomial], i: int, j: int, k: int
) -> list[TrigonometricPolynomial]:
    """The three summands of a Christoffel symbol."""
    slopes = ((0.5, i, j, k), (0.5, i, k, j), (-0.5, j, k, i))
    return [sign * inertia[min(a, b), max(a, b)].derivative(by) for sign, a, b, by in slopes]


@one_thread()
def harmonics_of(arm: RobotArm | str | Path) -> Harmonics:
    """Find the exact form of D by effect and of the potential energy.

    Parameters
    ----------
    arm
        A serial arm, the name of a built-in one or the path of its file.

    Returns
    -------
    Harmonics
        The harmonics above round-off, SI units; all others are structural zeros.

    Raises
    ------
    ArmError
        If the arm has so many joints that its grid takes more than `MOST_BYTES`.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> len(harmonics_of(load_arm("two_link")).inertia[0, 0])
    2
    """
    return harmonics_behind(arm_of(arm), 0)


def harmonics_behind(arm: RobotArm, first: int) -> Harmonics:
    """D_ij for the joints from `first` (from 0) on, which need a smaller grid, and the potential energy."""
    _require_affordable(arm, first)
    cut = round_off_cut(arm)
    inertia: dict[tuple[int, int, int], TrigonometricPolynomial] = {}
    left_out = 0.0
    for s in range(first, arm.n_joints):
        for i, values in _inertia_on_grid(_only_link(arm, s), first):
            rows, largest = _polynomials(arm, values, range(i + 1, s + 1), DEGREE, cut[0])
            left_out = max(left_out, largest)
            # Rows are D_ii .. D_is of translation, then of rotation.
            for j in range(i, s + 1):
                inertia[s, i, j] = rows[j - i :: s + 1 - i].above(0.0)
    potential, largest = _polynomials(arm, _potential_on_grid(arm), range(arm.n_joints), 1, cut[1])
    return Harmonics(arm, AbsoluteVelocities.of(arm), inertia, potential, cut, max(left_out, largest))


def _require_affordable(arm: RobotArm, first: int) -> None:
    """Refuse an arm whose grid takes too much memory, before any is taken."""
    size = _bytes(arm, first)
    if size <= MOST_BYTES:
        return
    n = arm.n_joints
    outer = next((i for i in range(first, n) if _bytes(arm, i) <= MOST_BYTES), None)
    affordable = "" if outer is None else f"elements from D{joined((outer, outer))} on, and c, are possible; "
    raise ArmError(
        f"finding the exact equations of arm {arm.name} takes too much memory",
        where=f"arm {arm.name}",
        expected=f"a grid of at most {MOST_BYTES / 1e9:g} GB, as of 10 revolute joints",
        found=f"{n} joints: values on a grid of {size / 1e9:.3g} GB",
        next_step=f"{affordable}without exact equations any number of joints is possible: `gd-analyze ROBOT "
        "TRAJECTORY`, `gd-analyze simplify ROBOT --level element` and `gd-analyze formulations`",
    )


def _bytes(arm: RobotArm, first: int) -> int:
    """Size of the larger of two grids: of D behind `first`, and of the potential energy."""
    n = arm.n_joints
    inertia = (
        2 * (n - first) * math.prod(len(_axis_nodes(arm, joint, DEGREE)) for joint in range(first + 1, n))
    )
    potential = n * math.prod(len(_axis_nodes(arm, joint, 1)) for joint in range(n))
    return np.dtype(float).itemsize * max(inertia if first < n else 0, potential)


def _only_link(arm: RobotArm, s: int) -> RobotArm:
    """The arm up to link s, with all other links massless."""
    weightless = tuple(
        replace(link, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))) for link in arm.links[:s]
    )
    return replace(
        arm,
        joints=arm.joints[: s + 1],
        links=(*weightless, arm.links[s]),
        drives=(),
        dh_table=(),
        spread=None,
    )


def round_off_cut(arm: RobotArm) -> tuple[float, float]:
    """Largest amplitude from round-off of a harmonic that is zero.

    A value of D passes some 10 n roundings of terms that sum to at most sum_s m_s L^2 + |I_s| with the arm
    stretched out. The transform averages values with weights of magnitude 1, for m and for -m. The weights
    for the powers of a prismatic joint sum to 2.
    """
    # The grid moves prismatic joints by up to 1 m.
    prismatic = arm.is_revolute.count(False)
    reach = arm.reach + max(float(np.linalg.norm(com)) for com in arm.com) + prismatic
    reach += float(np.linalg.norm(arm.joints[0].placement.translation))
    unit = 10 * arm.n_joints * float(np.finfo(float).eps) / 2 * 2.0 ** (prismatic + any(arm.is_revolute))
    inertia = float((arm.mass * max(reach, 1.0) ** 2 + np.abs(arm.inertia_com).sum(axis=(1, 2))).sum())
    potential = float(arm.mass.sum() * reach * np.linalg.norm(arm.gravity_vector))
    return unit * inertia, unit * potential


def _axis_nodes(arm: RobotArm, joint: int, degree: int) -> FloatArray:
    """Evenly spaced angles, or positions of a prismatic joint about zero."""
    if arm.is_revolute[joint]:
        return 2 * np.pi * np.arange(2 * degree + 1) / (2 * degree + 1)
    return np.linspace(-1.0, 1.0, degree + 1) if degree > 1 else np.array([0.0, 1.0])


def _grid(arm: RobotArm, joints: range, degree: int) -> tuple[tuple[int, ...], FloatArray]:
    nodes = [_axis_nodes(arm, joint, degree) for joint in joints]
    shape = tuple(map(len, nodes))
    q = np.zeros((arm.n_joints, math.prod(shape)))
    for joint, mesh in zip(joints, np.meshgrid(*nodes, indexing="ij"), strict=True):
        q[joint] = mesh.ravel()
    return shape, q


def _inertia_on_grid(arm: RobotArm, first: int) -> Iterator[tuple[int, FloatArray]]:
    """Rows i of D from `first` on, D_ii .. D_in by effect, on the grid of joints beyond i.

    Values have shape (2 (n - i), 5, 5, ...).
    """
    n = arm.n_joints
    # All rows on the grid of the first take n times its memory, separate grids a quarter more time.
    for i in range(first, n):
        shape, q = _grid(arm, range(i + 1, n), DEGREE)
        for joint in range(1, i + 1):
            q[joint] = _axis_nodes(arm, joint, DEGREE)[0]
        out = np.empty((2, n - i, q.shape[1]))
        for chunk in chunks(q.shape[1]):
            moments = composite.composite_moments(arm, solve_kinematics(arm, q[:, chunk]))
            inertia = np.empty((2, n, n, q[:, chunk].shape[1]))
            composite.inertia(moments, inertia)
            out[..., chunk] = inertia[:, i, i:]
        yield i, out.reshape(-1, *shape)


def _potential_on_grid(arm: RobotArm) -> FloatArray:
    """Potential energy of every link, shape (n, 3, 3, ...)."""
    shape, q = _grid(arm, range(arm.n_joints), 1)
    out = np.empty((arm.n_joints, q.shape[1]))
    for chunk in chunks(q.shape[1]):
        positions = solve_kinematics(arm, q[:, chunk]).com_positions
        out[:, chunk] = -np.einsum("s,a,san->sn", arm.mass, arm.gravity_vector, positions)
    return out.reshape(-1, *shape)


def _polynomials(
    arm: RobotArm, values: FloatArray, joints: range, degree: int, cut: float
) -> tuple[TrigonometricPolynomial, float]:
    """P functions from their values on a grid, and the largest amplitude up to `cut`, over `cut`."""
    revolute = [a for a, joint in enumerate(joints, start=1) if arm.is_revolute[joint]]
    table: Array = values
    if revolute:
        # For real values non-negative multiples of the first revolute joint suffice.
        table = np.fft.rfftn(values, axes=(*revolute[1:], revolute[0]), norm="forward")
    digits = [np.arange(size) for size in table.shape[1:]]
    for a, joint in enumerate(joints, start=1):
        if not arm.is_revolute[joint]:
            inverse = np.linalg.inv(np.vander(_axis_nodes(arm, joint, degree), increasing=True))
            table = np.moveaxis(np.tensordot(inverse, table, axes=(1, a)), 0, a)
        elif a != revolute[0]:
            digits[a - 1] = (digits[a - 1] + degree) % (2 * degree + 1) - degree
    # m and -m are conjugate; the lexicographically larger one stands for both.
    mesh = np.ix_(*digits)
    number = np.zeros((1,) * len(digits), dtype=np.int64)
    for a in revolute:
        number = number * (2 * degree + 1) + mesh[a - 1]
    shape = table.shape[1:] or (1,)
    table = (table * (1 + np.sign(number))).reshape(len(table), -1)
    amplitudes = np.abs(table)
    left_out = float(amplitudes[amplitudes <= cut].max(initial=0.0)) / cut if cut else 0.0
    columns = np.flatnonzero((amplitudes > cut).any(axis=0))
    multiples = np.zeros((len(columns), arm.n_joints), dtype=np.int64)
    for joint, digit, place in zip(joints, digits, np.unravel_index(columns, shape), strict=False):
        multiples[:, joint] = digit[place]
    prismatic = tuple(not revolute for revolute in arm.is_revolute)
    polynomials = TrigonometricPolynomial(prismatic, multiples, table[:, columns].astype(complex))
    return polynomials.above(cut), left_out
