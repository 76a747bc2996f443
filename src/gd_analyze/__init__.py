"""Split a robot arm's dynamics by effect, rank the parts, drop what the torque budget allows.

>>> import gd_analyze as gd
>>> arm = gd.load_arm("puma560")
>>> trajectory = gd.read_trajectory("pick-and-place", arm)
>>> dataset = gd.decompose(arm, trajectory)
>>> ranking = gd.rank(dataset)
>>> model = gd.simplify(arm, trajectory, gd.Budget.parse("1%"))
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from gd_analyze.version import __version__

if TYPE_CHECKING:
    from gd_analyze.authority import cross_check
    from gd_analyze.certification import Box, certify, certify_positive_definite, simplify_certified
    from gd_analyze.decomposition import decompose, decompose_states
    from gd_analyze.dominance import rank, text_verdicts
    from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
    from gd_analyze.harmonics import harmonics_of
    from gd_analyze.harmonics.equations import equations
    from gd_analyze.main_job import analyze, find
    from gd_analyze.models import (
        ElementModel,
        HarmonicModel,
        SimplifiedModel,
        evaluate,
        load_model,
        save_model,
    )
    from gd_analyze.robots import RobotArm, builtin_arms, load_arm
    from gd_analyze.simplification import (
        Budget,
        ExactDynamics,
        payload_effect,
        rank_terms,
        simplify,
        states_in_box,
        states_of,
        torque_uncertainty,
        trade_off,
    )
    from gd_analyze.store import load_results, save_results
    from gd_analyze.trajectories import Trajectory, plan, read_trajectory, write_trajectory

_HOMES = {
    "authority": ("cross_check",),
    "certification": ("Box", "certify", "certify_positive_definite", "simplify_certified"),
    "decomposition": ("decompose", "decompose_states"),
    "dominance": ("rank", "text_verdicts"),
    "errors": ("GdAnalyzeError", "GdAnalyzeWarning"),
    "harmonics.equations": ("equations",),
    "harmonics.transform": ("harmonics_of",),
    "main_job": ("analyze", "find"),
    "models": (
        "ElementModel",
        "HarmonicModel",
        "SimplifiedModel",
        "evaluate",
        "evaluate_states",
        "load_model",
        "save_model",
    ),
    "robots": ("RobotArm", "builtin_arms", "load_arm"),
    "simplification": (
        "Budget",
        "ExactDynamics",
        "payload_effect",
        "rank_terms",
        "simplify",
        "states_in_box",
        "states_of",
        "torque_uncertainty",
        "trade_off",
    ),
    "store": ("load_results", "save_results"),
    "trajectories": ("Trajectory", "plan", "read_trajectory", "write_trajectory"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Box",
    "Budget",
    "ElementModel",
    "ExactDynamics",
    "GdAnalyzeError",
    "GdAnalyzeWarning",
    "HarmonicModel",
    "RobotArm",
    "SimplifiedModel",
    "Trajectory",
    "__version__",
    "analyze",
    "builtin_arms",
    "certify",
    "certify_positive_definite",
    "cross_check",
    "decompose",
    "decompose_states",
    "equations",
    "evaluate",
    "evaluate_states",
    "find",
    "harmonics_of",
    "load_arm",
    "load_model",
    "load_results",
    "payload_effect",
    "plan",
    "rank",
    "rank_terms",
    "read_trajectory",
    "save_model",
    "save_results",
    "simplify",
    "simplify_certified",
    "states_in_box",
    "states_of",
    "text_verdicts",
    "torque_uncertainty",
    "trade_off",
    "write_trajectory",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that the command line answers at once."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = importlib.import_module(f"{__name__}.{_HOME_OF[name]}")
    return getattr(home, name)


def __dir__() -> list[str]:
    return sorted(__all__)
