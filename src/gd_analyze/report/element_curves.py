"""What the figures of D, h and c draw, on the page and on paper."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import Element
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.results.findings import Findings


def rank_of(findings: Findings, element: Element) -> int:
    """Place of an element in the ranking, from 0."""
    return int(np.flatnonzero(findings.dominance.element.values == element.label)[0])


def element_curves(findings: Findings, element: Element) -> dict[str, FloatArray]:
    """Values of an element at the set points that are drawn, shape (N,) each.

    "combined" of every element, "translation" and "rotation" of D and h, and the shares "centrifugal" and
    "coriolis" of h. A part that the ranking calls zero is zero here.
    """
    _, dataset = findings.drawn
    zero = findings.dominance.part_peak.values[rank_of(findings, element), :, None] == 0.0
    parts = np.where(zero, 0.0, element.parts(dataset))
    curves = {"combined": parts.sum(axis=0)}
    if element.quantity != "gravity_loading":
        curves |= dict(zip(EFFECTS, parts, strict=True))
    if element.quantity == "coriolis_centrifugal":
        for share in ("centrifugal", "coriolis"):
            values = dataset[share].values[:, :, element.i].T
            curves[share] = np.where(zero, 0.0, values).sum(axis=0)
    return curves
