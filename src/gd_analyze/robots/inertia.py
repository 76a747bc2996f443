"""Inertia tensors: from their entries, and moved to another point."""

from __future__ import annotations

import numpy as np

from gd_analyze.vectors import FloatArray


def symmetric_tensor(
    xx: float, yy: float, zz: float, xy: float = 0.0, xz: float = 0.0, yz: float = 0.0
) -> FloatArray:
    """Put entries, as they stand in the tensor, into place, shape (3, 3)."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def of_point_mass(mass: float, place: FloatArray) -> FloatArray:
    """What a mass at a place adds to the inertia about the origin: the parallel-axis theorem."""
    added: FloatArray = mass * ((place @ place) * np.eye(3) - np.outer(place, place))
    return added
