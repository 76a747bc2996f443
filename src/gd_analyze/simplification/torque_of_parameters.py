"""A model's torque with the base parameters as inputs: its terms stay, their coefficients follow."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import BaseParameters
from gd_analyze.errors import UsageError
from gd_analyze.harmonics.lagrangian import summed_per_unit
from gd_analyze.harmonics.parameter_terms import energy_terms_of_parameters
from gd_analyze.harmonics.terms import EnergyTerm
from gd_analyze.operations.program import Program
from gd_analyze.simplification.harmonic import HARMONIC_LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.torque_program import program_of_parameters

# Share of its summands by which a coefficient differs from its sum of base parameters through round-off.
_ROUND_OFF = 1e-9


def torque_of_parameters(model: SimplifiedModel, base: BaseParameters) -> Program:
    """Program of the model's torque whose inputs include the base parameters, parameters1, parameters2, ...

    Raises
    ------
    UsageError
        If the model's coefficients are not the arm's own, or it has none.
    """
    level = HARMONIC_LEVELS.get(model.level.name)
    if level is None:
        raise _refused(model, f"level {model.level.name}")
    energies = energy_terms_of_parameters(model.form.harmonics, base)
    weights: Mapping[Any, FloatArray] = energies
    if not all(isinstance(term, EnergyTerm) for term in model.terms):
        weights = summed_per_unit(
            (per_unit, model.form.torques_of_energy(energy)) for energy, per_unit in energies.items()
        )
    if not model.terms.keys() <= weights.keys():
        raise _refused(model, "a term that its geometry has not")
    of_terms = {term: weights[term] for term in model.terms}
    numbers = np.array([parameter.number for parameter in base])
    for term, weight in model.terms.items():
        size = np.abs(of_terms[term]) @ np.abs(numbers)
        if abs(of_terms[term] @ numbers - weight) > _ROUND_OFF * size:
            raise _refused(model, "coefficients of another arm")
    torques = summed_per_unit(
        (per_unit, level.source(model.form, term)) for term, per_unit in of_terms.items()
    )
    return program_of_parameters(model.form.velocities, torques, len(base))


def _refused(model: SimplifiedModel, reason: str) -> UsageError:
    return UsageError(
        "the model's coefficients are no sums of base parameters",
        where="functions",
        expected="a model of level term or energy",
        found=reason,
        next_step=f"export the exact torque of {model.arm.name}: name the arm in place of the model",
    )
