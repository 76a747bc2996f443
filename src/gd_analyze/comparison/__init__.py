"""The formulations side by side: what they cost, how long they take, how far they agree."""

from gd_analyze.comparison.agreement import agreement
from gd_analyze.comparison.compare import Comparison, compare
from gd_analyze.comparison.costs import Growth, count_cost, growth
from gd_analyze.comparison.generic_chain import generic_chain
from gd_analyze.comparison.polynomial import Polynomial, exact_polynomial
from gd_analyze.comparison.text_costs import text_costs
from gd_analyze.comparison.timing import time_methods

__all__ = [
    "Comparison",
    "Growth",
    "Polynomial",
    "agreement",
    "compare",
    "count_cost",
    "exact_polynomial",
    "generic_chain",
    "growth",
    "text_costs",
    "time_methods",
]
