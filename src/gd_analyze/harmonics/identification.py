"""The exact form of an arm's dynamics, read off from its numbers.

Every element of D is a polynomial of degree 2 in (cos q_k, sin q_k) of each revolute and in q_k of each
sliding joint, the potential energy of degree 1. Such a function is fixed by its values on a tensor grid of 5
(3) angles per revolute and 3 (2) places per sliding joint; a discrete Fourier (Vandermonde) transform along
each axis returns its coefficients. No computer algebra is involved, and effects stay apart because they are
apart in the values.

What link s adds to D_ij (i <= j <= s) depends on q_{i+1}..q_s only, and so does its grid; every link for
itself costs hardly more than all together, since the last link's grid is larger than all others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gd_analyze.formulations import composite_moments as composite
from gd_analyze.harmonics.basis import DEGREE, Basis, Ids, Run
from gd_analyze.harmonics.series import Series
from gd_analyze.kinematics import solve_kinematics
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array, FloatArray

_CHUNK = 4096


@dataclass(frozen=True, eq=False)
class Harmonics:
    """An arm's dynamics as sums of basis functions.

    Parameters
    ----------
    arm, basis
        The arm and its basis functions.
    inertia_by_link
        What link s adds to D_ij by effect, i <= j <= s: {(s, i, j): (translation, rotation)}, from 0.
    potential
        Potential energy, J, up to a constant; c_i is its derivative by q_i.
    noise
        Largest coefficient that round-off can feign: of D (kg m^2) and of the potential (J).
    gap
        Smallest coefficient kept over largest left out: how clear the cut is.
    """

    arm: RobotArm
    basis: Basis
    inertia_by_link: dict[tuple[int, int, int], tuple[Series, Series]]
    potential: Series
    noise: tuple[float, float]
    gap: float

    @cached_property
    def inertia(self) -> dict[tuple[int, int], tuple[Series, Series]]:
        """D_ij by effect for i <= j, joints from 0."""
        n = self.arm.n_joints
        return {
            (i, j): (self._over_links(i, j, 0), self._over_links(i, j, 1))
            for i in range(n)
            for j in range(i, n)
        }

    def _over_links(self, i: int, j: int, effect: int) -> Series:
        parts = [self.inertia_by_link[s, i, j][effect] for s in range(j, self.arm.n_joints)]
        # Links may cancel; what is left of two equal coefficients is round-off.
        return Series.gathered(
            self.basis,
            np.concatenate([part.ids for part in parts]),
            np.concatenate([part.coefficients for part in parts]),
            self.noise[0],
        )

    @cached_property
    def gravity_loading(self) -> tuple[Series, ...]:
        """c_i, N m."""
        return tuple(self.potential.derivative(i) for i in range(self.arm.n_joints))

    @cached_property
    def potential_by_link(self) -> tuple[Series, ...]:
        """What every link adds to the potential energy."""
        return tuple(
            _potential_of(_only_link(self.arm, s), self.basis, _Cut(), self.noise[1])
            for s in range(self.arm.n_joints)
        )

    def coupling(self, i: int, j: int, k: int) -> tuple[Series, Series]:
        """h_ijk by effect, symmetric in j and k: Christoffel symbol of D, by exact differentiation."""
        key = (i, min(j, k), max(j, k))
        if key not in self._couplings:
            self._couplings[key] = (self._christoffel(*key, 0), self._christoffel(*key, 1))
        return self._couplings[key]

    @cached_property
    def _couplings(self) -> dict[tuple[int, int, int], tuple[Series, Series]]:
        return {}

    def _christoffel(self, i: int, j: int, k: int, effect: int) -> Series:
        def slope(a: int, b: int, by: int) -> Series:
            return self.inertia[min(a, b), max(a, b)][effect].derivative(by)

        total = slope(i, j, k) + slope(i, k, j) + -1.0 * slope(j, k, i)
        return 0.5 * total.cut(2 * DEGREE * self.noise[0])


def identify(arm: RobotArm) -> Harmonics:
    """Read the exact form of D by effect and of the potential energy off the numbers.

    Parameters
    ----------
    arm
        Any serial arm.

    Returns
    -------
    Harmonics
        Coefficients that round-off cannot have made; everything else is a structural zero.

    Examples
    --------
    >>> from gd_analyze.robots import load_arm
    >>> len(identify(load_arm("two_link")).inertia[0, 0][0])
    2
    """
    basis = Basis.of(arm)
    noise = _noise(arm, basis)
    cut = _Cut()
    inertia: dict[tuple[int, int, int], tuple[Series, Series]] = {}
    for s in range(arm.n_joints):
        for (i, j), parts in _inertia_on_grid(_only_link(arm, s)).items():
            behind = range(i + 1, s + 1)
            translation, rotation = (
                cut.series(basis, *_coefficients(arm, basis, part, behind, DEGREE), noise[0])
                for part in parts
            )
            inertia[s, i, j] = (translation, rotation)
    return Harmonics(arm, basis, inertia, _potential_of(arm, basis, cut, noise[1]), noise, cut.gap)


def _potential_of(arm: RobotArm, basis: Basis, cut: _Cut, noise: float) -> Series:
    """Potential energy of an arm, or of the beginning of the arm the basis is of."""
    values = _potential_on_grid(arm)
    return cut.series(basis, *_coefficients(arm, basis, values, range(arm.n_joints), 1), noise)


def _only_link(arm: RobotArm, s: int) -> RobotArm:
    """Cut the arm off behind link s and leave that link alone its mass."""
    weightless = tuple(
        replace(link, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))) for link in arm.links[:s]
    )
    return replace(arm, joints=arm.joints[: s + 1], links=(*weightless, arm.links[s]), drives=(), dh_table=())


class _Cut:
    """Separates coefficients from round-off, and remembers how clearly."""

    def __init__(self) -> None:
        self._largest_left_out = 0.0
        self._smallest_kept = np.inf

    def series(self, basis: Basis, ids: Ids, coefficients: FloatArray, noise: float) -> Series:
        magnitudes = np.abs(coefficients)
        kept = magnitudes > noise
        # Without mass, or without gravity, nothing is rounded and every coefficient is 0.
        if noise > 0.0:
            left_out, smallest = magnitudes[~kept].max(initial=0.0), magnitudes[kept].min(initial=np.inf)
            self._largest_left_out = max(self._largest_left_out, float(left_out) / noise)
            self._smallest_kept = min(self._smallest_kept, float(smallest) / noise)
        order = np.argsort(ids[kept])
        return Series(basis, ids[kept][order], coefficients[kept][order])

    @property
    def gap(self) -> float:
        return self._smallest_kept / self._largest_left_out if self._largest_left_out > 0.0 else np.inf


def _noise(arm: RobotArm, basis: Basis) -> tuple[float, float]:
    """What round-off can make of a coefficient that is zero.

    A value of D passes some 10 n roundings of terms that add up to at most sum_s m_s L^2 + |I_s| of the arm
    stretched out. A transform's coefficient is a mean of values with weights of magnitude 1, and joining
    the two exponentials of a cosine or sine doubles it, once per run.
    """
    # The grid moves sliding joints by up to 1 m, whatever their limits.
    slides = arm.is_revolute.count(False)
    reach = arm.reach + max(float(np.linalg.norm(com)) for com in arm.com) + slides
    reach += float(np.linalg.norm(arm.joints[0].placement.translation))
    unit = 10 * arm.n_joints * float(np.finfo(float).eps) / 2 * 2.0 ** len(basis.runs)
    inertia = float((arm.mass * max(reach, 1.0) ** 2 + np.abs(arm.inertia_com).sum(axis=(1, 2))).sum())
    potential = float(arm.mass.sum() * reach * np.linalg.norm(arm.gravity))
    return unit * inertia, unit * potential


def _axis_nodes(arm: RobotArm, joint: int, degree: int) -> FloatArray:
    """Evenly spaced angles, or places of a sliding joint around zero."""
    if arm.is_revolute[joint]:
        return 2 * np.pi * np.arange(2 * degree + 1) / (2 * degree + 1)
    return np.linspace(-1.0, 1.0, degree + 1) if degree > 1 else np.array([0.0, 1.0])


def _grid(arm: RobotArm, joints: range, degree: int) -> tuple[tuple[int, ...], FloatArray]:
    nodes = [_axis_nodes(arm, joint, degree) for joint in joints]
    shape = tuple(len(node) for node in nodes)
    q = np.zeros((arm.n_joints, int(np.prod(shape, dtype=int))))
    for joint, mesh in zip(joints, np.meshgrid(*nodes, indexing="ij"), strict=True):
        q[joint] = mesh.ravel()
    return shape, q


def _inertia_on_grid(arm: RobotArm) -> dict[tuple[int, int], FloatArray]:
    """D_ij by effect on the grid of the joints behind i, shape (2, 5, 5, ...)."""
    n = arm.n_joints
    shape, q = _grid(arm, range(1, n), DEGREE)
    out = np.empty((2, n, n, q.shape[1]))
    for chunk in _chunks(q.shape[1]):
        moments = composite.composite_moments(arm, solve_kinematics(arm, q[:, chunk]))
        composite.inertia(moments, out[..., chunk])
    out = out.reshape(2, n, n, *shape)
    # Behind i: the grid's axes of joints 2..i stay at their first node.
    return {(i, j): out[:, i, j].reshape(2, -1, *shape[i:])[:, 0] for i in range(n) for j in range(i, n)}


def _potential_on_grid(arm: RobotArm) -> FloatArray:
    shape, q = _grid(arm, range(arm.n_joints), 1)
    out = np.empty(q.shape[1])
    for chunk in _chunks(q.shape[1]):
        positions = solve_kinematics(arm, q[:, chunk]).com_positions
        out[chunk] = -np.einsum("s,a,san->n", arm.mass, arm.gravity, positions)
    return out.reshape(shape)


def _chunks(count: int) -> Iterator[slice]:
    return (slice(start, min(start + _CHUNK, count)) for start in range(0, count, _CHUNK))


def _coefficients(
    arm: RobotArm, basis: Basis, values: FloatArray, joints: range, degree: int
) -> tuple[Array, FloatArray]:
    """Numbers of basis functions and their coefficients, from values on the grid of `joints`."""
    revolute = tuple(a for a, joint in enumerate(joints) if arm.is_revolute[joint])
    table: Array = np.fft.fftn(values, axes=revolute, norm="forward") if revolute else values.astype(complex)
    for a, joint in enumerate(joints):
        if not arm.is_revolute[joint]:
            inverse = np.linalg.inv(np.vander(_axis_nodes(arm, joint, degree), increasing=True))
            table = np.moveaxis(np.tensordot(inverse, table, axes=(1, a)), 0, a)
    numbers: list[list[int]] = []
    for run in basis.runs:
        present = [joint for joint in run.joints if joint in joints]
        axis = len(numbers)
        width = table.shape[axis : axis + len(present)]
        table = table.reshape(*table.shape[:axis], -1, *table.shape[axis + len(present) :])
        rows, chosen = _joined(run, present, width, table, axis)
        table = rows
        numbers.append(chosen)
    ids = np.ravel_multi_index(tuple(np.meshgrid(*numbers, indexing="ij")), basis.sizes)
    return ids.ravel(), np.ascontiguousarray(table.real).ravel()


def _joined(
    run: Run, present: list[int], width: tuple[int, ...], table: Array, axis: int
) -> tuple[Array, list[int]]:
    """Join exponentials of a run into its modes along one axis; the modes' numbers within the run."""
    if run.sliding:
        return table, list(range(table.shape[axis])) if present else [0]
    chosen, rows = [], []
    for number, mode in enumerate(run.modes):
        k = dict(zip(run.joints, mode.multiples, strict=True))
        reachable = all(2 * abs(k[j]) < w for j, w in zip(present, width, strict=True))
        if not reachable or any(k[j] for j in run.joints if j not in present):
            continue
        place, mirror = (
            int(np.ravel_multi_index([sign * k[j] % w for j, w in zip(present, width, strict=True)], width))
            if present
            else 0
            for sign in (1, -1)
        )
        plus, minus = np.take(table, place, axis=axis), np.take(table, mirror, axis=axis)
        rows.append(plus if mode.is_one else plus + minus if mode.kind == "cos" else 1j * (plus - minus))
        chosen.append(number)
    return np.stack(rows, axis=axis), chosen
