"""Simplified models: evaluate, hold against the exact dynamics, save and load."""

from gd_analyze.models.element import ElementModel
from gd_analyze.models.element_level import Part, parts_of
from gd_analyze.models.evaluation import Evaluation, evaluate, evaluate_states, torque_csv
from gd_analyze.models.harmonic import HarmonicModel
from gd_analyze.models.model_file import load_model, save_model
from gd_analyze.models.simplified import LEVELS, ErrorTable, Level, SimplifiedModel

__all__ = [
    "LEVELS",
    "ElementModel",
    "ErrorTable",
    "Evaluation",
    "HarmonicModel",
    "Level",
    "Part",
    "SimplifiedModel",
    "evaluate",
    "evaluate_states",
    "load_model",
    "parts_of",
    "save_model",
    "torque_csv",
]
