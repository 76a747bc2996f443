"""Pinocchio's rnea: called from Python state by state, and compiled by the headers that its wheel holds."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from peers.timed import Way, library, way

# As Pinocchio's own build files have them.
_DEFINED = (
    "-DNDEBUG",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)


def rnea_library(folder: Path) -> ctypes.CDLL | str:
    """Compile rnea, which takes half a minute; or say why it cannot be done."""
    import casadi
    import pinocchio

    # The wheel of Pinocchio holds its headers and Boost's, that of CasADi Eigen's.
    include = Path(pinocchio.__file__).parents[4] / "include"
    eigen = Path(casadi.GlobalOptions.getCasadiIncludePath()) / "eigen3"
    for needed in (include / "pinocchio" / "multibody.hpp", include / "boost", eigen):
        if not needed.exists():
            return f"no {needed.name} beside Pinocchio or CasADi"
    command = ("g++", "-std=c++17", "-O3", "-march=native", "-w", *_DEFINED, f"-I{include}", f"-I{eigen}")
    source = Path(__file__).with_name("rnea.cpp").read_text("utf-8")
    try:
        return library(folder, {"rnea.cpp": source}, *command)
    except FileNotFoundError:
        return "no g++"
    except subprocess.CalledProcessError as failed:
        said = next((line for line in failed.stderr.splitlines() if "error" in line), "no reason given")
        return f"Pinocchio's headers do not compile: {said}"


def compiled_rnea(made: ctypes.CDLL, arm: RobotArm, drives: bool, states: States) -> Way:
    """Call the compiled rnea in a loop of C++."""
    handle = made_arm(made, arm, drives)
    return way("rnea C++", lambda *given: made.all(handle, *given), states)


def made_arm(made: ctypes.CDLL, arm: RobotArm, drives: bool) -> ctypes.c_void_p:
    """Put the arm together in C++."""
    model = _model(arm, drives)
    numbers = []
    for joint, placement, body, rotor in zip(
        arm.joints, list(model.jointPlacements)[1:], list(model.inertias)[1:], model.armature, strict=True
    ):
        numbers += [placement.rotation.ravel(), placement.translation, joint.axis]
        numbers += [[body.mass], body.lever, body.inertia.ravel(), [rotor]]
    flat = np.concatenate(numbers)
    gravity = np.array(arm.gravity_vector)
    made.make.restype = ctypes.c_void_p
    pointers = [ctypes.c_void_p(x.ctypes.data) for x in (gravity, flat)]
    return ctypes.c_void_p(made.make(arm.n_joints, *pointers))


def rnea_from_python(arm: RobotArm, drives: bool, states: States) -> Way:
    """Call Pinocchio's own build of rnea in a loop of Python."""
    import pinocchio as pin

    model = _model(arm, drives)
    data, rnea = model.createData(), pin.rnea
    torque = np.full_like(states.q, np.nan)

    def run(passes: int) -> None:
        for _ in range(passes):
            for k, state in enumerate(zip(*states.arrays, strict=True)):
                torque[k] = rnea(model, data, *state)

    return Way("rnea Python", run, torque)


def _model(arm: RobotArm, drives: bool) -> Any:
    model = pinocchio_model(arm)
    if drives:
        model.armature = np.array(arm.drive_inertia)
    return model
