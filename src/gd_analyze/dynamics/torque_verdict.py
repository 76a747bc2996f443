"""Whether a measured torque is that of the model, joint by joint, in few kinds."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import JointFit

Verdict = Literal[
    "follows",
    "follows but for friction",
    "too light",
    "too heavy",
    "other sign",
    "another joint's",
    "below friction",
    "does not follow",
    "not measured",
]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
# Of these the robot file is to blame, or how the log was read.
CONTRADICTING: tuple[Verdict, ...] = (
    "too light",
    "too heavy",
    "other sign",
    "another joint's",
    "does not follow",
)

# Share of the measured variance from which on the model alone is enough: what is left is, as RMS, less than a
# third (sqrt(0.1)) of what was measured.
FOLLOWS = 0.9
# Correlation beside friction from which on the model's torque is taken to be there: it makes two thirds
# (0.8^2) of the variance that friction leaves.
THERE = 0.8
# Factor up to which model and measurement are as large: torque constants and gears' efficiencies, by which
# currents become torques, are known to some 20 %.
AS_LARGE = 4.0 / 3.0
# Friction is Coulomb's and viscous to within this part of it: it depends on load, warmth and place as well.
FRICTION_IS_KNOWN = 0.2
# Standard errors from which on a difference is one.
SIGMAS = 3.0


def verdict_of(fit: JointFit, explained: float, explained_by: FloatArray, joint: int) -> tuple[Verdict, int]:
    """Judge one joint.

    Parameters
    ----------
    fit
        Friction beside the model.
    explained
        Share of the measured variance that the model alone explains.
    explained_by
        The same for every joint's model, shape (n,).
    joint
        Which of them it is, from 0.

    Returns
    -------
    verdict, joint
        And which other joint's model the measurement is, from 1; 0 where it is none's.
    """
    if explained >= FOLLOWS:
        return "follows", 0
    others = np.delete(explained_by, joint)
    best = float(others.max(initial=-np.inf))
    if best >= max(FOLLOWS, fit.explained):
        return "another joint's", int(np.flatnonzero(explained_by == best)[0]) + 1
    if np.isfinite(fit.slope) and abs(fit.slope) > SIGMAS * fit.slope_error:
        if fit.partial <= -THERE:
            return "other sign", 0
        if fit.partial >= THERE:
            return _by_size(fit), 0
    # Were the model right, friction beside it would leave at least the model's own torque.
    hidden = fit.own <= max(fit.left, FRICTION_IS_KNOWN * fit.like_friction)
    return ("below friction" if hidden else "does not follow"), 0


def _by_size(fit: JointFit) -> Verdict:
    sure = abs(fit.slope - 1.0) > SIGMAS * fit.slope_error
    if fit.slope > AS_LARGE and sure:
        return "too light"
    if fit.slope < 1.0 / AS_LARGE and sure:
        return "too heavy"
    return "follows but for friction"
