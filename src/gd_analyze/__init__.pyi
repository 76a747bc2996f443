# Public names, each once, with their homes: type checkers read this file, and so does __init__.py.
from . import tables as tables
from . import types as types
from .certification.certificate import certify as certify
from .certification.positive_definite import certify_positive_definite as certify_positive_definite
from .diagnosis.diagnose import diagnose as diagnose
from .dynamics.base_parameters import base_parameters as base_parameters
from .dynamics.decomposition import decompose as decompose
from .dynamics.dominance import rank as rank
from .dynamics.measured_torque import compare_torque as compare_torque
from .dynamics.regressor import regressor as regressor
from .errors import GdAnalyzeError as GdAnalyzeError
from .errors import GdAnalyzeWarning as GdAnalyzeWarning
from .exporting.export import export as export
from .exporting.export import export_decomposition as export_decomposition
from .identification.excitation import exciting_motion as exciting_motion
from .identification.identify import identify as identify
from .motions.pool import pool as pool
from .motions.read import read_log as read_log
from .motions.read import read_trajectory as read_trajectory
from .motions.trajectory import Trajectory as Trajectory
from .motions.trajectory import write_trajectory as write_trajectory
from .results.store import load_findings as load_findings
from .robots.arm_toml import save_arm as save_arm
from .robots.catalogue import builtin_arms as builtin_arms
from .robots.catalogue import load_arm as load_arm
from .simplification.equations import equations as equations
from .simplification.model_file import load_model as load_model
from .simplification.model_file import save_model as save_model
from .simplification.trade_off import trade_off as trade_off
from .studies.batch import batch as batch
from .studies.evaluation import evaluate as evaluate
from .studies.main_job import analyze as analyze
from .studies.plan import plan as plan
from .studies.simplifying import simplify as simplify

__version__: str
__all__: list[str]
