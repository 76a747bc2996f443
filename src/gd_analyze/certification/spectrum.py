"""Waves by joint and degree: how curved what they add up to can be, and what that hides between nodes.

What is bounded, and why, is said in `grid`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial


@dataclass(frozen=True, eq=False)
class Spectra:
    """Amplitudes and curvatures of waves; called with some chosen, shape (W,), it adds them up by joint."""

    sizes: FloatArray
    curvatures: FloatArray
    multiples: NDArray[np.int64]

    @classmethod
    def of(cls, waves: TrigonometricPolynomial, box: Box) -> Spectra:
        """Those of waves that slide as far as they can in a box."""
        every = waves.magnitudes()
        sizes, curvatures = every.sizes(box.farthest), every.curvatures(box.farthest)
        return cls(sizes[0], curvatures[0], np.abs(waves.multiples))

    def __call__(self, chosen: NDArray[np.bool_]) -> Spectrum:
        """Add up those chosen."""
        sizes, most = self.sizes * chosen, int(self.multiples.max(initial=0))
        by_multiple = [np.bincount(m, weights=sizes, minlength=most + 1) for m in self.multiples.T]
        return Spectrum(np.array(by_multiple), chosen @ self.curvatures, float(sizes.sum()))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes by joint and |multiple|, shape (n, D + 1), curvatures by joint, (n,), and all amplitudes."""

    amplitudes: FloatArray
    curvatures: FloatArray
    total: float

    def beyond(self, joint: int, degree: int) -> tuple[float, float]:
        """Amplitudes a and curvatures b of what has a higher degree in a joint."""
        high = np.arange(degree + 1, self.amplitudes.shape[1])
        return float(self.amplitudes[joint, high].sum()), float(self.amplitudes[joint, high] @ high**2)

    def curvature(self, joint: int, degree: int, largest: float) -> float:
        """Bound K_k by amplitudes, or by what f reaches."""
        if not degree:
            return float(self.curvatures[joint])
        more, curved = self.beyond(joint, degree)
        return degree**2 * (largest + more) + curved

    def bound(self, reaches: FloatArray, degrees: Sequence[int], largest: float) -> float:
        """G_0 from G_n; joints that share of f are moved to their nodes last, so that this is least."""
        for joint in sorted(range(len(degrees)), key=lambda k: not degrees[k]):
            loss, degree = float(reaches[joint]) ** 2 / 2, degrees[joint]
            left = 1.0 - loss * degree**2
            if not left > 0.0:
                return math.inf
            largest = (largest + loss * self.curvature(joint, degree, 0.0)) / left
        return largest
