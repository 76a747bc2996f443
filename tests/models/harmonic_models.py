"""Models made of harmonic terms: the exact one of any arm, and the numeric torques beside it."""

from __future__ import annotations

import numpy as np

from gd_analyze.harmonics import harmonics_of
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.models import HarmonicModel
from gd_analyze.models.harmonic import torques_of_energy
from gd_analyze.models.simplified import ErrorTable
from gd_analyze.operations import OperationCount
from gd_analyze.robots import RobotArm

# Identification is exact to a few hundred eps of the largest element (its noise is measured in
# tests/harmonics); a torque sums some thousand terms of that size. Models that lack a term, or hold it with
# a wrong factor, are off by its share, which in these arms is 1e-6 and more.
ROUND_OFF = 1e-10


def exact_model(arm: RobotArm, drives: bool = False, level: str = "energy") -> HarmonicModel:
    n = arm.n_joints
    energy = energy_terms(harmonics_of(arm), arm.drive_inertia if drives else None)
    nothing = ErrorTable(np.ones(n), np.zeros(n), np.zeros(n))
    return HarmonicModel(
        arm=arm,
        level=level,
        energy=energy if level == "energy" else (),
        torques=torques_of_energy(arm, energy),
        drives=drives,
        budget=np.ones(n),
        budget_stated="1 N m",
        promise=nothing,
        made_for={"box": "drawn", "states": 5, "seed": 0},
        operations_full=OperationCount(3, 2, 1),
    )
