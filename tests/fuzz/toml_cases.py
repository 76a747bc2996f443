"""Arm files: valid ones, what is done to them, and what must hold of an arm that is read."""

from __future__ import annotations

import json
import re
import tempfile
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from changes import Stage, text_format
from hostile_values import Raw
from tree_changes import TREE_CHANGES

from gd_analyze import load_arm, save_arm
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.files import data_folder
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.description import describe, fingerprint
from gd_analyze.tables import decompose_states, states_in_box
from gd_analyze.types import RobotArm, States

FULL = """
format = "gd-analyze arm 1"
name = "full"
title = "Every key"
convention = "modified"
gravity = [0.0, 0.0, -9.81]
sources = ["made for a test"]
assumptions = ["all"]
spread = [
    [0.1, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.01],
    [0.0, 0.01, -0.02, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0],
]
[[joints]]
name = "turn"
alpha_deg = -90.0
a_mm = 500.0
theta = 0.1
d = 0.2
range_deg = [-90.0, 90.0]
velocity_limit_deg = 120.0
acceleration_limit = 5.0
[[joints]]
name = "slide"
kind = "prismatic"
range_mm = [100.0, 500.0]
velocity_limit = 1.0
acceleration_limit_mm = 2000.0
[[links]]
name = "first"
mass = 2.0
com_mm = [0.0, 0.0, 100.0]
inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }
mass_uncertainty = 0.05
com_uncertainty_mm = [2.0, 2.0, 2.0]
inertia_uncertainty = { xx = 0.004, yy = 0.009, zz = 0.008, xz = 0.002 }
inertia_uncertainty_about = "origin"
as_measured = false
without_payload = { mass = 1.5, com_mm = [0.0, 0.0, 90.0], inertia = { xx = 0.02, yy = 0.02, zz = 0.01 } }
[[links]]
name = "second"
mass = 1.0
com = [0.0, 0.0, 0.01]
inertia_about = "origin"
inertia = { xx = 0.02, yy = 0.02, zz = 0.01, xy = 0.001 }
[[drives]]
inertia = 0.5
inertia_uncertainty = 0.02
gear_ratio = -62.5
viscous = 0.001
coulomb = [0.4, -0.4]
torque_limit = 97.0
[[drives]]
inertia = 0.25
"""
# With an inertia that violates the triangle inequality by as much as measurements do, which is told.
MEASURED = FULL.replace("zz = 0.01, xy", "zz = 0.0415, xy")
PLACED = """
format = "gd-analyze arm 1"
name = "placed"
convention = "placement"
doubts = ["whether it exists"]
joints = [
  { xyz = [0.0, 0.0, 0.3], rpy = [0.1, -0.2, 0.3], axis = [0.6, 0.0, 0.8], range_deg = [-90.0, inf] },
  { kind = "prismatic", xyz_mm = [400.0, 0.0, 0.0], range = [-inf, 0.5], \
rotation = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]] },
  { rpy_deg = [90.0, 0.0, 0.0] },
]
links = [
  { frame_xyz_mm = [350.0, 0.0, 0.0], frame_rpy_deg = [0.0, 0.0, 180.0], mass = 3.0, com = [0.2, 0.0, 0.0], \
inertia = { xx = 0.002, yy = 0.04, zz = 0.04 } },
  { frame_xyz = [0.1, 0.0, 0.0], frame_rotation = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]], \
mass = 1.5, com = [0.15, 0.0, 0.0], inertia = { xx = 0.001, yy = 0.015, zz = 0.015 } },
  { frame_rpy = [0.0, 1.5, 0.0], mass = 0.5, com = [0.05, 0.0, 0.0], \
inertia = { xx = 0.001, yy = 0.001, zz = 0.001 } },
]
"""
TWO_LINK = (data_folder("robots") / "two_link.toml").read_text(encoding="utf-8")
BASES = [tomllib.loads(text) for text in (FULL, TWO_LINK, MEASURED, PLACED)]
# Beyond, an evaluation takes seconds for good reasons.
MOST_JOINTS = 10


def toml(tree: Any) -> str:
    """A tree as TOML, its lists of tables as people write them."""
    if not isinstance(tree, dict):
        return _inline(tree)
    plain = {key: value for key, value in tree.items() if not _is_tables(value)}
    lines = [f"{_key(key)} = {_inline(value)}" for key, value in plain.items()]
    for key, tables in tree.items():
        if key not in plain:
            for table in tables:
                lines += [f"[[{_key(key)}]]", *(f"{_key(k)} = {_inline(v)}" for k, v in table.items())]
    return "\n".join(lines) + "\n"


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _text(key)


def _inline(value: Any) -> str:
    match value:
        case Raw():
            return value.text
        case dict():
            return "{" + ", ".join(f"{_key(k)} = {_inline(v)}" for k, v in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(_inline, value)) + "]"
        case str():
            return _text(value)
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case int() if abs(value) > 10**300:
            return hex(value)
    return repr(value)


def _text(value: str) -> str:
    """A TOML string that says it exactly, by escapes where TOML needs them."""
    return '"' + re.sub(r'[\x00-\x1f"\\\x7f]', lambda sign: f"\\u{ord(sign[0]):04x}", value) + '"'


STAGES = (Stage(TREE_CHANGES, toml, weight=3),)


def use(arm: RobotArm) -> None:
    """What is read comes back from description and TOML, is finite, and its effects sum to the torque."""
    n, drives = arm.n_joints, bool(arm.drives)
    with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # told on reading, or of limits that are not stated
        described = arm_in(describe(arm))
        path = Path(folder) / "written.toml"
        save_arm(arm, path)
        written = load_arm(path)
        drawn = states_in_box(arm, 3)
    assert fingerprint(described) == fingerprint(arm), "another arm by its description"
    assert fingerprint(written, drives) == fingerprint(arm, drives), "another arm by its TOML"
    json.dumps(describe(arm), allow_nan=False)
    if n > MOST_JOINTS:
        return
    assert all(np.isfinite(x).all() for x in drawn.arrays), "states that are not finite"
    random = np.random.default_rng(0)
    states = States(*(random.uniform(-2.0, 2.0, (3, n)) for _ in range(3)))
    effects = decompose_states(arm, states, drives=drives)
    for name, values in effects.items():
        assert np.isfinite(values).all(), f"{name} is not finite"
    forces = np.einsum("keij,kj->kei", effects["inertia"], states.qdd) + effects["coriolis_centrifugal"]
    loads = [forces[:, 0], forces[:, 1], effects["gravity_loading"]]
    loads += [effects["drive_torque"]] if drives else []
    # Sums of some ten products each, in two orders.
    scale = np.abs(effects["inertia"]).sum(axis=(1, 3)) * 2.0 + sum(map(np.abs, loads))
    assert (np.abs(sum(loads) - effects["torque"]) <= 100 * np.finfo(float).eps * scale).all(), "another sum"


FORMAT = text_format(BASES, STAGES, load_arm, use)
