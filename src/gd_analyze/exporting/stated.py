"""What a controller can hold a state against: errors and box as numbers, one per joint."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.certificate import Certificate
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import rounded_up


@dataclass(frozen=True)
class Stated:
    """Numbers that hold in one direction.

    Parameters
    ----------
    meaning
        What they are, in words.
    values
        One per joint.
    towards
        The infinity in whose direction they may be rounded.
    """

    meaning: str
    values: tuple[float, ...]
    towards: float

    @property
    def in_single(self) -> Stated:
        """The same in single precision: no bound smaller, no box larger.

        Examples
        --------
        >>> Stated("a bound", (0.1, 0.5), math.inf).in_single.values
        (0.10000000149011612, 0.5)
        >>> Stated("and to", (0.1, 0.5), -math.inf).in_single.values
        (0.09999999403953552, 0.5)
        """
        near = np.array(self.values, dtype=np.float32)
        beyond = np.nextafter(near, np.float32(self.towards))
        short = near < self.values if self.towards > 0.0 else near > np.array(self.values)
        return replace(self, values=tuple(np.where(short, beyond, near).tolist()))


def stated(model: SimplifiedModel | None, certificate: Certificate | None) -> Mapping[str, Stated]:
    """Take the numbers, by name, from a model and what is proven of it."""
    found: dict[str, Stated] = {}

    def state(name: str, meaning: str, values: FloatArray, towards: float = -math.inf) -> None:
        found[name] = Stated(meaning, tuple(map(float, values)), towards)

    if model is not None:
        meaning = "largest torque error at the states that the model was made for"
        state("sampled_error", meaning, model.accuracy.errors.largest, math.inf)
    if certificate is not None:
        box = certificate.box
        bounds = np.array([up(float(x)) for x in certificate.certified])
        state("error_bound", "no state within the box has a larger torque error", bounds, math.inf)
        state("lower", "the box: positions from", box.lower, math.inf)
        state("upper", "and to", box.upper)
        state("rate", "rates up to, either way", box.velocity)
        state("acceleration", "accelerations up to, either way", box.acceleration)
    return found


def up(value: float) -> float:
    """Round up to six digits what has more.

    Examples
    --------
    >>> up(0.1), up(-2.3), up(0.12345678)
    (0.1, -2.3, 0.123457)
    """
    return value if float(f"{value:.6g}") == value else rounded_up(value, 6)
