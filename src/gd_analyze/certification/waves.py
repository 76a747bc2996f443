"""Polynomials in sines, cosines and sliding variables as sums of waves, which bounds and grids can handle.

A product of sines and cosines is a sum of waves Re(C exp(i m.q)) of integer multiples m; a wave's amplitude
|C| is the largest it can get, whatever the sines and cosines it came from. Sliding variables go along as
powers: the wave of multiples m is Re(C prod_k b_k), b_k = exp(i m_k q_k) of a turning and q_k^m_k of a
sliding joint.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.harmonics.terms import Monomial
from gd_analyze.vectors import Array, FloatArray

Polynomial = Mapping[Monomial, float]
Multiples = tuple[int, ...]

# Positions evaluated at once: their values of some twenty polynomials fit the cache.
_CHUNK = 8192


class Expansion:
    """Monomials as waves, each worked out once."""

    def __init__(self, sliding: Sequence[bool]) -> None:
        self.sliding = tuple(sliding)
        self._known: dict[Monomial, dict[Multiples, complex]] = {}

    def __call__(self, monomial: Monomial) -> dict[Multiples, complex]:
        """Multiples and coefficients; of m and -m, which are one wave, the one that is lexically larger."""
        if monomial not in self._known:
            table: dict[Multiples, complex] = {(0,) * len(self.sliding): 1.0 + 0.0j}
            for kind, multiples in monomial:
                table = self._times(table, kind, multiples)
            folded: dict[Multiples, complex] = defaultdict(complex)
            for key, value in table.items():
                mirror = self._mirrored(key)
                folded[max(key, mirror)] += value if key >= mirror else value.conjugate()
            self._known[monomial] = dict(folded)
        return self._known[monomial]

    def _times(
        self, table: dict[Multiples, complex], kind: str, multiples: Multiples
    ) -> dict[Multiples, complex]:
        # cos x = (e^ix + e^-ix) / 2, sin x = -i (e^ix - e^-ix) / 2.
        one, other = {"cos": (0.5, 0.5), "sin": (-0.5j, 0.5j), "power": (1.0, 0.0)}[kind]
        out: dict[Multiples, complex] = defaultdict(complex)
        for key, value in table.items():
            out[tuple(a + b for a, b in zip(key, multiples, strict=True))] += one * value
            if other:
                out[tuple(a - b for a, b in zip(key, multiples, strict=True))] += other * value
        return out

    def _mirrored(self, key: Multiples) -> Multiples:
        return tuple(m if slides else -m for m, slides in zip(key, self.sliding, strict=True))


@dataclass(frozen=True, eq=False)
class Waves:
    """P polynomials over the same waves.

    Parameters
    ----------
    sliding
        Whether each joint slides.
    multiples
        m of every wave, shape (W, n); of a sliding joint the power.
    coefficients
        C, shape (P, W).
    """

    sliding: tuple[bool, ...]
    multiples: NDArray[np.int64]
    coefficients: NDArray[np.complex128]

    @classmethod
    def of(cls, polynomials: Sequence[Polynomial], expansion: Expansion) -> Waves:
        """Expand polynomials."""
        place: dict[Multiples, int] = {}
        rows, columns, values = [], [], []
        for p, polynomial in enumerate(polynomials):
            for monomial, weight in polynomial.items():
                for key, value in expansion(monomial).items():
                    rows.append(p)
                    columns.append(place.setdefault(key, len(place)))
                    values.append(weight * value)
        out = np.zeros((len(polynomials), len(place)), dtype=complex)
        np.add.at(out, (np.array(rows, dtype=int), np.array(columns, dtype=int)), np.array(values))
        multiples = np.array(list(place), dtype=np.int64).reshape(len(place), len(expansion.sliding))
        return cls(expansion.sliding, multiples, out)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Largest multiple, or power, of every joint."""
        return tuple(int(d) for d in np.abs(self.multiples).max(axis=0, initial=0))

    def sizes(self, farthest: FloatArray) -> FloatArray:
        """Largest magnitude of every wave in every polynomial, shape (P, W).

        Parameters
        ----------
        farthest
            Largest magnitude of every joint's position, shape (n,).
        """
        return np.asarray(np.abs(self.coefficients) * self._powers(farthest[:, None])[:, 0])

    def curvatures(self, farthest: FloatArray) -> FloatArray:
        """Largest second derivative of every wave in every polynomial by every joint, shape (P, W, n).

        Parameters
        ----------
        farthest
            Largest magnitude of every joint's position, shape (n,).
        """
        sizes = self.sizes(farthest)
        out = np.empty((*sizes.shape, len(self.sliding)))
        for k, slides in enumerate(self.sliding):
            m = self.multiples[:, k]
            if not slides:
                out[..., k] = sizes * m**2
                continue
            lowered = self.multiples.copy()
            lowered[:, k] = np.maximum(m - 2, 0)
            out[..., k] = Waves(self.sliding, lowered, self.coefficients).sizes(farthest) * (m * (m - 1))
        return out

    def times(self, factors: FloatArray) -> Waves:
        """Multiply every polynomial by its factor, shape (P,)."""
        return Waves(self.sliding, self.multiples, self.coefficients * factors[:, None])

    def only(self, chosen: NDArray[np.bool_]) -> Waves:
        """Leave out the other waves."""
        return Waves(self.sliding, self.multiples[chosen], self.coefficients[:, chosen])

    def __call__(self, q: FloatArray) -> FloatArray:
        """Values at positions (n, K), shape (P, K)."""
        turning = ~np.array(self.sliding)
        angles = self.multiples[:, turning].astype(float) @ q[turning]
        powers = self._powers(q)
        values = self.coefficients.real @ (powers * np.cos(angles))
        values -= self.coefficients.imag @ (powers * np.sin(angles))
        return np.asarray(values)

    def on_grid(self, nodes: Sequence[FloatArray]) -> Iterator[FloatArray]:
        """Values on the tensor grid of every joint's nodes, in pieces (P, K) of its row-major order.

        Joint after joint the nodes' values of 1, cos, sin, .. are contracted with the coefficients, so that a
        position costs a few multiplications instead of its own sines and cosines.
        """
        bases = [self._basis(k, node) for k, node in enumerate(nodes)]
        counts = [len(node) for node in nodes]
        inner = len(counts)
        while inner and np.prod(counts[inner - 1 :], dtype=float) <= _CHUNK:
            inner -= 1
        table = self._table()
        kept = table.shape[inner + 1 :]
        # Outer joints once, all their nodes; shape (P, outer positions, B of the inner joints).
        table = _contracted(table.reshape(*table.shape[: inner + 1], -1), bases[:inner])
        table = table.reshape(len(table), -1, *kept)
        step = max(1, int(_CHUNK // np.prod(counts[inner:], dtype=float)))
        for start in range(0, table.shape[1], step):
            piece = table[:, start : start + step]
            values = _contracted(piece.reshape(-1, *kept, 1), bases[inner:])
            yield values.reshape(len(table), -1)

    def _powers(self, q: FloatArray) -> FloatArray:
        """Product of the sliding joints' powers, shape (W, K)."""
        out = np.ones((len(self.multiples), q.shape[1]))
        for k in np.flatnonzero(self.sliding):
            out *= q[k] ** self.multiples[:, [k]]
        return out

    def _basis(self, joint: int, nodes: FloatArray) -> FloatArray:
        """1, cos, sin, cos 2, sin 2, .. or 1, q, q^2, .. at the nodes, shape (N, B)."""
        degree = self.degrees[joint]
        if self.sliding[joint]:
            return np.asarray(nodes[:, None] ** np.arange(degree + 1))
        out = np.ones((len(nodes), 2 * degree + 1))
        angles = np.outer(nodes, np.arange(1, degree + 1))
        out[:, 1::2], out[:, 2::2] = np.cos(angles), np.sin(angles)
        return out

    def _table(self) -> FloatArray:
        """Coefficients of the products of the joints' basis functions, shape (P, B_1, .., B_n)."""
        shape = [d + 1 if slides else 2 * d + 1 for d, slides in zip(self.degrees, self.sliding, strict=True)]
        shift = np.array([0 if slides else d for d, slides in zip(self.degrees, self.sliding, strict=True)])
        table: Array = np.zeros((len(self.coefficients), *shape), dtype=complex)
        table[(slice(None), *(self.multiples + shift).T)] = self.coefficients
        turns = [
            np.eye(size) if slides else _euler(d).T
            for d, size, slides in zip(self.degrees, shape, self.sliding, strict=True)
        ]
        return np.ascontiguousarray(_contracted(table[..., None], turns).real).reshape(-1, *shape)


def _euler(degree: int) -> Array:
    """exp(i m q), m = -d..d, in 1, cos q, sin q, .., shape (2 d + 1, 2 d + 1)."""
    out = np.zeros((2 * degree + 1, 2 * degree + 1), dtype=complex)
    out[degree, 0] = 1.0
    for m in range(1, degree + 1):
        out[degree + m, [2 * m - 1, 2 * m]] = 1.0, 1.0j
        out[degree - m, [2 * m - 1, 2 * m]] = 1.0, -1.0j
    return out


def _contracted(table: Array, bases: Sequence[Array]) -> Array:
    """Contract (P, B_1, .., B_m, rest) with bases (N_k, B_k) to (P, N_1, .., N_m, rest), the last first."""
    counts = [len(basis) for basis in bases]
    behind = table.shape[-1]
    for k in reversed(range(len(bases))):
        # As products of many small matrices, which no two threads quarrel about.
        table = np.matmul(bases[k], table.reshape(-1, bases[k].shape[1], behind))
        behind *= counts[k]
    return table
