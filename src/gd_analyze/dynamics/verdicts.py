"""The rule of verdicts: which parts represent an element, and whether it counts.

An element of D, h or c is the sum of a translational and a rotational part; drives add to the diagonal of D.

Round-off
    A part whose peak is at most `ROUND_OFF` times the largest part of its quantity is not there: an element
    is a sum of some tens of terms as large as that. What is left is the links' element.
Needed
    A part is needed if leaving it out changes the links' element by more than the threshold, a share of the
    element's peak over the motion.
Represents
    Over the motion: the parts needed at any set point. With a threshold below one half at least one is, as
    one makes half of the peak or more. Above that, neither may be, and the larger represents the element:
    leaving out the smaller changes it least, and an element that is there is not represented by nothing.
    At a set point: the parts needed there or, if neither is, those that represent it over the motion.
Negligible
    A torque is, if it is at most an equal share of the error allowed at every joint it acts on, so that all
    negligible elements may be left out together: n of D, one of h and one of c make a joint's torque.
Verdict
    "zero", if neither part nor a drive is there; "negligible", if the torque, the drive's included, is;
    "drive", if that of the links' parts is; "gravity", of any other element of c, which is all translation;
    or else the parts that represent the element.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.text import percent

ROUND_OFF = 64 * float(np.finfo(float).eps)
# What represents an element, in the numbering 1 for translation plus 2 for rotation.
DOMINANT = np.array(["zero", "translation", "rotation", "both"])


def is_round_off(values: FloatArray, largest: FloatArray | float) -> Array:
    """Whether values are round-off of something as large as `largest`."""
    return np.abs(values) <= ROUND_OFF * largest


def least_changes(
    part_peaks: FloatArray, peak: FloatArray, largest: FloatArray | float, threshold: float
) -> FloatArray:
    """Change of elements beyond which a part is needed, (2, ...); infinite for a part that is not there.

    Parameters
    ----------
    part_peaks, peak
        Peaks over the motion of translation and rotation, (2, ...), and of their sum, (...).
    largest
        Largest part of the element's quantity over the motion.
    threshold
        Share of the peak.
    """
    is_there = ~is_round_off(part_peaks, largest)
    peak = np.where(is_there.all(axis=0), peak, part_peaks.max(axis=0))
    return np.where(is_there, threshold * peak, np.inf)


def representing(part_peaks: FloatArray, least: FloatArray) -> Array:
    """Whether translation and rotation represent elements over the motion, (2, ...)."""
    needed: Array = part_peaks > least
    is_larger = np.stack([part_peaks[0] >= part_peaks[1], part_peaks[0] < part_peaks[1]])
    return needed | (~needed.any(axis=0) & is_larger & np.isfinite(least))


def representing_at(needed: Array, over_motion: Array) -> Array:
    """Whether parts represent elements at set points, from those needed there and over the motion."""
    return needed | (~needed.any(axis=0) & over_motion)


def effect_words(represents: Array) -> Array:
    """What represents elements, in words of `DOMINANT`, from whether either part does, (2, ...)."""
    return DOMINANT[represents[0] + 2 * represents[1]]


def sharing_elements(n_joints: int) -> int:
    """Count the elements that share the error allowed of a torque: n of D, one of h and one of c."""
    return n_joints + 2


def negligible_torque(allowed: FloatArray) -> FloatArray:
    """Torque up to which an element is negligible, of the error allowed at every joint, (n,) or (n, S)."""
    return allowed / sharing_elements(len(allowed))


def verdict_words(
    dominant: Array, is_zero: Array, is_negligible: Array, are_links_negligible: Array, is_gravity: Array
) -> Array:
    """Verdicts, of what represents elements, with the drive and of the links' parts alone."""
    conditions = [is_zero, is_negligible, are_links_negligible, is_gravity]
    return np.select(conditions, ["zero", "negligible", "drive", "gravity"], dominant)


def verdict_definition(threshold: float, n_joints: int) -> str:
    """When a part is needed, and when an element is negligible."""
    return (
        f"parts whose loss changes the element by more than {percent(threshold)} of its peak; negligible, if "
        f"its torque is at most 1/{sharing_elements(n_joints)} of the budget"
    )
