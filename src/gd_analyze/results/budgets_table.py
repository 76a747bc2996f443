"""The path of models through the one that is shown, as a table: what a reader sees who changes the budget."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.schema import table
from gd_analyze.simplification.element import ELEMENT, parts_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.ranking import TermRanking

if TYPE_CHECKING:
    import xarray as xr


def budgets_table(
    path: Sequence[SimplifiedModel], factors: Sequence[float], ranking: TermRanking
) -> xr.Dataset:
    """Tabulate what is kept, at what error and how many operations, for each multiple of the budget.

    Of a model of torque or energy terms, `kept` says which of the ranked torque terms remain: one remains as
    long as anything does that makes it. Of a model of parts, `kept_parts` says which of these do. A recursion
    keeps neither.
    """
    form, counts = path[0].form, [model.operations for model in path]
    values: dict[str, Any] = {
        "budget": [model.accuracy.budget for model in path],
        "operations": [count.total for count in counts],
        "multiplications": [count.multiplications for count in counts],
        "additions": [count.additions for count in counts],
        "largest_error": [model.accuracy.errors.largest for model in path],
    }
    coords: dict[str, Any] = {
        "factor": ("factor", list(factors), {"long_name": "multiple of the budget"}),
    }
    if path[0].level.has_torque_terms:
        terms = [ranked.term for ranked in ranking.terms]
        kept = [[term in model.torques for term in terms] for model in path]
        values["kept"] = np.array(kept, dtype=bool).reshape(len(path), len(terms))
        coords["rank"] = np.arange(1, len(terms) + 1)
    elif path[0].level is ELEMENT:
        parts = parts_of(form.arm.n_joints)
        values["kept_parts"] = [[part in model.terms for part in parts] for model in path]
        coords["part"] = [part.label for part in parts]
    return table("budgets", values, form.arm.is_revolute, coords)
