"""Which statement of a formulation does how much of its arithmetic.

The operations of a run are booked to the statement of the formulation (or of the kinematics) that asked for
them, found on Python's call stack while it runs. So the parts add up to the whole by construction, and no
count is kept by hand.
"""

from __future__ import annotations

import ast
import math
import sys
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FrameType

import numpy as np

from gd_analyze import formulations, kinematics
from gd_analyze.comparison.methods import Method
from gd_analyze.operations import OperationCount
from gd_analyze.operations.counting import Tally, counting_array, counting_function
from gd_analyze.robots import RobotArm


@dataclass(frozen=True)
class Place:
    """Where operations are asked for.

    Parameters
    ----------
    module
        File of the formulation, "kinematics", or "comparison" where D, h and c are put together.
    function
        Outermost function of that file on the call stack.
    target
        What the statement assigns to, as written; "" for a statement that assigns nothing.
    helper
        Innermost function of the same file: `function` itself unless it calls a helper.
    """

    module: str
    function: str
    target: str
    helper: str


_ELSEWHERE = Place("comparison", "", "", "")
_FOLDER = str(Path(formulations.__file__).parent)
_KINEMATICS = str(Path(kinematics.__file__))


def count_by_place(method: Method, arm: RobotArm) -> dict[Place, OperationCount]:
    """Count one method's torque, as executed, statement by statement.

    Parameters
    ----------
    method
        One of `METHODS`.
    arm
        The arm.

    Returns
    -------
    dict
        Operations by place; they add up to `count_cost(method, arm).executed` but for sines and cosines,
        which every method takes once per revolute joint.
    """
    tally = _LocatedTally()
    states = (counting_array(state, tally) for state in np.full((3, arm.n_joints), 0.5))
    cos, sin = (counting_function(function, tally) for function in (math.cos, math.sin))
    method.torque(arm, *states, gravity=True, cos=cos, sin=sin)
    places = tally.multiplied.keys() | tally.added.keys()
    return {place: OperationCount(tally.multiplied[place], tally.added[place], 0) for place in places}


class _LocatedTally(Tally):
    """A tally that looks where every operation comes from."""

    def __init__(self) -> None:
        self.multiplied: Counter[Place] = Counter()
        self.added: Counter[Place] = Counter()
        super().__init__()

    def __setattr__(self, name: str, value: object) -> None:
        if isinstance(value, int) and value and name in ("multiplications", "additions"):
            booked = self.multiplied if name == "multiplications" else self.added
            booked[_place(sys._getframe(2))] += 1
        super().__setattr__(name, value)


def _place(frame: FrameType | None) -> Place:
    """Outermost statement of a formulation or of the kinematics that the frame was called from."""
    inner = outer = None
    while frame is not None:
        path = frame.f_code.co_filename
        if path == _KINEMATICS or path.startswith(_FOLDER):
            if inner is None or inner.f_code.co_name.startswith("<"):
                inner = frame
            outer = frame
        frame = frame.f_back
    if inner is None or outer is None:
        return _ELSEWHERE
    path = outer.f_code.co_filename
    target = _targets(path).get(outer.f_lineno, "")
    return Place(Path(path).stem, outer.f_code.co_name, target, inner.f_code.co_name)


@cache
def _targets(path: str) -> dict[int, str]:
    """What is assigned to, by line of a source file."""
    targets: dict[int, str] = {}
    for node in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign):
            first = node.targets[0] if isinstance(node, ast.Assign) else node.target
            name = ast.unparse(first)
        elif isinstance(node, ast.Expr | ast.Return) and node.value is not None:
            name = ast.unparse(node.value).partition("(")[0] if isinstance(node, ast.Expr) else "return"
        else:
            continue
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1):
            targets[line] = name
    return targets
