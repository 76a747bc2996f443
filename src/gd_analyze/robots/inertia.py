"""Inertia tensors: from their entries, moved to another point, and as second moments of matter."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import Array, FloatArray


def symmetric_tensor(
    xx: float, yy: float, zz: float, xy: float = 0.0, xz: float = 0.0, yz: float = 0.0
) -> FloatArray:
    """Put entries, as they stand in the tensor, into place, shape (3, 3)."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def of_point_mass(mass: float, place: FloatArray) -> FloatArray:
    """What a mass at a place adds to the inertia about the origin: the parallel-axis theorem."""
    added: FloatArray = mass * ((place @ place) * np.eye(3) - np.outer(place, place))
    return added


def second_moment(inertia_com: Array) -> Array:
    """tr(I)/2 - I: to matrices of positions what the inertia tensor is to vectors, about the same point."""
    return 0.5 * np.trace(inertia_com) * np.eye(3) - inertia_com


def second_moment_about_origin(mass: float, com: Array, inertia_com: Array) -> Array:
    """Second moment about the origin that the centre of mass is measured from: shifted by m r r^T, (3, 3)."""
    return second_moment(inertia_com) + mass * np.outer(com, com)
