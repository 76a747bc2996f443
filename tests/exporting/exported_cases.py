"""What is printed in every language: exact dynamics, models of every level, decompositions."""

from __future__ import annotations

from functools import cache

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from made_models import exact_model, model_of

STATES = 1000
LINKS = ("two_link", "puma560", "stanford")
CASES = (
    *LINKS,
    *(f"two_link {level}" for level in LEVELS),
    "puma560 term",
    "puma560 recursive",
    "stanford element",
    "stanford energy",
    *(f"{name} decomposition" for name in LINKS),
)
TORQUES = tuple(case for case in CASES if not case.endswith("decomposition"))
MODELS = tuple(case for case in TORQUES if case not in LINKS)
# For languages that take long to load a text.
FEW = ("two_link element", "two_link recursive", "stanford", "two_link decomposition")


# Made when a test asks for them, and not before: programs are kept in the tests' own folder.
@cache
def subject(case: str) -> ExportInput:
    """What a case is of."""
    name, _, what = case.partition(" ")
    arm = load_arm(name)
    if what == "decomposition":
        return ExportInput.of_decomposition(arm)
    if not what:
        return ExportInput.of_exact(ExactForm(arm, arm.counts_drives(None)))
    return proven(exact_model(arm, arm.counts_drives(None), LEVELS[what]))


@cache
def states(arm: str) -> States:
    """Many states of an arm."""
    return states_in_box(load_arm(arm), STATES, seed=5)


def proven(model: SimplifiedModel) -> ExportInput:
    """With numbers as if something were proven: what they are does not matter to a printer."""
    arm = model.arm
    n = arm.n_joints
    # No number of these is one of single precision.
    box = Box(np.full(n, -0.7), np.full(n, 1.1), np.full(n, 2.3), np.full(n, 3.3), "a box")
    nothing = np.zeros((n, n))
    certificate = Certificate(box, 0.1 + np.arange(n) / 3, np.zeros(n), (nothing, nothing, nothing))
    return ExportInput.of_model(model, None, certificate)


def round_model(arm: RobotArm, level: str = "energy") -> SimplifiedModel:
    """A model of few digits, the same to the last bit on every machine."""
    form = ExactForm(arm)
    terms = {term: round(weight, 3) for term, weight in LEVELS[level].terms(form).items()}
    return model_of(form, LEVELS[level], {term: x for term, x in terms.items() if x})
