"""Polynomials in sines, cosines and the variables of prismatic joints, as sums of harmonics.

The harmonic with multiples m is Re(C prod_k b_k), with b_k = exp(i m_k q_k) for a revolute joint and q_k^m_k
for a prismatic one. Harmonics are found by a Fourier transform, and easily bounded and differentiated: the
amplitude |C| is a harmonic's largest value, and a derivative multiplies C by i m_k or lowers a power. The
multiples m and -m stand for the same harmonic; the one kept is lexically larger in the revolute joints.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray

# Degree of D in every joint variable, one for each of two velocities.
DEGREE = 2
# Positions evaluated at once: the values of some twenty polynomials fit the cache.
_POSITIONS_AT_ONCE = 8192
# Number of coefficients up to which a dense sum is as fast as a sparse one.
_DENSE_COEFFICIENTS = 1 << 16
# Share of nonzero coefficients above which a dense sum is as fast as a sparse one.
_DENSE_SHARE = 0.3
# Numbers in the tables held at once, 32 MB.
_NUMBERS_IN_TABLES = 1 << 22


@dataclass(frozen=True, eq=False)
class TrigonometricPolynomial:
    """P polynomials over the same W harmonics."""

    prismatic: tuple[bool, ...]
    multiples: NDArray[np.int64]  # (W, n), m of every harmonic or power, all rows distinct
    coefficients: NDArray[np.complex128]  # (P, W)

    # NumPy leaves array * polynomial to `__rmul__`.
    __array_ufunc__ = None

    @classmethod
    def stacked(cls, parts: Sequence[TrigonometricPolynomial]) -> TrigonometricPolynomial:
        """Concatenate the polynomials of all parts."""
        multiples = np.concatenate([part.multiples for part in parts])
        _, first, place = np.unique(numbers(multiples), return_index=True, return_inverse=True)
        out = np.zeros((sum(len(part.coefficients) for part in parts), len(first)), dtype=complex)
        row, column = 0, 0
        for part in parts:
            height, width = part.coefficients.shape
            out[row : row + height, place[column : column + width]] = part.coefficients
            row, column = row + height, column + width
        return cls(parts[0].prismatic, multiples[first], out)

    @classmethod
    def summed(cls, parts: Sequence[TrigonometricPolynomial]) -> TrigonometricPolynomial:
        """Sum of several parts with P polynomials each."""
        count = len(parts[0].coefficients)
        return cls.stacked(parts).added([*range(count)] * len(parts), count)

    @classmethod
    def constant(cls, prismatic: tuple[bool, ...], value: float) -> TrigonometricPolynomial:
        """One constant polynomial."""
        return cls(
            prismatic, np.zeros((1, len(prismatic)), dtype=np.int64), np.array([[value]], dtype=complex)
        )

    def __len__(self) -> int:
        return len(self.multiples)

    @cached_property
    def revolute(self) -> NDArray[np.bool_]:
        """Whether each joint is revolute, shape (n,)."""
        return ~np.array(self.prismatic)

    def __add__(self, other: TrigonometricPolynomial) -> TrigonometricPolynomial:
        return TrigonometricPolynomial.summed([self, other])

    def __mul__(self, factor: float | FloatArray) -> TrigonometricPolynomial:
        """Multiply all polynomials by one factor, or each by its own, shape (P,)."""
        return TrigonometricPolynomial(
            self.prismatic, self.multiples, self.coefficients * np.reshape(factor, (-1, 1))
        )

    __rmul__ = __mul__

    def __getitem__(self, polynomials: slice | Sequence[int] | NDArray[Any]) -> TrigonometricPolynomial:
        return TrigonometricPolynomial(self.prismatic, self.multiples, self.coefficients[polynomials])

    def added(self, places: Sequence[int], count: int) -> TrigonometricPolynomial:
        """Form `count` sums: polynomial p is added to sum places[p]."""
        out = np.zeros((count, len(self)), dtype=complex)
        for place, row in zip(places, self.coefficients, strict=True):
            out[place] += row
        return TrigonometricPolynomial(self.prismatic, self.multiples, out)

    def total(self) -> TrigonometricPolynomial:
        """Sum of all P polynomials."""
        return self.added([0] * len(self.coefficients), 1)

    def only(self, chosen: NDArray[np.bool_]) -> TrigonometricPolynomial:
        """Keep the chosen harmonics."""
        return TrigonometricPolynomial(self.prismatic, self.multiples[chosen], self.coefficients[:, chosen])

    def above(self, floor: float | FloatArray) -> TrigonometricPolynomial:
        """Drop coefficients up to `floor`, and harmonics without any left."""
        coefficients = np.where(np.abs(self.coefficients) > floor, self.coefficients, 0.0)
        polynomials = TrigonometricPolynomial(self.prismatic, self.multiples, coefficients)
        return polynomials.only((coefficients != 0.0).any(axis=0))

    def derivative(self, joint: int) -> TrigonometricPolynomial:
        """Derivative with respect to q_joint (from 0); exact."""
        dependent = self.only(self.multiples[:, joint] != 0)
        multiples, coefficients = dependent.multiples, dependent.coefficients
        m = multiples[:, joint]
        if not self.prismatic[joint]:
            return TrigonometricPolynomial(self.prismatic, multiples, coefficients * (1j * m))
        lowered = multiples - np.eye(len(self.prismatic), dtype=np.int64)[joint]
        return TrigonometricPolynomial(self.prismatic, lowered, coefficients * m)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Largest multiple or power of every joint."""
        return tuple(int(d) for d in np.abs(self.multiples).max(axis=0, initial=0))

    def sizes(self, farthest: FloatArray) -> FloatArray:
        """Largest magnitude of every harmonic where |q| <= `farthest`, shape (P, W)."""
        return np.asarray(np.abs(self.coefficients) * self._powers(farthest[:, None])[:, 0])

    def curvatures(self, farthest: FloatArray) -> FloatArray:
        """Largest second derivative by every joint where |q| <= `farthest`, shape (P, W, n)."""
        sizes = self.sizes(farthest)
        out = np.empty((*sizes.shape, len(self.prismatic)))
        for k, prismatic in enumerate(self.prismatic):
            m = self.multiples[:, k]
            if not prismatic:
                out[..., k] = sizes * m**2
                continue
            lowered = self.multiples.copy()
            lowered[:, k] = np.maximum(m - 2, 0)
            twice_less = TrigonometricPolynomial(self.prismatic, lowered, self.coefficients)
            out[..., k] = twice_less.sizes(farthest) * (m * (m - 1))
        return out

    def __call__(self, q: FloatArray) -> FloatArray:
        """Values at positions (n, K), shape (P, K)."""
        angles = self.multiples[:, self.revolute].astype(float) @ q[self.revolute]
        powers = self._powers(q)
        real, imaginary = self.parts
        return np.asarray(real @ (powers * np.cos(angles)) - imaginary @ (powers * np.sin(angles)))

    @cached_property
    def parts(self) -> tuple[Any, Any]:
        """Real and imaginary coefficients, shape (P, W); sparse arrays if most of many are zero."""
        parts = self.coefficients.real.copy(), self.coefficients.imag.copy()
        size = self.coefficients.size
        if size <= _DENSE_COEFFICIENTS or np.count_nonzero(self.coefficients) > _DENSE_SHARE * size:
            return parts
        from scipy.sparse import csr_array

        return csr_array(parts[0]), csr_array(parts[1])

    def magnitudes(self) -> TrigonometricPolynomial:
        """One polynomial whose coefficients are the summed magnitudes of those of all polynomials."""
        total = np.abs(self.coefficients).sum(axis=0, keepdims=True)
        return TrigonometricPolynomial(self.prismatic, self.multiples, total.astype(complex))

    def on_grid(self, nodes: Sequence[FloatArray]) -> Iterator[FloatArray]:
        """Values on the tensor grid of all joints' nodes, in pieces (P, K) of its row-major order.

        The coefficients are contracted with the values of 1, cos, sin, .. at the nodes, joint by joint, so
        that a position costs a few multiplications instead of its own sines and cosines.
        """
        bases = [self._basis(k, node) for k, node in enumerate(nodes)]
        table = self._table
        yield from _on_grid(table.reshape(len(table), -1), bases)

    def _powers(self, q: FloatArray) -> FloatArray:
        """Product of the powers of the prismatic variables, shape (W, K)."""
        out = np.ones((len(self.multiples), q.shape[1]))
        for k in np.flatnonzero(self.prismatic):
            out *= q[k] ** self.multiples[:, [k]]
        return out

    def _basis(self, joint: int, nodes: FloatArray) -> FloatArray:
        """1, cos, sin, cos 2, sin 2, .. or 1, q, q^2, .. at the nodes, shape (N, B)."""
        degree = self.degrees[joint]
        if self.prismatic[joint]:
            return np.asarray(nodes[:, None] ** np.arange(degree + 1))
        out = np.ones((len(nodes), 2 * degree + 1))
        angles = np.outer(nodes, np.arange(1, degree + 1))
        out[:, 1::2], out[:, 2::2] = np.cos(angles), np.sin(angles)
        return out

    @cached_property
    def _table(self) -> FloatArray:
        """Coefficients of the products of the joints' basis functions, shape (P, B_1, .., B_n)."""
        shape = tuple((1 + self.revolute) * self.degrees + 1)
        out = np.zeros((len(self.coefficients), *shape))
        for p, row in enumerate(self.coefficients):
            nonzero = np.flatnonzero(row)
            # Most single polynomials depend on few joints.
            multiples = self.multiples[nonzero]
            degrees = np.abs(multiples).max(axis=0, initial=0)
            lowest = degrees * self.revolute
            table: Array = np.zeros((1, *(degrees + lowest + 1)), dtype=complex)
            table[(0, *(multiples + lowest).T)] = row[nonzero]
            small = table.shape[1:]
            bases = [
                _euler(int(d)).T if turns else np.eye(d + 1)
                for d, turns in zip(degrees, self.revolute, strict=True)
            ]
            values = _contracted(table[..., None], bases).real
            out[p][tuple(slice(size) for size in small)] = values.reshape(small)
        return out


