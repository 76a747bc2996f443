"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.search.how import How as How
from gd_analyze.search.ranking import RankedTerm as RankedTerm
from gd_analyze.search.ranking import TermRanking as TermRanking
from gd_analyze.search.ranking import rank_terms as rank_terms
from gd_analyze.search.simplify import simplify as simplify
from gd_analyze.search.simplify import simplify_exact as simplify_exact
from gd_analyze.search.trade_off import TradeOffPoint as TradeOffPoint
from gd_analyze.search.trade_off import curves as curves
from gd_analyze.search.trade_off import trade_off as trade_off
