"""Model files: valid ones, what is done to them, and what must hold of a model that is read."""

from __future__ import annotations

import json
import tempfile
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from changes import Stage, text_format
from hostile_values import Raw
from toml_cases import FULL
from tree_changes import TREE_CHANGES

from gd_analyze import load_arm, load_model, save_model, simplify
from gd_analyze.operations.program import plain_program
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.simplification.torque_program import ROUGH
from gd_analyze.types import LEVELS, ExactForm, SimplifiedModel
from made_models import exact_model, signed
from recordings import swung


def _bases() -> list[dict[str, Any]]:
    """Models of every level, of an arm with drives and one without, and one for two motions."""
    with tempfile.TemporaryDirectory() as folder:
        path, written = Path(folder) / "arm.toml", Path(folder) / "model.json"
        path.write_text(FULL)
        bases = []
        for arm, drives in ((load_arm("two_link"), False), (load_arm(path), True)):
            for level in LEVELS.values():
                save_model(exact_model(arm, drives, level), written)
                bases.append(json.loads(written.read_text(encoding="utf-8")))
        save_model(simplify("two_link", [swung(20.0, "slow"), swung(2.2, "fast")], "20%"), written)
        bases.append(json.loads(written.read_text(encoding="utf-8")))
    return bases


BASES = _bases()


def _signed(text: str) -> str:
    """The same with the digest of its content, as its parser understands numbers and keys said twice."""
    with suppress(TypeError, ValueError, RecursionError):
        return json.dumps(signed(json.loads(text)), indent=0)
    return text


def _reconciled(random: Random, document: Any) -> Any:
    """The same, but the program follows from arm and terms, if they can."""
    with suppress(Exception):  # whatever damage does to functions that are given it unchecked
        level = LEVELS[document["level"]]
        form = ExactForm(arm_in(document["arm"]), document["drives"])
        with np.errstate(all="ignore"):
            program = level.write(form, level.from_entries(form, document["terms"]), ROUGH)
        steps, outputs = plain_program(program)
        return document | {
            "steps": steps,
            "outputs": outputs,
        }
    return document


def _json(tree: Any) -> str:
    """A tree as JSON."""
    raw: list[str] = []

    def marked(value: Raw) -> str:
        raw.append(value.text)
        return f"raw {len(raw)}"

    text = json.dumps(tree, default=marked)
    for number, insertion in enumerate(raw, 1):
        text = text.replace(f'"raw {number}"', insertion)
    return text


STAGES = (
    Stage(TREE_CHANGES, lambda tree: tree, weight=4),
    Stage({"reconcile": _reconciled}, lambda tree: _signed(_json(tree)), weight=12),
)


def use(model: SimplifiedModel) -> None:
    """What is read is finite at ordinary states in range and counts its own operations."""
    n = model.arm.n_joints
    lower = np.clip(model.arm.limits("lower"), -3.0, 3.0)
    upper = np.clip(model.arm.limits("upper"), -3.0, 3.0)
    random = np.random.default_rng(1)
    q = random.uniform(np.minimum(lower, upper), upper, (4, n))
    velocities, accelerations = random.uniform(-2.0, 2.0, (2, 4, n))
    for quantity, values in (
        ("torque", model.torque(q, velocities, accelerations)),
        ("inertia", model.inertia(q)),
        ("coriolis_centrifugal", model.coriolis_centrifugal(q, velocities)),
        ("gravity_loading", model.gravity_loading(q)),
    ):
        assert np.isfinite(values).all(), f"{quantity} is not finite"
    kinds = [step.operation for step in model.program.steps]
    counts = kinds.count("multiply"), kinds.count("add") + kinds.count("subtract")
    count = model.operations
    assert counts == (count.multiplications, count.additions), "operations are not the program's"
    accuracy = model.accuracy
    stated = (accuracy.allowed, accuracy.errors.peak_torque, accuracy.errors.largest, accuracy.errors.rms)
    assert all(x.shape == (n,) and np.isfinite(x).all() and (x >= 0).all() for x in stated), "no errors"


FORMAT = text_format(BASES, STAGES, load_model, use)
