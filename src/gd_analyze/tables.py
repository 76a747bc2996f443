"""Steps between the jobs: states, payloads, verdicts over time, parameters, terms, and the results file."""

from __future__ import annotations

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.dominance_over_time import dominance_over_time, verdicts
from gd_analyze.dynamics.forward_dynamics import joint_accelerations
from gd_analyze.dynamics.pinocchio_check import cross_check
from gd_analyze.dynamics.robustness import robustness
from gd_analyze.dynamics.simulation import simulate
from gd_analyze.dynamics.uncertainty import torque_uncertainty
from gd_analyze.harmonics.transform import harmonics_of
from gd_analyze.motions.states import states_in_box, states_of
from gd_analyze.results.store import load_results, save_results
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.model_torque import payload_effect
from gd_analyze.simplification.term_ranking import rank_terms

__all__ = [
    "cross_check",
    "decompose_states",
    "dominance_over_time",
    "harmonics_of",
    "joint_accelerations",
    "load_results",
    "payload_effect",
    "rank_terms",
    "robustness",
    "save_results",
    "simulate",
    "states_in_box",
    "states_of",
    "text_verdicts",
    "torque_uncertainty",
    "verdicts",
    "with_payload",
]
