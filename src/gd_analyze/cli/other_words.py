"""Words that people type in place of a verb or a function, and the command that does it."""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Mapping, Sequence

_POSTURE = "`gd-analyze equations ROBOT --at 0,-30,...`"

# ROBOT and TRAJECTORY stand for what the user typed behind the word.
_OF_VERBS = {
    "torque torques tau inverse_dynamics inverse id rnea dynamics": "`gd-analyze ROBOT TRAJECTORY` writes "
    f"torques and all their parts into analysis.h5; {_POSTURE} prints D, h and c at one posture",
    "inertia mass_matrix mass inertia_matrix d crba": "`gd-analyze equations ROBOT --element D` prints its "
    f"formulas, {_POSTURE} its numbers at one posture",
    "coriolis centrifugal christoffel h": "`gd-analyze equations ROBOT --element h` prints its formulas, "
    f"{_POSTURE} its numbers at one posture",
    "gravity gravity_torque gravity_loading gravity_vector c": "`gd-analyze equations ROBOT --element c` "
    f"prints its formulas, {_POSTURE} its numbers at one posture",
    "coriolis_matrix": "`gd-analyze export ROBOT --to c --what coriolis_matrix` writes it as a function",
    "regressor": "`gd-analyze export ROBOT --to python --what regressor` writes it as a function; "
    "`gd-analyze equations ROBOT --parameters` prints the base parameters that it multiplies",
    "parameters base_parameters minimal_parameters base inertial_parameters": "`gd-analyze equations ROBOT "
    "--parameters` prints them",
    "forward_dynamics forward fd aba accelerations simulate simulation": "`gd-analyze export ROBOT --to "
    "python --what forward` writes accelerations as a function; docs/simulation.md computes motions",
    "derivatives linearize linearise gradient": "`gd-analyze export ROBOT --to c --what derivatives` writes "
    "them as a function",
    "jacobian jacobians kinematics fk ik forward_kinematics inverse_kinematics": "gd-analyze has dynamics "
    "only; Pinocchio, which is installed with it, has kinematics: pinocchio.computeJointJacobians",
    "friction": "`gd-analyze identify ROBOT LOG` fits links, drives and friction; `gd-analyze ROBOT LOG "
    "--fit-friction` fits friction alone",
    "analyse run main start": "`gd-analyze ROBOT TRAJECTORY` is the main job",
    "decompose decomposition split parts dominance rank": "`gd-analyze ROBOT TRAJECTORY` splits and ranks "
    "the elements; `gd-analyze rank-terms ROBOT TRAJECTORY` ranks single terms",
    "info show inspect check validate list robots robot models": "`gd-analyze arms ROBOT` shows an arm and "
    "its implausible numbers; without ROBOT it lists the built-in arms",
    "convert": "`gd-analyze arms ROBOT --to toml` prints the arm as TOML; `gd-analyze export ROBOT --to "
    "LANGUAGE` writes its equations as source text",
    "codegen generate compile write": "`gd-analyze export ROBOT --to c` writes exact dynamics, or a "
    "model.json in place of ROBOT",
    "plot draw figure": "`gd-analyze figures ROBOT TRAJECTORY` draws D, h and c by effect",
    "trajectory trajectories motion log read": "`gd-analyze columns ROBOT LOG` shows how a log is read; "
    "`gd-analyze plan ROBOT --from LIST --to LIST --duration SECONDS` makes a motion",
    "calibrate calibration estimate fit sysid identification": "`gd-analyze identify ROBOT LOG` fits links, "
    "drives and friction",
    "reduce approximate budget": "`gd-analyze simplify ROBOT TRAJECTORY --budget 1%`",
    "prove proof verify bound": "`gd-analyze certify MODEL` bounds a model's torque error; `gd-analyze "
    "evaluate MODEL TRAJECTORY` measures it",
    "test error": "`gd-analyze evaluate MODEL TRAJECTORY` compares a model with exact dynamics",
    "diff difference": "`gd-analyze compare ROBOT OTHER` compares two files of a robot",
    "methods cost costs operations": "`gd-analyze formulations ROBOT` counts and compares the formulations",
    "sweep many grid": "`gd-analyze batch TABLE` does the main job for every row of a table",
    "payload": "`gd-analyze ROBOT TRAJECTORY --payload LIST` loads the arm",
    "help": "`gd-analyze --help`, or `gd-analyze VERB --help`",
}

_ALWAYS = "omit it: D, h and c are always written beside torque"
# In place of the words of `export --what`.
OF_FUNCTIONS = {
    **dict.fromkeys(("inertia", "mass_matrix", "d", "m", "crba"), _ALWAYS),
    **dict.fromkeys(("gravity", "gravity_loading", "c", "g"), _ALWAYS),
    **dict.fromkeys(("coriolis", "coriolis_centrifugal", "centrifugal", "h"), _ALWAYS),
    **dict.fromkeys(("inverse_dynamics", "id", "rnea", "tau", "model"), "give torque"),
    **dict.fromkeys(("forward_dynamics", "fd", "aba", "accelerations"), "give forward"),
    **dict.fromkeys(("christoffel", "coriolis_matrices"), "give coriolis_matrix"),
    **dict.fromkeys(("jacobian", "gradient", "linearization"), "give derivatives, which are those of torque"),
    **dict.fromkeys(("base_parameters", "minimal_parameters"), "give parameters"),
    **dict.fromkeys(("parts", "effects", "dominance"), "give decomposition"),
}
# In place of the words of `export --to`.
OF_LANGUAGES = {
    **dict.fromkeys(("c++", "cxx", "cc", "eigen"), "give cpp"),
    **dict.fromkeys(("numpy", "py"), "give python"),
    **dict.fromkeys(("octave", "simulink", "m"), "give matlab"),
    **dict.fromkeys(("tex", "pdf"), "give latex"),
    **dict.fromkeys(("rust", "julia", "fortran", "java", "cython"), "give c, and call it from there"),
    "toml": "`gd-analyze arms ROBOT --to toml` prints an arm as TOML",
}


def in_place_of_verb(word: str, following: Sequence[str]) -> str | None:
    """What does the job that a word names, with the robot and motion behind it; None if it names none."""
    said_for = {key: said for keys, said in _OF_VERBS.items() for key in keys.split()}
    plain = word.lower().replace("-", "_")
    matches = difflib.get_close_matches(plain, said_for, n=1, cutoff=0.85)
    if not matches:
        return None
    said = said_for[matches[0]]
    files = [shlex.quote(entry) for entry in following if not entry.startswith("-")]
    for place, file in zip((("ROBOT",), ("TRAJECTORY", "LOG")), files, strict=False):
        for name in place:
            said = said.replace(f" {name}", f" {file}")
    return said


def in_place_of(word: str, names: Sequence[str], said_for: Mapping[str, str]) -> str | None:
    """What to give in place of a word: as the table says, or the name most like it."""
    near = difflib.get_close_matches(word, names, n=1)
    return said_for.get(word.replace("-", "_"), f"did you mean {near[0]}?" if near else None)
