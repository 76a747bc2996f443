"""Levels of simplification, and the models made at them: evaluate, hold against the exact, save and load."""

from gd_analyze.levels.budget import Budget
from gd_analyze.levels.evaluation import Evaluation, evaluate, torque_csv
from gd_analyze.levels.exact import ExactDynamics, ExactForm
from gd_analyze.levels.level import Level
from gd_analyze.levels.levels import ELEMENT, ENERGY, LEVELS, TERM, level_named
from gd_analyze.levels.losses import Loss, losses
from gd_analyze.levels.model import SimplifiedModel
from gd_analyze.levels.model_file import load_model, save_model
from gd_analyze.levels.parts import Part, parts_of
from gd_analyze.levels.payload_effect import PayloadEffect, payload_effect
from gd_analyze.levels.promise import ErrorTable, Promise, SearchStep

__all__ = [
    "ELEMENT",
    "ENERGY",
    "LEVELS",
    "TERM",
    "Budget",
    "ErrorTable",
    "Evaluation",
    "ExactDynamics",
    "ExactForm",
    "Level",
    "Loss",
    "Part",
    "PayloadEffect",
    "Promise",
    "SearchStep",
    "SimplifiedModel",
    "evaluate",
    "level_named",
    "load_model",
    "losses",
    "parts_of",
    "payload_effect",
    "save_model",
    "torque_csv",
]
