"""How far from the motion the budget holds, and what is proven there."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.margin import Margin
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import rows_of


def margins(findings: Findings) -> str:
    """How far from the motion the budget holds and errors are bounded, in words."""
    return Margin.parse(findings.tables["tube"].attrs["margin"]).in_words(findings.arm)


def tube_bound(findings: Findings) -> FloatArray | None:
    """Proven bound on every joint's error near the motion, N m, shape (n,); None if there is none."""
    bound = findings.tables["tube"].tube_certified
    return None if bound.isnull().any() else np.asarray(bound.values)


def near_bound(findings: Findings) -> FloatArray | None:
    """The same bound; with several motions, the largest of their bounds.

    Each motion's bound is multiplied by the overall allowed error over the error allowed along the motion.
    """
    bound = tube_bound(findings)
    if bound is None or "motions" not in findings.tables:
        return bound
    motions = findings.tables["motions"]
    return np.asarray(
        (motions.certified * (findings.model.accuracy.allowed / motions.allowed_error)).max("motion")
    )


def bound_ratio(findings: Findings) -> float | None:
    """Largest ratio of the certified bound to the worst error found, where that exceeds round-off."""
    rows = rows_of(findings.tables["beyond"], "joint")
    pairs = [(row["certified"], row["worst_found"]) for row in rows if row["certified"] is not None]
    return max((bound / error for bound, error in pairs if error > findings.round_off), default=None)