def _on_grid(table: FloatArray, bases: Sequence[FloatArray]) -> Iterator[FloatArray]:
    """Contract (P, B_1 .. B_m) with bases (N_k, B_k), in pieces of row-major order."""
    counts, sizes = [len(basis) for basis in bases], [basis.shape[1] for basis in bases]
    inner = len(counts)
    while inner and np.prod(counts[inner - 1 :], dtype=float) <= _POSITIONS_AT_ONCE:
        inner -= 1
    behind = math.prod(sizes[inner:])
    if inner > 1 and len(table) * math.prod(counts[:inner]) * behind > _NUMBERS_IN_TABLES:
        # The tables at all positions of the outer joints would take too much memory.
        by_first = table.reshape(len(table), sizes[0], -1)
        for row in bases[0]:
            yield from _on_grid(np.matmul(row, by_first), bases[1:])
        return
    # All nodes of the outer joints at once, shape (P, outer positions, B of the inner joints).
    outer = _contracted(table.reshape(len(table), *sizes[:inner], behind), bases[:inner])
    outer = outer.reshape(len(table), -1, behind)
    step = max(1, int(_POSITIONS_AT_ONCE // np.prod(counts[inner:], dtype=float)))
    for start in range(0, outer.shape[1], step):
        piece = outer[:, start : start + step]
        values = _contracted(piece.reshape(-1, *sizes[inner:], 1), bases[inner:])
        yield values.reshape(len(table), -1)


def numbers(multiples: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number rows (K, n) of small integers so that the numbers have the order and signs of the rows."""
    radix = 2 * np.abs(multiples).max(axis=0, initial=0) + 1
    return np.asarray(multiples @ np.append(np.cumprod(radix[:0:-1])[::-1], 1))


def _euler(degree: int) -> Array:
    """exp(i m q), m = -d..d, in 1, cos q, sin q, .., shape (2 d + 1, 2 d + 1)."""
    out = np.zeros((2 * degree + 1, 2 * degree + 1), dtype=complex)
    out[degree, 0] = 1.0
    for m in range(1, degree + 1):
        out[degree + m, [2 * m - 1, 2 * m]] = 1.0, 1.0j
        out[degree - m, [2 * m - 1, 2 * m]] = 1.0, -1.0j
    return out


def _contracted(table: Array, bases: Sequence[Array]) -> Array:
    """Contract (P, B_1, .., B_m, rest) with bases (N_k, B_k), the last first, to (P, N_1, .., N_m, rest)."""
    counts = [len(basis) for basis in bases]
    behind = table.shape[-1]
    for k in reversed(range(len(bases))):
        # Many small products: BLAS stays in one thread.
        table = np.matmul(bases[k], table.reshape(-1, bases[k].shape[1], behind))
        behind *= counts[k]
    return table
