"""Three-vectors and 3x3 tensors whose last axis runs over the set points.

The component axis comes just before the set-point axis: vectors are ``(..., 3, N)``, tensors
``(..., 3, 3, N)``. One set point is N = 1. The long axis being contiguous, every operation below
streams through memory; all of them also accept arrays of objects (numbers that count operations,
symbols).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
FloatArray = NDArray[np.float64]
Elementwise = Callable[[Array], Array]


def cross(a: Array, b: Array, out: Array | None = None) -> Array:
    """Vector product a x b, into `out` where it is given."""
    if out is None:
        out = np.empty(np.broadcast_shapes(a.shape, b.shape), dtype=np.result_type(a, b))
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[..., y, :], b[..., z, :], out=out[..., x, :])
        out[..., x, :] -= a[..., z, :] * b[..., y, :]
    return out


def dot(a: Array, b: Array) -> Array:
    """Scalar product a . b."""
    return np.einsum("...cn,...cn->...n", a, b)


def apply(tensor: Array, vector: Array) -> Array:
    """Tensor times vector."""
    return np.einsum("...abn,...bn->...an", tensor, vector)


def outer(a: Array, b: Array) -> Array:
    """Dyad a b^T."""
    return np.einsum("...an,...bn->...abn", a, b)


def set_points_last(states: Array) -> Array:
    """Turn ``(..., n)`` states into ``(n, N)`` with N contiguous."""
    return np.ascontiguousarray(states.reshape(-1, states.shape[-1]).T)


def set_points_first(values: Array, leading: tuple[int, ...]) -> Array:
    """Turn ``(..., N)`` results into ``(*leading, ...)``: the inverse of `set_points_last`."""
    return np.moveaxis(values, -1, 0).reshape(*leading, *values.shape[:-1])
