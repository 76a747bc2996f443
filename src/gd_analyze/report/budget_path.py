"""What a reader sees who changes the budget: numbers of the models on one path through the one shown."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.report.beyond_chart import place
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row, budget_rows
from gd_analyze.text import pretty

# Decades of the axis that errors over the budget stand on.
DECADES = (-2, 1)


@dataclass(frozen=True)
class BudgetPath:
    """The path, smallest budget first.

    Parameters
    ----------
    rows
        Of `gd_analyze.results.rows.budget_rows`.
    flags
        Of everything that any budget keeps, by rank of a term or label of a part: at which budgets it is
        kept, "1" or "0" each.
    asked
        Place of the budget that was asked for.
    """

    rows: list[Row]
    flags: dict[Any, str]
    asked: int

    @classmethod
    def of(cls, findings: Findings) -> BudgetPath:
        """Read the table."""
        rows = budget_rows(findings)
        kept = [set(row["kept"]) for row in rows]
        everything = sorted(set().union(*kept))
        flags = {one: "".join("1" if one in of_row else "0" for of_row in kept) for one in everything}
        return cls(rows, flags, next(k for k, row in enumerate(rows) if row["factor"] == 1.0))

    @property
    def moves(self) -> bool:
        """Whether any budget gives another model than the one asked for."""
        return len({row["operations"] for row in self.rows}) > 1

    def data(self, findings: Findings) -> dict[str, Any]:
        """Values for the page's script; places are percent of the axis from its left."""
        model, allowed = findings.model, findings.model.accuracy.allowed
        errors = np.array([row["largest_error"] for row in self.rows])
        ratio = np.divide(errors, allowed, out=np.zeros_like(errors), where=allowed > 0.0)
        return {
            "factor": [row["factor"] for row in self.rows],
            "label": [budget_words(row["budget"]) for row in self.rows],
            "operations": [row["operations"] for row in self.rows],
            "kept": [len(row["kept"]) for row in self.rows],
            "keeps": {"terms": model.level.keeps, "parts": "parts"}.get(summary.made_of(findings), ""),
            "exact": model.operations_full.total,
            "largest_error": [[float(f"{error:.4g}") for error in row] for row in errors],
            "place": [[place(share, *DECADES) for share in row] for row in ratio],
            "limit": [place(row["factor"], *DECADES) for row in self.rows],
            "allowed": allowed.tolist(),
            "whole": model.accuracy.whole.tolist(),
            "shares_of": model.accuracy.asked.shares_of,
            "unit": [joint.effort_unit for joint in findings.arm.joints],
        }


def budget_words(budget: str) -> str:
    """Say of what a budget's percentages are, numbers to three digits.

    Examples
    --------
    >>> budget_words("1% or 10% friction"), budget_words("0.5 N m")
    ('1 % of peak torque or 10 % of friction', '0.5 N m')
    """
    rounded = re.sub(r"\d+(\.\d+)?(e[+-]?\d+)?", lambda found: f"{float(found[0]):.3g}", budget)
    told = re.sub(r"% (?=limit|friction|uncertainty)", " % of ", pretty(rounded))
    return re.sub(r"%(?=$|,| or)", " % of peak torque", told)
