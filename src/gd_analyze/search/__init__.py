"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.search.ranking import RankedTerm, TermRanking, rank_terms
from gd_analyze.search.simplify import How, simplify, simplify_exact
from gd_analyze.search.trade_off import TradeOffPoint, curves, trade_off
from gd_analyze.search.uncertainty import torque_uncertainty

__all__ = [
    "How",
    "RankedTerm",
    "TermRanking",
    "TradeOffPoint",
    "curves",
    "rank_terms",
    "simplify",
    "simplify_exact",
    "torque_uncertainty",
    "trade_off",
]
