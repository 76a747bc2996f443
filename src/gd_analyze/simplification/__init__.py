"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.certificate import Certificate, certify
from gd_analyze.simplification.element_level import model_of, simplify, torque_by_part
from gd_analyze.simplification.error_field import Box
from gd_analyze.simplification.harmonic_level import simplify_harmonics
from gd_analyze.simplification.losses import Loss, losses
from gd_analyze.simplification.states import States, states_in_box, states_of

__all__ = [
    "Box",
    "Budget",
    "Certificate",
    "Loss",
    "States",
    "certify",
    "losses",
    "model_of",
    "simplify",
    "simplify_harmonics",
    "states_in_box",
    "states_of",
    "torque_by_part",
]
