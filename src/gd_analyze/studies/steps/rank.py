"""The third step of the main job: the elements of the dynamics by what they do to torque."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from gd_analyze.dynamics.dominance import rank
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.simplification.budget import Budget
from gd_analyze.studies.steps.decompose import RunDynamics
from gd_analyze.studies.steps.read import RunInputs

if TYPE_CHECKING:
    import xarray as xr


def rank_step(inputs: RunInputs, dynamics: RunDynamics, budget: Budget) -> xr.Dataset:
    """Rank the elements, and give verdicts at a budget."""
    return rank(
        dynamics.points.dataset,
        threshold=inputs.settings.dominance,
        budget=dynamics.exact.under(budget).allowed(budget),
        extremes=dynamics.points.extremes,
    )


def warn_of_too_many_terms(dynamics: RunDynamics) -> None:
    """Warn where single terms are not ranked."""
    if dynamics.too_many_terms:
        name = dynamics.exact.arm.name
        text = f"{name} has {dynamics.too_many_terms}: elements are ranked, single terms are not"
        warnings.warn(text, GdAnalyzeWarning, stacklevel=2)
