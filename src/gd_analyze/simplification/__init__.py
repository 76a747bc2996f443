"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.certificate import Certificate, certify
from gd_analyze.simplification.error_field import Box
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.losses import Loss, losses
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.states import States, states_in_box, states_of

__all__ = [
    "Box",
    "Budget",
    "Certificate",
    "ExactDynamics",
    "Loss",
    "States",
    "certify",
    "losses",
    "simplify",
    "simplify_exact",
    "states_in_box",
    "states_of",
]
