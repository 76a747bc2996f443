"""What is proven of the model, in words: near the motion, and beside what a search found."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.tube import Margin
from gd_analyze.results.error_words import WorstError, worst_error
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of


def tube_proven(findings: Findings) -> WorstError | None:
    """Error that is proven near the motion, of the joint where it is worst; None where nothing is proven."""
    bound = tube_bound(findings)
    return None if bound is None else worst_error(findings.model, bound)


def tube_bound(findings: Findings) -> FloatArray | None:
    """What is proven of every joint's error near the motion, N m, shape (n,); None where nothing is."""
    bound = findings.tables["tube"].tube_certified
    return None if bound.isnull().any() else np.asarray(bound.values)


def margins_told(findings: Findings) -> str:
    """How far from the motion that is, in words."""
    return Margin.parse(findings.tables["tube"].attrs["margin"]).in_words(findings.arm)


def tube_sentence(findings: Findings) -> str:
    """Say what is proven of the model around this motion."""
    worst, note = tube_proven(findings), str(findings.tables["tube"].attrs["note"])
    if worst is None:
        return note
    size = f"above {worst.in_words}" if findings.model.saves else "beyond round-off, as nothing is dropped"
    return (
        f"Proven: no state within {margins_told(findings)} of the motion, between its set points too, has a "
        f"torque error {size}." + (f" {note}" if note else "")
    )


def bound_ratio(findings: Findings) -> float | None:
    """How far the certified bound lies above the worst error found, at most, where that is an error."""
    rows = rows_of(findings.tables["beyond"], "joint")
    pairs = [(row["certified"], row["worst_found"]) for row in rows if row["certified"] is not None]
    return max((bound / found for bound, found in pairs if found > findings.round_off), default=None)
