"""Choosing what to keep of the dynamics under a torque error budget."""

from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element_level import model_of, simplify, torque_by_part
from gd_analyze.simplification.losses import Loss, losses

__all__ = ["Budget", "Loss", "losses", "model_of", "simplify", "torque_by_part"]
