"""What is printed: exact dynamics, models of every level, decompositions, odd arms, hostile names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

import gd_analyze as gd
from changed_programs import rounded
from gd_analyze.certification.certificate import Certificate
from gd_analyze.dynamics.drivetrain import has_friction
from gd_analyze.exporting.export_input import FURTHER, ExportInput
from gd_analyze.types import ExactForm, Joint, Link
from made_models import exact_model, model_of, running
from strategies import random_states

LINKS = ("two_link", "puma560", "stanford")
CASES = (
    *LINKS,
    *(f"two_link {level}" for level in (*gd.types.LEVELS, "program")),
    "puma560 term",
    "puma560 program",
    "stanford element",
    "stanford energy",
    *(f"{name} decomposition" for name in LINKS),
    *(f"{name} further" for name in LINKS),
)
TORQUES = tuple(case for case in CASES if not case.endswith(("decomposition", "further")))
MODELS = tuple(case for case in TORQUES if case not in LINKS)
# For languages that take long to load a text.
FEW = ("two_link element", "two_link program", "stanford further", "two_link decomposition")
# Arms of which hardly anything is left.
ODD = {
    "weightless": (0.0, "revolute", "prismatic"),
    "slides": (1.0, "prismatic", "prismatic"),
    "spins": (1.0, "revolute"),
}


def _odd(name: str) -> gd.types.RobotArm:
    mass, *kinds = ODD[name]
    limits = {"lower": -3.0, "upper": 3.0, "velocity_limit": 3.0, "acceleration_limit": 10.0}
    joints = tuple(Joint(f"j{k}", kind, **limits) for k, kind in enumerate(kinds))
    links = tuple(Link(f"l{k}", mass, np.zeros(3), np.eye(3) * 0.1 * mass) for k in range(len(kinds)))
    return gd.types.RobotArm(name, joints, links, np.array([0.0, 0.0, -9.81]))


# Made when a test asks for them, and not before: programs are kept in the tests' own folder.
@cache
def subject(case: str) -> ExportInput:
    """What a case is of."""
    name, _, what = case.partition(" ")
    arm = _odd(name) if name in ODD else gd.load_arm(name)
    if what == "decomposition":
        return ExportInput.of_decomposition(arm)
    if what in ("", "further"):
        exact = ExportInput.of_exact(ExactForm(arm, arm.counts_drives(None)))
        further = tuple(x for x in FURTHER if x != "friction" or has_friction(arm))
        return exact.with_functions(further) if what else exact
    if what == "program":
        form = ExactForm(arm, arm.counts_drives(None))
        return proven(running(rounded(form.program), form))
    return proven(exact_model(arm, arm.counts_drives(None), gd.types.LEVELS[what]))


@cache
def states(case: str, count: int = 1000) -> gd.types.States:
    """Many states of a case's arm."""
    name = case.partition(" ")[0]
    if name in ODD:
        return random_states(len(ODD[name]) - 1, count, 2)
    return gd.tables.states_in_box(gd.load_arm(name), count, seed=5)


def proven(model: gd.types.SimplifiedModel) -> ExportInput:
    """With numbers as if something were proven: what they are does not matter to a printer."""
    n = model.arm.n_joints
    # No number of these is one of single precision.
    box = gd.types.Box(np.full(n, -0.7), np.full(n, 1.1), np.full(n, 2.3), np.full(n, 3.3), "a box")
    nothing = np.zeros((n, n))
    certificate = Certificate(box, 0.1 + np.arange(n) / 3, np.zeros(n), (nothing, nothing, nothing))
    return ExportInput.of_model(model, None, certificate)


def round_model(arm: gd.types.RobotArm, level: str = "energy") -> gd.types.SimplifiedModel:
    """A model of few digits, the same to the last bit on every machine."""
    form = ExactForm(arm)
    terms = {term: round(weight, 3) for term, weight in gd.types.LEVELS[level].terms(form).items()}
    return model_of(form, gd.types.LEVELS[level], {term: x for term, x in terms.items() if x})


# Names chosen to do harm: they end a comment, a string or a line somewhere, or mean something there.
NAMES = (
    "*/ #error out",
    '"""\nraise SystemExit("out")\n"""',
    "'); system('touch out'); ('",
    "</script><script>alert(1)</script>",
    r"\input{/etc/passwd}",
    r"\end{document} \write18{touch out} % & $ # _ ^ ~ { }",
    '#read("x") $x$ @y',
    "??/\n#error out ??",
    "ends with a backslash \\",
    "/* // ' \" `touch out`",
    "%{\nerror('out')\n%}",
    "double",
    "while",
    "lambda",
    "Überarm 腕 \u202e\u0000\x1b[2J",
    "",
    "   ",
    "3",
    "_",
    "x" * 500,
    "a b",
    "a_b",
    "A-b",
    "same",
    "same",
    "{{ 7 * 7 }} {% include 'x' %}",
    "^^5cinput{x} \r\n#error out",
    "...\n error('out')",
)
# What is exported, and the first of the names: every name at some joint.
HOSTILE = tuple(
    (case, first)
    for case, step in (("two_link energy", 2), ("puma560", 18), ("two_link decomposition", 2))
    for first in range(0, len(NAMES), step)
)


def _forced(what: Any, **names: Any) -> Any:
    """Rename past the checks that names of arms are held to, which refuse most of these."""
    made = replace(what)
    for key, name in names.items():
        object.__setattr__(made, key, name)
    return made


def renamed(what: ExportInput, names: Sequence[str]) -> ExportInput:
    """The same functions, of an arm with these names, over and over, its model's budget and states too."""

    def name(k: int) -> str:
        return names[k % len(names)]

    arm, n = what.arm, what.n
    joints = tuple(_forced(joint, name=name(k)) for k, joint in enumerate(arm.joints))
    links = tuple(_forced(link, name=name(n + k)) for k, link in enumerate(arm.links))
    arm = _forced(arm, name=name(2 * n), title=name(2 * n + 1), joints=joints, links=links)
    model, certificate = what.model, what.certificate
    if model is not None:
        fitted_on = {"trajectory": name(2 * n + 3), "trajectory_fingerprint": "0" * 64, "set_points": 9}
        accuracy = _forced(model.accuracy, budget=name(2 * n + 2), fitted_on=fitted_on)
        model = _forced(model, accuracy=accuracy)
    if certificate is not None:
        certificate = replace(certificate, region=replace(certificate.box, where=name(2 * n + 4)))
    return replace(what, arm=arm, model=model, certificate=certificate)


@cache
def hostile(case: str, first: int) -> ExportInput:
    """A case with all names from the first on."""
    what = replace(subject(case), name=f"evil_{case.replace(' ', '_')}_{first}")
    return renamed(what, NAMES[first:] + NAMES[:first])
