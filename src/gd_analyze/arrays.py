"""Arrays: vectors and tensors with the set points last, round-off, and checks of given arrays.

The component axis comes just before the set-point axis: vectors are ``(..., 3, N)``, tensors ``(..., 3, 3,
N)``. One set point is N = 1. The long axis being contiguous, every operation below streams through memory;
all of them also accept arrays of objects (numbers that count operations, symbols), whose methods `cos` and
`sin` NumPy calls.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gd_analyze.text import LARGEST, in_python

if TYPE_CHECKING:
    from collections.abc import Iterator

    from gd_analyze.errors import GdAnalyzeError

Array = NDArray[Any]
FloatArray = NDArray[np.float64]

# Set points at a time: long enough to hide the cost of an array call, short enough that what one pass needs
# stays in the cache.
CHUNK = 4096


def members(values: object) -> list[Any]:
    """Members of an array or another collection; any other value alone."""
    if isinstance(values, np.ndarray):
        return list(values.ravel().tolist())
    return list(values) if isinstance(values, Iterable) else [values]


def evenly(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` evenly spaced set points, with the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def chunks(count: int, length: int = CHUNK) -> Iterator[slice]:
    """Cut `count` set points into slices of a length."""
    return (slice(start, min(start + length, count)) for start in range(0, count, length))


def runs(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """First place and end of every run of True, shape (R, 2)."""
    return np.flatnonzero(np.diff(mask, prepend=False, append=False)).reshape(-1, 2)


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


def product(a: Array, b: Array) -> Array:
    """Product of two matrices."""
    return np.einsum("abn,bcn->acn", a, b)


def times_constant(a: Array, constant: Array) -> Array:
    """Product of a matrix and a constant one on its right."""
    return np.einsum("abn,bc->acn", a, constant)


def outer(a: Array, b: Array) -> Array:
    """Dyad a b^T."""
    return np.einsum("...an,...bn->...abn", a, b)


def rigid_acceleration(omega: Array, omega_dot: Array, lever: Array) -> Array:
    """Acceleration of a point of a rigid body relative to another of its points, a lever away."""
    return cross(omega_dot, lever) + cross(omega, cross(omega, lever))


def skew(axis: Array) -> Array:
    """Matrix of the vector product with a constant vector, (3, 3)."""
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def homogeneous(rotation: Array, translation: Array) -> Array:
    """Placement as a matrix, (4, 4)."""
    return np.vstack([np.column_stack([rotation, translation]), [0.0, 0.0, 0.0, 1.0]])


def turn_parts(axis: Array) -> tuple[Array, Array, Array]:
    """Constants F, S, C of the turn F + S sin q + C cos q about a unit axis (Rodrigues), (3, 3) each."""
    by_sin = skew(axis)
    square = by_sin @ by_sin
    return np.eye(3) + square, by_sin, -square


def turn_about(axis: Array, cos_q: Array, sin_q: Array) -> Array:
    """Turn about a constant unit axis, 1 + S sin q + S^2 (1 - cos q) with S its `skew`, (3, 3, N)."""
    by_sin = skew(axis)
    square = by_sin @ by_sin
    out = np.empty((3, 3, len(cos_q)), np.result_type(cos_q, float))
    for a, b in np.ndindex(3, 3):
        # A whole number, which no count takes for an addition where it is zero.
        out[a, b] = int(a == b) + by_sin[a, b] * sin_q + square[a, b] * (1.0 - cos_q)
    return out


def set_points_last(states: Array) -> Array:
    """Turn ``(..., n)`` states into ``(n, N)`` with N contiguous."""
    return np.ascontiguousarray(states.reshape(-1, states.shape[-1]).T)


# Torques of every joint come from the same forces. Below this share of the arm's largest torque a number is
# what cancellation leaves: thousands of roundings (eps = 2e-16), yet far below any joint's real torque.
ROUND_OFF_SHARE = 1e-12


def round_off_of(torque: FloatArray, explained: float = 0.0) -> float:
    """Torque (N m) that is only round-off among torques (N, n).

    `explained` is the torque that round-off explains where no joint needs any torque, see
    `pinocchio_check.round_off_bounds`.
    """
    largest = float(np.abs(torque).max())
    return explained if largest <= explained else ROUND_OFF_SHARE * largest


def peak_magnitude(torque: FloatArray, explained: float = 0.0) -> FloatArray:
    """Largest magnitude of torques (N, n) per joint, shape (n,); exactly 0 where it is round-off."""
    peak = np.abs(torque).max(axis=0)
    return np.where(peak > round_off_of(torque, explained), peak, 0.0)


def falling(value: float) -> float:
    """Sort key for falling magnitude; values that differ only by round-off have the same key."""
    return -float(f"{abs(value):.9e}")


def are_possible(values: ArrayLike) -> bool:
    """Whether all numbers are finite and none is larger than `LARGEST`."""
    array = np.asarray(values, dtype=float)
    # A nan makes its array's smallest number nan.
    return bool(array.min(initial=0.0) >= -LARGEST and array.max(initial=0.0) <= LARGEST)


def array_of(values: Any, name: str, error: type[GdAnalyzeError]) -> FloatArray:
    """Take an array, or a list of numbers, as floats, or raise `error`; copy only what must be."""
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.array(None)
    if array.dtype.kind not in "fiub":
        message, value_text = f"{name} is not made of numbers", in_python(values)
        raise error(message, where=name, expected="an array of numbers", found=value_text)
    return array.astype(float, copy=False)


def frozen(array: FloatArray) -> FloatArray:
    """Take an array that nobody can write to as it is, and a read-only copy of any other."""
    owner: Any = array
    while isinstance(owner, np.ndarray) and not owner.flags.writeable:
        owner = owner.base
    if owner is not None:
        array = array.copy()
        array.flags.writeable = False
    return array


def require_possible(array: FloatArray, name: str, error: type[GdAnalyzeError]) -> None:
    """Raise `error` where a number is not finite or larger than `LARGEST`."""
    if not are_possible(array):
        wrong = ~(np.abs(array) <= LARGEST)
        raise error(
            f"{name} is {'too large' if np.isfinite(array).all() else 'not finite'}",
            where=f"{name}{list(map(int, np.argwhere(wrong)[0]))}",
            expected=f"finite numbers up to {LARGEST:g}",
            found=str(array[wrong][0]),
        )
