"""Arms, and what is exported of them, whose names were chosen by somebody who means harm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from exported_cases import subject

from gd_analyze.exporting.export_input import ExportInput

# What ends a comment, a string or a line somewhere, or means something there.
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


def forced(what: Any, **names: Any) -> Any:
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
    joints = tuple(forced(joint, name=name(k)) for k, joint in enumerate(arm.joints))
    links = tuple(forced(link, name=name(n + k)) for k, link in enumerate(arm.links))
    arm = forced(arm, name=name(2 * n), title=name(2 * n + 1), joints=joints, links=links)
    model = what.model
    if model is not None:
        fitted_on = {"trajectory": name(2 * n + 3), "trajectory_fingerprint": "0" * 64, "set_points": 9}
        accuracy = forced(model.accuracy, budget=name(2 * n + 2), fitted_on=fitted_on)
        model = forced(model, accuracy=accuracy)
    certificate = what.certificate
    if certificate is not None:
        certificate = replace(certificate, region=replace(certificate.box, where=name(2 * n + 4)))
    return replace(what, arm=arm, model=model, certificate=certificate)


@cache
def hostile(case: str, first: int) -> ExportInput:
    """A case with all names from the first on."""
    what = replace(subject(case), name=f"evil_{case.replace(' ', '_')}_{first}")
    return renamed(what, NAMES[first:] + NAMES[:first])
