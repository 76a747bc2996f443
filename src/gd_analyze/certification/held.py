"""A model that keeps its budget over a region, and how this is known."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.certificate import Certificate
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel


class Held(NamedTuple):
    """A model that keeps its budget over a region, and how this is known."""

    model: SimplifiedModel
    certificate: Certificate | None = None  # its proven bound, if any
    tried: int = 0  # random states or positions, none of which exceeds the budget; 0 if it is proven
    found: FloatArray | None = None  # largest torque error found from these, N m (N), shape (n,)
    where: str = ""  # name of these states
    near: ExactDynamics | None = None  # exact dynamics at states it was fitted on
    tried_are: str = "states"  # or "positions", each at its worst velocities and accelerations
    stopped: str = ""  # why its search ended early: "after 20 s", "on request"


def proven(model: SimplifiedModel, certificate: Certificate | None) -> SimplifiedModel:
    """The model with its proven bound."""
    if certificate is None:
        return model
    return model.stating(replace(model.accuracy, certificate=certificate.stated))
