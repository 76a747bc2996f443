"""Levels of simplification, and the models made at them: evaluate, hold against the exact, save and load."""

from gd_analyze.levels.budget import Budget as Budget
from gd_analyze.levels.element import ELEMENT as ELEMENT
from gd_analyze.levels.energy import ENERGY as ENERGY
from gd_analyze.levels.evaluation import Evaluation as Evaluation
from gd_analyze.levels.evaluation import evaluate as evaluate
from gd_analyze.levels.evaluation import torque_csv as torque_csv
from gd_analyze.levels.exact import ExactDynamics as ExactDynamics
from gd_analyze.levels.exact import ExactForm as ExactForm
from gd_analyze.levels.exact import warn_without_torque as warn_without_torque
from gd_analyze.levels.level import Level as Level
from gd_analyze.levels.levels import LEVELS as LEVELS
from gd_analyze.levels.levels import level_named as level_named
from gd_analyze.levels.losses import Loss as Loss
from gd_analyze.levels.losses import losses as losses
from gd_analyze.levels.model import SimplifiedModel as SimplifiedModel
from gd_analyze.levels.model_file import load_model as load_model
from gd_analyze.levels.model_file import save_model as save_model
from gd_analyze.levels.parts import Part as Part
from gd_analyze.levels.parts import parts_of as parts_of
from gd_analyze.levels.payload_effect import PayloadEffect as PayloadEffect
from gd_analyze.levels.payload_effect import payload_effect as payload_effect
from gd_analyze.levels.promise import ErrorTable as ErrorTable
from gd_analyze.levels.promise import Promise as Promise
from gd_analyze.levels.promise import SearchStep as SearchStep
from gd_analyze.levels.term import TERM as TERM
