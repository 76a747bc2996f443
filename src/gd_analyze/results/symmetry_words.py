"""Whether the model's D is symmetric, and what to use where it must be."""

from __future__ import annotations

from gd_analyze.results.findings import Findings
from gd_analyze.text import joined


def unsymmetric(findings: Findings) -> list[tuple[int, int]]:
    """Elements of D', row and column from 1, of which the model keeps other terms than of their mirror image.

    Torques are simplified one by one at the level of torque terms; D' is the matrix of absolute rates.
    """
    model = findings.model
    if not model.level.has_torque_terms or model.level.is_mechanical:
        return []
    kept = [
        (term.row, term.velocities[0].joint, term.monomial)
        for term in model.torques
        if term.quantity == "inertia" and term.row != term.velocities[0].joint
    ]
    places = {(i, j) for i, j, monomial in kept if (j, i, monomial) not in set(kept)}
    return sorted({(min(place) + 1, max(place) + 1) for place in places})


def unsymmetric_told(findings: Findings) -> str:
    """Say that D is not symmetric, and what to use where it must be; "" where it is."""
    places = unsymmetric(findings)
    if not places:
        return ""
    i, j = places[0]
    count = len(places)
    pairs = "one pair of mirror images" if count == 1 else f"{count} pairs of mirror images"
    return (
        f"Each torque is simplified by itself, so the model's D is not symmetric: it keeps different terms "
        f"in {pairs}, first in D{joined((i - 1, j - 1))} and D{joined((j - 1, i - 1))}. To compute torques "
        "this does no harm. Where D must be symmetric, as in simulation or in a controller that relies on "
        "energy, use `--level energy`."
    )
