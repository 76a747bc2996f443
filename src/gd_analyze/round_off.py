"""What counts as round-off of a torque; docs/decisions/0006."""

from __future__ import annotations

import numpy as np

from gd_analyze.vectors import FloatArray

# Torques of every joint come from the same forces. Below this share of the arm's largest torque a number is
# what cancellation leaves: thousands of roundings (eps = 2e-16), yet far below any joint's real torque.
ROUND_OFF_SHARE = 1e-12


def round_off_of(torque: FloatArray, explained: float = 0.0) -> float:
    """Torque (N m) that is only round-off among torques (N, n).

    Parameters
    ----------
    torque
        Torques, N m, shape (N, n).
    explained
        What round-off explains where no joint needs any torque, as `pinocchio_check.round_off_bounds` has it:
        then there is no real torque to take a share of.
    """
    largest = float(np.abs(torque).max())
    return explained if largest <= explained else ROUND_OFF_SHARE * largest


def peak_magnitude(torque: FloatArray, explained: float = 0.0) -> FloatArray:
    """Largest magnitude of torques (N, n) per joint, shape (n,); exactly 0 where it is round-off."""
    peak = np.abs(torque).max(axis=0)
    return np.where(peak > round_off_of(torque, explained), peak, 0.0)


def falling(value: float) -> float:
    """Sort key for falling magnitude, the same for values that only round-off tells apart."""
    return -float(f"{abs(value):.9e}")
