"""Names that users try, and those that there are: what an AttributeError says."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import NoReturn

_INERTIA, _H, _CHRISTOFFEL = "inertia(q)", "coriolis_centrifugal(q, qd)", "christoffel(q)"
_C, _TORQUE, _QDD = "gravity_loading(q)", "torque(q, qd, qdd)", "forward_dynamics(q, qd, torque)"
_CALLS = (_INERTIA, _H, _CHRISTOFFEL, _C, _TORQUE, _QDD)
# Words of the field and of other libraries for the dynamics of a model, and how they are called.
DYNAMICS = {
    **dict.fromkeys(("D", "M", "mass", "mass_matrix", "inertia_matrix"), _INERTIA),
    **dict.fromkeys(("h", "C", "coriolis", "coriolis_matrix", "centrifugal", "velocity_torque"), _H),
    **dict.fromkeys(("c", "G", "g", "gravity", "gravity_torque", "gravload"), _C),
    **dict.fromkeys(("tau", "rne", "rnea", "inverse_dynamics"), _TORQUE),
}
# The same for exact dynamics, which have more.
EXACT_DYNAMICS = DYNAMICS | {
    **dict.fromkeys(
        ("D_tran", "D_translation", "D_rot", "D_rotation", "by_effect", "effects"),
        "inertia(q, by_effect=True), translation first",
    ),
    **dict.fromkeys(("h_tran", "h_rot"), "coriolis_centrifugal(q, qd, by_effect=True), translation first"),
    **dict.fromkeys(("h_ijk", "christoffel_symbols"), _CHRISTOFFEL),
    **dict.fromkeys(("accel", "acceleration", "aba", "fd", "qdd"), _QDD),
}
# And for an arm, whose dynamics are an object of their own.
OF_ARM = {
    name: f"gd.types.ArmDynamics(arm).{call}"
    for name, call in (EXACT_DYNAMICS | {call.partition("(")[0]: call for call in _CALLS}).items()
}
# For the package, words for its jobs, too.
PACKAGE = OF_ARM | {
    **dict.fromkeys(("load", "arm", "robot", "load_robot", "load_urdf", "read_arm"), "gd.load_arm"),
    **dict.fromkeys(("log", "load_log", "read_csv", "read_bag"), "gd.read_log"),
    **dict.fromkeys(("motion", "load_trajectory", "read_motion"), "gd.read_trajectory"),
    **dict.fromkeys(("run", "main"), "gd.analyze"),
    **dict.fromkeys(("dominance", "verdict", "ranking"), "gd.rank"),
    **dict.fromkeys(("decomposition", "split"), "gd.decompose"),
    **dict.fromkeys(("reduce", "approximate"), "gd.simplify"),
    **dict.fromkeys(("codegen", "generate", "write"), "gd.export"),
    "save": "gd.save_model, gd.save_arm or gd.tables.save_results",
    "open": "gd.load_findings",
    "parameters": "gd.base_parameters",
    "Y": "gd.regressor",
    "compare": "gd.compare_torque, of a log, or `gd-analyze compare A B` in a terminal, of two arms",
    **dict.fromkeys(("formulations", "formulation"), "`gd-analyze formulations ROBOT` in a terminal"),
}


def missing(owner: str, name: str, guesses: Mapping[str, str], names: Mapping[str, str]) -> AttributeError:
    """Make the error for a name that there is not: it says what the user means, or the most similar name.

    `guesses` and `names`, those that there are, say how each is written in code.
    """
    similar = difflib.get_close_matches(name, names, n=1)
    meant = guesses.get(name) or (names[similar[0]] if similar else "")
    return AttributeError(f"{owner} has no {name}" + (f"; did you mean {meant}?" if meant else ""))


def guessing(guesses: Mapping[str, str]) -> Callable[[object, str], NoReturn]:
    """Make the `__getattr__` of a class, which Python calls for names that there are not."""

    def of_missing(value: object, name: str) -> NoReturn:
        owner = type(value).__name__
        if name.startswith("_"):  # Python and notebooks ask for many of these
            raise AttributeError(f"{owner} has no {name}")
        raise missing(owner, name, guesses, {other: other for other in dir(value) if other[0] != "_"})

    return of_missing
