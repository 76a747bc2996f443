"""A model that keeps its budget over a region, and how this is known."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple
from warnings import catch_warnings

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.motions.pool import pool
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel


class Held(NamedTuple):
    """A model that keeps its budget over a region, and how this is known."""

    model: SimplifiedModel
    certificate: Certificate | None = None  # its proven bound, if any
    tried: int = 0  # random states or positions, none of which exceeds the budget; 0 if it is proven
    found: FloatArray | None = None  # largest torque error found from these, N m (N), shape (n,)
    where: str = ""  # name of these states
    near: ExactDynamics | None = None  # exact dynamics at states it was fitted on
    tried_are: str = "states"  # or "positions", each at its worst velocities and accelerations


def proven(model: SimplifiedModel, certificate: Certificate | None) -> SimplifiedModel:
    """The model with its proven bound."""
    if certificate is None:
        return model
    return model.stating(replace(model.accuracy, certificate=certificate.stated))


def stated_region(model: SimplifiedModel, motions: Sequence[Trajectory]) -> Box | Tube | None:
    """Region of the bound that a model states; None without one, or without the motion that it is near.

    That motion is one of those given, all of them together, or a shipped one.
    """
    stated = model.accuracy.certificate
    if stated is None:
        return None
    if not stated.trajectory_fingerprint:
        return Box(stated.lower, stated.upper, stated.velocity, stated.acceleration, stated.where)
    name = str(model.accuracy.fitted_on.get("trajectory"))
    candidates = [*motions, *([pool(motions)] if len(motions) > 1 else [])]
    if name in shipped_trajectories():
        # What is suspicious about it was told when the model was made.
        with suppress(GdAnalyzeError), catch_warnings(action="ignore", category=GdAnalyzeWarning):
            candidates.append(read_trajectory(name, model.arm))
    for motion in candidates:
        if motion.fingerprint == stated.trajectory_fingerprint:
            return Tube.along(model.arm, motion, stated.margin)
    return None
