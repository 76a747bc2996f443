"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.losses import Loss, losses
from gd_analyze.simplification.payload_effect import PayloadEffect, payload_effect
from gd_analyze.simplification.ranking import RankedTerm, TermRanking, rank_terms
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.states import States, states_in_box, states_of
from gd_analyze.simplification.trade_off import TradeOffPoint, curves, trade_off
from gd_analyze.simplification.uncertainty import torque_uncertainty

__all__ = [
    "Budget",
    "ExactDynamics",
    "Loss",
    "PayloadEffect",
    "RankedTerm",
    "States",
    "TermRanking",
    "TradeOffPoint",
    "curves",
    "losses",
    "payload_effect",
    "rank_terms",
    "simplify",
    "simplify_exact",
    "states_in_box",
    "states_of",
    "torque_uncertainty",
    "trade_off",
]
